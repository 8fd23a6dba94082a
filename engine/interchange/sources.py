"""Sources of `measure`: one row for each kind of file, and the function that reads any of them.

Rows do not describe columns: tables of known tools are rows of `tables.layouts`. A new kind of file is a function from
a path to `Tracks`, a row here, and a sample in its test.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType

import numpy as np

from engine.errors import InterchangeError, reading
from engine.interchange.mcap.read import road_of_mcap
from engine.interchange.openscenario import read as openscenario
from engine.interchange.openscenario.read import Imported
from engine.interchange.recording import SAME_INSTANT, Recording
from engine.interchange.road_levels import level_notes
from engine.interchange.tables.columns import NO_NAMES
from engine.interchange.tables.heights import may_be_apart
from engine.interchange.tables.parquet import embedded_road
from engine.interchange.tables.read import Window, read_tracks, recording_of
from engine.interchange.tables.track import TableTrack, Tracks
from engine.opendrive.read import read_opendrive
from engine.tables import SLIDING
from engine.vocabulary import State

HEAD = 4096
"""Bytes at the beginning of a file that identify its kind."""
SCENARIO = ".xosc"


@dataclass(frozen=True)
class Source:
    """One kind of file."""

    what: str
    """Description in words."""
    suffixes: tuple[str, ...]
    mark: bytes
    """Text within its first bytes, if several kinds share a suffix."""
    reader: str
    """`module:function` from a path to `Tracks`, imported on demand; "" for files that `read_tracks` reads."""
    conventions: str
    """Its units and reference point, and their conversion."""


SOURCES: Mapping[str, Source] = MappingProxyType(
    {
        "esmini log": Source(
            "esmini's `--csv_logger`",
            (".csv",),
            b"Entitity_Name",
            "engine.interchange.logs.esmini:read_esmini_log",
            "positions are rear axles; they become centres with the logged boxes",
        ),
        "table": Source("a table of trajectories", (".csv", ".parquet"), b"", "", "see the layouts"),
        "SUMO": Source(
            "SUMO's FCD output",
            (".xml",),
            b"<fcd-export",
            "engine.interchange.logs.sumo:read_fcd",
            "positions are front bumpers, angles clockwise from north, sizes those of SUMO's classes",
        ),
        "CommonRoad": Source(
            "a CommonRoad scenario",
            (".xml",),
            b"<commonRoad",
            "engine.interchange.logs.commonroad:read_commonroad",
            "time steps of the file's own size; the ego is its solution, `NAME.solution.xml`, where that lies beside; "
            "buildings are walls",
        ),
        "CARLA": Source(
            "CARLA's recorder, as text",
            (".txt", ".log"),
            b"Frame ",
            "engine.interchange.logs.carla:read_recorder",
            "centimetres and degrees, y points right of x: they become metres, radians and y left of x",
        ),
        "OSI": Source(
            "a trace of OSI's GroundTruth",
            (".osi",),
            b"",
            "engine.interchange.logs.osi:read_osi",
            "protobuf messages behind their lengths; positions and velocities are those of the boxes' centres",
        ),
        "MCAP": Source(
            "an MCAP, of ours or of OSI's GroundTruth",
            (".mcap",),
            b"\x89MCAP",
            "engine.interchange.mcap.read:read_mcap",
            "ours: boxes of foxglove.SceneUpdate, speeds of `/numbers`; OSI's and omega-prime's: as a trace, and the "
            "road that is in it",
        ),
    }
)
"""Kinds in the order of the search: the first whose suffix and mark fit."""
XOSC = Source(
    "OpenSCENARIO",
    (SCENARIO,),
    b"",
    "",
    "actors that follow timed polylines, and the road beside it; rear axles become centres",
)
SUFFIXES: tuple[str, ...] = tuple(dict.fromkeys(suffix for row in SOURCES.values() for suffix in row.suffixes))


def source_of(path: Path) -> Source:
    """Return the row of a file.

    Raises:
        InterchangeError: its kind is not supported, or it cannot be opened.
    """
    rows = [row for row in SOURCES.values() if path.suffix.lower() in row.suffixes]
    if not rows:
        raise InterchangeError("this is not a recording", f"name a file that ends in {', '.join(SUFFIXES)}", path.name)
    if all(row.mark == b"" for row in rows):
        return rows[0]
    head = _head(path)
    found = next((row for row in rows if row.mark in head), None)
    if found is None:
        kinds = " nor ".join(row.what for row in rows)
        raise InterchangeError(f"this is neither {kinds}", "name a recording of these kinds", path.name)
    return found


def _head(path: Path) -> bytes:
    with reading(path), path.open("rb") as file:
        return file.read(HEAD)


def read_traffic(
    path: Path, rate: float | None = None, esmini: Path | None = None, columns: Mapping[str, str] = NO_NAMES
) -> Tracks:
    """Return all road users of a recording, each with its own track.

    `rate`: samples per second, if the time counts samples; `esmini`: library that plays an `.xosc` that requires a
    simulator; `columns`: meanings of a table's columns, as in `{"time [ms]": "zeit"}`, if their names do not show them.

    Raises:
        InterchangeError: unreadable, or not a recording of a supported kind.
    """
    if columns and (path.suffix.lower() == SCENARIO or source_of(path).reader):
        raise InterchangeError("only the columns of a table have names to choose", "leave --columns out", path.name)
    if path.suffix.lower() == SCENARIO:
        read = read_recording(path, esmini=esmini)
        return tracks_of_recording(read.recording, path.name, read.remarks)
    source = source_of(path)
    if not source.reader:
        return read_tracks(path, rate, columns)
    module, _, function = source.reader.partition(":")
    read_it: Callable[[Path], Tracks] = getattr(import_module(module), function)
    return read_it(path)


def read_recording(
    path: Path,
    ego: str | None = None,
    step: float | None = None,
    rate: float | None = None,
    window: Window | None = None,
    esmini: Path | None = None,
    columns: Mapping[str, str] = NO_NAMES,
) -> Imported:
    """Return the recording of an ego and the actors near it, from a file of any kind, or a part of it; as
    `read_traffic`.
    """
    if columns or path.suffix.lower() != SCENARIO:
        traffic = read_traffic(path, rate, columns=columns)
        return _with_road(recording_of(traffic, path.stem, ego, step, window), path, traffic)
    read = _scenario(path, ego, step, esmini)
    return read if window is None else replace(read, recording=_within(read.recording, window, path.name))


def _with_road(read: Imported, path: Path, traffic: Tracks) -> Imported:
    """Return the recording of this traffic on the road within a Parquet file or an MCAP, if it contains one."""
    inside = {".parquet": embedded_road, ".mcap": road_of_mcap}.get(path.suffix.lower())
    found = inside(path) if inside else None
    if found is None:
        return read
    name, content = road_file(found[0]), found[1]
    try:
        with TemporaryDirectory() as folder:
            place = Path(folder) / name
            place.write_bytes(content)
            road = replace(read_opendrive(place), content=content)
            levels = () if may_be_apart(traffic.tracks) else level_notes(road)
    except InterchangeError as error:
        return replace(read, remarks=(*read.remarks, f"the road in it cannot be read: {error}"))
    recording = replace(read.recording, buildings=road.buildings)
    return Imported(recording, road, (*read.remarks, *road.notes, *levels))


def road_file(called: str) -> str:
    """Return a file name for the road of a recording, with letters that every file system accepts."""
    plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in called)[:60]
    return f"{plain or 'road'}.xodr"


def _scenario(path: Path, ego: str | None, step: float | None, esmini: Path | None) -> Imported:
    """Return the recording of an `.xosc`, as written or else as esmini plays it.

    Raises:
        InterchangeError: the file cannot be read as written, and esmini is not given or does not open it.
    """
    try:
        return openscenario.read_openscenario(path, ego=ego, step=step)
    except InterchangeError as refused:
        if esmini is None:
            raise
        from engine.interchange.esmini.recorded import play_and_record

        played = recording_of(play_and_record(esmini, path, step), path.stem, ego, step)
        return replace(played, remarks=(f"played by esmini, as it cannot be read alone: {refused}", *played.remarks))


def _within(recording: Recording, window: Window, file: str) -> Recording:
    """Return the samples of a window, and the contact if it is in it."""
    since = recording.time - recording.time[0]
    in_window = (since >= window[0] - SAME_INSTANT) & (since <= window[1] + SAME_INSTANT)
    if not recording.there[in_window, 0].any():
        message = f"the ego is not there from {window[0]:g} to {window[1]:g} s"
        raise InterchangeError(message, f"name a window within 0 to {since[-1]:.6g} s", file)
    contact, time = recording.contact, recording.time[in_window]
    inside = contact is not None and time[0] <= contact.time <= time[-1]
    part = replace(recording, time=time, states=recording.states[in_window], contact=contact if inside else None)
    return part.from_zero()


def tracks_of_recording(recording: Recording, file: str, remarks: tuple[str, ...] = ()) -> Tracks:
    """Return tracks of the actors that appear, each while it is present."""
    begin = float(recording.time[0])
    tracks: list[TableTrack] = []
    for number, actor in enumerate(recording.actors):
        there = np.flatnonzero(recording.there[:, number])
        if not len(there):
            continue
        states = recording.states[there, number]
        tracks.append(
            TableTrack(
                label=actor.name,
                name=actor.name,
                kind=actor.kind,
                is_ego=number == 0,
                time=recording.time[there] - begin,
                positions=states[:, [State.X, State.Y]],
                heading=states[:, State.HEADING],
                speed=states[:, State.SPEED],
                length=actor.length,
                width=actor.width,
                rear_to_center=actor.rear_to_center,
                slides=states[:, State.PRESENT] == SLIDING,
                breaks=np.diff(there, append=there[-1] + 1) > 1,
            )
        )
    return Tracks(tuple(tracks), remarks, file, begin, buildings=recording.buildings)
