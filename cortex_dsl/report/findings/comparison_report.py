"""Result of `cortexc compare`: the conditions of each file in pairs of runs, and the failures that differ.

Data and the JSON document only; the view is `cortex_dsl/report/views/comparison.py`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from cortex_dsl.report.blocks import Drawing
from cortex_dsl.report.findings.gate_report import Measured
from engine.display import counted
from engine.gates.decision import Answer, RateDecision
from engine.gates.paired import PairTable
from engine.scenes import Scenes

if TYPE_CHECKING:
    from cortex_dsl.diagnostics import CompileError, Diagnostic
    from cortex_dsl.source import Source

LEVEL = 0.05
"""Holm's p below which a difference is stated."""


class ConditionKind(StrEnum):
    """Family of a condition; p values of a family are corrected together."""

    EXPECT = "expect"
    CONTACT = "contact"
    AVOIDABLE = "avoidable"


class Change(StrEnum):
    """Difference between the runs of a pair."""

    NEW = "new"
    """A keeps a condition that B breaks."""
    CURED = "cured"
    """A breaks a condition, B none."""
    MOVED = "moved"
    """Both fail, B in no condition that A keeps, in failures of different kinds."""
    KEPT = "kept"
    """Both fail, in failures of the same kind."""


@dataclass(frozen=True)
class Condition:
    """A condition of a file in all pairs that count."""

    name: str
    kind: ConditionKind
    table: PairTable
    p_holm: float = float("nan")
    """Holm's p within the family, over all files; NaN without a test."""

    @property
    def verdict(self) -> str:
        """Return `worse` or `better` for a difference that the test shows, else ""."""
        if not self.p_holm < LEVEL:
            return ""
        return "worse" if self.table.difference > 0.0 else "better"


@dataclass(frozen=True)
class RunNumbers:
    """The run of one side in a scene."""

    event: str
    """End of the run in words."""
    numbers: tuple[Measured, ...] = ()
    replay: str = ""
    """Command that repeats the run."""

    @property
    def text(self) -> str:
        return "; ".join(part for part in (self.event, ", ".join(each.text for each in self.numbers)) if part)


@dataclass(frozen=True)
class Example:
    """The first pair of a kind of change."""

    number: int
    """Number of the pair, from 1."""
    seed: int | None
    """Seed of `cortexc FILE --seed N`; None: the scene has none."""
    key: str
    """Stream key of the scene."""
    params: Mapping[str, float]
    """Values of the params, in the units of the file."""
    a: RunNumbers
    b: RunNumbers
    scenes: tuple[Scenes, ...] = field(default=(), compare=False, repr=False)
    """Scenes of A and B, one row each, until the files are made."""


@dataclass(frozen=True)
class FoundChange:
    """Pairs with the same change between failures of the same kinds."""

    change: Change
    a: str
    """Failure of A in words; "" if A does not fail."""
    b: str
    count: int
    example: Example
    cases: tuple[str, ...] = ()
    """Scenarios of the example, below the folder of the results."""
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    """All files of the example, by their places below that folder."""
    drawings: tuple[Drawing, ...] = field(default=(), repr=False)
    """The example driven by A and by B; () if it is not drawn."""

    @property
    def kind(self) -> str:
        """Return both failures in words, once if they are equal or the only one."""
        if self.change is Change.MOVED:
            return f"{self.a} -> {self.b}"
        return self.a if self.change is Change.CURED else self.b


@dataclass(frozen=True)
class NotRun:
    """Scenes without a pair of runs, for one reason."""

    side: str
    """`A`, `B`, or `A and B`."""
    reason: str
    count: int
    number: int
    """Number of the first pair."""


@dataclass(frozen=True)
class Searched:
    """Result of the search for differences, which is no sample."""

    scenes: int
    valid: int
    method: str
    changes: tuple[FoundChange, ...] = ()
    stopped: bool = False

    def count(self, change: Change) -> int:
        return sum(each.count for each in self.changes if each.change is change)


