"""What others record: one drive, written as each of them would write it, comes to the same states and the same numbers.

The samples are written here, from the columns that each data set or simulator publishes.
"""

import json
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import cortex_dsl as cx
from engine.interchange import InterchangeError
from engine.interchange.every_pair import rank_pairs
from engine.interchange.measuring import measure
from engine.interchange.opendrive import write_opendrive
from engine.interchange.recording import Recording
from engine.interchange.sources import SOURCES, read_recording, read_traffic
from engine.interchange.tables import write_csv, write_parquet
from engine.interchange.tables.layouts import LAYOUTS, SUMO_SIZES, layout_of
from engine.maps import RoadSpec
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State

RATE, SAMPLES = 10, 50
CAR = MODELS[ActorKind.CAR]
FOOT = 0.3048


@dataclass(frozen=True)
class Drive:
    """One who drives straight on."""

    name: str
    x: float
    y: float
    heading: float
    speed: float
    length: float = CAR.length
    width: float = CAR.width

    def at(self, k: int) -> tuple[float, float]:
        way = self.speed * k / RATE
        return self.x + way * math.cos(self.heading), self.y + way * math.sin(self.heading)

    def point(self, k: int, ahead: float) -> tuple[float, float]:
        x, y = self.at(k)
        return x + ahead * math.cos(self.heading), y + ahead * math.sin(self.heading)

    @property
    def velocity(self) -> tuple[float, float]:
        return self.speed * math.cos(self.heading), self.speed * math.sin(self.heading)


CROSSING = (Drive("1", -30.0, 2.0, 0.0, 10.0), Drive("2", 3.0, -27.0, math.pi / 2, 8.0))
PASSING = (Drive("1", -30.0, 2.0, 0.0, 10.0), Drive("2", 28.0, 4.5, math.pi, 8.0))
"""For boxes whose sides are parallel to the axes."""


def csv_of(header: str, rows: list[list[object]], separator: str = ",") -> str:
    lines = [separator.join(map(str, row)) for row in rows]
    return "\n".join([header, *lines]) + "\n"


def every(drives: tuple[Drive, ...]) -> list[tuple[Drive, int]]:
    return [(drive, k) for drive in drives for k in range(SAMPLES)]


def levelx(folder: Path) -> Path:
    """inD, rounD, uniD, exiD: frames, degrees, and two files beside."""
    header = (
        "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,"
        "xAcceleration,yAcceleration,lonVelocity,latVelocity,lonAcceleration,latAcceleration"
    )
    rows = [
        [
            7,
            d.name,
            k,
            k,
            *d.at(k),
            math.degrees(d.heading) % 360.0,
            d.width,
            d.length,
            *d.velocity,
            0,
            0,
            d.speed,
            0,
            0,
            0,
        ]
        for d, k in every(CROSSING)
    ]
    (folder / "07_tracks.csv").write_text(csv_of(header, rows))
    meta = "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class"
    (folder / "07_tracksMeta.csv").write_text(
        csv_of(meta, [[7, d.name, 0, SAMPLES - 1, SAMPLES, d.width, d.length, "car"] for d in CROSSING])
    )
    (folder / "07_recordingMeta.csv").write_text(csv_of("recordingId,locationId,frameRate", [[7, 1, f"{RATE}.0"]]))
    return folder / "07_tracks.csv"


def highd(folder: Path) -> Path:
    """highD: upper left corners in an image, y down."""
    header = "frame,id,x,y,width,height,xVelocity,yVelocity,xAcceleration,yAcceleration,dhw,thw,ttc,precedingId,laneId"
    rows = [
        [
            k,
            d.name,
            d.at(k)[0] - d.length / 2,
            -d.at(k)[1] - d.width / 2,
            *(d.length, d.width),
            d.velocity[0],
            -d.velocity[1],
            0,
            0,
            0,
            0,
            0,
            0,
            2,
        ]
        for d, k in every(PASSING)
    ]
    (folder / "01_tracks.csv").write_text(csv_of(header, rows))
    meta = [[d.name, d.length, d.width, 0, SAMPLES - 1, SAMPLES, "Car", 1 + (d.heading == 0.0)] for d in PASSING]
    (folder / "01_tracksMeta.csv").write_text(
        csv_of("id,width,height,initialFrame,finalFrame,numFrames,class,drivingDirection", meta)
    )
    (folder / "01_recordingMeta.csv").write_text(csv_of("id,frameRate,locationId", [[1, RATE, 2]]))
    return folder / "01_tracks.csv"


