"""Who drives from outside: controllers, and scenes driven by them.

A controller is a function of observations (n, d) to actions (n, a), or an object that has a memory:

    reset(lanes, keys)               new scenes begin in these lanes (m,); `keys` (m, 6) are their stream keys
    act(observations, active)        actions (n, a); what a lane gives that is not `active` (n,) is left

Rows are lanes, scenes side by side, n of them at every call. `drive` hands scenes to it in fixed blocks, in their
order, padded at the end, for a matrix product gives other bits for another n.

What was decided is kept with the scenes (`Scenes.actions`). From then on they are scenes like all others: either host
runs them, the reference driver is held against them, they replay and export, and no controller is asked again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from engine.config import Config, ContactConfig, SimulationConfig
from engine.control import Control
from engine.errors import ArgumentError, ControllerError, CortexError, nearest
from engine.host import empty_results, outcomes, requested
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes
from engine.stepping import Lanes, names_of, observed
from engine.tables import Bools, Floats, Ints

BLOCK = 256
"""Scenes that a controller is asked about at once."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


# -- controllers -------------------------------------------------------------------------------------------------------


@runtime_checkable
class Controller(Protocol):
    """One with a memory."""

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """New scenes begin in these lanes."""
        ...

    def act(self, observations: Floats, active: Bools) -> Floats:
        """(n, a) actions."""
        ...


@dataclass(frozen=True)
class _Memoryless:
    """A function as a controller."""

    function: Callable[[Floats], Floats]

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """Nothing is remembered."""

    def act(self, observations: Floats, active: Bools) -> Floats:
        del active
        return self.function(observations)


def controller_of(name: str, driver: object) -> Controller:
    """Return what is asked for the controller of this name."""
    if isinstance(driver, Controller) and not isinstance(driver, type):
        return driver
    if callable(driver) and not isinstance(driver, type):
        return _Memoryless(driver)
    raise ArgumentError(
        f"the controller `{name}` is no function and has not both `reset` and `act`, but is a {type(driver).__name__}",
        "give a function of observations (n, d) to actions (n, a), or an object with `reset(lanes, keys)` and "
        "`act(observations, active)`",
    )


def controllers_of(program: Program, given: object) -> tuple[Controller, ...]:
    """Return one controller for each control of a program, in its order.

    `given` is the one of the ego, or of the only one there is, or a mapping from names to controllers.
    """
    names = names_of(program.controls)
    if not names:
        raise ControllerError(
            f"nobody in {program.name} is driven from outside, so that no controller is asked",
            "give the ego a controller: `with behavior ExternalBehavior()`",
        )
    drivers: Mapping[str, object] = given if isinstance(given, Mapping) else {_meant(program): given}
    for name in drivers:
        if name not in names:
            near = nearest(name, names)
            cure = f"did you mean `{near}`?" if near else f"name one of {', '.join(names)}"
            raise ControllerError(f"{program.name} has no controller `{name}`", cure)
    missing = [name for name in names if name not in drivers]
    if missing:
        raise ControllerError(
            f"nobody drives for the controller{'s' * (len(missing) > 1)} {', '.join(f'`{name}`' for name in missing)}",
            "give a mapping from the name of each controller to who drives: `ego={" + f'"{missing[0]}": …' + "}`",
        )
    return tuple(controller_of(name, drivers[name]) for name in names)


def _meant(program: Program) -> str:
    """The controller that is meant where no name is said: the ego's, or the first."""
    controls = sorted(program.controls, key=lambda control: control.actor)
    return controls[0].controller


# -- questions and answers ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Seat:
    """A controller in its place."""

    control: Control
    controller: Controller

    def reset(self, lanes: Ints, keys: Ints) -> None:
        self._ask(lambda: self.controller.reset(lanes, keys), "reset")

    def act(self, observations: Floats, active: Bools, times: Floats) -> Floats:
        """What it decides, checked where it is `active`. `times` (n,): of the samples [s], for messages."""
        given = self._ask(lambda: self.controller.act(observations, active), "act")
        return checked(self.control, given, active, times)

    def _ask(self, question: Callable[[], Any], what: str) -> Any:
        try:
            return question()
        except CortexError:
            raise
        except Exception as error:
            who, kind = f"the controller `{self.control.controller}`", type(error).__name__
            raise ControllerError(
                f"{who} raised {kind} in `{what}`: {error}{_place(error)}",
                "correct it; what was finished before is kept",
            ) from error


