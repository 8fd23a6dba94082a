"""Tables of known data sets and simulators: one row each, with columns, units and conventions.

A layout is recognized by its columns. The formats are published: inD, rounD, uniD and exiD (levelXData, "The inD
dataset format"), highD (Krajewski et al. 2018, ITSC; "highD format"), INTERACTION (Zhan et al. 2019, section on data
format), NGSIM (FHWA-HRT-06-137, data dictionary), Argoverse 2 (Wilson et al. 2021, motion forecasting, `ObjectState`),
SUMO ("FCD output", `xml2csv`), esmini (`dat2csv`). A new one is a row here and a sample in its test.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from types import MappingProxyType

from engine.vocabulary import ActorKind


class Point(IntEnum):
    """Reference point of an actor's position."""

    CENTER = 0
    FRONT = 1
    """The middle of the front bumper."""
    REAR_AXLE = 2
    CORNER = 3
    """The upper left corner of a box in an image with axis-parallel sides."""


@dataclass(frozen=True)
class Beside:
    """A file that accompanies a table, with the same name except for its end, and a row of columns that are read."""

    end: str
    """End of its name, in place of the table's own, `Layout.end`."""
    columns: Mapping[str, str]
    """Columns by meaning, as in `Layout.columns`; with `actor` among them, a row is of one actor, else of the
    recording.
    """


@dataclass(frozen=True)
class Layout:
    """One layout."""

    name: str
    """Name of the tool or data set."""
    known_by: tuple[str, ...]
    """Columns that all its tables have; no other layout has all of them."""
    columns: Mapping[str, str]
    """Column and unit by meaning (see `columns.PLAIN`), as in `heading [deg]`; a time in `frames` is a count."""
    point: Point
    said: str
    """Its conventions in words."""
    rate: float = 0.0
    """Frames per second, if the data set has a constant rate; else an accompanying file has it."""
    y_down: bool = False
    """True if y points down, or right of x, and angles are clockwise."""
    compass: bool = False
    """True if headings are clockwise from north."""
    end: str = ""
    """End of its file names, if other files accompany them."""
    beside: tuple[Beside, ...] = ()
    also: tuple[str, str] = ("", "")
    """Beginnings of the names of two files of one recording, each with its own actors: both are read."""
    part: str = ""
    """Column with the number of the recording to which a row belongs."""
    kinds: Mapping[str, ActorKind] = field(default_factory=dict[str, ActorKind])
    """Its own words or codes for kinds, in small letters; all others are understood as in any table."""
    sizes: Mapping[ActorKind, tuple[float, float]] = field(default_factory=dict[ActorKind, tuple[float, float]])
    """Length and width [m] by kind, if its tables have none and its models are known."""
    ego: str = ""
    """Its name of the ego, if it has one."""
    separator: str = ","
    example: str = ""
    """Example of a file name."""


_OBSTACLES = dict.fromkeys(("static", "background", "construction", "riderless_bicycle", "unknown"), ActorKind.OBSTACLE)
_LEVELX = {
    "time": "frame [frames]",
    "actor": "trackId",
    "x": "xCenter [m]",
    "y": "yCenter [m]",
    "heading": "heading [deg]",
    "vel_x": "xVelocity [m/s]",
    "vel_y": "yVelocity [m/s]",
    "length": "length [m]",
    "width": "width [m]",
}
SUMO_SIZES: Mapping[ActorKind, tuple[float, float]] = MappingProxyType(
    {
        ActorKind.CAR: (5.0, 1.8),
        ActorKind.TRUCK: (7.1, 2.4),
        ActorKind.BUS: (12.0, 2.5),
        ActorKind.MOTORCYCLE: (2.2, 0.9),
        ActorKind.BICYCLE: (1.6, 0.65),
        ActorKind.PEDESTRIAN: (0.215, 0.478),
    }
)
"""SUMO's default sizes of the vehicle classes passenger, truck, bus, motorcycle, bicycle and pedestrian."""
SUMO_SAID = "positions are front bumpers, angles count clockwise from north, sizes are SUMO's own of each class"

