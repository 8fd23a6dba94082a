"""`cortexc measure FILE`: metrics and risk of a recorded case, from any driver: a table of trajectories, or an `.xosc`.

`cortexc import FILE.xosc` does the same for a case that another tool wrote, and reads its road too.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.export import OSC_VERSIONS
from cortex_dsl.cli.measure_all import check_options, esmini_of, options_of_all, rank
from cortex_dsl.cli.recording_options import columns_of, rate_of, window_of
from cortex_dsl.console.command import Command, Parser, typed_again
from cortex_dsl.console.request import seconds
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import place_files, reason
from cortex_dsl.interchange.formats import FORMATS, RECORDINGS, SCENARIO
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from cortex_dsl.report.findings.interchange_report import MeasuredReport
    from engine.interchange.contract import Export, InterchangeError
    from engine.interchange.openscenario.read import Imported


@dataclass(frozen=True)
class Reader:
    """Which recordings one of the commands `measure` and `import` reads."""

    name: str
    suffixes: tuple[str, ...]
    example: str


MEASURED = Reader("measure", RECORDINGS, "cortexc measure trajectories.csv")
IMPORTED = Reader("import", (SCENARIO,), "cortexc import case.xosc")


def _perform(reader: Reader, options: argparse.Namespace, terminal: Terminal) -> int:
    """Read, measure, show."""
    from engine.interchange.contract import InterchangeError

    _check(reader, options)
    try:
        if options.all:
            return rank(options, terminal)
        report = _report(reader, options, terminal)
        report = _converted(report, options) if options.to else report
    except InterchangeError as error:
        return _refused(error, options, terminal)
    _show(report, options, terminal)
    return Exit.FINE


def _check(reader: Reader, options: argparse.Namespace) -> None:
    """Raises UsageError where the file cannot be meant."""
    path = options.file
    if path.suffix.lower() not in reader.suffixes:
        raise UsageError(f"`{path}` is not a recording that `cortexc {reader.name}` reads", _instead(path, reader))
    try:
        if path.is_dir():
            raise UsageError(f"`{path}` is a folder", f"name a file in it: {', '.join(reader.suffixes)}")
        if not path.exists():
            raise UsageError(f"there is no file `{path}`", _similar(path, reader))
    except OSError as error:
        raise UsageError(f"cannot read `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None
    check_options(options)
    if options.out is not None and not options.to:
        raise UsageError("--out has no effect without --to", "leave --out out, or name formats with --to")
    if options.force and not (options.to or options.table or options.page):
        raise UsageError("--force has no effect without --to", "leave --force out, or name formats with --to")
    if options.osc is not None and "xosc" not in (options.to or ()):
        raise UsageError("--osc has no effect without --to xosc", "leave --osc out, or add xosc to --to")


def _instead(path: Path, reader: Reader) -> str:
    """What reads this kind of file."""
    suffix = path.suffix.lower()
    if suffix == ".scn":
        return f"`cortexc {path}` runs a scenario"
    if suffix == ".xodr":
        return "a road has no traffic: name the .xosc that plays on it"
    if suffix in MEASURED.suffixes:
        return f"`cortexc measure {path}` reads it"
    return f"name a file that ends in {', '.join(reader.suffixes)}"


def _similar(path: Path, reader: Reader) -> str:
    try:
        names = [each.name for each in path.parent.iterdir() if each.suffix.lower() in reader.suffixes]
    except OSError:
        return f"there is no folder `{path.parent}` either"
    match = nearest(path.name, names)
    if match is None:
        return f"name a file that ends in {', '.join(reader.suffixes)}"
    return f"did you mean `{path.parent / match}`?"


def _report(reader: Reader, options: argparse.Namespace, terminal: Terminal) -> "MeasuredReport":
    from cortex_dsl.console.kernels import METRICS, compile_kernels
    from cortex_dsl.report.findings.interchange_report import MeasuredReport, road_outline
    from engine.interchange.measuring import measure
    from engine.road import build_network
    from engine.road.outline import outline

    read = _read(options)
    compile_kernels(terminal, METRICS)
    measured = measure(read.recording, options.profile)
    own = read.recording.road
    return MeasuredReport(
        file=str(options.file),
        recording=read.recording,
        measured=measured,
        profile=options.profile,
        remarks=(*read.remarks, *measured.not_judged),
        road=read.road,
        lines=road_outline(read.road) if own is None else outline(build_network(own)),
        again=typed_again(reader.name, options.words),
    )


def _read(options: argparse.Namespace) -> "Imported":
    from engine.interchange.sources import read_recording

    return read_recording(
        options.file,
        ego=options.ego,
        step=options.step,
        rate=options.rate,
        columns=dict(options.columns),
        window=options.window,
        esmini=esmini_of(options),
    )


def _refused(error: "InterchangeError", options: argparse.Namespace, terminal: Terminal) -> Exit:
    """The file has errors, or does not hold what it was asked for."""
    message = f"{error.place}: {error.message}" if error.place else error.message
    terminal.complain(message, error.cure)
    if options.json:
        content = {"message": message, "help": error.cure or None, "exit_code": int(Exit.DIAGNOSTICS)}
        terminal.document("error", content)
    return Exit.DIAGNOSTICS


def _show(report: "MeasuredReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.interchange_report import measured_content
    from cortex_dsl.report.terminal.interchange_view import measured_view

    if options.json:
        terminal.document("measure", measured_content(report))
    else:
        console = terminal.out
        console.print(measured_view(report, console.width, ascii_only=console.options.ascii_only))


def _profile(text: str) -> str:
    from engine.risk import PROFILES

    if text not in PROFILES:
        match = nearest(text, PROFILES)
        meant = f"did you mean `{match}`?" if match else f"there are {', '.join(PROFILES)}"
        raise argparse.ArgumentTypeError(f"cannot be `{text}`: {meant}")
    return text


def _options(reader: Reader, parser: Parser) -> None:
    endings = ", ".join(f"*{suffix}" for suffix in reader.suffixes)
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE", help=f"a recording: {endings}")
    parser.add_argument("--ego", metavar="NAME", help="the actor to judge (the one called ego, or else the first)")
    parser.add_argument(
        "--step", type=seconds(0.0001, 10.0), metavar="S", help="time step of the metrics (that of the file)"
    )
    if reader is MEASURED:
        parser.add_argument("--rate", type=rate_of, metavar="HZ", help="frames per second of a table of frames")
        parser.add_argument(
            "--columns",
            type=columns_of,
            default=(),
            metavar="NAME=COLUMN,…",
            help="columns of a table whose names are not known: time=zeit,actor=objekt",
        )
    else:
        parser.set_defaults(rate=None, columns=())
    parser.add_argument(
        "--window", type=window_of, metavar="S,S", help="only a part: start and end, in seconds after the first row"
    )
    parser.add_argument(
        "--profile", type=_profile, default="paper", metavar="NAME", help="thresholds of the risk (paper)"
    )
    parser.add_argument("--esmini", type=Path, metavar="PATH", help="library that plays an xosc (CORTEXC_ESMINI)")
    parser.add_argument("--to", type=_formats, metavar="FORMATS", help=f"also write it as: {', '.join(CONVERTIBLE)}")
    parser.add_argument(
        "--osc", choices=OSC_VERSIONS, metavar="V", help=f"version of OpenSCENARIO: {', '.join(OSC_VERSIONS)} (1.2)"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the written files (that of FILE)")
    parser.add_argument("--force", action="store_true", help="overwrite files that have other contents")
    options_of_all(parser, offered=reader is MEASURED)


# -- `--to`: a recording in other formats, beside the file that it was read from or in a folder of its own -------------

CONVERTIBLE = tuple(name for name, entry in FORMATS.items() if not entry.needs)
"""What a recording from elsewhere can be turned into."""


def _formats(text: str) -> tuple[str, ...]:
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


def _converted(report: "MeasuredReport", options: argparse.Namespace) -> "MeasuredReport":
    """The recording in other formats, beside the file or in `--out`.

    Raises:
        UsageError: something else stands there, or the files cannot be written.
        InterchangeError: the format cannot carry it, or a package is missing.
    """
    folder = options.out or options.file.parent
    exports = list(_exports(report, options))
    files = {
        name: content if isinstance(content, bytes) else content.encode()
        for export in exports
        for name, content in export.files.items()
    }
    place_files(folder, files, force=options.force)
    remarks = dict.fromkeys((*report.remarks, *(remark for export in exports for remark in export.remarks)))
    return replace(report, remarks=tuple(remarks), written=tuple(str(folder / name) for name in files))


def _exports(report: "MeasuredReport", options: argparse.Namespace) -> "Iterator[Export]":
    from cortex_dsl.interchange.formats import recording_writer_of

    for name in options.to:
        if FORMATS[name].of_recording:
            yield recording_writer_of(name)(report.recording, options.file.stem)
        else:
            yield _with_road(report, _scenario if name == "scn" else _openscenario, options)


def _with_road(
    report: "MeasuredReport",
    write: "Callable[[MeasuredReport, str | None, argparse.Namespace], Export]",
    options: argparse.Namespace,
) -> "Export":
    """What is written on the road that was read, and beside it a copy of that."""
    from engine.interchange.contract import Export

    road = report.road
    export = write(report, None if road is None else road.path.name, options)
    copy = {} if road is None else {road.path.name: road.copy()}
    return Export({**export.files, **copy}, export.remarks)


def _openscenario(report: "MeasuredReport", road: str | None, options: argparse.Namespace) -> "Export":
    from engine.interchange.contract import ExportOptions
    from engine.interchange.openscenario import write_trajectories

    how = ExportOptions() if options.osc is None else ExportOptions(options.osc)
    return write_trajectories(report.recording, options.file.stem, how, road)


def _scenario(report: "MeasuredReport", road: str | None, options: argparse.Namespace) -> "Export":
    """Everybody replayed, and params around the start of the ego and of the one who decides the risk."""
    from cortex_dsl.interchange.recorded_scn import write_recorded

    return write_recorded(report.recording, options.file.stem, road, report.pair + 1)


# -- the two commands --------------------------------------------------------------------------------------------------

EPILOG = """\
tables: one row for each actor and time, as CSV or Parquet; positions are
centres of outlines. Either omega-prime's columns (total_nanos, idx, x, y, …,
yaw, type, role, subtype), or
  needed         time [s], id, x [m], y [m]
  where missing  heading [rad] and speed [m/s] follow from the motion;
                 length [m], width [m], type and role get usual values
  other names and units are understood: t, track_id, yaw_deg, speed [km/h],
  timestamp_ms, vx and vy; a `frame` needs --rate; for any others, see
  --columns. Times may be dates, and numbers have decimal commas