def interaction(folder: Path) -> Path:
    """INTERACTION: milliseconds."""
    header = "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy,psi_rad,length,width"
    rows = [
        [d.name, k + 1, (k + 1) * 100, "car", *d.at(k), *d.velocity, d.heading, d.length, d.width]
        for d, k in every(CROSSING)
    ]
    path = folder / "vehicle_tracks_000.csv"
    path.write_text(csv_of(header, rows))
    return path


def argoverse(folder: Path) -> Path:
    """Argoverse 2: Parquet, ten steps a second, no sizes."""
    import pyarrow
    import pyarrow.parquet

    drives = every(CROSSING)
    table = {
        "observed": [True] * len(drives),
        "track_id": [d.name for d, _ in drives],
        "object_type": ["vehicle"] * len(drives),
        "object_category": [2] * len(drives),
        "timestep": [k for _, k in drives],
        "position_x": [d.at(k)[0] for d, k in drives],
        "position_y": [d.at(k)[1] for d, k in drives],
        "heading": [d.heading for d, _ in drives],
        "velocity_x": [d.velocity[0] for d, _ in drives],
        "velocity_y": [d.velocity[1] for d, _ in drives],
        "scenario_id": ["0a1e"] * len(drives),
        "focal_track_id": ["1"] * len(drives),
        "city": ["austin"] * len(drives),
    }
    path = folder / "scenario_0a1e.parquet"
    pyarrow.parquet.write_table(pyarrow.table(table), path)
    return path


def ngsim(folder: Path) -> Path:
    """NGSIM: feet, front bumpers."""
    header = (
        "Vehicle_ID,Frame_ID,Total_Frames,Global_Time,Local_X,Local_Y,Global_X,Global_Y,v_Length,v_Width,v_Class,v_Vel,"
        "v_Acc,Lane_ID,Preceding,Following,Space_Headway,Time_Headway"
    )
    rows = [
        [
            d.name,
            k,
            SAMPLES,
            1118846980200 + 100 * k,
            *(at / FOOT for at in d.point(k, d.length / 2)),
            0,
            0,
            d.length / FOOT,
            d.width / FOOT,
            2,
            d.speed / FOOT,
            0,
            1,
            0,
            0,
            0,
            0,
        ]
        for d, k in every(CROSSING)
    ]
    path = folder / "trajectories.csv"
    path.write_text(csv_of(header, rows))
    return path


def of_sumo() -> tuple[Drive, ...]:
    length, width = SUMO_SIZES[ActorKind.CAR]
    return tuple(Drive(d.name, d.x, d.y, d.heading, d.speed, length, width) for d in CROSSING)


def fcd(folder: Path) -> Path:
    """SUMO's FCD output: front bumpers, degrees from north."""
    steps = []
    for k in range(SAMPLES):
        who = "".join(
            f'<vehicle id="{d.name}" x="{x!r}" y="{y!r}" angle="{90.0 - math.degrees(d.heading)!r}" type="passenger" '
            f'speed="{d.speed}" pos="1" lane="e_0" slope="0"/>'
            for d in of_sumo()
            for x, y in [d.point(k, d.length / 2)]
        )
        steps.append(f'<timestep time="{k / RATE}">{who}</timestep>')
    path = folder / "fcd.xml"
    path.write_text(f'<?xml version="1.0"?>\n<fcd-export>{"".join(steps)}<timestep time="99"/></fcd-export>\n')
    return path


