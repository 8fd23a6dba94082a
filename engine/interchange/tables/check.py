"""An exported table read back, and held against the run."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from engine.interchange.contract import ExportOptions, Finding, InterchangeError
from engine.interchange.measuring import same_run
from engine.interchange.recording import RecordedCase
from engine.interchange.tables.read import read_table


def check_table(case: RecordedCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """The rows are the run, to a millimetre."""
    for name in (each for each in names if each.endswith((".csv", ".parquet"))):
        try:
            read = read_table(folder / name, step=case.recording.step).recording
        except InterchangeError as error:
            yield Finding(error.place or name, error.message, error.cure)
            continue
        yield from same_run(case, read, name)
