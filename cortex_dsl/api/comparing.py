"""Comparison of two sides on files: paired runs, their statistics, and a search for differences. Prints nothing.

Pair i of seed S is run i of seed S (`cortex_dsl.api.seeded_runs`), whose scene both sides drive. The result of a file
depends on the file, the sides and the plan only.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from shlex import join

import numpy as np

from cortex_dsl.api.comparison_cases import SEARCHED, with_cases, without_scenes
from cortex_dsl.api.contenders import (
    NotComparableError,
    Side,
    SideKind,
    check_sides,
    check_spaces,
    contender,
    failing_scenes,
    searched_side,
    side_of,
)
from cortex_dsl.api.difference_search import search_differences, start_of
from cortex_dsl.api.limits import Budget, budget_of, probability_of
from cortex_dsl.api.pairs import Collected, PairBlock, Pairing
from cortex_dsl.api.scenario_files import ScenarioFile, scenario_files
from cortex_dsl.api.seeded_runs import (
    BLOCK,
    OnRuns,
    Prepare,
    check_seed,
    draw_scenes,
    no_run_text,
    only_scene,
    seeds_of,
)
from cortex_dsl.api.testing import results_of_files
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.comparison_report import ComparisonReport, FileComparison, FoundChange, Searched
from engine.driving.blocks import BLOCK as DRIVER_BLOCK
from engine.errors import ControllerError
from engine.gates.decision import UNDECIDED, Answer, RateDecision, decide_rate
from engine.sampling import sample
from engine.search.statistics import holm, residual_bound
from engine.tables import Floats, Ints
from engine.vocabulary import RECORDS

PAIRS = 1000
"""Pairs of a file by default."""
OnComparison = Callable[[FileComparison], None]


@dataclass(frozen=True)
class ComparisonPlan:
    """Settings of a comparison."""

    a: Side
    b: Side
    budget: Budget = field(default_factory=lambda: budget_of(PAIRS))
    seed: int = 0
    search: int = 0
    """Scenes of the search for differences; 0: none."""
    max_new: float | None = None
    scene: int | None = None
    """Seed of the only scene that is driven; None: as many as the budget says."""
    jobs: int = 1
    words: tuple[str, ...] = ()
    """Words of a command line that name settings of the drivers."""
    stems: Mapping[str, str] = field(default_factory=dict)
    """Beginning of the names of kept cases, by the path of their file; empty: no case is kept."""


def compare(
    a: str,
    b: str,
    files: str | Path | Iterable[str | Path] = (),
    *,
    budget: int | str = PAIRS,
    seed: int = 0,
    search: int = 0,
    max_new: float | None = None,
    ego_a: object = None,
    ego_b: object = None,
    block: int = DRIVER_BLOCK,
    observe: str = RECORDS,
    jobs: int = 1,
) -> ComparisonReport:
    """Compare two drivers, two versions of a file, or two searches on equal scenes.

    Args:
        a: a driver (`python:…`, `process:…`), a behavior for the ego, a file, or the folder of a search; so is `b`.
        b: see `a`.
        files: files and folders in which two drivers drive.
        budget: pairs of runs on each file, or a time for all files such as `"90s"`.
        seed: seed of the first pair.
        search: scenes of a search for differences.
        max_new: largest probability of a new failure; the runs stop as soon as they decide it.
        ego_a: driver of the controllers of a file or search, as for `Scenario.driven_by`; so is `ego_b`.
        ego_b: see `ego_a`.
        block: scenes in one query of a driver.
        observe: what drivers observe, `records` or `egocentric`.
        jobs: threads or processes; the result does not depend on it.

    Raises:
        ArgumentError: a side names nothing, or a number cannot be.
        NotComparableError: the sides cannot be compared.
        NoSuchPathError: a path does not exist, or a folder has no scenario.
        ControllerError: a driver cannot be loaded.
    """
    named = [files] if isinstance(files, str | Path) else list(files)
    plan = ComparisonPlan(
        a=side_of(a, ego_a, block, observe),
        b=side_of(b, ego_b, block, observe),
        budget=budget_of(budget),
        seed=seed,
        search=search,
        max_new=None if max_new is None else probability_of(max_new, "--max-new"),
        jobs=jobs,
    )
    return run_comparison(compared_files(plan, named), plan)


def compared_files(plan: ComparisonPlan, named: Sequence[str | Path]) -> tuple[ScenarioFile, ...]:
    """Return the files of a comparison: those that are named, or the version or run that is A.

    Raises:
        NotComparableError: the sides do not belong together.
        NoSuchPathError: a path does not exist.
    """
    check_sides(plan.a, plan.b, has_files=bool(named))
    if plan.a.kind is SideKind.VERSION:
        for side in (plan.a, plan.b):
            scenario_files([side.word])
    return scenario_files(named) if named else (ScenarioFile(Path(plan.a.word), found=False),)


def run_comparison(
    files: Sequence[ScenarioFile],
    plan: ComparisonPlan,
    on_file: OnComparison | None = None,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
) -> ComparisonReport:
    """Compare both sides on all files; `on_file` is called with each result, in the order of the files.

    A KeyboardInterrupt ends the comparison with the pairs that are done.

    Raises:
        ArgumentError: the seed cannot be.
        WorkersLostError: a worker process was killed.
    """
    check_seed(plan.seed)
    started, results = time.monotonic(), list[FileComparison]()
    try:
        for result in results_of_files(compare_file, files, plan, started, on_runs, prepare):
            results.append(result)
            if on_file is not None:
                on_file(result)
            if result.interrupted:
                break
    except KeyboardInterrupt:
        pass
    return ComparisonReport(
        a=plan.a.word,
        b=plan.b.word,
        files=tuple(_corrected(results)),
        seed=plan.seed,
        budget=plan.budget.text,
        timed=math.isfinite(plan.budget.seconds),
        command=join(_command(plan, [file.path for file in files], whole=True)),
        not_run=len(files) - len(results),
        seconds=time.monotonic() - started,
    )


def _command(plan: ComparisonPlan, paths: Sequence[Path], *, whole: bool) -> list[str]:
    """Return the words of the command of a comparison, or without `whole` those before `--scene N`."""
    drivers = plan.a.kind not in (SideKind.VERSION, SideKind.RUN)
    words = ["cortexc", "compare", plan.a.word, plan.b.word, *(as_argument(path) for path in paths if drivers)]
    if not drivers:
        sides = (("--ego-a", plan.a), ("--ego-b", plan.b))
        words += [word for flag, side in sides for name in _egos(side) for word in (flag, name)]
    words += plan.words
    if not whole:
        return words
    if plan.scene is not None:
        return [*words, "--scene", str(plan.scene)]
    options = {"--budget": plan.budget.text, "--seed": plan.seed or None, "--search": plan.search or None}
    options["--max-new"] = plan.max_new
    return [*words, *(word for flag, value in options.items() if value is not None for word in (flag, f"{value}"))]


def _egos(side: Side) -> list[str]:
    """Return the names of the drivers of a side."""
    return [word for flag, word in zip(side.driver_words, side.driver_words[1:], strict=False) if flag == "--ego"]


def _corrected(files: Sequence[FileComparison]) -> list[FileComparison]:
    """Return the results with Holm's p of each family of conditions, over all files that have a test."""
    tested = [(number, row) for number, file in enumerate(files) if not file.untested for row in file.conditions]
    found: dict[tuple[int, str, str], float] = {}
    for kind in {row.kind for _, row in tested}:
        members = [(number, row) for number, row in tested if row.kind is kind]
        values = holm([row.table.p for _, row in members])
        found |= {(number, row.name, kind): p for (number, row), p in zip(members, values, strict=True)}
    return [
        replace(
            file,
            conditions=tuple(
                replace(row, p_holm=found.get((number, row.name, row.kind), math.nan)) for row in file.conditions
            ),
        )
        for number, file in enumerate(files)
    ]


