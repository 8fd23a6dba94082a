"""Result of `cortexc test`: a row for each file, a check for each limit, the first failing run of each broken limit.

Data and the JSON document only; each other format is a file of `cortex_dsl/report/gates`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from cortex_dsl.report.findings.readable import significant
from engine.display import counted
from engine.gates.decision import RateDecision

if TYPE_CHECKING:
    from cortex_dsl.diagnostics import CompileError, Diagnostic
    from cortex_dsl.source import Source


class Status(StrEnum):
    """Status of a check or a file; a file has the gravest status of its checks."""

    PASS = "pass"  # noqa: S105 - no password
    KNOWN = "known"
    """A failure that the baseline lists."""
    UNDECIDED = "undecided"
    """The interval of a probability holds its limit."""
    FAIL = "FAIL"
    ERROR = "error"
    """The file has errors, no driver, or no valid scene."""


GRAVITY = tuple(Status)
"""All statuses, the gravest last."""


class Kind(StrEnum):
    """Kind of a check, as baselines and documents name it."""

    EXPECT = "expect"
    CONTACT = "contact"
    BOUND = "bound"
    PROBABILITY = "probability"
    CONTROLLER = "controller"


@dataclass(frozen=True)
class Measured:
    """A number of a run with its name and unit."""

    name: str
    value: float
    unit: str = ""

    @property
    def text(self) -> str:
        return f"{self.name} {significant(self.value, 3)} {self.unit}".rstrip()


@dataclass(frozen=True)
class FailedRun:
    """The first run that breaks a limit."""

    number: int
    """Number of the run, from 1."""
    seed: int | None
    """Seed of `cortexc FILE --seed N`, which repeats the run; None: the file has one run only."""
    numbers: tuple[Measured, ...] = ()
    event: str = ""
    """End of the run in words, or the message of a controller."""

    @property
    def text(self) -> str:
        """Return number, end and numbers of the run: `run 3, 1.25 s: contact: ego and truck; ego 36 km/h`."""
        parts = "; ".join(part for part in (self.event, ", ".join(each.text for each in self.numbers)) if part)
        return f"run {self.number:,}, {parts}"


@dataclass(frozen=True)
class Check:
    """One limit of one file."""

    name: str
    """Name of the `expect`, or text of the bound."""
    kind: Kind
    status: Status
    runs: int
    """Valid runs that were judged."""
    failures: int
    """Runs that broke the limit."""
    place: str = ""
    """File of the `expect`; "": the tested file."""
    line: int = 0
    """Line of the `expect` in its file; 0: none."""
    first: FailedRun | None = None
    replay: str = ""
    """Command that repeats the first failing run."""
    limit: float | None = None
    """Largest allowed probability of a failure; None: no run may fail."""
    rate: RateDecision | None = None
    """Decision on the probability."""
    cured: bool = False
    """Whether the baseline lists a failure that no longer occurs."""

    @property
    def broken(self) -> bool:
        """Return True for a failure, known or not."""
        return self.status in (Status.FAIL, Status.KNOWN)

    @property
    def text(self) -> str:
        """Return the result in words: `broken in 3 of 200 runs`."""
        if self.kind is Kind.CONTROLLER:
            return f"failed in {counted(self.failures, 'run')}" if self.failures else "answered in every run"
        if self.runs == 1 and self.rate is None:
            return "broken" if self.failures else "kept"
        runs = counted(self.runs, "run")
        result = f"broken in {self.failures:,} of {runs}" if self.failures else f"kept in {runs}"
        if self.limit is None or self.rate is None:
            return result
        low, high, limit = (f"{significant(100.0 * each, 3)} %" for each in (self.rate.low, self.rate.high, self.limit))
        return f"{result}: probability {low} to {high}, limit {limit}"


CURED = "a known failure no longer occurs: update the baseline"
"""Message of a cured failure under `--strict-baseline`."""


@dataclass(frozen=True)
class FileResult:
    """Result of one file."""

    path: str
    digest: str = ""
    """Digest of the program; "" for a file with errors."""
    seed: int = 0
    kept: bool = False
    """True for a file that leaves nothing to chance, of which there is one run."""
    runs: int = 0
    """Runs that began."""
    valid: int = 0
    """Runs that count."""
    seconds: float = 0.0
    checks: tuple[Check, ...] = ()
    error: "CompileError | None" = None
    """Errors of the file."""
    source: "Source | None" = None
    diagnostics: "tuple[Diagnostic, ...]" = ()
    """Errors, warnings and notes of the compiler."""
    no_scene: str = ""
    """Reason why no run counts; "" if one does."""
    no_driver: str = ""
    """Reason why nobody drives: no driver is named, or it does not fit the file; "" if one does."""
    remarks: tuple[str, ...] = ()
    imports: tuple[str, ...] = ()
    """Real paths of the files that it imports."""
    found: bool = False
    """True for a file that was found in a folder, False for one that was named."""

    @property
    def status(self) -> Status:
        if self.trouble:
            return Status.ERROR
        return max((check.status for check in self.checks), key=GRAVITY.index, default=Status.PASS)

    @property
    def trouble(self) -> str:
        """Return the reason of the status `error`; "" without one."""
        return self.no_driver or self.no_scene or ("" if self.error is None else self.error.message)


@dataclass(frozen=True)
class GateReport:
    """Result of all files, in the order of their paths."""

    files: tuple[FileResult, ...]
    seed: int = 0
    budget: str = ""
    """Budget as the user gave it."""
    timed: bool = False
    """True if the number of runs depends on the machine."""
    undecided_passes: bool = False
    strict: bool = False
    """True if a cured failure fails."""
    seconds: float = 0.0
    remarks: tuple[str, ...] = ()
    not_run: int = 0
    """Files that were left out as the test was interrupted."""
    command: str = ""
    """Command that gives the same result."""

    def checks(self, *statuses: Status) -> Iterator[tuple[FileResult, Check]]:
        """Yield the checks with one of the statuses, with their files."""
        for file in self.files:
            yield from ((file, check) for check in file.checks if check.status in statuses)

    @property
    def cured(self) -> tuple[tuple[FileResult, Check], ...]:
        """Return the failures of the baseline that no longer occur."""
        return tuple((file, check) for file in self.files for check in file.checks if check.cured)

    @property
    def has_broken_limit(self) -> bool:
        """Return True if a stated limit is broken: by a new failure, an open decision, or a cured failure if strict."""
        failing = (Status.FAIL,) if self.undecided_passes else (Status.FAIL, Status.UNDECIDED)
        return any(self.checks(*failing)) or (self.strict and bool(self.cured))

    @property
    def has_file_errors(self) -> bool:
        return any(file.error is not None for file in self.files)

    @property
    def lacks_driver(self) -> bool:
        """Return True if a file cannot be driven as the command line says."""
        return any(file.no_driver for file in self.files)

    @property
    def lacks_scene(self) -> bool:
        """Return True if a file has no valid scene."""
        return any(file.no_scene for file in self.files)

    @property
    def passed(self) -> bool:
        return not (self.not_run or self.has_broken_limit or any(file.trouble for file in self.files))

    @property
    def runs(self) -> int:
        return sum(file.runs for file in self.files)

    @property
    def headline(self) -> str:
        """Return the counts in a sentence: `12 of 14 files pass; 1 FAIL, 1 known; 2,400 runs`."""
        counts = dict(self.counts)
        passed = f"{counts.pop(Status.PASS):,} of {counted(len(self.files), 'file')} pass"
        others = ", ".join(f"{count:,} {status}" for status, count in reversed(counts.items()) if count)
        cured = f"{counted(len(self.cured), 'known failure')} cured" if self.cured else ""
        left_out = f"interrupted, {counted(self.not_run, 'file')} not run" if self.not_run else ""
        return "; ".join(part for part in (passed, others, cured, counted(self.runs, "run"), left_out) if part)

    @property
    def counts(self) -> Mapping[Status, int]:
        """Return the number of files of each status."""
        return {status: sum(file.status is status for file in self.files) for status in Status}


# -- the document of --json --------------------------------------------------------------------------------------------

TEST_SCHEMA_VERSION = 1
"""Version of the fields below; it rises when one changes its meaning or goes away."""


def gate_content(report: GateReport) -> dict[str, Any]:
    """Return the report as a document; only the fields `seconds` differ between two equal commands."""
    return {
        "test_schema_version": TEST_SCHEMA_VERSION,
        "command": report.command,
        "passed": report.passed,
        "seed": report.seed,
        "budget": report.budget,
        "runs_depend_on_time": report.timed,
        "counts": {status.lower(): count for status, count in report.counts.items()},
        "runs": report.runs,
        "cured": len(report.cured),
        "not_run": report.not_run,
        "remarks": list(report.remarks),
        "files": [_file_content(file) for file in report.files],
        "seconds": report.seconds,
    }


def _file_content(file: FileResult) -> dict[str, Any]:
    from cortex_dsl.report.findings.snippet import as_json

    return {
        "path": file.path,
        "status": file.status.lower(),
        "digest": file.digest or None,
        "kept": file.kept,
        "seed": None if file.kept else file.seed,
        "runs": file.runs,
        "valid": file.valid,
        "trouble": file.trouble or None,
        "diagnostics": [] if file.source is None else as_json(file.source, file.diagnostics),
        "remarks": list(file.remarks),
        "checks": [_check_content(check) for check in file.checks],
        "seconds": file.seconds,
    }


def _check_content(check: Check) -> dict[str, Any]:
    rate = check.rate
    return {
        "name": check.name,
        "kind": check.kind.value,
        "status": check.status.lower(),
        "cured": check.cured,
        "line": check.line or None,
        "place": check.place or None,
        "runs": check.runs,
        "failures": check.failures,
        "max_probability": check.limit,
        "interval": None if rate is None else [rate.low, rate.high],
        "first_failure": None if check.first is None else _failure_content(check.first, check.replay),
    }


def _failure_content(first: FailedRun, replay: str) -> dict[str, Any]:
    return {
        "run": first.number,
        "seed": first.seed,
        "event": first.event or None,
        "numbers": [{"name": each.name, "value": each.value, "unit": each.unit} for each in first.numbers],
        "replay": replay,
    }
