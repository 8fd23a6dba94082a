"""Scenes driven by controllers (`engine.driving.controllers`).

A `Driver` passes scenes to a controller in fixed blocks, in their order. The last block is padded, because the bits of
a matrix product depend on the number of rows.

The decisions are stored with the scenes (`Scenes.actions`). From then on they are scenes like all others: either host
runs them, the reference driver is applied to them, they are replayed and exported, and no controller is asked again.

A function has no memory: if it fails twice over a question, it is asked about each half of the scenes separately, until
only those remain over which it always fails. A block with a stateful controller or a process is driven again.
"""

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.assessment import take
from engine.config import ActorDriver, Config, ContactConfig, SimulationConfig
from engine.driving.controllers import ControllerSlot, fault_of, seats_of, settled
from engine.driving.observations import observed
from engine.driving.stepping import ParallelRuns
from engine.errors import ControllerError, LostError
from engine.host import coasting, empty_results, outcomes, requested
from engine.outcomes import Outcomes
from engine.program import Program
from engine.run_count import report_runs
from engine.scenes import Scenes
from engine.streams import scene_in_words
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import RECORDS, STORED, Verdict

# -- a question, with a second try after a failure ---------------------------------------------------------------------

HOPELESS = 16
"""Number of lost scenes, with none finished, at which a driver is given up."""


@dataclass
class DriverHistory:
    """Results of the questions that a driver has answered so far."""

    answered: set[int] = field(default_factory=set)
    """Numbers of the controls for which it has given an action that can be driven; if empty, it is no usable driver."""
    finished: bool = False
    """True if a scene has reached its end."""
    lost: int = 0
    """Number of scenes over which it failed."""

    @property
    def should_abort(self) -> bool:
        """Return True if `HOPELESS` scenes are lost and none has finished."""
        return not self.finished and self.lost >= HOPELESS


@dataclass(frozen=True)
class Answer:
    """Answer of a controller to one question."""

    actions: Floats
    """(n, a)"""
    lost: dict[int, LostError] = field(default_factory=dict)
    """Error of each row over which it fails."""
    recovered: LostError | None = None
    """Error of the first try, if the second one succeeded for all rows."""


def query_with_retries(seat: ControllerSlot, seen: Floats, queried: Bools, times: Floats) -> Answer:
    """Return the answer about the rows of `seen` (n, d) selected by `queried` (n,), for samples at `times` (n,) [s].

    Raises:
        LostError: the controller fails, and is stateful.
    """
    try:
        return Answer(seat.answer(seen, queried, times))
    except LostError as error:
        if seat.remembers:
            raise
        first = error
    try:
        return Answer(seat.answer(seen, queried, times), recovered=first)
    except LostError:
        answer = _in_halves(seat, seen, queried, times)
        return answer if answer.lost else replace(answer, recovered=first)


def _in_halves(seat: ControllerSlot, seen: Floats, queried: Bools, times: Floats) -> Answer:
    """Ask about ever fewer rows."""
    actions, lost = np.zeros((len(seen), len(seat.control.actions))), dict[int, LostError]()
    waiting: list[Ints] = [np.flatnonzero(queried)]
    while waiting:
        rows = waiting.pop()
        try:
            actions[rows] = seat.answer(_alone(seen, rows), queried, times)[rows]
        except LostError as error:
            if len(rows) > 1:
                waiting.extend(reversed(np.array_split(rows, 2)))
                continue
            lost[int(rows[0])] = error
    return Answer(actions, lost)


def _alone(seen: Floats, rows: Ints) -> Floats:
    """Return (len(seen), d): `rows` of `seen` in place, and copies of the first of them elsewhere.

    The number of rows stays the same, because the bits of a matrix product depend on it.
    """
    only = np.repeat(seen[rows[:1]], len(seen), axis=0)
    only[rows] = seen[rows]
    return only