@dataclass(frozen=True)
class FileComparison:
    """A and B on one file."""

    path: str
    digests: tuple[str, str] = ("", "")
    """Digests of the programs of A and B."""
    seed: int = 0
    kept: bool = False
    """True for files that leave nothing to chance, of which there is one pair."""
    drawn: bool = True
    """True if the scenes are independent draws; False for the failures of two searches."""
    pairs: int = 0
    """Pairs that began."""
    valid: int = 0
    """Pairs in which both runs count."""
    conditions: tuple[Condition, ...] = ()
    changes: tuple[FoundChange, ...] = ()
    """Changes, the most frequent kinds first."""
    lost_by_b: int = 0
    """Pairs over which the driver of B failed and that of A did not."""
    repeats: tuple[int, int] = (0, 0)
    """Scenes of the first block that A and B drove otherwise when they drove it again."""
    repeated: int = 0
    """Scenes that were driven twice."""
    limit: float | None = None
    """Largest allowed probability of a new failure."""
    decision: RateDecision | None = None
    residual: float | None = None
    """Upper 95 % bound of the probability of a new failure, if no pair has one."""
    searched: Searched | None = None
    not_run: tuple[NotRun, ...] = ()
    remarks: tuple[str, ...] = ()
    error: "CompileError | None" = None
    source: "Source | None" = None
    diagnostics: "tuple[Diagnostic, ...]" = ()
    refusal: str = ""
    """Reason why A and B cannot be compared on the file; "" if they can."""
    no_scene: str = ""
    """Reason why no pair counts; "" if one does."""
    table: Mapping[str, Sequence[Any]] = field(default_factory=dict, repr=False)
    """Columns of the pairs."""
    actors: tuple[str, ...] = ()
    interrupted: bool = False
    seconds: float = 0.0

    @property
    def runs(self) -> int:
        """Return the number of runs of both sides, searched scenes included."""
        return 2 * (self.pairs + (0 if self.searched is None else self.searched.scenes))

    @property
    def trouble(self) -> str:
        """Return the reason why there is no result; "" with one."""
        return self.refusal or self.no_scene or ("" if self.error is None else self.error.message)

    @property
    def deterministic(self) -> bool:
        return not any(self.repeats)

    @property
    def untested(self) -> str:
        """Return the reason why there is no paired test; "" with one."""
        if not self.deterministic:
            return "a driver is not deterministic"
        if not self.drawn:
            return "the scenes are failures of searches and no independent draws"
        if self.limit is not None:
            return "with --max-new the number of scenes depends on their results"
        return "" if self.valid else "no pair counts"

    def count(self, change: Change) -> int:
        """Return the number of pairs with a change."""
        return sum(each.count for each in self.changes if each.change is change)

    @property
    def has_new_failures(self) -> bool:
        """Return True if the comparison fails."""
        if self.limit is not None:
            return self.decision is not None and self.decision.answer is Answer.BROKEN
        found = self.searched is not None and self.searched.count(Change.NEW)
        return bool(self.count(Change.NEW) or found or self.lost_by_b)


@dataclass(frozen=True)
class ComparisonReport:
    """A and B on all files, in the order of their paths."""

    a: str
    b: str
    files: tuple[FileComparison, ...]
    seed: int = 0
    budget: str = ""
    timed: bool = False
    """True if the number of pairs depends on the machine."""
    command: str = ""
    """Command that gives this result again."""
    not_run: int = 0
    """Files that were left out as the comparison was interrupted."""
    seconds: float = 0.0

    @property
    def interrupted(self) -> bool:
        return bool(self.not_run) or any(file.interrupted for file in self.files)

    @property
    def pairs(self) -> int:
        return sum(file.pairs for file in self.files)

    def count(self, change: Change) -> int:
        return sum(file.count(change) for file in self.files)

    @property
    def has_new_failures(self) -> bool:
        return any(file.has_new_failures for file in self.files)

    @property
    def passed(self) -> bool:
        return not (self.interrupted or self.has_new_failures or any(file.trouble for file in self.files))

    @property
    def not_deterministic(self) -> tuple[str, ...]:
        """Return a sentence for each driver that drove a block otherwise the second time."""
        found = {"A": 0, "B": 0}
        for file in self.files:
            for side, count in zip(found, file.repeats, strict=True):
                found[side] += count
        scenes = counted(sum(file.repeated for file in self.files), "scene")
        return tuple(
            f"{side} is not deterministic: it drives {count:,} of {scenes} otherwise the second time"
            for side, count in found.items()
            if count
        )

    def changes(self, *wanted: Change) -> "Iterator[tuple[FileComparison, FoundChange]]":
        """Yield the changes of the given sorts with their files."""
        for file in self.files:
            yield from ((file, each) for each in file.changes if each.change in wanted)

    @property
    def headline(self) -> str:
        """Return the counts in a sentence: `3 new failures, 1 cured, 0 moved, 12 kept in 1,000 pairs`."""
        if not self.pairs:
            return "nothing is compared"
        new = counted(self.count(Change.NEW), "new failure") if self.count(Change.NEW) else "no new failure"
        others = ", ".join(f"{self.count(change):,} {change}" for change in (Change.CURED, Change.MOVED, Change.KEPT))
        parts = [f"{new}, {others} in {counted(self.pairs, 'pair')}"]
        searched = sum(file.searched.count(Change.NEW) for file in self.files if file.searched is not None)
        if searched:
            parts.append(f"{counted(searched, 'new failure')} found by the search")
        if lost := sum(file.lost_by_b for file in self.files):
            parts.append(f"B's driver failed in {counted(lost, 'scene')} that A drove")
        if self.interrupted:
            parts.append("interrupted" + (f", {counted(self.not_run, 'file')} not run" if self.not_run else ""))
        return "; ".join(parts)