LAYOUTS: Sequence[Layout] = (
    Layout(
        name="inD, rounD, uniD, exiD",
        known_by=("recordingId", "trackId", "frame", "xCenter", "yCenter"),
        columns=_LEVELX,
        point=Point.CENTER,
        said="frames count, headings are degrees, a size of 0 is unknown",
        end="_tracks.csv",
        beside=(
            Beside("_recordingMeta.csv", {"rate": "frameRate"}),
            Beside("_tracksMeta.csv", {"actor": "trackId", "type": "class"}),
        ),
        example="07_tracks.csv",
    ),
    Layout(
        name="highD",
        known_by=("frame", "id", "x", "y", "width", "height", "xVelocity", "yVelocity", "laneId"),
        columns={
            "time": "frame [frames]",
            "actor": "id",
            "x": "x [m]",
            "y": "y [m]",
            "vel_x": "xVelocity [m/s]",
            "vel_y": "yVelocity [m/s]",
            "length": "width [m]",
            "width": "height [m]",
        },
        point=Point.CORNER,
        said="positions are upper left corners of boxes in the image, y points down, `width` is a length",
        y_down=True,
        end="_tracks.csv",
        beside=(
            Beside("_recordingMeta.csv", {"rate": "frameRate"}),
            Beside("_tracksMeta.csv", {"actor": "id", "type": "class"}),
        ),
        example="01_tracks.csv",
    ),
    Layout(
        name="INTERACTION",
        known_by=("track_id", "frame_id", "timestamp_ms", "agent_type", "vx", "vy"),
        columns={
            "time": "timestamp_ms [ms]",
            "actor": "track_id",
            "x": "x [m]",
            "y": "y [m]",
            "vel_x": "vx [m/s]",
            "vel_y": "vy [m/s]",
            "heading": "psi_rad [rad]",
            "length": "length [m]",
            "width": "width [m]",
            "type": "agent_type",
        },
        point=Point.CENTER,
        said="pedestrians and cyclists are in a file of their own, without headings and sizes",
        also=("vehicle_tracks", "pedestrian_tracks"),
        part="case_id",
        example="vehicle_tracks_000.csv",
    ),
    Layout(
        name="Argoverse 2",
        known_by=("track_id", "timestep", "object_type", "position_x", "position_y", "velocity_x"),
        columns={
            "time": "timestep [frames]",
            "actor": "track_id",
            "x": "position_x [m]",
            "y": "position_y [m]",
            "heading": "heading [rad]",
            "vel_x": "velocity_x [m/s]",
            "vel_y": "velocity_y [m/s]",
            "type": "object_type",
        },
        point=Point.CENTER,
        said="ten frames a second, no sizes; `AV` is the ego",
        rate=10.0,
        part="scenario_id",
        kinds={**_OBSTACLES, "motorcyclist": ActorKind.MOTORCYCLE},
        ego="AV",
        example="scenario_0a1e6f0a.parquet",
    ),
    Layout(
        name="NGSIM",
        known_by=("Vehicle_ID", "Global_Time", "Local_X", "Local_Y", "v_Vel"),
        columns={
            "time": "Global_Time [ms]",
            "actor": "Vehicle_ID",
            "x": "Local_X [ft]",
            "y": "Local_Y [ft]",
            "speed": "v_Vel [ft/s]",
            "length": "v_Length [ft]",
            "width": "v_Width [ft]",
            "type": "v_Class",
        },
        point=Point.FRONT,
        said="feet, and positions are the middle of the front bumper",
        part="Location",
        kinds={"1": ActorKind.MOTORCYCLE, "2": ActorKind.CAR, "3": ActorKind.TRUCK},
        example="trajectories-0750am-0805am.csv",
    ),
    Layout(
        name="SUMO FCD as a table",
        known_by=("timestep_time", "vehicle_id", "vehicle_x", "vehicle_y", "vehicle_angle"),
        columns={
            "time": "timestep_time [s]",
            "actor": "vehicle_id",
            "x": "vehicle_x [m]",
            "y": "vehicle_y [m]",
            "z": "vehicle_z [m]",
            "heading": "vehicle_angle [deg]",
            "speed": "vehicle_speed [m/s]",
            "type": "vehicle_type",
        },
        point=Point.FRONT,
        said=SUMO_SAID,
        compass=True,
        sizes=SUMO_SIZES,
        separator=";",
        example="fcd.csv",
    ),
    Layout(
        name="esmini's dat2csv",
        known_by=("time", "id", "name", "x", "y", "h", "p", "r", "speed"),
        columns={
            "time": "time [s]",
            "actor": "name",
            "x": "x [m]",
            "y": "y [m]",
            "z": "z [m]",
            "heading": "h [rad]",
            "speed": "speed [m/s]",
        },
        point=Point.REAR_AXLE,
        said="positions are rear axles; kinds and sizes are not logged",
        example="sim.csv",
    ),
)
"""Layouts in the order of the search."""


def layout_of(header: Sequence[str]) -> Layout | None:
    """Return the layout with these columns, in any case; None for a table of no known tool."""
    names = {name.strip().casefold() for name in header}
    return next((row for row in LAYOUTS if all(name.casefold() in names for name in row.known_by)), None)
