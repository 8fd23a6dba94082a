"""`--to`: a recording in other formats, beside the file that it was read from or in a folder of its own."""

import argparse
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.files import reason
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from cortex_dsl.report.measured_view import MeasuredReport
    from engine.interchange.export import Export
    from engine.interchange.recording import Recording

WRITERS: Mapping[str, str] = {
    "csv": "engine.interchange.tables:write_csv",
    "parquet": "engine.interchange.tables:write_parquet",
    "mcap": "engine.interchange.mcap:write_mcap",
    "xosc": "cortex_dsl.cli.converting:write_openscenario",
}
"""What a recording without a road of ours can be turned into."""


def formats(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    names = tuple(dict.fromkeys(word.strip().removeprefix(".").lower() for word in text.split(",")))
    for name in names:
        if name not in WRITERS:
            match = nearest(name, WRITERS)
            meant = f"did you mean `{match}`?" if match else f"there are {', '.join(WRITERS)}"
            raise argparse.ArgumentTypeError(f"cannot be `{name}`: {meant}")
    return names


def written(report: "MeasuredReport", options: argparse.Namespace) -> "MeasuredReport":
    """The recording in other formats, beside the file or in `--out`.

    Raises:
        UsageError: something else stands there, or the files cannot be written.
        InterchangeError: the format cannot carry it, or a package is missing.
    """
    from dataclasses import replace

    from cortex_dsl.exports.files import standing, write_all

    folder = options.out or options.file.parent
    exports = [_writer(name)(report.recording, options.file.stem) for name in options.to]
    files = {
        name: content if isinstance(content, bytes) else content.encode()
        for export in exports
        for name, content in export.files.items()
    }
    try:
        there = standing(folder, files)
        if there.other and not options.force:
            cure = "name another folder with --out, or write over it with --force"
            raise UsageError(f"`{folder / there.other[0]}` holds something else", cure)
        write_all(folder, files)
    except OSError as error:
        raise UsageError(f"cannot write `{error.filename or folder}`: {reason(error)}", "name another --out") from None
    except ValueError:
        raise UsageError(f"`{folder}` cannot be the name of a folder", "name another one with --out") from None
    told = dict.fromkeys((*report.remarks, *(remark for export in exports for remark in export.remarks)))
    return replace(report, remarks=tuple(told), written=tuple(str(folder / name) for name in files))


def _writer(name: str) -> Any:
    module, _, function = WRITERS[name].partition(":")
    return getattr(import_module(module), function)


def write_openscenario(recording: "Recording", stem: str) -> "Export":
    """The `.xosc` alone: a road that was read is not written again."""
    from engine.interchange.export import ExportOptions
    from engine.interchange.openscenario import write_trajectories

    return write_trajectories(recording, stem, ExportOptions(), None)