def fcd_table(folder: Path) -> Path:
    """The same through SUMO's xml2csv, a row without anybody at the end."""
    header = "timestep_time;vehicle_angle;vehicle_id;vehicle_lane;vehicle_pos;vehicle_slope;vehicle_speed;vehicle_type"
    rows = [
        [k / RATE, 90.0 - math.degrees(d.heading), d.name, "e_0", 1, 0, d.speed, "passenger", *d.point(k, d.length / 2)]
        for d, k in every(of_sumo())
    ]
    path = folder / "fcd.csv"
    path.write_text(csv_of(f"{header};vehicle_x;vehicle_y", rows, ";") + "99;;;;;;;;;\n")
    return path


def esmini_log(folder: Path) -> Path:
    """Esmini's --csv_logger: a block of columns for each entity, rear axles."""
    names = ["Entitity_Name [-]", "Entitity_ID [-]", "Current_Speed [m/s]", "Wheel_Angle [deg]", "bb_x [m]", "bb_y [m]"]
    names += [
        "bb_length [m]",
        "bb_width [m]",
        "World_Position_X [m]",
        "World_Position_Y [m]",
        "World_Heading_Angle [rad]",
    ]
    header = ["Index [-]", "TimeStamp [s]", *(f"#{n} {name}" for n in (1, 2) for name in names)]
    behind = CAR.rear_to_center
    rows = [
        [k, f"{k / RATE:.6f}"]
        + [
            cell
            for n, d in enumerate(CROSSING)
            for cell in (d.name, n, d.speed, 0, behind, 0, d.length, d.width, *d.point(k, -behind), d.heading)
        ]
        for k in range(SAMPLES)
    ]
    path = folder / "full_log.csv"
    path.write_text("Version: 2, Scenario File Name: a.xosc\n" + csv_of(" , ".join(header), rows, " , "))
    return path


def dat_table(folder: Path) -> Path:
    """Esmini's dat2csv: a line above the names, rear axles, no sizes."""
    rows = [
        [f"{k / RATE:.3f}", n, d.name, *d.point(k, -CAR.rear_to_center), 0.0, d.heading, 0.0, 0.0, d.speed, 0.0, 0.0]
        for n, d in enumerate(CROSSING)
        for k in range(SAMPLES)
    ]
    path = folder / "sim.csv"
    header = "time, id, name, x, y, z, h, p, r, speed, wheel_angle, wheel_rot"
    path.write_text("Version: 2, OpenDRIVE: a.xodr, 3DModel: \n" + csv_of(header, rows, ", "))
    return path


def carla_log(folder: Path) -> Path:
    """CARLA's recorder as text: centimetres, degrees, y right of x."""
    lines = ["Version: 1", "Map: Town05", "Date: 02/21/24 10:46:20", "", "Frame 1 at 0 seconds"]
    for d in CROSSING:
        x, y = d.at(0)
        lines += [f" Create {d.name}: vehicle.audi.a2 (1) at ({100 * x!r}, {-100 * y!r}, 0)", "  number_of_wheels = 4"]
    lines += [" Create 9: traffic.traffic_light (3) at (1, 2, 3)"]
    for k in range(SAMPLES):
        lines += [f"Frame {k + 1} at {k / RATE!r} seconds", " Positions: 3"]
        for d in CROSSING:
            x, y = d.at(k)
            yaw = -math.degrees(d.heading)
            lines.append(f"  Id: {d.name} Location: ({100 * x!r}, {-100 * y!r}, 0) Rotation: (0, 0, {yaw!r})")
        lines += ["  Id: 9 Location: (1, 2, 3) Rotation: (0, 0, 0)", " State traffic lights: 1", "  Id: 9 state: 2"]
        lines += [" Dynamic actors: 2"]
        for d in CROSSING:
            vx, vy = d.velocity
            lines.append(f"  Id: {d.name} linear_velocity: ({vx!r}, {-vy!r}, 0) angular_velocity: (0, 0, 0)")
        lines += [" Actor bounding boxes: 2"]
        for d in CROSSING:
            half = f"({50 * d.length!r}, {50 * d.width!r}, 70)"
            lines.append(f"  Id: {d.name} origin: (0, 0, 0) extension: {half}")
    path = folder / "recorder.txt"
    path.write_text("\n".join(lines) + "\n")
    return path