BLOCK = 256
"""Number of scenes about which a controller is asked in one call."""
RESTING = -1
"""Verdict code of a scene that is not driven with its block."""
ENDS = (Verdict.VALID, Verdict.ABORTED)
"""Verdicts of scenes that have come to an end."""
RECOVERED = "; this did not happen again"
TWICE = 2
"""Number of times a block is driven in which a controller fails, before it is halved."""
MAX_LOGGED_FAILURES = 5
"""Number of kinds of failure that are logged separately; the rest is logged as a count."""
LOG = logging.getLogger(__name__)
"""Log of the controllers' failures; a command line writes it to stderr."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


# -- driven scenes -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Driven:
    """Driven scenes with their actions, outcomes and failures."""

    scenes: Scenes
    outcomes: Outcomes
    failures: tuple[ControllerError, ...] = ()
    """Failures of controllers, one for each scene that was lost."""
    recovered: tuple[ControllerError, ...] = ()
    """Failures that did not recur when the scenes were driven again; no scene was lost."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return one line for each failure, for `controller.log`."""
        return (
            *(failure.message for failure in self.failures),
            *(f"{failure.message}{RECOVERED}" for failure in self.recovered),
        )

    def tell(self, reported: set[str] | None = None) -> "Driven":
        """Log each kind of failure that `reported` does not contain yet, add it there, and return these scenes."""
        reported = set() if reported is None else reported
        for failures, more, end in ((self.failures, "scene", ""), (self.recovered, "time", RECOVERED)):
            for line in _in_brief([each for each in failures if each.kind not in reported], more):
                LOG.warning("%s%s", line, end)
            reported.update(each.kind for each in failures)
        return self


@dataclass(frozen=True, eq=False)
class Driver:
    """A driver as a setting of a run (`Config.driver`)."""

    given: object
    """A controller, or a mapping from controller names to controllers."""
    block: int = BLOCK
    """Number of scenes per question; results depend on it."""
    observe: str = RECORDS
    """Kind of its observations (`engine.vocabulary.OBSERVABLE`)."""
    name: str = ""
    """Its name for users: `python:mine.planner:drive`."""
    digest: str = ""
    """SHA-256 of the file that defines it; "" if there is no such file."""
    can_drive_new_scenes: bool = True
    """True if it can drive scenes that were not driven before."""
    history: DriverHistory = field(default_factory=DriverHistory, repr=False)

    def without_history(self) -> "Driver":
        """Return a copy with an empty history, so that no search influences another."""
        return replace(self, history=DriverHistory())

    def has(self, key: Ints, genome: Floats) -> bool:
        """Return `can_drive_new_scenes`: a controller can drive the scene of every stream key and genome."""
        del key, genome
        return self.can_drive_new_scenes

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
        measures: int = STORED,
    ) -> Driven:
        """Drive all valid scenes.

        Raises:
            ControllerError: a controller cannot be asked, has never given an action that can be driven, or fails
                everywhere.
        """
        work = self._work(program, config, contact, jobs, measures)
        runs, block = work.runs, self.block
        results = empty_results(program, requested(program, coasting(program, scenes)), measures)
        actions = np.empty((len(scenes), runs.turns, runs.numbers))
        for first in range(0, len(scenes), block):
            rows = np.arange(first, min(first + block, len(scenes)))
            room = actions[first : first + block]
            decided = _patiently(work, _padded(scenes, rows, block), room if len(room) == block else None)
            for array, found in zip(cast("tuple[NDArray[Any], ...]", results), decided.results, strict=True):
                array[rows] = found[: len(rows)]
            if decided.actions is not room:
                room[:] = decided.actions[: len(rows)]
            report_runs(len(rows))
        verdict = np.where(results.verdict == Verdict.CONTROLLER, results.verdict, scenes.verdict)
        scenes = replace(scenes, actions=actions, verdict=verdict.astype(np.int32))
        silent = len(work.history.answered) < len(work.seats) and not scenes.valid.any()
        if work.failures and (work.history.should_abort or silent):
            raise work.failures[0]
        return Driven(scenes, outcomes(results), tuple(work.failures), tuple(work.recovered))

    def _work(
        self, program: Program, config: SimulationConfig, contact: ContactConfig, jobs: int, measures: int
    ) -> "_Work":
        """Return slots for a block, with controllers that have received the header of their questions."""
        seats, records = seats_of(program, self.given), self.observe == RECORDS
        for seat in seats:
            seat.initialize(self.block, observed(program, records), config.time_step)
        runs = ParallelRuns(program, self.block, config, contact, records, jobs, measures)
        return _Work(runs, seats, self.history)