# -- one file ----------------------------------------------------------------------------------------------------------


def compare_file(
    file: ScenarioFile,
    plan: ComparisonPlan,
    seconds: float = np.inf,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
) -> FileComparison:
    """Return the result of one file, of as many pairs as its budget or `seconds` allow.

    Raises:
        UnreadableFileError: the file cannot be read.
    """
    started = time.monotonic()
    result = FileComparison(str(file.path), seed=plan.seed, limit=plan.max_new)
    try:
        result = _comparing(file, plan, result, prepare).finished(started + seconds, on_runs)
    except CompileError as error:
        result = replace(result, error=error, source=error.source, diagnostics=tuple(error.diagnostics))
    except (ControllerError, NotComparableError) as error:
        result = replace(result, refusal=str(error))
    return replace(result, seconds=time.monotonic() - started)


def _in_turn(found: Sequence[tuple[Floats, Ints]]) -> tuple[Floats, Ints]:
    """Return the genomes (n, d) and keys (n, 6) of the failures of all searches in turn, each scene once."""
    genomes, keys = (np.concatenate(parts) for parts in zip(*found, strict=True))
    turns = np.argsort(np.concatenate([np.arange(len(each)) for _, each in found]), kind="stable")
    genomes, keys = genomes[turns], keys[turns]
    scenes = np.hstack([np.ascontiguousarray(genomes, dtype=np.float64).view(np.int64), keys])
    first = np.sort(np.unique(scenes, axis=0, return_index=True)[1])
    return genomes[first], keys[first]