def commonroad(folder: Path) -> Path:
    """CommonRoad: two obstacles at whole steps."""

    def state(d: Drive, k: int, tag: str) -> str:
        x, y = d.at(k)
        return (
            f"<{tag}><position><point><x>{x!r}</x><y>{y!r}</y></point></position><orientation><exact>{d.heading!r}"
            f"</exact></orientation><time><exact>{k}</exact></time><velocity><exact>{d.speed}</exact></velocity></{tag}>"
        )

    obstacles = "".join(
        f'<dynamicObstacle id="{d.name}"><type>car</type><shape><rectangle><length>{d.length!r}</length>'
        f"<width>{d.width!r}</width></rectangle></shape>{state(d, 0, 'initialState')}<trajectory>"
        + "".join(state(d, k, "state") for k in range(1, SAMPLES))
        + "</trajectory></dynamicObstacle>"
        for d in CROSSING
    )
    path = folder / "scenario.xml"
    path.write_text(f'<commonRoad timeStepSize="{1 / RATE}" commonRoadVersion="2020a">{obstacles}</commonRoad>')
    return path


def test_what_stands_beside_a_road_of_commonroad(tmp_path: Path) -> None:
    """Buildings that are rectangles are walls; what else there is, is left out by name."""
    text = commonroad(tmp_path).read_text()
    assert read_recording(tmp_path / "scenario.xml").recording.buildings is None
    box = "<rectangle><length>9</length><width>4</width>"
    turned = f"{box}<orientation>0.5</orientation><center><x>300</x><y>-7</y></center></rectangle>"
    shapes = [("building", turned), ("pillar", turned), ("building", 2 * f"{box}</rectangle>")]
    around = "".join(
        f'<environmentObstacle id="{number}"><type>{kind}</type><shape>{shape}</shape></environmentObstacle>'
        for number, (kind, shape) in enumerate(shapes, 71)
    )
    path = tmp_path / "town.xml"
    path.write_text(text.replace("</commonRoad>", f"{around}</commonRoad>"))
    read = read_recording(path)
    assert read.recording.buildings is not None
    assert read.recording.buildings.tolist() == [[300.0, -7.0, 0.5, 9.0, 4.0]]
    (said,) = [each for each in read.remarks if "environment" in each]
    assert said.endswith('not rectangular buildings are left out: the first is "72"')
    path.write_text(path.read_text().replace("<width>4", "<width>-4"))
    with pytest.raises(InterchangeError, match="a building of -4 m"):
        read_recording(path)


def number(field: int, value: int) -> bytes:
    """A whole number of a protobuf message."""
    digits = [value >> shift & 127 for shift in range(0, max(value.bit_length(), 1), 7)]
    return bytes([field << 3, *(digit | 128 for digit in digits[:-1]), digits[-1]])


def inner(field: int, content: bytes) -> bytes:
    """A message in a protobuf message, or a text."""
    return number(field, len(content)).replace(bytes([field << 3]), bytes([field << 3 | 2]), 1) + content