# -- the document ------------------------------------------------------------------------------------------------------

COMPARISON_SCHEMA_VERSION = 1
"""Version of the fields below; it rises when one changes its meaning or goes away."""


def comparison_content(report: ComparisonReport) -> dict[str, Any]:
    """Return the report as a document without times, so that equal commands give equal documents."""
    return {
        "comparison_schema_version": COMPARISON_SCHEMA_VERSION,
        "a": report.a,
        "b": report.b,
        "passed": report.passed,
        "interrupted": report.interrupted,
        "deterministic": not report.not_deterministic,
        "seed": report.seed,
        "budget": report.budget,
        "pairs_depend_on_time": report.timed,
        "pairs": report.pairs,
        "changes": {change.value: report.count(change) for change in Change},
        "not_run": report.not_run,
        "command": report.command,
        "files": [_file_content(file) for file in report.files],
    }


def _file_content(file: FileComparison) -> dict[str, Any]:
    from cortex_dsl.report.findings.snippet import as_json

    return {
        "path": file.path,
        "digests": {"a": file.digests[0] or None, "b": file.digests[1] or None},
        "trouble": file.trouble or None,
        "kept": file.kept,
        "independent": file.drawn,
        "pairs": file.pairs,
        "valid": file.valid,
        "deterministic": {"a": not file.repeats[0], "b": not file.repeats[1]},
        "no_test": file.untested or None,
        "conditions": [_condition_content(each, tested=not file.untested) for each in file.conditions],
        "changes": [_change_content(each) for each in file.changes],
        "lost_by_b": file.lost_by_b,
        "max_new": None if file.limit is None else _decision_content(file.limit, file.decision),
        "residual_bound": file.residual,
        "search": None if file.searched is None else _searched_content(file.searched),
        "not_run": [vars(each) for each in file.not_run],
        "remarks": list(file.remarks),
        "diagnostics": [] if file.source is None else as_json(file.source, file.diagnostics),
    }


def _condition_content(condition: Condition, *, tested: bool) -> dict[str, Any]:
    table = condition.table
    return {
        "name": condition.name,
        "kind": condition.kind.value,
        "table": dict(zip(("kept_kept", "kept_broken", "broken_kept", "broken_broken"), table.counts, strict=True)),
        "difference": table.difference,
        "interval": [*table.interval] if tested else None,
        "p": table.p if tested else None,
        "p_holm": condition.p_holm if tested else None,
        "verdict": condition.verdict or None,
    }


def _decision_content(limit: float, decision: RateDecision | None) -> dict[str, Any]:
    interval = None if decision is None else [decision.low, decision.high]
    return {"limit": limit, "answer": None if decision is None else decision.answer.value, "interval": interval}


def _change_content(found: FoundChange) -> dict[str, Any]:
    example = found.example
    return {
        "change": found.change.value,
        "kind": found.kind,
        "count": found.count,
        "pair": example.number,
        "seed": example.seed,
        "key": example.key,
        "params": dict(example.params),
        "a": {"failure": found.a or None, **_run_content(example.a)},
        "b": {"failure": found.b or None, **_run_content(example.b)},
        "cases": list(found.cases),
    }


def _run_content(run: RunNumbers) -> dict[str, Any]:
    return {
        "event": run.event or None,
        "numbers": [{"name": each.name, "value": each.value, "unit": each.unit} for each in run.numbers],
        "replay": run.replay or None,
    }


def _searched_content(searched: Searched) -> dict[str, Any]:
    return {
        "method": searched.method,
        "scenes": searched.scenes,
        "valid": searched.valid,
        "stopped": searched.stopped,
        "changes": [_change_content(each) for each in searched.changes],
    }
