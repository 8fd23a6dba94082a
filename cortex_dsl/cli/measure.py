"""`cortexc measure FILE`: metrics and risk of a recorded case, from any driver: a table of trajectories, or an `.xosc`.

`cortexc import FILE.xosc` does the same for a case that another tool wrote, and reads its road too.
"""

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.export import OSC, esmini_named
from cortex_dsl.console.command import Command, Condition, Option, typed_again
from cortex_dsl.console.request import seconds, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import OverwriteFlags, place_files, reason
from cortex_dsl.interchange.formats import FORMATS, RECORDINGS, SCENARIO
from cortex_dsl.spelling import nearest
from engine.errors import InterchangeError
from engine.interchange.contract import Export, ExportOptions

if TYPE_CHECKING:
    from cortex_dsl.report.findings.interchange_report import MeasuredReport
    from cortex_dsl.report.findings.ranking_report import RankedReport
    from engine.interchange.openscenario.read import Imported
    from engine.interchange.tables.track import Tracks


@dataclass(frozen=True)
class Reader:
    """Kinds of recordings that `measure` or `import` reads."""

    name: str
    suffixes: tuple[str, ...]
    example: str


MEASURED = Reader("measure", RECORDINGS, "cortexc measure trajectories.csv")
IMPORTED = Reader("import", (SCENARIO,), "cortexc import case.xosc")


def _perform(reader: Reader, options: argparse.Namespace, terminal: Terminal) -> int:
    """Read, measure, show."""
    for row in (*TABLES, *RANKING):  # `import` has none of them
        vars(options).setdefault(row.dest, row.default)
    _check(reader, options)
    try:
        if options.all:
            return _rank(options, terminal)
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
    if options.table is not None and options.table == options.page:
        raise UsageError(f"--table and --page are both `{options.table}`", "name two files")


def _instead(path: Path, reader: Reader) -> str:
    """Return a hint on the command that reads this kind of file."""
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
        again=typed_again(reader.name, options.command_line),
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
        esmini=_esmini_of(options),
    )


