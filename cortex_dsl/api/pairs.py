"""Pairs of runs: scenes that both sides of a comparison drive, the conditions that each run breaks, and the changes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from shlex import join
from typing import Any

import numpy as np

from cortex_dsl.api.contenders import Contender
from cortex_dsl.api.seeded_runs import check_mistake, drive, end_numbers, touched
from cortex_dsl.report.findings.comparison_report import (
    Change,
    Condition,
    ConditionKind,
    Example,
    FoundChange,
    NotRun,
    RunNumbers,
)
from cortex_dsl.report.findings.failures import BLAMES, kind_text
from cortex_dsl.report.findings.gate_report import Measured
from engine.assessment import take
from engine.dependence import leaves_nothing_to_chance
from engine.driving.blocks import Driven
from engine.gates.paired import PairTable, pair_table
from engine.outcomes import Assessment, Outcomes
from engine.program import Program
from engine.risk import PROFILES, assess
from engine.sampling import sample
from engine.scenes import Scenes
from engine.search.evaluator import assessment
from engine.search.insight.kinds import codes, kind_of
from engine.streams import format_key, format_keys
from engine.tables import Bools, Floats, Ints
from engine.verdicts import blame
from engine.vocabulary import Blame, Column, Sense, Verdict

CONTACT, AVOIDABLE = "contact of the ego", "avoidable contact"
REASONS = {
    Verdict.INFEASIBLE: "no scene",
    Verdict.EXHAUSTED: "no scene",
    Verdict.ABORTED: "a requirement on the run was broken",
    Verdict.CONTROLLER: "the driver failed",
}
"""Reasons why a run of a pair does not count."""

Failure = tuple[tuple[str, ...], tuple[int, ...] | str | None]
"""Kind of a failing run: names of its broken conditions, and the code of its contact (`Kind`), `building` or None."""


@dataclass(frozen=True)
class SideRuns:
    """Driven scenes of one side, and what they broke."""

    done: Driven
    runs: Assessment
    """Arrays (n, …)."""
    blame: Ints
    """(n,) `Blame`"""
    broken: Bools
    """(n, conditions)"""
    values: Floats
    """(n, conditions) Robustness of each `expect`, negative if it is broken; of contacts minus the continuous risk."""
    codes: Ints
    """(n, 6) Kind of each contact (`engine.search.insight.kinds.codes`)."""

    @property
    def outcomes(self) -> Outcomes:
        return self.done.outcomes

    @property
    def valid(self) -> Bools:
        return np.equal(self.outcomes.verdict, Verdict.VALID)


@dataclass(frozen=True)
class PairBlock:
    """Scenes that both sides drove, in a row."""

    numbers: Ints
    """(n,) Numbers of the pairs, from 1."""
    seeds: Ints | None
    a: SideRuns
    b: SideRuns

    @property
    def valid(self) -> Bools:
        return self.a.valid & self.b.valid


class Pairing:
    """Both sides on one file."""

    def __init__(self, a: Contender, b: Contender, jobs: int, pair_command: Sequence[str] = ()) -> None:
        self.a, self.b, self.jobs = a, b, jobs
        self.pair_command = tuple(pair_command)
        """Words of the command that repeats the pair of a seed, without the seed; (): there is none."""
        self.same = a.program.digest == b.program.digest
        """True if one scene serves both."""
        self.names, self.kinds, self._columns = _conditions(a.program, b.program)
        self.base = np.array([kind is not ConditionKind.AVOIDABLE for kind in self.kinds])
        """(conditions,) True for those whose breach is a failure; an avoidable contact is a contact already."""

    @property
    def sides(self) -> tuple[Contender, Contender]:
        return self.a, self.b

    @property
    def only_in_one(self) -> tuple[str, ...]:
        """Return a remark for each `expect` that only one side has."""
        expects = [_expects(side.program) for side in self.sides]
        return tuple(
            f"the `expect` {name} is in {label} only and is not compared"
            for label, own, others in (("A", *expects), ("B", *reversed(expects)))
            for name in own
            if name not in others
        )

    # -- runs

    def run(self, numbers: Ints, seeds: Ints | None, scenes: Scenes) -> PairBlock:
        """Let both sides drive scenes of A, and judge the runs.

        Raises:
            CompileError: a run met a mistake of a file.
            ControllerError: a driver fails everywhere.
        """
        theirs = scenes if self.same else self._resampled(scenes)
        one, other = (
            self._judged(side, drawn, k) for k, (side, drawn) in enumerate(((self.a, scenes), (self.b, theirs)))
        )
        return PairBlock(numbers, seeds, one, other)

    def _resampled(self, scenes: Scenes) -> Scenes:
        """Return the scenes of B with the genomes and keys of scenes of A."""
        scenario = self.b.scenario
        return sample(scenario.program, scenes.genomes, scenes.keys, scenario.config.simulation, self.jobs)

    def _judged(self, side: Contender, scenes: Scenes, number: int) -> SideRuns:
        program, config = side.program, side.scenario.config
        done = drive(side.scenario, side.driver, scenes, self.jobs)
        check_mistake(side.scenario, done, program.name)
        outcomes = done.outcomes
        risk = assess(outcomes, PROFILES["paper"])
        runs = assessment(done.scenes, outcomes, risk)
        said = np.full(len(outcomes), int(Blame.NONE), dtype=np.int32)
        hit = np.flatnonzero(outcomes.collided & (outcomes.verdict == Verdict.VALID))
        if len(hit):
            struck, references = take(done.scenes, hit), config.search.references
            said[hit] = blame(program, struck, config.simulation, config.contact, self.jobs, references)
        columns = [each[number] for each in self._columns]
        contact = touched(outcomes)[:, np.newaxis]
        broken = np.concatenate(
            [outcomes.broken[:, columns] == 1.0, contact, said[:, np.newaxis] == Blame.AVOIDABLE], 1
        )
        danger = -np.nan_to_num(runs.continuous)[:, np.newaxis]
        values = np.concatenate([outcomes.sought[:, columns], danger, danger], 1)
        return SideRuns(done, runs, said, broken, values, codes(runs, said))

    def driven_otherwise(self, block: PairBlock) -> tuple[int, int]:
        """Return the number of scenes that A and B drive otherwise if they drive them again."""
        return _otherwise(self.a, block.a, self.jobs), _otherwise(self.b, block.b, self.jobs)

    # -- failures

    def failure(self, judged: SideRuns, row: int) -> Failure | None:
        """Return the kind of a failing run; None if it does not fail."""
        names = tuple(
            name
            for name, broken, base in zip(self.names, judged.broken[row], self.base, strict=True)
            if broken and base
        )
        if not names:
            return None
        outcomes = judged.outcomes
        if outcomes.collided[row]:
            return names, tuple(judged.codes[row].tolist())
        return names, "building" if CONTACT in names else None

    def failure_text(self, failure: Failure | None, program: Program) -> str:
        """Return a failure in words."""
        if failure is None:
            return ""
        names, code = failure
        expects = [f"`{name}` is broken" for name in names if name != CONTACT]
        if isinstance(code, tuple):
            kind = kind_of(*code)
            expects.insert(0, f"contact: {kind_text(program.actors, kind)}; {BLAMES[kind.blame][0]}")
        elif code is not None:
            expects.insert(0, f"contact: {program.actors[0]} and a {code}")
        return "; ".join(expects)

    def example(self, block: PairBlock, row: int) -> Example:
        """Return the numbers of both runs of a pair."""
        scenes = block.a.done.scenes
        seed = None if block.seeds is None else int(block.seeds[row])
        params = dict(zip(self.a.program.space.names, scenes.genomes[row].tolist(), strict=True))
        rows = np.array([row])
        drawn = tuple(take(judged.done.scenes, rows) for judged in (block.a, block.b))
        a, b = (
            self._run_numbers(side, judged, row, self._replay(side, judged, row, seed))
            for side, judged in zip(self.sides, (block.a, block.b), strict=True)
        )
        return Example(int(block.numbers[row]), seed, format_key(scenes.keys[row]), params, a, b, drawn)

    def _run_numbers(self, side: Contender, judged: SideRuns, row: int, replay: str) -> RunNumbers:
        event, numbers = end_numbers(side.program, judged.outcomes, row)
        robustness = (
            Measured(f"robustness of {name}", float(judged.values[row, column]))
            for column, (name, kind) in enumerate(zip(self.names, self.kinds, strict=True))
            if kind is ConditionKind.EXPECT
        )
        return RunNumbers(event, (*numbers, *robustness), replay)

    def _replay(self, side: Contender, judged: SideRuns, row: int, seed: int | None) -> str:
        """Return the command that repeats a run, or both runs of the pair; "" without one."""
        if seed is None and not self.alone:
            return ""
        if side.command and (side is self.a or self.same or _is_single(side, judged.done.scenes, row, seed)):
            words = () if seed is None else ("--seed", str(seed))
            return join(("cortexc", side.command[0], *words, *side.command[1:]))
        scene = () if seed is None else ("--scene", str(seed))
        return join((*self.pair_command, *scene)) if self.pair_command else ""

    @cached_property
    def alone(self) -> bool:
        """Return True if there is one pair only, without a seed."""
        return all(leaves_nothing_to_chance(side.program) for side in self.sides)


def _is_single(side: Contender, scenes: Scenes, row: int, seed: int | None) -> bool:
    """Return True if a scene is that of a seed; another genome may be the first that allows one."""
    single = side.scenario.scene_of_seed(seed)
    pairs = (single.genomes[0], scenes.genomes[row]), (single.keys[0], scenes.keys[row])
    return all(np.array_equal(one, other) for one, other in pairs)


def _expects(program: Program) -> dict[str, int]:
    """Return the names of the `expect`s with their columns."""
    found = enumerate(program.judged.objectives)
    return {each.name: column for column, each in found if each.sense is Sense.EXPECT}


def _conditions(
    a: Program, b: Program
) -> tuple[tuple[str, ...], tuple[ConditionKind, ...], tuple[tuple[int, int], ...]]:
    """Return names and kinds of the conditions, and the columns of their `expect`s in A and B; contacts are last."""
    own, theirs = _expects(a), _expects(b)
    names = [name for name in own if name in theirs]
    kinds = (*(ConditionKind.EXPECT for _ in names), ConditionKind.CONTACT, ConditionKind.AVOIDABLE)
    return (*names, CONTACT, AVOIDABLE), kinds, tuple((own[name], theirs[name]) for name in names)


def _otherwise(side: Contender, judged: SideRuns, jobs: int) -> int:
    """Return the number of scenes that a driver drives otherwise if it drives them again."""
    if side.driver is None:
        return 0
    scenes = judged.done.scenes
    again = drive(side.scenario, side.driver, replace(scenes, actions=np.zeros((len(scenes), 0, 0))), jobs)
    same = again.outcomes.verdict == judged.outcomes.verdict
    rows = np.flatnonzero(scenes.valid)
    same[rows] &= (again.scenes.actions[rows] == scenes.actions[rows]).all(axis=(1, 2))
    return int((~same).sum())


# -- all pairs ---------------------------------------------------------------------------------------------------------


@dataclass
class _Found:
    """Pairs with one change so far."""

    a: str
    b: str
    example: Example
    count: int = 0


@dataclass
class Collected:
    """All pairs of a file so far."""

    pairing: Pairing
    pairs: int = 0
    valid: int = 0
    new: int = 0
    """Pairs with a new failure."""
    lost: bool = False
    """True if a driver failed in some pair."""
    lost_by_b: int = 0
    otherwise: int = 0
    """Pairs whose scenes differ at the start."""
    last: Verdict = Verdict.VALID
    """Verdict of the last scene of A that does not count, else of B."""
    tables: list[PairTable] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)
    """(n, 2, conditions) Values of the pairs that count, of A and B."""
    genomes: list[Floats] = field(default_factory=list)
    """(n, d) Genomes of the pairs that count."""
    failed_a: list[Bools] = field(default_factory=list)
    """(n,) True for those in which A fails."""
    parts: list[dict[str, list[Any]]] = field(default_factory=list)
    """Columns of the table of pairs, block by block."""
    _changes: dict[tuple[Change, Failure | None, Failure | None], _Found] = field(default_factory=dict)
    _not_run: dict[tuple[str, str], tuple[int, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tables = [PairTable() for _ in self.pairing.names]

    def take(self, block: PairBlock) -> Bools:
        """Add the pairs of a block; return (n,) True for those with a new, cured or moved failure."""
        valid, (a, b) = block.valid, (block.a, block.b)
        self.pairs += len(valid)
        self.valid += int(valid.sum())
        self._count_lost(block)
        for column, table in enumerate(self.tables):
            self.tables[column] = table + pair_table(a.broken[valid, column], b.broken[valid, column])
        self.values.append(np.stack([a.values[valid], b.values[valid]], axis=1))
        self.genomes.append(a.done.scenes.genomes[valid])
        self.failed_a.append(np.asarray(a.broken[valid].any(axis=1)))
        self.otherwise += 0 if self.pairing.same else int((valid & ~_starts_alike(self.pairing, a, b)).sum())
        changes = self._take_changes(block)
        self.parts.append(_columns(self.pairing, block, changes))
        return np.array([change not in (None, Change.KEPT) for change in changes], dtype=bool)

    def _count_lost(self, block: PairBlock) -> None:
        """Count the pairs in which a run does not count."""
        verdicts = [each.outcomes.verdict for each in (block.a, block.b)]
        self.lost = self.lost or any(bool((verdict == Verdict.CONTROLLER).any()) for verdict in verdicts)
        self.lost_by_b += int(((verdicts[1] == Verdict.CONTROLLER) & (verdicts[0] == Verdict.VALID)).sum())
        reasons = [_reasons(each) for each in (block.a, block.b)]
        for row in np.flatnonzero(~block.valid).tolist():
            one, other = (each.get(row, "") for each in reasons)
            self.last = Verdict(int(verdicts[0][row] or verdicts[1][row]))
            both = (
                [("A and B", one)] if one == other else [(side, why) for side, why in (("A", one), ("B", other)) if why]
            )
            for key in both:
                count, first = self._not_run.get(key, (0, int(block.numbers[row])))
                self._not_run[key] = (count + 1, first)

    def _take_changes(self, block: PairBlock) -> list[Change | None]:
        """Return the change of each pair, None where both keep all conditions or a run does not count."""
        a, b = block.a, block.b
        changes: list[Change | None] = [None] * len(block.numbers)
        is_new: Bools = np.asarray((b.broken & ~a.broken).any(axis=1))
        is_cured: Bools = ~np.asarray(b.broken.any(axis=1))
        for row in np.flatnonzero(block.valid & (a.broken | b.broken).any(axis=1)).tolist():
            failures = [self.pairing.failure(judged, row) for judged in (a, b)]
            same = Change.KEPT if failures[0] == failures[1] else Change.MOVED
            changes[row] = change = Change.NEW if is_new[row] else Change.CURED if is_cured[row] else same
            self.new += change is Change.NEW
            self._add(change, failures, block, row)
        return changes

    def _add(self, change: Change, failures: Sequence[Failure | None], block: PairBlock, row: int) -> None:
        """Count a change; a new failure is described by B alone, a cured one by A alone."""
        key = (change, None if change is Change.NEW else failures[0], None if change is Change.CURED else failures[1])
        if key not in self._changes:
            a, b = (
                self.pairing.failure_text(failure, side.program)
                for failure, side in zip(failures, self.pairing.sides, strict=True)
            )
            self._changes[key] = _Found(a, b, self.pairing.example(block, row))
        self._changes[key].count += 1

    # -- results

    @property
    def changes(self) -> tuple[FoundChange, ...]:
        """Return the changes: sort by sort, the most frequent kinds first."""
        order = list(Change)
        found = [FoundChange(key[0], each.a, each.b, each.count, each.example) for key, each in self._changes.items()]
        return tuple(sorted(found, key=lambda each: (order.index(each.change), -each.count, each.example.number)))

    @property
    def not_run(self) -> tuple[NotRun, ...]:
        found = (NotRun(side, why, *numbers) for (side, why), numbers in self._not_run.items())
        return tuple(sorted(found, key=lambda each: (-each.count, each.side, each.reason)))

    @property
    def conditions(self) -> tuple[Condition, ...]:
        rows = zip(self.pairing.names, self.pairing.kinds, self.tables, strict=True)
        return tuple(Condition(name, kind, table) for name, kind, table in rows)

    @property
    def table(self) -> dict[str, list[Any]]:
        """Return the columns of the table of pairs."""
        names = self.parts[0] if self.parts else {}
        return {name: [value for part in self.parts for value in part[name]] for name in names}


def _starts_alike(pairing: Pairing, a: SideRuns, b: SideRuns) -> Bools:
    """Return (n,) True for pairs whose actors start alike."""
    if len(pairing.a.program.actors) != len(pairing.b.program.actors):
        return np.zeros(len(a.outcomes), dtype=bool)
    columns = len(pairing.a.program.actors) * len(Column)
    one, other = (each.done.scenes.values[:, :columns] for each in (a, b))
    return ((one == other) | (np.isnan(one) & np.isnan(other))).all(axis=1)


def _reasons(judged: SideRuns) -> dict[int, str]:
    """Return the reason of each run that does not count, by its row."""
    verdict = judged.outcomes.verdict
    reasons = {row: REASONS[Verdict(int(verdict[row]))] for row in np.flatnonzero(verdict != Verdict.VALID).tolist()}
    lost = np.flatnonzero(verdict == Verdict.CONTROLLER).tolist()
    if lost and len(judged.done.failures) == len(lost):
        said = sorted(judged.done.failures, key=lambda failure: failure.message)
        kinds = list(dict.fromkeys(failure.kind for failure in said))
        text = kinds[0] if len(kinds) == 1 else f"{kinds[0]}, and {len(kinds) - 1} other failures"
        reasons |= dict.fromkeys(lost, f"{REASONS[Verdict.CONTROLLER]}: {text}")
    return reasons


MEASURES = ("end_time", "min_distance", "continuous")
"""Numbers of each run in the table of pairs: results of `engine.assessment`."""


def _columns(pairing: Pairing, block: PairBlock, changes: Sequence[Change | None]) -> dict[str, list[Any]]:
    """Return the columns of some pairs."""
    scenes = block.a.done.scenes
    seeds: list[Any] = [None] * len(block.numbers) if block.seeds is None else block.seeds.tolist()
    columns: dict[str, list[Any]] = {
        "pair": block.numbers.tolist(),
        "seed": seeds,
        "key": format_keys(scenes.keys),
        **{
            f"param_{name}": scenes.genomes[:, gene].tolist() for gene, name in enumerate(pairing.a.program.space.names)
        },
        "change": ["" if change is None else change.value for change in changes],
    }
    for label, judged in (("a", block.a), ("b", block.b)):
        columns[f"verdict_{label}"] = [Verdict(code).name.lower() for code in judged.outcomes.verdict.tolist()]
        columns |= {f"{name}_{label}": getattr(judged.runs, name).tolist() for name in MEASURES}
        columns |= {f"{name}_{label}": values for name, values in _condition_columns(pairing, judged)}
    return columns


def _condition_columns(pairing: Pairing, judged: SideRuns) -> Iterator[tuple[str, list[Any]]]:
    """Yield the columns of each condition: broken 1, kept 0, NaN for a run that does not count; and the robustness."""
    words = {CONTACT: "contact", AVOIDABLE: "avoidable"}
    for column, (name, kind) in enumerate(zip(pairing.names, pairing.kinds, strict=True)):
        broken = np.where(judged.valid, judged.broken[:, column].astype(np.float64), np.nan)
        yield words.get(name, f"broken_{name}"), broken.tolist()
        if kind is ConditionKind.EXPECT:
            yield f"robustness_{name}", np.where(judged.valid, judged.values[:, column], np.nan).tolist()
