"""Baseline of a test: failures that are known, so that only new ones fail.

A baseline is a TOML file with an entry for each known failure: `file` (relative to the folder of the baseline), name of
the limit (`expect`), `kind`, `digest` of the program, and `replay`, the options that repeat its first failing run.
"""

import os
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path, PurePath
from typing import Any, cast

from cortex_dsl.report.findings.gate_report import Check, FileResult, GateReport, Kind, Status
from engine.errors import CortexError, UnreadableFileError
from engine.strict_json import json_text

HEAD = """\
# Known failures of `cortexc test`: they do not fail. `--update-baseline` writes this file.
version = 1
"""
VERSION = 1


class BaselineError(CortexError):
    """A baseline that cannot be read as one."""


@dataclass(frozen=True)
class Entry:
    """One known failure."""

    file: str
    """Path relative to the folder of the baseline, with `/`."""
    expect: str
    kind: str
    digest: str = ""
    replay: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """Return the identity of the failure."""
        return self.file, self.kind, self.expect


@dataclass(frozen=True)
class Baseline:
    """Known failures, and remarks on the file that lists them."""

    path: Path
    entries: tuple[Entry, ...] = ()
    remarks: tuple[str, ...] = ()

    def name_of(self, file: str) -> str:
        """Return the name of a tested file in the baseline."""
        return PurePath(os.path.relpath(file, self.path.parent)).as_posix()


def read_baseline(path: Path, *, may_be_missing: bool = False) -> Baseline:
    """Return the baseline in a file.

    Raises:
        BaselineError: the file is no TOML, or an entry lacks its file, limit or kind.
        UnreadableFileError: it cannot be read.
    """
    try:
        content = tomllib.loads(path.read_bytes().decode("utf-8"))
    except FileNotFoundError as error:
        if may_be_missing:
            return Baseline(path)
        raise UnreadableFileError(path, error) from error
    except OSError as error:
        raise UnreadableFileError(path, error) from error
    except ValueError as error:  # of TOML and of UTF-8
        raise BaselineError(
            f"`{path}` is no baseline: {error}", "correct it, or write it anew with --update-baseline"
        ) from error
    version, listed = content.get("version", VERSION), content.get("failure", [])
    if version != VERSION or not isinstance(listed, list):
        raise BaselineError(
            f"`{path}` is no baseline of version {VERSION}", "remove it, and write it anew with --update-baseline"
        )
    rows = cast("list[Any]", listed)
    remarks = [
        f"`{path}`: unknown key `{name}`, which is ignored" for name in content if name not in ("version", "failure")
    ]
    entries = [_entry(path, number, row, remarks) for number, row in enumerate(rows, start=1)]
    return Baseline(path, tuple({entry.key: entry for entry in entries}.values()), tuple(remarks))


def _entry(path: Path, number: int, row: Any, remarks: list[str]) -> Entry:
    """Return an entry, and add a remark for each unknown key.

    Raises:
        BaselineError: a key is missing, or is no text.
    """
    known = [field.name for field in fields(Entry)]
    if not isinstance(row, dict):
        raise BaselineError(f"`{path}`: entry {number} is no table", "write `[[failure]]` above each entry")
    values = cast("dict[str, Any]", row)
    remarks += (
        f"`{path}`: entry {number} has the unknown key `{name}`, which is ignored"
        for name in values
        if name not in known
    )
    given = {name: value for name, value in values.items() if name in known}
    for name in ("file", "expect", "kind"):
        if not given.get(name):
            raise BaselineError(f"`{path}`: entry {number} has no `{name}`", "write it, or remove the entry")
    if wrong := next((name for name, value in given.items() if not isinstance(value, str)), None):
        raise BaselineError(f"`{path}`: `{wrong}` of entry {number} is no text", "put it in quotation marks")
    if given["kind"] not in {kind.value for kind in Kind}:
        remarks.append(f"`{path}`: entry {number} has the unknown kind `{given['kind']}`, which no check has")
    return Entry(**given)


# -- compared with a test ----------------------------------------------------------------------------------------------


def compared(report: GateReport, baseline: Baseline) -> GateReport:
    """Return the report with the known failures marked as known, those that no longer occur as cured, and remarks."""
    remarks = [*baseline.remarks, *(text for file in report.files for text in _remarks(file, baseline))]
    files = tuple(compared_file(file, baseline) for file in report.files)
    return replace(report, files=files, remarks=(*report.remarks, *remarks))


def compared_file(file: FileResult, baseline: Baseline) -> FileResult:
    """Return the result of a file with its known failures marked as known, and those that no longer occur as cured."""
    known = {(entry.kind, entry.expect) for entry in _entries_of(file, baseline)}
    return replace(file, checks=tuple(_compared_check(check, known) for check in file.checks))


def _entries_of(file: FileResult, baseline: Baseline) -> list[Entry]:
    """Return the entries of a file; none if it cannot be run."""
    name = baseline.name_of(file.path)
    return [] if file.trouble else [entry for entry in baseline.entries if entry.file == name]


def _remarks(file: FileResult, baseline: Baseline) -> Iterator[str]:
    """Yield remarks on entries that no longer fit their file."""
    entries = _entries_of(file, baseline)
    if any(entry.digest and entry.digest != file.digest for entry in entries):
        yield f"`{file.path}` has changed since `{baseline.path}` was written: its digest differs"
    there = {(check.kind.value, check.name) for check in file.checks}
    for each in entries:
        if (each.kind, each.expect) not in there:
            yield f'`{baseline.path}`: `{file.path}` has no {each.kind} "{each.expect}" any more'


def _compared_check(check: Check, known: set[tuple[str, str]]) -> Check:
    if (check.kind.value, check.name) not in known:
        return replace(check, cured=False)
    if check.status is Status.FAIL:
        return replace(check, status=Status.KNOWN)
    return replace(check, cured=check.status is Status.PASS)


# -- written -----------------------------------------------------------------------------------------------------------


def updated(report: GateReport, baseline: Baseline) -> Baseline:
    """Return the baseline with the failures of a test, and the earlier entries of all files that did not run."""
    ran = {baseline.name_of(file.path) for file in report.files if not file.trouble}
    rest = [entry for entry in baseline.entries if entry.file not in ran]
    new = [_entry_of(baseline, file, check) for file, check in report.checks(Status.FAIL, Status.KNOWN)]
    return replace(baseline, entries=tuple(sorted((*rest, *new), key=lambda entry: entry.key)))


def _entry_of(baseline: Baseline, file: FileResult, check: Check) -> Entry:
    seed = None if check.first is None else check.first.seed
    replay = "" if seed is None else f"--seed {seed}"
    return Entry(baseline.name_of(file.path), check.name, check.kind.value, file.digest, replay)


def baseline_text(entries: Iterable[Entry]) -> str:
    """Return the text of a baseline."""
    return "\n".join([HEAD, *("\n".join(_lines(entry)) + "\n" for entry in entries)])


def _lines(entry: Entry) -> Sequence[str]:
    return ["[[failure]]", *(f"{name} = {_quoted(value)}" for name, value in asdict(entry).items() if value)]


def _quoted(text: str) -> str:
    """Return a text as a basic string of TOML."""
    return json_text(text).replace("\x7f", "\\u007f")
