"""All files of the requested cases, in memory, before the first file is written."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from cortex_dsl.interchange.cases import ExportCase
from cortex_dsl.interchange.formats import FORMATS, missing_extra
from engine.errors import InterchangeError
from engine.interchange.contract import Export, ExportOptions


@dataclass(frozen=True)
class Gathered:
    """Files to write, with their remarks."""

    files: dict[str, bytes] = field(default_factory=dict)
    """Contents by file name; several cases may share a file."""
    formats: dict[str, str] = field(default_factory=dict)
    """Format of the row that first asked for the file, by file name."""
    names: list[list[str]] = field(default_factory=list)
    """Names of all files of each case."""
    remarks: dict[tuple[str, str], list[int]] = field(default_factory=dict)
    """Cases (from 0) of each remark, by format and sentence."""
    refused: dict[str, InterchangeError] = field(default_factory=dict)
    """Error for each format that cannot represent a case; no file of that format is written."""


def gather(cases: Sequence[ExportCase], formats: Sequence[str], options: ExportOptions) -> Gathered:
    """Return the files of every case in every format that can represent all cases; the other formats are `refused`.

    Raises:
        InterchangeError: no format can; its place names case and format.
    """
    made: dict[str, list[Export]] = {}
    gathered = Gathered()
    for name in formats:
        try:
            _refuse_without_package(name)
            made[name] = [_export(case, name, options) for case in cases]
        except InterchangeError as error:
            gathered.refused[name] = error
    if not made:
        raise next(iter(gathered.refused.values()))
    for number in range(len(cases)):
        gathered.names.append([])
        for name, exports in made.items():
            _add(gathered, number, name, exports[number])
    return gathered


def _refuse_without_package(name: str) -> None:
    """Raises InterchangeError where a package is missing; the other formats are written all the same."""
    if cure := missing_extra(name):
        raise InterchangeError(f"it needs the package `{FORMATS[name].package}`, which is not installed", cure, name)


def _export(case: ExportCase, name: str, options: ExportOptions) -> Export:
    stem = case.recording.name
    try:
        return FORMATS[name].writer(case, stem, options)
    except InterchangeError as error:
        raise InterchangeError(error.message, error.cure, error.place or f"{stem} as {name}") from error


def _add(gathered: Gathered, number: int, name: str, export: Export) -> None:
    for file, content in export.files.items():
        data = content if isinstance(content, bytes) else content.encode("utf-8")
        if gathered.files.setdefault(file, data) != data:
            raise ValueError(f"two exports differ about {file}")
        gathered.formats.setdefault(file, name)
        if file not in gathered.names[number]:
            gathered.names[number].append(file)
    for remark in export.remarks:
        gathered.remarks.setdefault((name, remark), []).append(number)