def osi(folder: Path) -> Path:
    """ASAM OSI: protobuf messages, each behind its length."""

    def reals(field: int, *values: float) -> bytes:
        return inner(field, b"".join(struct.pack("<Bd", n << 3 | 1, value) for n, value in enumerate(values, 1)))

    trace = b""
    for k in range(SAMPLES):
        truth = inner(2, number(1, 100 + k // RATE) + number(2, k % RATE * (10**9 // RATE))) + inner(3, number(1, 2))
        for d in CROSSING:
            pose = reals(2, *d.at(k), 0.7) + reals(3, 0.0, 0.0, d.heading) + reals(4, *d.velocity, 0.0)
            base = inner(2, reals(1, d.length, d.width, 1.5) + pose)
            truth += inner(5, inner(1, number(1, int(d.name))) + base + number(3, 2) + inner(6, number(1, 4)))
        trace += struct.pack("<I", len(truth)) + truth
    path = folder / "trace.osi"
    path.write_bytes(trace)
    return path


def osi_mcap(folder: Path) -> Path:
    """The same messages in an MCAP, behind their map, as omega-prime writes it, and beside another channel of them."""
    from mcap.writer import CompressionType, Writer

    trace, at = osi(folder).read_bytes(), 0
    with (folder / "trace.mcap").open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start()
        names = ("osi3.MapAsamOpenDrive", "osi3.GroundTruth", "osi3.GroundTruth")
        schemas = [writer.register_schema(name, "protobuf", b"") for name in names]
        topics = ("ground_truth_map", "ground_truth", "later")
        of_map, of_truth, later = (
            writer.register_channel(topic, "protobuf", schema) for topic, schema in zip(topics, schemas, strict=True)
        )
        road = write_opendrive(RoadSpec(), None, "road").encode()
        writer.add_message(of_map, 0, inner(1, b"a/town") + inner(2, road), 0)
        for k in range(SAMPLES):
            (size,) = struct.unpack_from("<I", trace, at)
            writer.add_message(of_truth, k, trace[at + 4 : at + 4 + size], k)
            at += 4 + size
        writer.add_message(later, SAMPLES, b"", SAMPLES)
        writer.finish()
    return folder / "trace.mcap"


def plain(folder: Path) -> Path:
    """A plain table with velocities and without headings."""
    rows = [[k, d.name, *d.at(k), *d.velocity, d.length, d.width, "car"] for d, k in every(CROSSING)]
    path = folder / "plain.csv"
    path.write_text(csv_of("frame,id,x,y,vx,vy,length,width,type", rows))
    return path


WRITERS: dict[Callable[[Path], Path], tuple[Drive, ...]] = {
    levelx: CROSSING,
    highd: PASSING,
    interaction: CROSSING,
    argoverse: CROSSING,
    ngsim: CROSSING,
    fcd: of_sumo(),
    fcd_table: of_sumo(),
    esmini_log: CROSSING,
    dat_table: CROSSING,
    carla_log: CROSSING,
    osi: CROSSING,
    osi_mcap: CROSSING,
    commonroad: CROSSING,
    plain: CROSSING,
}


def truth(drives: tuple[Drive, ...], like: Recording) -> Recording:
    """The drive itself, with the actors of what was read."""
    states = np.zeros((SAMPLES, len(drives), len(State)))
    for actor, d in enumerate(drives):
        for k in range(SAMPLES):
            states[k, actor, [State.X, State.Y, State.HEADING, State.SPEED, State.PRESENT]] = (
                *d.at(k),
                d.heading,
                d.speed,
                1.0,
            )
    return Recording("truth", like.actors, np.arange(SAMPLES) / RATE, states, 1 / RATE, commands=False)


@pytest.mark.parametrize("write", WRITERS, ids=lambda each: each.__name__)
def test_a_drive_is_read_as_it_was(write: Callable[[Path], Path], tmp_path: Path) -> None:
    """Places, headings, speeds and sizes to 1e-6, whatever the units and the reference point, and all numbers."""
    drives = WRITERS[write]
    found = read_recording(write(tmp_path), ego="1", rate=RATE if write is plain else None)
    recording = found.recording
    assert [actor.name for actor in recording.actors] == ["1", "2"]
    assert recording.step == pytest.approx(1 / RATE)
    for actor, drive in zip(recording.actors, drives, strict=True):
        assert (actor.kind, actor.length, actor.width) == (
            ActorKind.CAR,
            pytest.approx(drive.length, abs=1e-6),
            pytest.approx(drive.width, abs=1e-6),
        )
    expected = truth(drives, recording)
    off = recording.states - expected.states
    off[:, :, State.HEADING] = (off[:, :, State.HEADING] + math.pi) % (2 * math.pi) - math.pi
    assert np.abs(off[:, :, [State.X, State.Y, State.HEADING, State.SPEED]]).max() < 1e-6
    ours, theirs = measure(expected), measure(recording)
    assert theirs.risk.score[0] == ours.risk.score[0]
    for name in ("min_distance", "min_distance_time", "max_closing_speed", "distance_at_ms", "ttc_at_ms"):
        assert getattr(theirs.outcomes, name) == pytest.approx(getattr(ours.outcomes, name), abs=1e-6)
    assert not any("do not fit" in remark or "lie across" in remark for remark in found.remarks)


def test_an_mcap_of_osi_has_a_road_and_one_channel_is_read(tmp_path: Path) -> None:
    """The road is that of its map; what else tells of motion is named."""
    found = read_recording(osi_mcap(tmp_path))
    assert found.road is not None
    assert found.road.path.name == "a_town.xodr"
    assert 'of its channels of GroundTruth "ground_truth" is read, and not "later"' in found.remarks


def test_a_window_in_python_is_that_of_the_command(tmp_path: Path) -> None:
    """`cx.measure(window=…)` judges the part alone."""
    whole, part = (cx.measure(levelx(tmp_path), ego="1", window=window) for window in (None, (1, 2.5)))
    assert (len(whole.trajectory.states), len(part.trajectory.states)) == (SAMPLES, 16)
    assert np.allclose(part.trajectory.states[0], whole.trajectory.states[10])
    with pytest.raises(InterchangeError, match="`1` is not there from 7 to 9 s"):
        cx.measure(levelx(tmp_path), ego="1", window=(7, 9))


def test_every_row_has_a_sample() -> None:
    """Every layout and every kind of file is written above, or is ours and written by an export."""
    assert len({layout.name for layout in LAYOUTS}) == len(LAYOUTS) == 7
    assert set(SOURCES) == {"esmini log", "table", "SUMO", "CommonRoad", "CARLA", "OSI", "MCAP"}
    for layout in LAYOUTS:
        assert layout_of(layout.known_by) is layout


def test_ours_read_back_to_the_same_numbers(tmp_path: Path) -> None:
    """CSV, Parquet and MCAP of one recording, to 1e-6."""
    from engine.interchange.mcap import write_mcap

    like = read_recording(levelx(tmp_path), ego="1").recording
    numbers = []
    for write in (write_csv, write_parquet, write_mcap):
        for name, content in write(like, "again").files.items():
            (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
            read = read_recording(tmp_path / name).recording
            assert [(a.name, a.kind, a.length, a.width) for a in read.actors] == [
                (a.name, a.kind, a.length, a.width) for a in like.actors
            ]
            numbers.append([metric.value for metric in measure(read).metrics])
    for each in numbers[1:]:
        assert each == pytest.approx(numbers[0], abs=1e-6, nan_ok=True)


# -- what is wrong -----------------------------------------------------------------------------------------------------


def refused(path: Path, rate: float | None = None) -> str:
    with pytest.raises(InterchangeError) as caught:
        read_traffic(path, rate)
    assert caught.value.cure
    return f"{caught.value.place}: {caught.value.message}; {caught.value.cure}"


def test_files_that_belong_beside_are_asked_for(tmp_path: Path) -> None:
    """By name, with what they hold; the rate may be said instead."""
    path = levelx(tmp_path)
    (tmp_path / "07_recordingMeta.csv").unlink()
    assert "`07_recordingMeta.csv` is missing" in refused(path)
    assert "--rate 25" in refused(path)
    assert len(read_traffic(path, RATE).tracks) == 2
    (tmp_path / "07_tracksMeta.csv").write_text("recordingId,trackId,class\n7,1,car\n")
    assert "it has no row for `2`" in refused(path, RATE)
    assert "name `07_tracks.csv`" in refused(tmp_path / "07_tracksMeta.csv")
    (tmp_path / "07_recordingMeta.csv").write_text("recordingId,frameRate\n7,fast\n")
    assert '07_recordingMeta.csv, column `frameRate`: it should hold the frames a second, and holds "fast"' in refused(
        path
    )
    other = path.rename(tmp_path / "mine.csv")
    assert "ends in `_tracks.csv`" in refused(other)


def test_an_index_is_no_time(tmp_path: Path) -> None:
    """A frame asks for its rate, and nobody is told to call it a time."""
    said = refused(plain(tmp_path))
    assert "`frame` counts samples and is not a time" in said
    assert "--rate 25" in said
    assert read_traffic(tmp_path / "plain.csv", 20.0).remarks[0] == "`frame` counts 20 frames a second"


def test_columns_that_are_not_read_are_named(tmp_path: Path) -> None:
    """The first of them, and how many more there are."""
    (remark,) = [each for each in read_traffic(levelx(tmp_path)).remarks if "not read" in each]
    assert "`recordingId`, `trackLifetime`, `xAcceleration`" in remark
    (tmp_path / "t.csv").write_text("time,id,x,y,mood\n0,a,0,0,1\n")
    assert any("not read: `mood`" in each for each in read_traffic(tmp_path / "t.csv").remarks)


def test_several_recordings_in_one_table_are_refused(tmp_path: Path) -> None:
    """NGSIM's table has three roads in one, whose numbers of vehicles are the same."""
    lines = ngsim(tmp_path).read_text().splitlines()
    both = [f"{line},{'Location' if n == 0 else 'us-101' if n < 60 else 'i-80'}" for n, line in enumerate(lines)]
    (tmp_path / "all.csv").write_text("\n".join(both))
    assert '2 recordings are in it, by its column `Location`: "us-101", "i-80"' in refused(tmp_path / "all.csv")


def test_mixed_rates_are_told_by_name(tmp_path: Path) -> None:
    """Who has fewer rows than the others."""
    rows = [f"{k / 10},a,{k},0" for k in range(40)] + [f"{k / 2},b,{k},9" for k in range(8)]
    (tmp_path / "t.csv").write_text("\n".join(["time,id,x,y", *rows]))
    remarks = read_recording(tmp_path / "t.csv").remarks
    assert any("rates are mixed: rows every 0.1 s, of `b` every 0.5 s" in remark for remark in remarks)


@pytest.mark.parametrize(
    ("metre", "second", "words"),
    [(1000.0, 1.0, "moves at 20,000 m/s, which no actor on a road does: if positions are millimetres"),
     (1.0, 1000.0, "rows lie 100 s apart: if times are milliseconds, call them `time [ms]`")],
)  # fmt: skip
def test_units_that_cannot_be_are_told(tmp_path: Path, metre: float, second: float, words: str) -> None:
    """Positions and times are taken for metres and seconds, and it is said where that cannot be."""
    rows: list[list[object]] = [[k / 10 * second, "ego", 2.0 * k * metre, 0.0] for k in range(30)]
    (tmp_path / "a.csv").write_text(csv_of("time,id,x,y", rows))
    assert words in " ".join(read_traffic(tmp_path / "a.csv").remarks)
    (tmp_path / "b.csv").write_text(csv_of("time [ms],id,x [mm],y", [[1000 * t, i, 1000 * x, y] for t, i, x, y in
        ([k / 10, "ego", 2.0 * k, 0.0] for k in range(30))]))  # fmt: skip
    assert not any("m/s, which" in each or "apart" in each for each in read_traffic(tmp_path / "b.csv").remarks)


def test_who_walks_lies_in_a_file_beside(tmp_path: Path) -> None:
    """INTERACTION's pedestrians have neither headings nor sizes."""
    path = interaction(tmp_path)
    rows = "".join(f"P1,{k + 1},{(k + 1) * 100},pedestrian/bicycle,{5 + 0.1 * k},9,1.0,0.0\n" for k in range(SAMPLES))
    beside = tmp_path / "pedestrian_tracks_000.csv"
    beside.write_text(f"track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy\n{rows}")
    found = read_traffic(path)
    assert [(t.name, t.kind) for t in found.tracks] == [
        ("1", ActorKind.CAR),
        ("2", ActorKind.CAR),
        ("P1", ActorKind.BICYCLE),
    ]
    assert any("`pedestrian_tracks_000.csv` lies beside it" in remark for remark in found.remarks)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.xml", "<osm/>", "neither SUMO's FCD output nor a CommonRoad scenario"),
        ("a.xml", "<fcd-export><timestep time='0'/></fcd-export>", "nobody moves in it"),
        ("a.xml", "<fcd-export><timestep time='0'><vehicle id='1' x='a'/></timestep></fcd-export>", "a.xml, line 1"),
        ("a.xml", "<commonRoad timeStepSize='0.1'><dynamicObstacle id='1'/></commonRoad>", "<shape/rectangle>"),
        ("a.txt", "Frame 1 at 0 seconds\n", "no positions"),
        ("a.txt", "what is this", "neither CARLA's recorder"),
        ("a.csv", "Index [-], TimeStamp [s], #1 Entitity_Name [-]\n", "no column `#1 World_Position_X [m]`"),
        ("a.osi", "\x05\0\0\0abc", "a.osi, message 1: the message is cut off"),
        ("a.osi", "\x02\0\0\0\xff\xff", "the message cannot be decoded"),
        ("a.osi", "\x02\0\0\0\x08\x01", "nobody moves in it"),
        ("a.mcap", "\x89MCAP no", "not a readable MCAP file"),
        ("a.zip", "", "ends in .csv"),
    ],
)
def test_what_is_no_recording_is_refused(name: str, content: str, words: str, tmp_path: Path) -> None:
    """With its place and a cure."""
    (tmp_path / name).write_bytes(content.encode("latin-1"))
    assert words in refused(tmp_path / name)


def cure_of(path: Path) -> str:
    """What is said of a file that is refused, or that it is judged."""
    try:
        return repr(rank_pairs(read_traffic(path, float(RATE))))
    except InterchangeError as error:
        return error.cure


SPOILT = (b"", b"nan", b"1e308", b"9" * 30, b",", b'"', b"\n", b"\x00", b"\xff", b"<", b"&", b"-")


@pytest.mark.parametrize("write", WRITERS, ids=lambda each: each.__name__)
def test_spoilt_files_are_read_or_refused(write: Callable[[Path], Path], tmp_path: Path) -> None:
    """With a cure, and without a traceback: a few bytes of the table, or of a file beside it, are others."""
    path = write(tmp_path)
    originals = {file: file.read_bytes() for file in sorted(tmp_path.iterdir())}
    rng = np.random.default_rng(5)
    for _ in range(6):
        for file, content in originals.items():
            file.write_bytes(content)
        victim = list(originals)[rng.integers(len(originals))]
        content = originals[victim]
        at, cut = int(rng.integers(len(content))), int(rng.integers(9))
        victim.write_bytes(content[:at] + SPOILT[rng.integers(len(SPOILT))] + content[at + cut :])
        assert cure_of(path)


def test_degrees_of_longitude_are_no_metres(tmp_path: Path) -> None:
    """SUMO can write either."""
    steps = "".join(
        f'<timestep time="{k}"><vehicle id="1" x="{13.4 + k * 1e-4}" y="52.5" angle="90" speed="7"/></timestep>'
        for k in range(20)
    )
    (tmp_path / "geo.xml").write_text(f"<fcd-export>{steps}</fcd-export>")
    assert "without --fcd-output.geo" in refused(tmp_path / "geo.xml")


def test_mcap_of_others_names_what_it_holds(tmp_path: Path) -> None:
    """Of OSI's messages `GroundTruth` alone says who is where; one that is none is named by its number."""
    from mcap.writer import Writer

    for what in ("osi3.GroundTruth", "osi3.SensorData"):
        with (tmp_path / f"{what}.mcap").open("wb") as file:
            writer = Writer(file)
            writer.start()
            schema = writer.register_schema(name=what, encoding="protobuf", data=b"")
            channel = writer.register_channel(topic="/osi", message_encoding="protobuf", schema_id=schema)
            writer.add_message(channel, log_time=0, publish_time=0, data=json.dumps({}).encode())
            writer.finish()
    assert "its messages are osi3.SensorData" in refused(tmp_path / "osi3.SensorData.mcap")
    assert "osi3.GroundTruth.mcap, message 1: the message cannot be decoded" in refused(
        tmp_path / "osi3.GroundTruth.mcap"
    )
