"""The table of export formats for a case, their writers and checkers, and the files of several cases in memory.

Each function imports its modules when it is called: a writer, or the loader of a checker. A new format is a row and two
functions; see CONTRIBUTING.md.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Protocol

from cortex_dsl.interchange.cases import ExportCase
from engine.errors import InterchangeError
from engine.extras import installing, is_installed
from engine.interchange.contract import Export, ExportOptions, Finding

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from engine.interchange.recording import Recording


TABLES = (".csv", ".parquet")
LOGS = (".xml", ".txt", ".log", ".osi", ".mcap")
SCENARIO = ".xosc"
RECORDINGS = (*TABLES, *LOGS, SCENARIO)
"""Suffixes of readable recordings: tables of trajectories, logs of simulators and data sets (see
`engine.interchange.sources`), and OpenSCENARIO files with timed polylines."""


class Writer(Protocol):
    """Function that returns the files of one case; their names begin with `stem`."""

    def __call__(self, case: "ExportCase", stem: str, options: ExportOptions, /) -> Export: ...


class RecordingWriter(Protocol):
    """Function that returns the files of a recording; their names begin with `stem`."""

    def __call__(self, recording: "Recording", stem: str, /) -> Export: ...


class Checker(Protocol):
    """Function that returns the errors in the files of one case, which were written into a folder under these names."""

    def __call__(
        self, case: "ExportCase", folder: Path, names: Sequence[str], options: ExportOptions, /
    ) -> Iterator[Finding]: ...


@dataclass(frozen=True)
class Format:
    """One row."""

    suffixes: tuple[str, ...]
    """Suffixes of the files that it writes; first the file to open."""
    summary: str
    """Contents of these files."""
    readers: str
    """Programs that read them."""
    opened: str
    """Instruction for opening the first file, which is `{file}`."""
    writer: Writer
    """Function that writes a case."""
    load_checker: Callable[[], Checker]
    """Function that imports the checker, which reads the written files back and compares them with the run."""
    checked: str
    """Quantities that the checker compares; `{mode}`: the form of an OpenSCENARIO file."""
    of_recording: RecordingWriter | None = None
    """Function that writes a recording from elsewhere; None: the format needs more than motion."""
    needs: str = ""
    """Data that an imported recording lacks, so that it cannot be written in this format."""
    package: str = ""
    """Package that must be installed in addition to cortexc, by the name of its import."""
    extra: str = ""
    """The extra of cortexc that brings it."""


# -- writers: one case in one format, with its road --------------------------------------------------------------------


def openscenario(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """Return the `.xosc`, by replay or by maneuvers, and its road."""
    from engine.interchange.after_contact import shown_after_contact

    road = opendrive(case, stem, options)
    (road_file,) = road.files
    if options.mode == "maneuver":
        from cortex_dsl.interchange.maneuvers import maneuver_files

        export = maneuver_files(case, stem, options, road_file)
        return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))
    if options.player == "carla":
        from engine.interchange.openscenario.carla import write_for_carla as write
    else:
        from engine.interchange.openscenario import write_trajectories as write
    replay = shown_after_contact(case.replay, options.after_contact or "through")
    export = write(replay, stem, options, road_file)
    return Export({**export.files, **road.files}, (*case.left_out, *export.remarks, *road.remarks))


def opendrive(case: "ExportCase", _stem: str, options: ExportOptions) -> Export:
    """Return the road, under a name that all cases of the scenario share."""
    from cortex_dsl.api.concrete import map_copies
    from cortex_dsl.interchange.cases import road_name
    from engine.errors import InterchangeError
    from engine.interchange.opendrive import SOMEWHERE, write_opendrive
    from engine.maps import LaneletFile, MapFile

    program, name = case.scenario.program, road_name(case.scenario)
    if isinstance(program.road_spec, LaneletFile):
        what = "this format needs the road as OpenDRIVE, and a Lanelet2 map is not written as one"
        raise InterchangeError(what, "export to csv, mcap, commonroad or scn", program.road_spec.file)
    if isinstance(program.road_spec, MapFile):
        return Export(dict(map_copies(program)))
    place = SOMEWHERE if options.player == "carla" else ""
    text = write_opendrive(program.road_spec, case.recording.signals, name, case.road_provenance, place)
    return Export({f"{name}.xodr": text})


def parquet(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """Return the table of trajectories, with the road in its metadata, as omega-prime stores it.

    Raises:
        InterchangeError: pyarrow is not installed.
    """
    from engine.interchange.after_contact import shown_after_contact
    from engine.interchange.tables import write_parquet

    ((name, road),) = opendrive(case, stem, options).files.items()
    text = road if isinstance(road, str) else road.decode("utf-8", "replace")
    replay = shown_after_contact(case.replay, options.after_contact or "physics")
    export = write_parquet(replay, stem, (PurePath(name).stem, text))
    return Export(export.files, (*case.left_out, *export.remarks))


def scenic(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """Return `<stem>.scenic` and the road that it reads.

    Raises:
        InterchangeError: Scenic cannot read the road, or an import of the scenario.
    """
    from cortex_dsl.interchange.scenic import refuse_left_hand, write_scenic

    refuse_left_hand(case)
    road = opendrive(case, stem, options)
    (road_file,) = road.files
    export = write_scenic(case, f"{stem}.scenic", road_file)
    return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))


def csv(recording: "Recording", stem: str) -> Export:
    from engine.interchange.tables import write_csv

    return write_csv(recording, stem)


def parquet_of_recording(recording: "Recording", stem: str) -> Export:
    from engine.interchange.tables import write_parquet

    return write_parquet(recording, stem)


def mcap(recording: "Recording", stem: str) -> Export:
    from engine.interchange.mcap import write_mcap

    return write_mcap(recording, stem)


def commonroad(recording: "Recording", stem: str) -> Export:
    from engine.interchange.commonroad import write_commonroad

    return write_commonroad(recording, stem)


def scn(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    from cortex_dsl.interchange.scn import write_scn

    return write_scn(case, stem, options)


def _of_recording(write: RecordingWriter) -> Writer:
    """Turn a writer of recordings into a writer of cases: it writes present actors, with remarks on the others."""

    def written(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
        from engine.interchange.after_contact import shown_after_contact

        export = write(shown_after_contact(case.replay, options.after_contact or "physics"), stem)
        return replace(export, remarks=(*case.left_out, *export.remarks))

    return written


# -- loaders of checkers: the files of one case, read back -------------------------------------------------------------


def _check_xosc() -> Checker:
    from engine.interchange.openscenario.check import check_openscenario

    return check_openscenario


def _check_xodr() -> Checker:
    from engine.interchange.opendrive.check import check_opendrive

    return check_opendrive


def _check_commonroad() -> Checker:
    from engine.interchange.commonroad.check import check_commonroad

    return check_commonroad


def _check_scenic() -> Checker:
    from cortex_dsl.interchange.scenic.write import check_scenic

    return check_scenic


def _check_table() -> Checker:
    from engine.interchange.tables.read import check_table

    return check_table


def _check_mcap() -> Checker:
    from engine.interchange.mcap.check import check_mcap

    return check_mcap


def _check_scn() -> Checker:
    from cortex_dsl.interchange.scn import check_scn

    return check_scn


# -- the table ---------------------------------------------------------------------------------------------------------

PLAYED_BY_CARLA = "python scenario_runner.py --sync --frameRate RATE --openscenario {file}"
"""Command for an `.xosc` written for CARLA, in the folder of ScenarioRunner; RATE is in ticks a second."""
_ROAD, _SCENARIO = "a road made by `map`", "the scenario that it was a run of"
_MOTION = "motion at every sample, metrics and risk"
FORMATS: Mapping[str, Format] = {
    "xosc": Format(
        suffixes=(".xosc", ".xodr"),
        summary="OpenSCENARIO XML, and its road",
        readers="esmini, CARLA's ScenarioRunner, RoadRunner, dSPACE, Vector",
        opened="esmini --window 60 60 1000 600 --traj_filter 0 --osc {file}",
        writer=openscenario,
        load_checker=_check_xosc,
        checked="{mode}; the road's lanes",
    ),
    "xodr": Format(
        suffixes=(".xodr",),
        summary="OpenDRIVE: the road alone",
        readers="esmini, CARLA, SUMO's netconvert, Scenic",
        opened="odrviewer --window 60 60 1000 600 --odr {file}",
        writer=opendrive,
        load_checker=_check_xodr,
        checked="ids, links, and where the lanes lie",
        needs=_ROAD,
    ),
    "commonroad": Format(
        suffixes=(".cr.xml", ".solution.xml"),
        summary="CommonRoad 2020a: scenario, and the ego's motion as a solution",
        readers="commonroad-io, its drivability checker, CriMe",
        opened="from Python: CommonRoadFileReader('{file}').open()",
        writer=_of_recording(commonroad),
        of_recording=commonroad,
        needs=_ROAD,
        load_checker=_check_commonroad,
        checked="ids, references, the actors; motion is not read back",
    ),
    "scenic": Format(
        suffixes=(".scenic", ".xodr"),
        summary="Scenic source with every value fixed, and its road",
        readers="Scenic 3, and through it CARLA and MetaDrive",
        opened="scenic --2d {file}",
        writer=scenic,
        load_checker=_check_scenic,
        checked="the start of every actor; what follows is Scenic's own simulation",
        needs=_SCENARIO,
    ),
    "csv": Format(
        suffixes=(".csv",),
        summary="trajectories, in omega-prime's columns",
        readers="pandas, omega-prime, spreadsheets",
        opened="cortexc measure {file}",
        writer=_of_recording(csv),
        of_recording=csv,
        load_checker=_check_table,
        checked=_MOTION,
    ),
    "parquet": Format(
        suffixes=(".parquet",),
        summary="the same as a Parquet table, and the road in its metadata",
        readers="pandas, polars, DuckDB",
        opened="cortexc measure {file}",
        writer=parquet,
        of_recording=parquet_of_recording,
        load_checker=_check_table,
        checked=_MOTION,
        package="pyarrow",
        extra="export",
    ),
    "mcap": Format(
        suffixes=(".mcap",),
        summary="a scene that plays in a viewer",
        readers="Foxglove, Lichtblick, rerun",
        opened="open {file} in Foxglove or Lichtblick",
        writer=_of_recording(mcap),
        of_recording=mcap,
        load_checker=_check_mcap,
        checked="every message: actors, positions, headings, sizes, speeds, pedals",
        package="mcap",
        extra="export",
    ),
    "scn": Format(
        suffixes=(".scn",),
        summary="a scenario of cortexc that runs to the same outcome",
        readers="cortexc",
        opened="cortexc {file}",
        writer=scn,
        load_checker=_check_scn,
        checked="compiled and run again: every state and every metric, bit for bit",
    ),
}
"""Formats by the name that `--to` takes."""


CHECKED_BY_MODE: Mapping[str, str] = {
    "trajectory": _MOTION,
    "maneuver": "the rules of the format; motion is not checked, as only a simulator produces it",
}
"""Scope of the check of an `.xosc`, by its form."""


def checked_of(name: str, mode: str) -> str:
    """Return the scope of a check."""
    return FORMATS[name].checked.format(mode=CHECKED_BY_MODE[mode])


def missing_extra(name: str) -> str:
    """Return how to install the missing package of a format; "" if nothing is missing."""
    entry = FORMATS[name]
    return "" if is_installed(entry.package) else installing(entry.extra)


# -- all files of the requested cases ----------------------------------------------------------------------------------


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