def _comparing(
    file: ScenarioFile, plan: ComparisonPlan, result: FileComparison, prepare: Prepare | None
) -> "_Comparing":
    """Return the comparison of a file, whose sides fit.

    Raises:
        CompileError: a file has errors.
        NotComparableError, ControllerError: the sides cannot be compared.
    """
    if plan.a.kind is SideKind.RUN:
        searched = searched_side(plan.a), searched_side(plan.b)
        sides = [each.contender for each in searched]
        check_spaces(*(side.program for side in sides))
        found = [failing_scenes(each.run) for each in searched]
        failures = _Failures(*_in_turn(found), found[0][0])
        result = replace(result, path=f"{plan.a.word}, {plan.b.word}", drawn=False)
    else:
        own = plan.a.kind is SideKind.VERSION
        sides = [contender(side, Path(side.word) if own else file.path) for side in (plan.a, plan.b)]
        check_spaces(*(side.program for side in sides))
        failures = None
    if prepare is not None:
        for side in sides:
            prepare(side.scenario)
    shown = tuple(each for each in sides[1].scenario.compiled.diagnostics if each.severity is not Severity.HINT)
    result = replace(
        result,
        digests=(sides[0].program.digest, sides[1].program.digest),
        source=sides[1].scenario.compiled.source if shown else None,
        diagnostics=shown,
        actors=sides[0].program.actors,
    )
    words = () if failures is not None else _command(plan, [file.path], whole=False)
    return _Comparing(file.path, Pairing(sides[0], sides[1], plan.jobs, words), plan, result, failures)


@dataclass(frozen=True)
class _Failures:
    """Scenes that two searches found."""

    genomes: Floats
    keys: np.ndarray
    of_a: Floats
    """Genomes of the failures of A."""