inD, rounD, uniD, exiD, highD, INTERACTION, Argoverse 2, NGSIM, and logs of
esmini, SUMO (FCD), CARLA, CommonRoad and OSI are recognized by their contents,
and read with their units and conventions; keep their files in one folder."""
USAGE = "FILE [--ego NAME] [--to FORMATS] [options]"
USAGE_OF_ALL = "FILE [--ego NAME | --all] [--to FORMATS] [options]"


def _command(reader: Reader, description: str, epilog: str = "") -> Command:
    return Command(
        name=reader.name,
        usage=USAGE_OF_ALL if reader is MEASURED else USAGE,
        description=description,
        options=partial(_options, reader),
        function=partial(_perform, reader),
        epilog=epilog,
        needs=("file", f"{reader.name} what? name a recording", reader.example),
    )


MEASURE = _command(
    MEASURED,
    "Judge a recorded case by the metrics and the risk of cortexc: a table of\n"
    "trajectories, or an OpenSCENARIO file whose actors follow timed polylines.",
    EPILOG,
)
IMPORT = _command(
    IMPORTED,
    "Read an OpenSCENARIO file whose actors follow timed polylines, with the\n"
    "OpenDRIVE road beside it, and judge it by the metrics and the risk of cortexc.\n"
    "Nothing is downloaded.",
)