def _refused(error: InterchangeError, options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Report that the file has errors, or lacks the requested contents."""
    message = f"{error.place}: {error.message}" if error.place else error.message
    terminal.complain(message, error.cure)
    if options.json:
        content = {"message": message, "help": error.cure or None, "exit_code": int(Exit.DIAGNOSTICS)}
        terminal.document("error", content)
    return Exit.DIAGNOSTICS


def _show(report: "MeasuredReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.interchange_report import measured_content
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.views.recordings import measured_view

    if options.json:
        terminal.document("measure", measured_content(report))
    else:
        console = terminal.out
        console.print(rendered(measured_view(report), console.width, ascii_only=console.options.ascii_only))


# -- values of options that say how a recording is read ----------------------------------------------------------------


def _profile(text: str) -> str:
    from engine.risk import PROFILES

    if text not in PROFILES:
        match = nearest(text, PROFILES)
        meant = f"did you mean `{match}`?" if match else f"there are {', '.join(PROFILES)}"
        raise argparse.ArgumentTypeError(f"cannot be `{text}`: {meant}")
    return text


def _rate_of(text: str) -> float:
    """Return the samples per second."""
    try:
        value = float(text.removesuffix("Hz"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be samples a second, not `{text}`") from None
    if not 0.001 <= value <= 100_000.0:
        raise argparse.ArgumentTypeError(f"must lie between 0.001 and 100,000 a second, not {text}")
    return value


def _columns_of(text: str) -> tuple[tuple[str, str], ...]:
    """Return pairs: meaning of a column, with its unit if one is given, and its name in the table."""
    pairs = tuple(
        (name.strip(), column.strip()) for name, _, column in (each.partition("=") for each in text.split(","))
    )
    if not all(name and column for name, column in pairs):
        raise argparse.ArgumentTypeError(f"must be names and columns, as in time=zeit,actor=objekt, not `{text}`")
    for place in (0, 1):
        named = [pair[place] for pair in pairs]
        if twice := next((name for name in named if named.count(name) > 1), None):
            raise argparse.ArgumentTypeError(f"names `{twice}` twice")
    return pairs


def _window_of(text: str) -> tuple[float, float]:
    """Return begin and end [s]."""
    try:
        begin, end = (float(part.removesuffix("s")) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be two times, as in 12.4,18, not `{text}`") from None
    if not 0.0 <= begin < end < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a time from 0 on and a later one, not `{text}`")
    return begin, end


def _meters(text: str) -> float:
    try:
        value = float(text.removesuffix("m"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number of metres, not `{text}`") from None
    if not NEAREST <= value <= FARTHEST:
        raise argparse.ArgumentTypeError(f"must lie between {NEAREST:g} and {FARTHEST:g} m, not {text}")
    return value


# -- `--to`: a recording in other formats, next to its file or in a folder of its own ----------------------------------

CONVERTIBLE = tuple(name for name, entry in FORMATS.items() if not entry.needs)
"""Formats to which an imported recording can be converted."""


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
    """Write the recording in other formats, next to the file or in `--out`.

    Raises:
        UsageError: a file is in the way, or the files cannot be written.
        InterchangeError: the format cannot represent it, or a package is missing.
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


def _exports(report: "MeasuredReport", options: argparse.Namespace) -> Iterator[Export]:
    for name in options.to:
        if write := FORMATS[name].of_recording:
            yield write(report.recording, options.file.stem)
        else:
            yield _with_road(report, _scenario if name == "scn" else _openscenario, options)


def _with_road(
    report: "MeasuredReport",
    write: "Callable[[MeasuredReport, str | None, argparse.Namespace], Export]",
    options: argparse.Namespace,
) -> Export:
    """Write an export that refers to the road of the recording, and a copy of the road next to it."""
    road = report.road
    export = write(report, None if road is None else road.path.name, options)
    copy = {} if road is None else {road.path.name: road.copy()}
    return Export({**export.files, **copy}, export.remarks)


def _openscenario(report: "MeasuredReport", road: str | None, options: argparse.Namespace) -> Export:
    from engine.interchange.openscenario import write_trajectories

    how = ExportOptions() if options.osc is None else ExportOptions(options.osc)
    return write_trajectories(report.recording, options.file.stem, how, road)


def _scenario(report: "MeasuredReport", road: str | None, options: argparse.Namespace) -> Export:
    """Write a scenario that replays all actors.

    Its params vary the start of the ego and of the actor that decides the risk.
    """
    from cortex_dsl.interchange.recorded_scn import write_recorded

    return write_recorded(report.recording, options.file.stem, road, report.pair + 1)


# -- `--all`: every pair of a recording, the worst first ---------------------------------------------------------------

NEAREST, FARTHEST = 1.0, 1000.0
OVERWRITE = OverwriteFlags("--table or --page", "--force")


def _rank(options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Read a recording, assess every pair, write the requested files, and show the worst.

    Raises:
        InterchangeError: it cannot be read, or is too much.
        UsageError: a file stands in the way, or cannot be written.
    """
    from cortex_dsl.console.kernels import PAIRS, compile_kernels
    from cortex_dsl.report.findings.ranking_report import RankedReport
    from engine.interchange.every_pair import NEAR, rank_pairs
    from engine.interchange.sources import read_traffic

    tracks = read_traffic(options.file, options.rate, _esmini_of(options), dict(options.columns))
    compile_kernels(terminal, PAIRS)
    near = NEAR if options.near is None else options.near
    ranked = rank_pairs(tracks, near=near, step=options.step, profile=options.profile)
    written = tuple(str(path) for path in (options.table, options.page) if path is not None)
    report = RankedReport(
        str(options.file),
        ranked,
        near,
        options.profile,
        options.top,
        ranked.remarks,
        typed_again("measure", options.command_line),
        written,
    )
    _write_ranking(report, tracks, options)
    _show_ranking(report, options, terminal)
    return Exit.FINE


def _write_ranking(report: "RankedReport", tracks: "Tracks", options: argparse.Namespace) -> None:
    """Write both files, once both are made; a file in the way of either is reported before any is written."""
    files: dict[Path, bytes] = {}
    if options.table is not None:
        from cortex_dsl.report.findings.ranking_report import ranking_csv

        files[options.table] = ranking_csv(report.ranked).encode()
    if options.page is not None:
        from cortex_dsl.report.page.ranking_page import ranking_page

        files[options.page] = ranking_page(report, tracks).encode()
    for path in sorted(files, key=os.path.lexists, reverse=True):
        place_files(path.parent, {path.name: files[path]}, force=options.force, flags=OVERWRITE)


def _show_ranking(report: "RankedReport", options: argparse.Namespace, terminal: Terminal) -> None:
    if options.json:
        from cortex_dsl.report.findings.ranking_report import ranking_content

        terminal.document("ranking", ranking_content(report))
    else:
        from cortex_dsl.report.terminal.render import rendered
        from cortex_dsl.report.views.recordings import ranking_view

        terminal.out.print(rendered(ranking_view(report), terminal.out.width))


def _esmini_of(options: argparse.Namespace) -> Path | None:
    """Return the library of esmini that plays an `.xosc`; None if no library is named.

    Raises:
        UsageError: there is no library.
    """
    from engine.interchange.esmini import VARIABLE

    plays = options.file.suffix.lower() == SCENARIO
    return esmini_named(options.esmini) if options.esmini or (plays and os.environ.get(VARIABLE)) else None


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
OF_PAIRS = Condition("--all, which has no ego", lambda options: options.all is not None)
OTHER_FILE = Condition("a file that is no .xosc", lambda options: options.file.suffix.lower() != SCENARIO)
TO_XOSC = Condition("--to xosc", lambda options: "xosc" in (options.to or ()), "add xosc to --to")
TABLES = (
    Option("--rate", "frames per second of a table of frames", "HZ", _rate_of),
    Option(
        "--columns",
        "columns of a table whose names are not known: time=zeit,actor=objekt",
        "NAME=COLUMN,…",
        _columns_of,
        default=(),
    ),
)
RANKING = (
    Option("--all", "judge every pair of actors that comes near each other, the worst first", default=False),
    Option("--near", "with --all: the largest distance of a pair to judge (50 m)", "M", _meters, needs=("all",)),
    Option("--top", "with --all: number of rows to show", "N", whole_number(1, 100_000), default=20, needs=("all",)),
    Option("--table", "with --all: write every row into a table", "CSV", Path, needs=("all",)),
    Option("--page", "with --all: write a page with drawings", "HTML", Path, needs=("all",)),
)


def _options(reader: Reader) -> tuple[Option, ...]:
    endings = ", ".join(f"*{suffix}" for suffix in reader.suffixes)
    alone = (OF_PAIRS,) if reader is MEASURED else ()
    missing = (f"{reader.name} what? name a recording", reader.example)
    return (
        Option("file", f"a recording: {endings}", "FILE", Path, nargs="?", missing=missing),
        Option("--ego", "the actor to judge (the one called ego, or else the first)", "NAME", excludes=alone),
        Option("--step", "time step of the metrics (that of the file)", "S", seconds(0.0001, 10.0)),
        *(TABLES if reader is MEASURED else ()),
        Option(
            "--window", "only a part: start and end, in seconds after the first row", "S,S", _window_of, excludes=alone
        ),
        Option("--profile", "thresholds of the risk", "NAME", _profile, default="paper"),
        Option("--esmini", "library that plays an xosc (CORTEXC_ESMINI)", "PATH", Path, excludes=(OTHER_FILE,)),
        Option("--to", f"also write it as: {', '.join(CONVERTIBLE)}", "FORMATS", _formats, excludes=alone),
        replace(OSC, needs=(TO_XOSC,)),
        Option("--out", "folder for the written files (that of FILE)", "DIR", Path, needs=("to",)),
        Option("--force", "overwrite files that have other contents", default=False, needs=("to table page",)),
        *(RANKING if reader is MEASURED else ()),
    )


USAGE = "FILE [--ego NAME] [--to FORMATS] [options]"
USAGE_OF_ALL = "FILE [--ego NAME | --all] [--to FORMATS] [options]"


def _command(reader: Reader, description: str, epilog: str = "") -> Command:
    return Command(
        name=reader.name,
        usage=USAGE_OF_ALL if reader is MEASURED else USAGE,
        description=description,
        options=_options(reader),
        function=partial(_perform, reader),
        epilog=epilog,
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
