"""The table of formats that a case can be written in. A new one is a row here and a function; see CONTRIBUTING.md."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from cortex_dsl.exports.cases import ExportCase
    from cortex_dsl.exports.findings import Finding
    from engine.interchange.export import Export, ExportOptions


class Writer(Protocol):
    """What a row names: the files of one case, whose names begin with `stem`."""

    def __call__(self, case: "ExportCase", stem: str, options: "ExportOptions") -> "Export": ...


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
    writer: str
    """`module:function` of its `Writer`; imported when it is asked for."""
    checker: str = ""
    """The same of its `Checker`, which reads back what was written."""
    package: str = ""
    """What must be installed beside cortexc, by the name of its import."""
    extra: str = ""
    """The extra of cortexc that brings it."""


class Checker(Protocol):
    """What is wrong with the files of one case, which were written into a folder under these names."""

    def __call__(
        self, case: "ExportCase", folder: Path, names: Sequence[str], options: "ExportOptions"
    ) -> "Iterator[Finding]": ...


_MOTION = "cortex_dsl.exports.writers"
_CHECKS = "cortex_dsl.exports.checking"
FORMATS: Mapping[str, Format] = {
    "xosc": Format(
        suffixes=(".xosc", ".xodr"),
        summary="OpenSCENARIO XML, and its road",
        readers="esmini, CARLA's ScenarioRunner, RoadRunner, dSPACE, Vector",
        opened="esmini --window 60 60 1000 600 --traj_filter 0 --osc {file}",
        writer=f"{_MOTION}:openscenario",
        checker=f"{_CHECKS}.motion:openscenario",
    ),
    "xodr": Format(
        suffixes=(".xodr",),
        summary="OpenDRIVE: the road alone",
        readers="esmini, CARLA, SUMO's netconvert, Scenic",
        opened="odrviewer --window 60 60 1000 600 --odr {file}",
        writer=f"{_MOTION}:opendrive",
        checker=f"{_CHECKS}.documents:opendrive",
    ),
    "commonroad": Format(
        suffixes=(".cr.xml", ".solution.xml"),
        summary="CommonRoad 2020a: scenario, and the ego's way as a solution",
        readers="commonroad-io, its drivability checker, CriMe",
        opened="from Python: CommonRoadFileReader('{file}').open()",
        writer=f"{_MOTION}:commonroad",
        checker=f"{_CHECKS}.documents:commonroad",
    ),
    "scenic": Format(
        suffixes=(".scenic", ".xodr"),
        summary="Scenic source with every value fixed, and its road",
        readers="Scenic 3, and through it CARLA and MetaDrive",
        opened="scenic --2d {file}",
        writer="cortex_dsl.exports.scenic:files",
        checker=f"{_CHECKS}.documents:scenic",
    ),
    "csv": Format(
        suffixes=(".csv",),
        summary="trajectories, in omega-prime's columns",
        readers="pandas, omega-prime, spreadsheets",
        opened="cortexc measure {file}",
        writer=f"{_MOTION}:csv",
        checker=f"{_CHECKS}.motion:table",
    ),
    "parquet": Format(
        suffixes=(".parquet",),
        summary="the same as a Parquet table",
        readers="pandas, polars, DuckDB",
        opened="cortexc measure {file}",
        writer=f"{_MOTION}:parquet",
        checker=f"{_CHECKS}.motion:table",
        package="pyarrow",
        extra="export",
    ),
    "mcap": Format(
        suffixes=(".mcap",),
        summary="a scene that plays in a viewer",
        readers="Foxglove, Lichtblick, rerun",
        opened="open {file} in Foxglove or Lichtblick",
        writer=f"{_MOTION}:mcap",
        package="mcap",
        extra="export",
    ),
    "scn": Format(
        suffixes=(".scn",),
        summary="a scenario of cortexc that runs to the same outcome",
        readers="cortexc",
        opened="cortexc {file}",
        writer=f"{_MOTION}:scn",
        checker=f"{_CHECKS}.motion:scenario",
    ),
}
"""By the name that `--to` takes."""


def writer_of(name: str) -> Writer:
    """The function behind a row."""
    return _function(FORMATS[name].writer)


def checker_of(name: str) -> Checker | None:
    """The one that checks what was written; None where nothing of ours reads the format."""
    return _function(FORMATS[name].checker) if FORMATS[name].checker else None


def _function(place: str) -> Any:
    module, _, function = place.partition(":")
    return getattr(import_module(module), function)


def missing_extra(name: str) -> str:
    """How to install what a format needs and is not there; "" where nothing is missing."""
    entry = FORMATS[name]
    if not entry.package or find_spec(entry.package) is not None:
        return ""
    return f"pip install 'cortexc[{entry.extra}]'"