def _place(error: Exception) -> str:
    """Where it was raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return "" if trace is None else f" ({trace.tb_frame.f_code.co_filename}, line {trace.tb_lineno})"


def checked(control: Control, given: object, active: Bools, times: Floats) -> Floats:
    """Return actions (n, a) as numbers, if they can be driven where a lane is active.

    Raises:
        ControllerError: another shape, no numbers, NaN, or out of range: which, where and when.
    """
    who, shape = f"the controller `{control.controller}`", (len(active), len(control.actions))
    try:
        actions = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ControllerError(f"{who} gave no numbers, but {type(given).__name__}", _wanted(control)) from error
    if actions.shape != shape:
        raise ControllerError(f"{who} gave actions of shape {actions.shape}; expected {shape}", _wanted(control))
    for number, action in enumerate(control.actions):
        values = actions[:, number]
        wrong = np.flatnonzero(active & ~((values >= action.low) & (values <= action.high)))
        if len(wrong):
            lane, unit = int(wrong[0]), f" {action.unit}" if action.unit else ""
            raise ControllerError(
                f"{who} gave {action.name} = {values[lane]:g}{unit} in lane {lane} at {times[lane]:.2f} s",
                f"{action.name} lies in {action.low:g} .. {action.high:g}{unit}: `numpy.clip` holds it there",
            )
    return actions


def _wanted(control: Control) -> str:
    columns = ", ".join(f"{a.name} [{a.unit or '1'}, {a.low:g} .. {a.high:g}]" for a in control.actions)
    return f"give an array (n, {len(control.actions)}) with a row a lane: {columns}"


# -- driven scenes -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Driven:
    """Scenes with what was decided in them, and what became of them."""

    scenes: Scenes
    outcomes: Outcomes
    reproducible: bool = True
    """Whether a block that was driven twice was driven alike."""


@dataclass(frozen=True, eq=False)
class Driver:
    """Who drives, as a setting of a run (`Config.driver`)."""

    given: object
    """A controller, or a mapping from names to controllers."""
    block: int = BLOCK
    """Scenes that it is asked about at once; part of what decides a result."""
    name: str = ""
    """What people know it by: `python:mine.planner:drive`."""
    digest: str = ""
    """SHA-256 of the file that defines it; "" where there is none."""

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
    ) -> Driven:
        """Drive all valid scenes."""
        return drive(program, scenes, self.given, config, contact, self.block, jobs)


def driven(program: Program, scenes: Scenes, config: Config, jobs: int = 1) -> Scenes:
    """Return scenes as whom the config names drives in them; as they are where it names nobody."""
    if config.driver is None:
        return scenes
    done: Driven = config.driver.drive(program, scenes, config.simulation, config.contact, jobs)
    return done.scenes


def drive(
    program: Program,
    scenes: Scenes,
    driver: object,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    block: int = BLOCK,
    jobs: int = 1,
    twice: bool = False,
) -> Driven:
    """Drive all valid scenes by one controller, or a mapping from names to controllers.

    `twice`: the first block is driven again, to see whether the controller does the same.
    """
    seats = seats_of(program, driver)
    undecided = _undecided(program, scenes)
    results = empty_results(program, requested(program, undecided))
    parts: list[Floats] = []
    lanes = Lanes(program, block, config, contact, jobs=jobs)
    alike = True
    for first in range(0, len(scenes), block):
        rows = np.arange(first, min(first + block, len(scenes)))
        decided = _drive_block(lanes, _padded(scenes, rows, block), seats)[: len(rows)]
        for array, part in zip(results, lanes.results, strict=True):
            array[rows] = part[: len(rows)]
        parts.append(decided)
        if twice and first == 0:
            again = _drive_block(lanes, _padded(scenes, rows, block), seats)[: len(rows)]
            alike = decided.shape == again.shape and bool(np.array_equal(decided, again))
    actions = np.concatenate(parts) if parts else undecided.actions
    return Driven(replace(scenes, actions=actions), outcomes(results), alike)


def seats_of(program: Program, driver: object) -> tuple[Seat, ...]:
    """Return every control with its controller."""
    controllers = controllers_of(program, driver)
    return tuple(Seat(control, each) for control, each in zip(program.controls, controllers, strict=True))


def _undecided(program: Program, scenes: Scenes) -> Scenes:
    """The same scenes before anybody has driven."""
    return replace(scenes, actions=np.zeros((len(scenes), 0, sum(len(c.actions) for c in program.controls))))


def _padded(scenes: Scenes, rows: Ints, block: int) -> Scenes:
    """A block of scenes; what is left of it repeats the last one, and is not valid."""
    chosen = np.concatenate([rows, np.full(block - len(rows), rows[-1])])
    names = ("genomes", "keys", "verdict", "variant", "values", "draws", "attempts", "tested", "failed")
    taken = replace(scenes, **{name: getattr(scenes, name)[chosen] for name in names}, actions=np.zeros((0, 0, 0)))
    taken.verdict[len(rows) :] = -1
    return taken


def _drive_block(lanes: Lanes, scenes: Scenes, seats: Sequence[Seat]) -> Floats:
    """What is decided in a block, lane by lane (see `Lanes.decided`)."""
    every = np.arange(len(lanes))
    lanes.place(every, scenes)
    seen = [np.zeros((len(lanes), len(observed(lanes.program)))) for _ in seats]
    for seat in seats:
        seat.reset(every.astype(np.int64), scenes.keys)
    lanes.step()
    while lanes.running.any():
        times = lanes.samples * lanes.plan.layout.time_step
        for number, seat in enumerate(seats):
            asked = lanes.asked(number)
            if asked.any():
                seen[number][~asked] = 0.0
                lanes.observe(number, asked, seen[number])
                lanes.decide(number, asked, seat.act(seen[number].copy(), asked, times))
        lanes.step()
    return lanes.decided(every)
