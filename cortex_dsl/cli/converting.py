"""`--to`: a recording in other formats, beside the file that it was read from or in a folder of its own."""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.placing import place_files
from cortex_dsl.exports.formats import FORMATS
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from cortex_dsl.report.findings.interchange_report import MeasuredReport
    from engine.interchange.export import Export

CONVERTIBLE = tuple(name for name, entry in FORMATS.items() if not entry.needs)
"""What a recording from elsewhere can be turned into."""


def formats(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    names = tuple(dict.fromkeys(word.strip().removeprefix(".").lower() for word in text.split(",")))
    for name in names:
        if name in FORMATS and name not in CONVERTIBLE:
            needs = f"{name} needs {FORMATS[name].needs}"
            raise argparse.ArgumentTypeError(f"{needs}; a recording can become {', '.join(CONVERTIBLE)}")
        if name not in FORMATS:
            match = nearest(name, CONVERTIBLE)
            meant = f"did you mean `{match}`?" if match else f"there are {', '.join(CONVERTIBLE)}"
            raise argparse.ArgumentTypeError(f"cannot be `{name}`: {meant}")
    return names


def written(report: "MeasuredReport", options: argparse.Namespace) -> "MeasuredReport":
    """The recording in other formats, beside the file or in `--out`.

    Raises:
        UsageError: something else stands there, or the files cannot be written.
        InterchangeError: the format cannot carry it, or a package is missing.
    """
    from dataclasses import replace

    folder = options.out or options.file.parent
    exports = list(_exports(report, options))
    files = {
        name: content if isinstance(content, bytes) else content.encode()
        for export in exports
        for name, content in export.files.items()
    }
    place_files(folder, files, force=options.force)
    told = dict.fromkeys((*report.remarks, *(remark for export in exports for remark in export.remarks)))
    return replace(report, remarks=tuple(told), written=tuple(str(folder / name) for name in files))


def _exports(report: "MeasuredReport", options: argparse.Namespace) -> "Iterator[Export]":
    from cortex_dsl.exports.formats import recording_writer_of

    for name in options.to:
        if FORMATS[name].of_recording:
            yield recording_writer_of(name)(report.recording, options.file.stem)
        else:
            yield _openscenario(report, options.file.stem, options.osc)


def _openscenario(report: "MeasuredReport", stem: str, osc: str | None) -> "Export":
    """The `.xosc`, and beside it a copy of the road that was read."""
    from engine.interchange.export import Export, ExportOptions
    from engine.interchange.openscenario import write_trajectories

    road = None if report.road is None else Path(report.road.path)
    how = ExportOptions() if osc is None else ExportOptions(osc)
    export = write_trajectories(report.recording, stem, how, None if road is None else road.name)
    copy = {} if road is None else {road.name: road.read_bytes()}
    return Export({**export.files, **copy}, export.remarks)
