"""The table of formats that a case can be written in. A new one is a row here and a function; see CONTRIBUTING.md."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from engine.extras import installing, is_installed

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from engine.interchange.contract import Export, ExportOptions, Finding
    from engine.interchange.recording import Recording

TABLES = (".csv", ".parquet")
LOGS = (".xml", ".txt", ".log", ".osi", ".mcap")
SCENARIO = ".xosc"
RECORDINGS = (*TABLES, *LOGS, SCENARIO)
"""Suffixes of the recordings that are read: tables of trajectories, what simulators and data sets write otherwise (see
`engine.interchange.sources`), and OpenSCENARIO files with timed polylines."""


class Writer(Protocol):
    """What a row names: the files of one case, whose names begin with `stem`."""

    def __call__(self, case: "ExportCase", stem: str, options: "ExportOptions", /) -> "Export": ...


@dataclass(frozen=True)
class Format:
    """One row."""

    suffixes: tuple[str, ...]
    """Of the files it writes, the one to open first before the others."""
    summary: str
    """What is in them."""
    readers: str
    """Who reads them."""
    opened: str
    """What to do with it, `{file}` being the first file."""
    checker: str
    """`module:function` of its `Checker`, which reads back what was written; imported when it is asked for."""
    checked: str
    """What that holds against the run, `{mode}` being how OpenSCENARIO is written."""
    writer: str = ""
    """The same of its `Writer`."""
    of_recording: str = ""
    """`module:function` of a recording and a stem: in its place where nothing else of the case is written, and for
    recordings from elsewhere."""
    needs: str = ""
    """What a recording from elsewhere lacks, so that it cannot be turned into this."""
    package: str = ""
    """What must be installed beside cortexc, by the name of its import."""
    extra: str = ""
    """The extra of cortexc that brings it."""


class RecordingWriter(Protocol):
    """The files of a recording, whose names begin with `stem`."""

    def __call__(self, recording: "Recording", stem: str, /) -> "Export": ...


class Checker(Protocol):
    """What is wrong with the files of one case, which were written into a folder under these names."""

    def __call__(
        self, case: "ExportCase", folder: Path, names: Sequence[str], options: "ExportOptions", /
    ) -> "Iterator[Finding]": ...


PLAYED_BY_CARLA = "python scenario_runner.py --sync --frameRate RATE --openscenario {file}"
"""What to do with an `.xosc` written for CARLA, in the folder of ScenarioRunner; RATE is in ticks a second."""
_HERE, _ENGINE = "cortex_dsl.interchange", "engine.interchange"
_ROAD, _SCENARIO = "a road made by `map`", "the scenario that it was a run of"
_MOTION = "motion at every sample, metrics and risk"
FORMATS: Mapping[str, Format] = {
    "xosc": Format(
        suffixes=(".xosc", ".xodr"),
        summary="OpenSCENARIO XML, and its road",
        readers="esmini, CARLA's ScenarioRunner, RoadRunner, dSPACE, Vector",
        opened="esmini --window 60 60 1000 600 --traj_filter 0 --osc {file}",
        writer=f"{_HERE}.writing:openscenario",
        checker=f"{_ENGINE}.openscenario.check:check_openscenario",
        checked="{mode}; the road's lanes",
    ),
    "xodr": Format(
        suffixes=(".xodr",),
        summary="OpenDRIVE: the road alone",
        readers="esmini, CARLA, SUMO's netconvert, Scenic",
        opened="odrviewer --window 60 60 1000 600 --odr {file}",
        writer=f"{_HERE}.writing:opendrive",
        checker=f"{_ENGINE}.opendrive.check:check_opendrive",
        checked="ids, links, and where the lanes lie",
        needs=_ROAD,
    ),
    "commonroad": Format(
        suffixes=(".cr.xml", ".solution.xml"),
        summary="CommonRoad 2020a: scenario, and the ego's motion as a solution",
        readers="commonroad-io, its drivability checker, CriMe",
        opened="from Python: CommonRoadFileReader('{file}').open()",
        of_recording=f"{_ENGINE}.commonroad:write_commonroad",
        needs=_ROAD,
        checker=f"{_ENGINE}.commonroad.check:check_commonroad",
        checked="ids, references, the actors; motion is not read back",
    ),
    "scenic": Format(
        suffixes=(".scenic", ".xodr"),
        summary="Scenic source with every value fixed, and its road",
        readers="Scenic 3, and through it CARLA and MetaDrive",
        opened="scenic --2d {file}",
        writer=f"{_HERE}.writing:scenic",
        checker=f"{_HERE}.scenic.write:check_scenic",
        checked="the start of every actor; what follows is Scenic's own simulation",
        needs=_SCENARIO,
    ),
    "csv": Format(
        suffixes=(".csv",),
        summary="trajectories, in omega-prime's columns",
        readers="pandas, omega-prime, spreadsheets",
        opened="cortexc measure {file}",
        of_recording=f"{_ENGINE}.tables:write_csv",
        checker=f"{_ENGINE}.tables.read:check_table",
        checked=_MOTION,
    ),
    "parquet": Format(
        suffixes=(".parquet",),
        summary="the same as a Parquet table, and the road in its metadata",
        readers="pandas, polars, DuckDB",
        opened="cortexc measure {file}",
        writer=f"{_HERE}.writing:parquet",
        of_recording=f"{_ENGINE}.tables:write_parquet",
        checker=f"{_ENGINE}.tables.read:check_table",
        checked=_MOTION,
        package="pyarrow",
        extra="export",
    ),
    "mcap": Format(
        suffixes=(".mcap",),
        summary="a scene that plays in a viewer",
        readers="Foxglove, Lichtblick, rerun",
        opened="open {file} in Foxglove or Lichtblick",
        of_recording=f"{_ENGINE}.mcap:write_mcap",
        checker=f"{_ENGINE}.mcap.check:check_mcap",
        checked="every message: actors, positions, headings, sizes, speeds, pedals",
        package="mcap",
        extra="export",
    ),
    "scn": Format(
        suffixes=(".scn",),
        summary="a scenario of cortexc that runs to the same outcome",
        readers="cortexc",
        opened="cortexc {file}",
        writer=f"{_HERE}.scn:write_scn",
        checker=f"{_HERE}.scn:check_scn",
        checked="compiled and run again: every state and every metric, bit for bit",
    ),
}
"""By the name that `--to` takes."""


CHECKED_BY_MODE: Mapping[str, str] = {
    "trajectory": _MOTION,
    "maneuver": "the rules of the format; motion is not checked, as only a simulator produces it",
}
"""What is checked of an `.xosc`, by how it is written."""


def writer_of(name: str) -> Writer:
    """The function behind a row."""
    entry = FORMATS[name]
    return _function(entry.writer) if entry.writer else _of_recording(recording_writer_of(name))


def _of_recording(write: RecordingWriter) -> Writer:
    """Turn a writer of recordings into a writer of cases: it writes actors that take part and remarks on others."""

    def written(case: "ExportCase", stem: str, options: "ExportOptions") -> "Export":
        from engine.interchange.after_contact import shown_after_contact

        export = write(shown_after_contact(case.replay, options.after_contact or "physics"), stem)
        return replace(export, remarks=(*case.left_out, *export.remarks))

    return written


def recording_writer_of(name: str) -> "RecordingWriter":
    """Return the row's writer that needs a recording only."""
    return _function(FORMATS[name].of_recording)


def checker_of(name: str) -> Checker:
    """The one that checks what was written."""
    return _function(FORMATS[name].checker)


def checked_of(name: str, mode: str) -> str:
    """What a check looks at."""
    return FORMATS[name].checked.format(mode=CHECKED_BY_MODE[mode])


def _function(place: str) -> Any:
    module, _, function = place.partition(":")
    return getattr(import_module(module), function)


def missing_extra(name: str) -> str:
    """How to install what a format needs and is not there; "" where nothing is missing."""
    entry = FORMATS[name]
    return "" if is_installed(entry.package) else installing(entry.extra)
