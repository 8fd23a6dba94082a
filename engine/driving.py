"""Scenes driven by controllers (`engine.controllers`).

`drive` hands scenes to a controller in fixed blocks, in their order, padded at the end, for a matrix product gives
other bits for another n.

What was decided is kept with the scenes (`Scenes.actions`). From then on they are scenes like all others: either host
runs them, the reference driver is held against them, they replay and export, and no controller is asked again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.config import Config, ContactConfig, SimulationConfig
from engine.controllers import Seat, seats_of
from engine.errors import ControllerError
from engine.host import empty_results, outcomes, requested
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes
from engine.stacks import StackLostError
from engine.stepping import Lanes, observed
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
    reproducible: bool = True
    """Whether a block that was driven twice was driven alike."""
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
    for seat in seats:
        seat.meet(block, observed(program), config.time_step)
    alike, remarks = True, Remarks()
    for first in range(0, len(scenes), block):
        rows = np.arange(first, min(first + block, len(scenes)))
        part = _padded(scenes, rows, block)
        decided = _patiently(lanes, part, seats, remarks)
        for array, found in zip(cast("tuple[NDArray[Any], ...]", results), decided.results, strict=True):
            array[rows] = found[: len(rows)]
        parts.append(decided.actions[: len(rows)])
        if twice and first == 0:
            again = _patiently(lanes, part, seats, remarks)
            alike = bool(np.array_equal(decided.actions, again.actions))
    actions = np.concatenate(parts) if parts else undecided.actions
    verdict = np.where(results.verdict == Verdict.CONTROLLER, results.verdict, scenes.verdict)
    scenes = replace(scenes, actions=actions, verdict=verdict.astype(np.int32))
    return Driven(scenes, outcomes(results), alike, tuple(remarks.said))


def _undecided(program: Program, scenes: Scenes) -> Scenes:
    """The same scenes before anybody has driven."""
    return replace(scenes, actions=np.zeros((len(scenes), 0, sum(len(c.actions) for c in program.controls))))


def _padded(scenes: Scenes, rows: Ints, block: int) -> Scenes:
    """A block of scenes; what is left of it repeats the last one, and is not valid."""
    chosen = np.concatenate([rows, np.full(block - len(rows), rows[-1])])
    names = ("genomes", "keys", "verdict", "variant", "values", "draws", "attempts", "tested", "failed")
    taken = replace(scenes, **{name: getattr(scenes, name)[chosen] for name in names}, actions=np.zeros((0, 0, 0)))
    taken.verdict[len(rows) :] = RESTING
    return taken


@dataclass(frozen=True)
class _Block:
    """What a block came to."""

    actions: Floats
    results: tuple[NDArray[Any], ...]


@dataclass
class Remarks:
    """What is to be told of processes that were lost."""

    said: list[str] = field(default_factory=list)


def _patiently(lanes: Lanes, scenes: Scenes, seats: Sequence[Seat], remarks: Remarks) -> _Block:
    """Drive a block. Where a process is lost over it twice, each half of its scenes is driven alone, until one scene is
    left over which it is always lost: that one has the verdict CONTROLLER.
    """
    rows = np.flatnonzero(scenes.valid)
    lost = ""
    for _ in range(TWICE):
        try:
            return _Block(_drive_block(lanes, scenes, seats), lanes.copied())
        except StackLostError as error:
            lost = error.message
            remarks.said.append(lost)
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
    results = empty_results(lanes.program, requested(lanes.program, _undecided(lanes.program, scenes)))
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
