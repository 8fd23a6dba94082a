"""Test of one scenario file: its runs, the limits that they break, and the first run that breaks each.

A file that leaves nothing to chance is run once, any other file with successive seeds (`cortex_dsl.api.seeded_runs`).
"""

import os
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from shlex import join

import numpy as np

from cortex_dsl.api.limits import BUDGET, Budget, budget_of
from cortex_dsl.api.scenario import Scenario, load
from cortex_dsl.api.scenario_files import ScenarioFile
from cortex_dsl.api.seeded_runs import (
    BLOCK,
    NO_CONTACT,
    OnRuns,
    Prepare,
    check_mistake,
    draw_scenes,
    drive,
    end_numbers,
    fitting_driver,
    no_run_text,
    only_scene,
    seeds_of,
    touched,
)
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.gate_report import Check, FailedRun, FileResult, Kind, Measured, Status
from engine.config import Config
from engine.dependence import leaves_nothing_to_chance
from engine.driving.blocks import Driven, Driver
from engine.errors import ControllerError
from engine.gates.bounds import Bound, bounded_values
from engine.gates.decision import UNDECIDED, Answer, RateDecision, decide_rate
from engine.outcomes import Outcomes
from engine.program import Program
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Sense, Verdict

CONTROLLER = "controller"


@dataclass(frozen=True)
class GatePlan:
    """Settings of a test."""

    budget: Budget = field(default_factory=lambda: budget_of(BUDGET))
    seed: int = 0
    allow_collisions: bool = False
    bounds: tuple[Bound, ...] = ()
    max_probability: float | None = None
    of: str | None = None
    """Name of the `expect` whose probability is limited; None: contacts of the ego."""
    undecided_passes: bool = False
    driver: Driver | None = None
    replay: tuple[str, ...] = ()
    """Words of a replay command that name the driver."""
    jobs: int = 1


def check_file(
    file: ScenarioFile,
    plan: GatePlan,
    seconds: float = np.inf,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
) -> FileResult:
    """Return the result of one file, of as many runs as its budget or `seconds` allow.

    Raises:
        UnreadableFileError: the file cannot be read.
    """
    started = time.monotonic()
    result = FileResult(str(file.path), seed=plan.seed, found=file.found)
    try:
        scenario = load(file.path)
        compiled = scenario.compiled
        shown = tuple(each for each in compiled.diagnostics if each.severity is not Severity.HINT)
        result = replace(
            result,
            digest=scenario.program.digest,
            imports=_imports(scenario),
            source=compiled.source if shown else None,
            diagnostics=shown,
        )
        if prepare is not None:
            prepare(scenario)
        result = _Testing(scenario, plan, result).finished(started + seconds, on_runs)
    except CompileError as error:
        result = replace(result, error=error, source=error.source, diagnostics=tuple(error.diagnostics))
    except ControllerError as error:
        result = replace(result, no_driver=str(error))
    return replace(result, seconds=time.monotonic() - started)


def _imports(scenario: Scenario) -> tuple[str, ...]:
    return tuple(sorted({os.path.realpath(file.name) for file in scenario.compiled.source.imported}))


@dataclass(frozen=True)
class _Criterion:
    """A limit of a file: a condition that runs may break, and how often they may."""

    name: str
    kind: Kind
    """Kind of the condition: an `expect`, a contact, or a bound."""
    column: int = -1
    """Number of the `expect` among the objectives."""
    bound: Bound | None = None
    line: int = 0
    limit: float | None = None


@dataclass
class _Count:
    """Runs of a criterion so far."""

    runs: int = 0
    failures: int = 0
    first: FailedRun | None = None
    decision: RateDecision = UNDECIDED


def _criteria(program: Program, plan: GatePlan, *, kept: bool) -> tuple[_Criterion, ...]:
    """Return the limits of a file in the order of its text, bounds last.

    A probability limits one of them; the one run of a kept case is judged like any other condition.
    """
    limit = None if kept else plan.max_probability
    expects = [
        _Criterion(each.name, Kind.EXPECT, column, line=each.line, limit=limit if each.name == plan.of else None)
        for column, each in enumerate(program.judged.objectives)
        if each.sense is Sense.EXPECT
    ]
    limited = plan.max_probability is not None and plan.of is None
    contact = limited or not (expects or plan.allow_collisions)
    contacts = [_Criterion(NO_CONTACT, Kind.CONTACT, limit=limit if limited else None)] if contact else []
    return (*expects, *contacts, *(_Criterion(bound.text, Kind.BOUND, bound=bound) for bound in plan.bounds))


