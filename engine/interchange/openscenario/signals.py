"""The fixed-time plan of traffic lights, as phases of the road's signal controllers."""

from dataclasses import dataclass

from engine.interchange.opendrive import SignalGroup, signal_groups
from engine.interchange.recording import Recording, SignalTimes
from engine.interchange.xml_text import Element, child

RED, YELLOW, GREEN = "on;off;off", "off;on;off", "off;off;on"
"""Lamps from top to bottom, the spelling that esmini and ScenarioRunner read."""


@dataclass(frozen=True)
class SignalPhase:
    """What the lights of a group show for a time [s]."""

    name: str
    duration: float
    state: str


def add_signals(network: Element, recording: Recording) -> Element | None:
    """The lights of all junctions, last in a `RoadNetwork`; None where there are none, or no road of ours."""
    if recording.signals is None or recording.road is None:
        return None
    signals = child(network, "TrafficSignals")
    for group in signal_groups(recording.road):
        _add_controller(signals, group, recording.signals)
    return signals


def _add_controller(signals: Element, group: SignalGroup, times: SignalTimes) -> None:
    controller = child(signals, "TrafficSignalController", name=group.controller)
    for phase in phases(times, group.phase):
        element = child(controller, "Phase", name=phase.name, duration=phase.duration)
        for signal in group.signals:
            child(element, "TrafficSignalState", trafficSignalId=signal, state=phase.state)


def phases(times: SignalTimes, turn: int) -> tuple[SignalPhase, ...]:
    """What a group shows from the beginning of the run on, whose turn is the first (0) or second (1) of the plan.

    A run that begins in the middle of a phase begins with its rest, and the part before comes last.
    """
    mine = (
        SignalPhase("green", times.green, GREEN),
        SignalPhase("yellow", times.yellow, YELLOW),
        SignalPhase("clear", times.all_red, RED),
    )
    others = SignalPhase("red", times.slot, RED)
    plan = (*mine, others) if turn == 0 else (others, *mine)
    return tuple(phase for phase in _begun(plan, times.offset % times.cycle) if phase.duration > 0.0)


def _begun(plan: tuple[SignalPhase, ...], offset: float) -> tuple[SignalPhase, ...]:
    for index, phase in enumerate(plan):
        if offset < phase.duration:
            rest = SignalPhase(phase.name, phase.duration - offset, phase.state)
            before = SignalPhase(f"{phase.name}_before", offset, phase.state)
            return (rest, *plan[index + 1 :], *plan[:index], before)
        offset -= phase.duration
    return plan