def driven(driver: ActorDriver, program: Program, scenes: Scenes, config: Config, jobs: int = 1) -> Driven:
    """Drive scenes and log the failures.

    Raises:
        ControllerError: as `Driver.drive`, and if a controller failed over all of them.
    """
    done: Driven = driver.drive(program, scenes, config.simulation, config.contact, jobs)
    if done.failures and not done.scenes.valid.any():
        raise done.failures[0]
    return done.tell()


def can_be_driven(driver: ActorDriver | None, keys: Ints, genomes: Floats) -> Bools:
    """Return (n,) True if the scene of a key and genome can be driven; all True if there is no driver."""
    if driver is None:
        return np.ones(len(keys), dtype=bool)
    return np.array([driver.has(key, genome) for key, genome in zip(keys, genomes, strict=True)], dtype=bool)


def redriven(program: Program, scenes: Scenes, config: Config, jobs: int = 1) -> Scenes:
    """Return scenes that were driven before, with the decisions of this time; failures are not logged again.

    Raises:
        ControllerError: as `Driver.drive`.
    """
    if config.driver is None or not len(scenes):
        return scenes
    done: Driven = config.driver.drive(program, scenes, config.simulation, config.contact, jobs)
    return done.scenes


def _in_brief(failures: Sequence[ControllerError], noun: str) -> Iterator[str]:
    """Yield a line for each kind of failure, with its first scene and the number of further ones."""
    alike: dict[str, list[ControllerError]] = {}
    for failure in failures:
        alike.setdefault(failure.kind, []).append(failure)
    for first, *more in [*alike.values()][:MAX_LOGGED_FAILURES]:
        others = f", and {len(more):,} {noun}{'s' * (len(more) > 1)} more" if more else ""
        yield f"{first.message}{others}"
    if rest := [*alike.values()][MAX_LOGGED_FAILURES:]:
        yield f"and {sum(map(len, rest)):,} failures of other kinds"


@dataclass
class _Work:
    """Controllers, slots and failures so far of scenes being driven."""

    runs: ParallelRuns
    seats: Sequence[ControllerSlot]
    history: DriverHistory
    failures: list[ControllerError] = field(default_factory=list)
    """Errors, one for each scene that is lost."""
    recovered: list[ControllerError] = field(default_factory=list)


def _padded(scenes: Scenes, rows: Ints, block: int) -> Scenes:
    """Return the scenes `rows` as a block; its padding repeats the last row and has the verdict `RESTING`."""
    chosen = np.concatenate([rows, np.full(block - len(rows), rows[-1])])
    taken = take(replace(scenes, actions=np.zeros((len(scenes), 0, 0))), chosen)
    taken.verdict[len(rows) :] = RESTING
    return taken


@dataclass(frozen=True)
class _Block:
    """Decisions and results of a block."""

    actions: Floats
    results: tuple[NDArray[Any], ...]


def _patiently(work: _Work, scenes: Scenes, room: Floats | None = None) -> _Block:
    """Drive a block, whose actions may be written into `room`.

    If a controller fails over it twice, each half of its scenes is driven separately, until only one scene remains over
    which it always fails: that scene has the verdict CONTROLLER.

    Raises:
        LostError: it has failed over `HOPELESS` scenes, and none has ever come to its end.
    """
    rows, before, failed = np.flatnonzero(scenes.valid), len(work.failures), list[ControllerError]()
    reported = len(work.recovered)
    while len(failed) < TWICE:
        try:
            actions = _drive_block(work, scenes, room)
        except LostError as error:
            failed.append(error)
            work.history.lost -= len(work.failures) - before
            del work.failures[before:], work.recovered[reported:]
        else:
            work.recovered.extend(failed)
            work.history.finished |= bool(np.isin(work.runs.results.verdict[rows], ENDS).any())
            return _Block(actions, work.runs.copied())
    if len(rows) <= 1:
        return _lost(work, scenes, rows, failed[-1])
    halves = [_patiently(work, _only(scenes, part)) for part in np.array_split(rows, 2)]
    if len(work.failures) == before:
        work.recovered.append(failed[-1])
    chosen = np.isin(np.arange(len(scenes)), np.array_split(rows, 2)[0])
    return _Block(
        _either(chosen, halves[0].actions, halves[1].actions),
        tuple(_either(chosen, one, other) for one, other in zip(halves[0].results, halves[1].results, strict=True)),
    )