@dataclass(frozen=True)
class _Block:
    """Finished runs in a row."""

    numbers: Ints
    """(n,) Numbers of the runs, from 1."""
    seeds: Ints | None
    done: Driven

    @property
    def outcomes(self) -> Outcomes:
        return self.done.outcomes

    def seed(self, row: int) -> int | None:
        return None if self.seeds is None else int(self.seeds[row])


class _Testing:
    """Runs of one file, and what they broke."""

    def __init__(self, scenario: Scenario, plan: GatePlan, result: FileResult) -> None:
        self.scenario, self.plan = scenario, plan
        self.program = scenario.program
        self.kept = leaves_nothing_to_chance(self.program)
        self.criteria = _criteria(self.program, plan, kept=self.kept)
        self.counts = [_Count() for _ in self.criteria]
        self.lost = _Count()
        self.runs = self.valid = 0
        self.last = Verdict.VALID
        """Verdict of the last run that does not count."""
        self.driver = fitting_driver(self.program, plan.driver)
        unused = plan.driver is not None and not self.program.controls
        remarks = ("nobody in it is driven from outside, so that --ego has no effect",) if unused else ()
        self.result = replace(result, kept=self.kept, remarks=remarks)

    def finished(self, until: float, on_runs: OnRuns | None) -> FileResult:
        """Return the result after all runs; `until` is the time at which they end, by the monotonic clock [s].

        Raises:
            CompileError: a run met a mistake of the file.
        """
        budget = 1 if self.kept else self.plan.budget.runs
        while self.runs < budget and not self._is_settled() and (not self.runs or time.monotonic() < until):
            try:
                self._take(self._block(min(BLOCK, budget - self.runs)))
            except ControllerError as error:
                if self.driver is None:
                    raise
                self._lose(FailedRun(self.runs + 1, self._seed(self.runs), event=error.message))
                self.runs += 1
                break
            if on_runs is not None:
                on_runs(self.runs, budget)
            if not self.valid and not self.lost.runs:
                break
        return replace(self.result, runs=self.runs, valid=self.valid, checks=self._checks(), no_scene=self._no_scene())

    def _is_settled(self) -> bool:
        """Return True if further runs change nothing: every limit is on a probability, and decided."""
        return bool(self.criteria) and all(
            criterion.limit is not None and count.decision.answer is not Answer.OPEN
            for criterion, count in zip(self.criteria, self.counts, strict=True)
        )

    def _seed(self, index: int) -> int | None:
        return None if self.kept else int(seeds_of(self.plan.seed, np.array([index + 1]))[0])

    # -- runs

    def _block(self, count: int) -> _Block:
        """Draw and run the next scenes.

        Raises:
            ControllerError: the driver fails everywhere.
        """
        numbers = np.arange(self.runs + 1, self.runs + count + 1)
        if self.kept:
            seeds, scenes = None, only_scene(self.scenario)
        else:
            seeds = seeds_of(self.plan.seed, numbers)
            scenes = draw_scenes(self.scenario, seeds, self.plan.jobs, hopeful=self.valid > 0)
        return _Block(numbers, seeds, drive(self.scenario, self.driver, scenes, self.plan.jobs))

    def _take(self, block: _Block) -> None:
        """Judge the runs of a block.

        Raises:
            CompileError: a run met a mistake of the file.
        """
        check_mistake(self.scenario, block.done, self.result.path)
        verdict = block.outcomes.verdict
        valid = verdict == Verdict.VALID
        self.runs += len(verdict)
        self.valid += int(valid.sum())
        if not valid.all():
            self.last = Verdict(int(verdict[~valid][-1]))
        lost = np.flatnonzero(verdict == Verdict.CONTROLLER)
        self.lost.runs += int(valid.sum()) + len(lost)
        if len(lost):
            row = int(lost[0])
            event = block.done.failures[0].what if block.done.failures else "the driver failed"
            self._lose(FailedRun(int(block.numbers[row]), block.seed(row), event=event), len(lost))
        for criterion, count in zip(self.criteria, self.counts, strict=True):
            self._judge(criterion, count, block, valid)

    def _lose(self, first: FailedRun, count: int = 1) -> None:
        """Count runs in which the driver failed."""
        self.lost.failures += count
        self.lost.first = self.lost.first or first

    def _judge(self, criterion: _Criterion, count: _Count, block: _Block, valid: Bools) -> None:
        """Add the runs of a block to the count of a criterion; a decision on a probability stands."""
        if count.decision.answer is not Answer.OPEN:
            return
        values = self._values(criterion, block)
        broken = valid & self._broken(criterion, block, values)
        count.runs += int(valid.sum())
        count.failures += int(broken.sum())
        if count.first is None and broken.any():
            count.first = self._failed(criterion, block, int(np.flatnonzero(broken)[0]), values)
        if criterion.limit is not None:
            count.decision = decide_rate(count.failures, count.runs, criterion.limit)

    def _values(self, criterion: _Criterion, block: _Block) -> Floats | None:
        if criterion.bound is None:
            return None
        return bounded_values(criterion.bound, self.program, block.done.scenes, block.outcomes, self._config())

    def _config(self) -> Config:
        config = self.scenario.config
        return replace(config, search=replace(config.search, jobs=self.plan.jobs))

    def _broken(self, criterion: _Criterion, block: _Block, values: Floats | None) -> Bools:
        outcomes = block.outcomes
        if criterion.bound is not None and values is not None:
            return ~criterion.bound.holds(values)
        if criterion.kind is Kind.EXPECT:
            return outcomes.broken[:, criterion.column] == 1.0
        return touched(outcomes)

    def _failed(self, criterion: _Criterion, block: _Block, row: int, values: Floats | None) -> FailedRun:
        """Return the numbers of a run that breaks a criterion."""
        outcomes, numbers = block.outcomes, list[Measured]()
        if criterion.bound is not None and values is not None:
            value = float(values[row]) / criterion.bound.scale
            numbers.append(Measured(criterion.bound.name, value, criterion.bound.unit))
        elif criterion.kind is Kind.EXPECT:
            numbers.append(Measured("robustness", float(outcomes.sought[row, criterion.column])))
        event, more = end_numbers(self.program, outcomes, row)
        return FailedRun(int(block.numbers[row]), block.seed(row), (*numbers, *more), event)

    # -- results

    def _checks(self) -> tuple[Check, ...]:
        counted = zip(self.criteria, self.counts, strict=True)
        checks = [self._check(criterion, count) for criterion, count in counted] if self.valid else []
        if self.driver is not None:
            status = Status.FAIL if self.lost.failures else Status.PASS
            parts = CONTROLLER, Kind.CONTROLLER, status, self.lost.runs, self.lost.failures
            checks.append(Check(*parts, first=self.lost.first, replay=self._replay(self.lost.first)))
        return tuple(checks)

    def _check(self, criterion: _Criterion, count: _Count) -> Check:
        place, line = self._place(criterion.line)
        if criterion.limit is None:
            status = Status.FAIL if count.failures else Status.PASS
        else:
            status = OF_ANSWER[count.decision.answer]
        return Check(
            name=criterion.name,
            kind=criterion.kind if criterion.limit is None else Kind.PROBABILITY,
            status=status,
            runs=count.runs,
            failures=count.failures,
            place=place,
            line=line,
            first=count.first,
            replay=self._replay(count.first),
            limit=criterion.limit,
            rate=None if criterion.limit is None else count.decision,
        )

    def _place(self, line: int) -> tuple[str, int]:
        """Return the file of a line, "" for the tested file, and its number there."""
        for file in reversed(self.program.imported):
            if line >= file.first_line:
                return file.name, line - file.first_line + 1
        return "", line

    def _replay(self, first: FailedRun | None) -> str:
        """Return the command that repeats a run; "" without one."""
        if first is None:
            return ""
        seed = [] if first.seed is None else ["--seed", str(first.seed)]
        words = self.plan.replay if self.driver is not None else ()
        return join(["cortexc", as_argument(Path(self.result.path)), *seed, *words])

    def _no_scene(self) -> str:
        """Return the reason why no run counts; "" if one does, or if the driver failed in all."""
        if self.valid or self.lost.failures:
            return ""
        return no_run_text(self.program, self.last)


OF_ANSWER = {Answer.KEPT: Status.PASS, Answer.BROKEN: Status.FAIL, Answer.OPEN: Status.UNDECIDED}
