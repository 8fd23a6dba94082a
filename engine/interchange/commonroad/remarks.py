"""What CommonRoad cannot carry of a recording, or carries otherwise."""

from collections.abc import Iterator

from engine.interchange.commonroad.road import cycle
from engine.interchange.commonroad.solution import VEHICLES, has_size_of, nearest_vehicle
from engine.interchange.commonroad.timeline import Timeline
from engine.interchange.recording import ARMS


def remarks(line: Timeline) -> tuple[str, ...]:
    """Each as one sentence that names it."""
    return (*_contact(line), *_times(line), *_signals(line), *_ego(line), *_always())


def _contact(line: Timeline) -> Iterator[str]:
    contact, step = line.recording.contact, line.contact_step
    if contact is None or step is None:
        return
    names = " and ".join(line.recording.actors[i].name for i in contact.actors)
    if abs(step - round(step)) > 1e-6:
        yield (
            f"first contact, of {names} at {contact.time:.4f} s, lies between steps {int(step)} and {int(step) + 1}; "
            "CommonRoad knows whole steps only"
        )
    after = int(step + 1e-6) + 1
    yield f"at step {after} the two stand as they would without contact, as far on as their outlines overlap"
    yield "what follows first contact is contact physics, which no vehicle model of CommonRoad drives"


def _times(line: Timeline) -> Iterator[str]:
    if line.start != 0.0:
        yield f"step 0 is {line.start:g} s into the run, where the ego comes in"
    if len(line.recording.on_steps().stretches(0)) > 1:
        yield "the ego leaves and comes back; problem and solution end when it leaves first"
    late = [track.actor.name for track in line.others if track.waits]
    if late:
        yield (
            f"{', '.join(late)} must stand somewhere while not there: CommonRoad's obstacles are there from step 0; "
            "they wait aside, west of the road"
        )
    met = {track.index for track in line.others} | {0}
    for index, actor in enumerate(line.recording.actors):
        if index not in met:
            yield f"{actor.name} is never there at a whole step and left out"


def _signals(line: Timeline) -> Iterator[str]:
    signals = line.signals
    if signals is None:
        return
    if signals.controlled:
        yield "behaviours or monitors may change the traffic lights, and the file has their fixed plan"
    if not all(cycle(signals, arm, line.recording.step).is_exact for arm in ARMS):
        yield "traffic lights change at whole steps, as near to their plan as these allow"


def _ego(line: Timeline) -> Iterator[str]:
    actor, vehicle = line.ego.actor, nearest_vehicle(line.ego.actor)
    if not has_size_of(vehicle, actor):
        length, width = VEHICLES[vehicle]
        yield (
            f"the solution's ego is CommonRoad's vehicle {vehicle}, {length:g} m x {width:g} m, the nearest to "
            f"{actor.length:g} m x {actor.width:g} m"
        )


def _always() -> Iterator[str]:
    yield "CommonRoad has no names, masses, axles or pedals of obstacles, and steering of the ego alone"