def _lost(work: _Work, scenes: Scenes, rows: Ints, error: ControllerError) -> _Block:
    """Return the block whose scenes `rows` are lost to a controller's error, with the verdict CONTROLLER."""
    work.history.lost += len(rows)
    if work.history.should_abort:
        raise error
    runs = work.runs
    work.failures.extend(error.at(_place(runs, scenes, slot)) for slot in rows.tolist())
    results = empty_results(runs.program, requested(runs.program, coasting(runs.program, scenes)), runs.measures)
    results.verdict[rows] = Verdict.CONTROLLER
    blank = cast("tuple[NDArray[Any], ...]", tuple(results))
    return _Block(np.zeros((len(runs), runs.turns, runs.numbers)), blank)


def _place(runs: ParallelRuns, scenes: Scenes, slot: int) -> str:
    """Return the scene and the time of a slot in words."""
    scene, when = scene_in_words(scenes.keys[slot]), f"at {runs.times[slot]:.2f} s"
    return f"in {scene} {when}" if scene else when


def _only(scenes: Scenes, rows: Ints) -> Scenes:
    """Return the same block with only the scenes `rows` to be driven; other valid scenes rest."""
    verdict = np.full(len(scenes), RESTING, dtype=np.int32)
    verdict[rows] = scenes.verdict[rows]
    return replace(scenes, verdict=np.where(scenes.valid, verdict, scenes.verdict).astype(np.int32))


def _either(chosen: Bools, one: NDArray[Any], other: NDArray[Any]) -> NDArray[Any]:
    return np.where(chosen.reshape(-1, *[1] * (one.ndim - 1)), one, other)


def _drive_block(work: _Work, scenes: Scenes, room: Floats | None) -> Floats:
    """Return the decisions in a block, slot by slot (see `ParallelRuns.decided`)."""
    runs, every = work.runs, np.arange(len(work.runs))
    runs.place(every, scenes)
    rows = np.flatnonzero(scenes.valid)
    for seat in work.seats:
        seat.reset(rows, scenes.keys[rows])
    runs.step()
    while runs.running.any():
        times = runs.times
        for number, seat in enumerate(work.seats):
            queried = runs.asked(number)
            if queried.any():
                seen = runs.observe(number, queried)
                _decide(work, number, scenes, queried, query_with_retries(seat, seen, queried, times))
        runs.step()
    return runs.decided(every, room)


def _decide(work: _Work, number: int, scenes: Scenes, queried: Bools, answer: Answer) -> None:
    """Apply the decisions of a control to its slots; slots without an action that can be driven are lost, all others go
    on.

    Raises:
        ControllerError: no action can be driven, and none ever could.
    """
    control, history = work.seats[number].control, work.history
    if answer.recovered is not None:
        work.recovered.append(answer.recovered)
    wrong = np.isin(np.arange(len(queried)), list(answer.lost)) if answer.lost else np.zeros_like(queried)
    actions, undrivable = settled(control, answer.actions, queried & ~wrong)
    if undrivable is not None:
        wrong |= undrivable
    elif not answer.lost:
        work.runs.decide(number, queried, actions)
        history.answered.add(number)
        return
    failures = [
        (answer.lost.get(slot) or fault_of(control, actions[slot])).at(_place(work.runs, scenes, slot))
        for slot in np.flatnonzero(wrong).tolist()
    ]
    history.lost += len(failures)
    if not np.array_equal(wrong, queried):
        history.answered.add(number)
    elif number not in history.answered and history.should_abort:
        first = failures[0]
        raise first.for_good() if isinstance(first, LostError) else first
    work.failures.extend(failures)
    work.runs.lose(wrong)
    work.runs.decide(number, queried & ~wrong, actions)
