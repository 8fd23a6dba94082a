"""Scenes driven by controllers (`engine.driving.controllers`).

`drive` hands scenes to a controller in fixed blocks, in their order, padded at the end, for a matrix product gives
other bits for another n.

What was decided is kept with the scenes (`Scenes.actions`). From then on they are scenes like all others: either host
runs them, the reference driver is held against them, they replay and export, and no controller is asked again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.config import Config, ContactConfig, SimulationConfig
from engine.driving.controllers import Seat, seats_of
from engine.driving.stacks import StackLostError
from engine.driving.stepping import Lanes, observed
from engine.errors import ControllerError
from engine.host import coasting, empty_results, outcomes, requested
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes
from engine.search.assessment import take
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

BLOCK = 256
"""Scenes that a controller is asked about at once."""
RESTING = -1
"""In the place of the verdict of a scene that is not driven with its block."""
TWICE = 2
"""So often a block is driven over which a process is lost, before it is halved."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


# -- driven scenes -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Driven:
    """Scenes with what was decided in them, and what became of them."""

    scenes: Scenes
    outcomes: Outcomes
    remarks: tuple[str, ...] = ()
    """How often a process was lost, and why."""


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
    anew: bool = True
    """Whether it can be asked about scenes that nobody has driven."""

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
    if done.remarks and not done.scenes.valid.any():
        raise ControllerError(done.remarks[-1], "see what it printed, and start it by hand")
    return done.scenes


def drive(
    program: Program,
    scenes: Scenes,
    driver: object,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    block: int = BLOCK,
    jobs: int = 1,
) -> Driven:
    """Drive all valid scenes by one controller, or a mapping from names to controllers."""
    seats = seats_of(program, driver)
    undecided = coasting(program, scenes)
    results = empty_results(program, requested(program, undecided))
    lanes = Lanes(program, block, config, contact, jobs=jobs)
    actions = np.zeros((len(scenes), lanes.turns, lanes.numbers))
    for seat in seats:
        seat.meet(block, observed(program), config.time_step)
    remarks: list[str] = []
    for first in range(0, len(scenes), block):
        rows = np.arange(first, min(first + block, len(scenes)))
        part = _padded(scenes, rows, block)
        decided = _patiently(lanes, part, seats, remarks)
        for array, found in zip(cast("tuple[NDArray[Any], ...]", results), decided.results, strict=True):
            array[rows] = found[: len(rows)]
        actions[rows] = decided.actions[: len(rows)]
    verdict = np.where(results.verdict == Verdict.CONTROLLER, results.verdict, scenes.verdict)
    scenes = replace(scenes, actions=actions, verdict=verdict.astype(np.int32))
    return Driven(scenes, outcomes(results), tuple(remarks))


def _padded(scenes: Scenes, rows: Ints, block: int) -> Scenes:
    """A block of scenes; what is left of it repeats the last one, and is not valid."""
    chosen = np.concatenate([rows, np.full(block - len(rows), rows[-1])])
    taken = take(replace(scenes, actions=np.zeros((len(scenes), 0, 0))), chosen)
    taken.verdict[len(rows) :] = RESTING
    return taken


@dataclass(frozen=True)
class _Block:
    """What a block came to."""

    actions: Floats
    results: tuple[NDArray[Any], ...]


def _patiently(lanes: Lanes, scenes: Scenes, seats: Sequence[Seat], remarks: list[str]) -> _Block:
    """Drive a block. Where a process is lost over it twice, each half of its scenes is driven alone, until one scene is
    left over which it is always lost: that one has the verdict CONTROLLER.
    """
    rows = np.flatnonzero(scenes.valid)
    for _ in range(TWICE):
        try:
            return _Block(_drive_block(lanes, scenes, seats), lanes.copied())
        except StackLostError as error:
            remarks.append(error.message)
    if len(rows) <= 1:
        return _lost(lanes, scenes, rows)
    halves = [_patiently(lanes, _only(scenes, part), seats, remarks) for part in np.array_split(rows, 2)]
    chosen = np.isin(np.arange(len(scenes)), np.array_split(rows, 2)[0])
    return _Block(
        _either(chosen, halves[0].actions, halves[1].actions),
        tuple(_either(chosen, one, other) for one, other in zip(halves[0].results, halves[1].results, strict=True)),
    )


def _lost(lanes: Lanes, scenes: Scenes, rows: Ints) -> _Block:
    """Scenes over which a process is lost."""
    results = empty_results(lanes.program, requested(lanes.program, coasting(lanes.program, scenes)))
    results.verdict[rows] = Verdict.CONTROLLER
    blank = cast("tuple[NDArray[Any], ...]", tuple(results))
    return _Block(np.zeros((len(lanes), lanes.turns, lanes.numbers)), blank)


def _only(scenes: Scenes, rows: Ints) -> Scenes:
    """The same block, in which these scenes alone are driven."""
    verdict = np.full(len(scenes), RESTING, dtype=np.int32)
    verdict[rows] = scenes.verdict[rows]
    return replace(scenes, verdict=np.where(scenes.valid, verdict, scenes.verdict).astype(np.int32))


def _either(chosen: Bools, one: NDArray[Any], other: NDArray[Any]) -> NDArray[Any]:
    return np.where(chosen.reshape(-1, *[1] * (one.ndim - 1)), one, other)


def _drive_block(lanes: Lanes, scenes: Scenes, seats: Sequence[Seat]) -> Floats:
    """What is decided in a block, lane by lane (see `Lanes.decided`)."""
    every = np.arange(len(lanes))
    lanes.place(every, scenes)
    seen = [np.zeros((len(lanes), len(observed(lanes.program)))) for _ in seats]
    for seat in seats:
        seat.reset(every.astype(np.int64), scenes.keys)
    lanes.step()
    while lanes.running.any():
        times = lanes.times
        for number, seat in enumerate(seats):
            asked = lanes.asked(number)
            if asked.any():
                seen[number][~asked] = 0.0
                lanes.observe(number, asked, seen[number])
                lanes.decide(number, asked, seat.act(seen[number].copy(), asked, times))
        lanes.step()
    return lanes.decided(every)