class _Comparing:
    """Pairs of runs on one file."""

    def __init__(
        self, path: Path, pairing: Pairing, plan: ComparisonPlan, result: FileComparison, failures: _Failures | None
    ) -> None:
        self.path = path
        self.pairing, self.plan, self.failures = pairing, plan, failures
        self.kept = failures is None and pairing.alone
        self.found = Collected(pairing)
        self.decision = UNDECIDED
        remarks = (*(remark for side in pairing.sides for remark in side.remarks), *pairing.only_in_one)
        self.result = replace(result, kept=self.kept, remarks=remarks)

    def finished(self, until: float, on_runs: OnRuns | None) -> FileComparison:
        """Return the result after all pairs; `until` is the time at which they end, by the monotonic clock [s].

        Raises:
            CompileError: a run met a mistake of a file.
            ControllerError: a driver fails everywhere.
        """
        plan, found = self.plan, self.found
        budget = self._most()
        searched = None
        try:
            while found.pairs < budget and self.decision.answer is Answer.OPEN:
                if found.pairs and time.monotonic() >= until:
                    break
                self._take(self._block(min(BLOCK, budget - found.pairs)))
                if on_runs is not None:
                    on_runs(found.pairs, budget + plan.search)
                if not found.valid and self.failures is None and not self.found.lost:
                    break
            if plan.search and len(self.pairing.a.program.space) and (found.valid or self.failures is not None):
                start = start_of(found, None if self.failures is None else self.failures.of_a)
                searched = search_differences(self.pairing, start, plan.search, plan.seed)
        except KeyboardInterrupt:
            self.result = replace(self.result, interrupted=True)
        if searched is not None and searched.stopped:
            self.result = replace(self.result, interrupted=True)
        return self._result(searched)

    def _most(self) -> int:
        """Return the largest number of pairs."""
        if self.kept or self.plan.scene is not None:
            return 1
        return self.plan.budget.runs if self.failures is None else min(self.plan.budget.runs, len(self.failures.keys))

    def _block(self, count: int) -> PairBlock:
        """Draw and run the next pairs.

        Raises:
            CompileError: a run met a mistake of a file.
            ControllerError: a driver fails everywhere.
        """
        first, scenario, jobs = self.found.pairs, self.pairing.a.scenario, self.plan.jobs
        numbers = np.arange(first + 1, first + count + 1)
        if self.failures is not None:
            rows = slice(first, first + count)
            genomes, keys = self.failures.genomes[rows], self.failures.keys[rows]
            return self.pairing.run(
                numbers, None, sample(scenario.program, genomes, keys, scenario.config.simulation, jobs)
            )
        if self.kept:
            return self.pairing.run(numbers, None, only_scene(scenario))
        scene = self.plan.scene
        seeds = seeds_of(self.plan.seed, numbers) if scene is None else np.array([scene])
        scenes = draw_scenes(scenario, seeds, jobs, hopeful=self.found.valid > 0)
        return self.pairing.run(numbers, seeds, scenes)

    def _take(self, block: PairBlock) -> None:
        """Add the pairs of a block; the first block is driven twice."""
        if not self.found.pairs:
            repeats = self.pairing.driven_otherwise(block)
            self.result = replace(self.result, repeats=repeats, repeated=len(block.numbers))
        self.found.take(block)
        if self.plan.max_new is not None:
            self.decision = decide_rate(self.found.new, self.found.valid, self.plan.max_new)

    def _result(self, searched: Searched | None) -> FileComparison:
        found, result = self.found, self.result
        remarks = list(result.remarks)
        if found.otherwise:
            remarks.append(f"{found.otherwise:,} of {found.valid:,} scenes begin otherwise for B than for A")
        for label, side in zip("AB", self.pairing.sides, strict=True):
            remarks += [f"the driver of {label} does not observe {feature}" for feature in side.unobserved]
        if self.plan.search and not len(self.pairing.a.program.space):
            remarks.append("there is nothing to search: the file has no params")
        result = replace(
            result,
            pairs=found.pairs,
            valid=found.valid,
            conditions=found.conditions if found.valid else (),
            changes=self._with_cases(found.changes, ""),
            lost_by_b=found.lost_by_b,
            decision=self._decision(),
            searched=searched and replace(searched, changes=self._with_cases(searched.changes, SEARCHED)),
            not_run=found.not_run,
            remarks=tuple(remarks),
            table=found.table,
            no_scene=self._no_scene(),
        )
        bounded = result.deterministic and result.drawn and not self.kept and found.valid and not found.new
        bounded = bounded and self.plan.max_new is None  # else the number of pairs depends on their results
        return replace(result, residual=residual_bound(found.valid) if bounded else None)

    def _with_cases(self, changes: Sequence[FoundChange], more: str) -> tuple[FoundChange, ...]:
        """Return changes with their files, if the plan has names for them."""
        if (stem := self.plan.stems.get(str(self.path))) is not None:
            changes = with_cases(self.pairing, changes, stem + more)
        return without_scenes(changes)

    def _decision(self) -> RateDecision | None:
        return None if self.plan.max_new is None else self.decision

    def _no_scene(self) -> str:
        """Return the reason why no pair counts; "" if one does, if a driver failed, or if no search failed."""
        found = self.found
        if found.valid or self.found.lost or self.failures is not None or not found.pairs:
            return ""
        return no_run_text(self.pairing.a.program, found.last)
