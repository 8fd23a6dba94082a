"""Plain tables of other people: names, units, what is missing, and what is wrong."""

import math
import resource
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from engine.interchange import InterchangeError, Recording
from engine.interchange.openscenario.read import Imported
from engine.interchange.tables import cells, read, read_table
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State


@pytest.fixture
def table(tmp_path: Path):
    """Write a table and read it."""

    def read(text: str | bytes, ego: str | None = None, step: float | None = None, name: str = "t.csv") -> Imported:
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_table(path, ego, step)

    return read


def states(recording: Recording, name: str, column: State) -> np.ndarray:
    actor = [each.name for each in recording.actors].index(name)
    return recording.states[:, actor, column]


FULL = """time,id,x,y,heading,speed,length,width,type
0,ego,0,0,0,10,5,2,car
0,b,30,4,3.1,5,8,2.5,truck
0.1,ego,1,0,0,10,5,2,car
0.1,b,29.5,4,3.1,5,8,2.5,truck
"""


def test_a_plain_table_is_read(table) -> None:
    """As it stands; no more is said than which units are taken for granted, and nothing where they are written."""
    found = table(FULL)
    (remarks,) = found.remarks
    assert remarks.startswith(
        "no unit is said: `time` [s], `x` [m], `y` [m], `heading` [rad], `speed` [m/s], `length` [m]"
    )
    units = "time [s],id,x [m],y [m],heading [rad],speed [m/s],length [m],width [m],type"
    assert table(FULL.replace(FULL.splitlines()[0], units)).remarks == ()
    assert [actor.name for actor in found.recording.actors] == ["ego", "b"]
    assert found.recording.actors[1].kind == ActorKind.TRUCK
    assert found.recording.actors[1].length == 8.0
    assert found.recording.step == 0.1
    assert states(found.recording, "b", State.X).tolist() == [30.0, 29.5]
    assert states(found.recording, "b", State.SPEED).tolist() == [5.0, 5.0]
    assert not found.recording.commands


def test_rows_may_stand_in_any_order(table) -> None:
    """They are sorted by time; who comes first in the file is first after the ego."""
    head, *rows = FULL.splitlines()
    other = table("\n".join([head, *reversed(rows)]))
    assert np.array_equal(other.recording.states, table(FULL).recording.states)


@pytest.mark.parametrize(
    ("header", "row", "heading", "speed"),
    [
        ("t,track_id,x,y,yaw_deg,v [km/h]", "{t},ego,{x},{y},90,36", math.pi / 2, 10.0),
        ("timestamp_ms,agent_id,x,y,psi_rad,vel", "{ms},ego,{x},{y},1.5,10", 1.5, 10.0),
        ("Time [s],Name,X (m),Y (m),Heading [deg],Speed [mph]", "{t},ego,{x},{y},180,1", math.pi, 0.44704),
        ("seconds,object_id,pos_x,pos_y,theta,speed_kmh", "{t},ego,{x},{y},-1,3.6", -1.0, 1.0),
    ],
)
def test_names_and_units_are_understood(table, header: str, row: str, heading: float, speed: float) -> None:
    """Units in brackets or behind an underscore."""
    away = [(t, speed * t * math.cos(heading), speed * t * math.sin(heading)) for t in (0.0, 0.5)]
    rows = [row.format(t=t, ms=1000 * t, x=x, y=y) for t, x, y in away]
    recording = table("\n".join([header, *rows])).recording
    assert states(recording, "ego", State.HEADING) == pytest.approx([heading, heading])
    assert states(recording, "ego", State.SPEED) == pytest.approx([speed, speed])
    assert recording.time.tolist() == [0.0, 0.5]


def test_what_is_missing_comes_from_motion_and_kind(table) -> None:
    """Each with a remark; at standstill a heading stays."""
    rows = [f"{k / 10},a,0,{0.5 * min(k, 6)}" for k in range(10)]
    found = table("\n".join(["time,id,x,y", *rows]))
    assert states(found.recording, "a", State.HEADING) == pytest.approx([math.pi / 2] * 10)
    assert states(found.recording, "a", State.SPEED)[:6] == pytest.approx([5.0] * 6)
    assert states(found.recording, "a", State.SPEED)[8:] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert found.recording.actors[0].length == MODELS[ActorKind.CAR].length
    remarks = " ".join(found.remarks)
    for word in ("headings", "speeds", "length", "width", "no type", "--ego"):
        assert word in remarks


def test_headings_are_unwrapped(table) -> None:
    """A turn through the back is no spin."""
    rows = [f"{k / 10},a,{-k},0,{h}" for k, h in enumerate((3.0, 3.1, -3.08, -2.98))]
    heading = states(table("\n".join(["time,id,x,y,yaw", *rows])).recording, "a", State.HEADING)
    assert np.abs(np.diff(heading)).max() < 0.2


def test_who_is_the_ego(table) -> None:
    """Who is asked for; else who is called so; else the first, with a remark."""
    text = "time,id,x,y,heading\n0,a,0,0,0\n0,Ego,50,0,0\n0,c,90,0,0\n"
    assert table(text).recording.actors[0].name == "Ego"
    assert [actor.name for actor in table(text, ego="c").recording.actors] == ["c", "a", "Ego"]
    by_role = "time,id,x,y,heading,role\n0,a,0,0,0,\n0,b,50,0,0,ego\n"
    assert table(by_role).recording.actors[0].name == "b"
    assert any("`a` is taken" in remark for remark in table(text.replace("Ego", "b")).remarks)
    with pytest.raises(InterchangeError, match="`eggo`") as caught:
        table(text, ego="eggo")
    assert "Ego" in caught.value.cure


def test_uneven_times_are_kept_and_reported(table) -> None:
    """Every instant of anybody is a sample; between two of its rows an actor moves linearly."""
    rows = [f"{t},a,{10 * t},0" for t in (0.0, 0.13, 0.2, 0.34, 0.4, 0.55)] + [f"{t},b,0,{t}" for t in (0.0, 0.4)]
    found = table("\n".join(["time,id,x,y", *rows]), ego="a")
    assert len(found.recording) == 6
    assert states(found.recording, "b", State.Y) == pytest.approx([0.0, 0.13, 0.2, 0.34, 0.4, 0.4])
    assert states(found.recording, "b", State.PRESENT).tolist() == [1, 1, 1, 1, 1, 0]
    assert any("uneven" in remark for remark in found.remarks)


def test_who_is_missing_for_a_while_is_absent_then(table) -> None:
    """A gap is no slow drive."""
    rows = [f"{k / 10},a,0,0" for k in range(40)] + [f"{k / 10},b,{k},0" for k in range(40) if not 5 < k < 30]
    found = table("\n".join(["time,id,x,y", *rows]))
    assert states(found.recording, "b", State.PRESENT).tolist() == [float(not 5 < k < 30) for k in range(40)]
    assert any("`b` is missing" in remark for remark in found.remarks)


def test_the_step_is_found_to_the_digit(table) -> None:
    """From times that were rounded, with an instant between two steps among them."""
    times = [f"{k * 0.05:.4f}" for k in range(30)] + ["0.7123"]
    assert table("\n".join(["time,id,x,y", *(f"{t},a,0,0" for t in times)])).recording.step == 0.05
    thirds = [f"{k / 30:.9f}" for k in range(300)]
    step = table("\n".join(["time,id,x,y", *(f"{t},a,0,0" for t in thirds)])).recording.step
    assert step == pytest.approx(1 / 30, abs=1e-10)
    assert table(FULL, step=0.02).recording.step == 0.02


def test_marks_before_the_text_and_empty_lines_do_no_harm(table) -> None:
    """A byte order mark, carriage returns, blank lines, quotes."""
    text = b"\xef\xbb\xbf" + FULL.replace("\n", "\r\n").replace("ego,", '"ego",').encode() + b"\r\n\r\n"
    assert np.array_equal(table(text).recording.states, table(FULL).recording.states)


def test_times_of_a_wall_clock_keep_their_nanoseconds(table) -> None:
    """omega-prime counts from 1970, more than a float can hold."""
    start = 1_700_000_000_000_000_000
    rows = [f"{start + k * 50_000_001},0,{k},0,0,20,0,4.5,1.8,2,2,4" for k in range(5)]
    text = "total_nanos,idx,x,y,yaw,vel_x,vel_y,length,width,type,role,subtype\n" + "\n".join(rows)
    assert table(text).recording.time == pytest.approx([0.050000001 * k for k in range(5)], abs=1e-15)


def driven(
    heading: float, way: tuple[float, float], columns: str = "heading", speed: str = "", step: float = 0.1
) -> str:
    """A table of one that goes `way` metres in each step."""
    rows = [f"{k * step},a,{way[0] * k},{way[1] * k},{heading}{speed}" for k in range(20)]
    return "\n".join([f"time,id,x,y,{columns}", *rows])


@pytest.mark.parametrize(
    ("heading", "way"), [(90.0, (0.0, 1.0)), (-180.0, (-1.0, 0.0)), (5.0, (1.0, 0.09)), (2.0, (1.0, 0.0))]
)
def test_degrees_without_a_name_are_not_taken_for_radians(table, heading: float, way: tuple[float, float]) -> None:
    """Whether they jump, or are larger than radians can be, or only lie across the way in radians."""
    with pytest.raises(InterchangeError, match=r"radians|unless they are degrees") as caught:
        table(driven(heading, way))
    assert "heading_deg" in caught.value.cure
    found = table(driven(heading, way, "heading_deg"))
    assert states(found.recording, "a", State.HEADING) == pytest.approx([math.radians(heading)] * 20)
    with pytest.raises(InterchangeError, match="radians"):
        table("time,id,x,y,heading\n0,a,0,0,350\n0.1,a,1,0,10\n")


def test_headings_across_the_way_are_not_believed(table) -> None:
    """Positions are; who drives backwards, stands, jitters on the spot or drifts for a while keeps its headings."""
    across = table(driven(0.5, (-0.6, 1.0)))
    assert states(across.recording, "a", State.HEADING) == pytest.approx([math.atan2(1.0, -0.6)] * 20)
    assert any("do not fit the motion: they lie 92 degrees right of it" in remark for remark in across.remarks)
    for heading, way in ((math.pi, (1.0, 0.0)), (0.7, (0.0, 0.0)), (0.7, (0.05, -0.05))):
        kept = table(driven(heading, way))
        assert states(kept.recording, "a", State.HEADING) == pytest.approx([heading] * 20)
        assert not any("across" in remark for remark in kept.remarks)
    for heading, expected in ((3.1, True), (1.0 - math.pi, False)):
        way = (1.0, 0.05) if expected else (math.cos(1.0), math.sin(1.0))
        assert any("backwards, unless" in remark for remark in table(driven(heading, way)).remarks) == expected


@pytest.mark.parametrize("said", [36.0, 0.0, 30.0, -10.0])
def test_speeds_that_positions_contradict_are_not_believed(table, said: float) -> None:
    """They are taken from motion, which is said with both numbers, and with the unit that it might be."""
    found = table(driven(0.0, (1.0, 0.0), "heading,v", f",{said}"))
    assert states(found.recording, "a", State.SPEED) == pytest.approx([10.0] * 20)
    remarks = " ".join(found.remarks)
    assert ("is it km/h? call it `v [km/h]`" in remarks) == (said == 36.0)
    if said >= 0.0:
        assert f"column `v`: {said:g}, but the positions of `a` move at 10 m/s" in remarks
    for good in (10.0, 10.9, 9.2):
        kept = table(driven(0.0, (1.0, 0.0), "heading,v", f",{good}"))
        assert states(kept.recording, "a", State.SPEED).tolist() == [good] * 20
        assert not any("motion" in remark for remark in kept.remarks)


def test_one_speed_that_does_not_fit_is_replaced(table) -> None:
    """The others stay as they are written."""
    lines = driven(0.0, (1.0, 0.0), "heading,v", ",10.25").splitlines()
    lines[8] = lines[8].replace(",10.25", ",1e8")
    found = table("\n".join(lines))
    assert states(found.recording, "a", State.SPEED) == pytest.approx([10.25] * 7 + [10.0] + [10.25] * 12)
    assert any("1 of 20 speeds of `a` do not fit" in remark for remark in found.remarks)


def test_hard_braking_and_a_standing_start_fit(table) -> None:
    """So does who stops within a step, as after a blow."""
    x, rows = 0.0, []
    for k in range(30):
        v = 0.0 if k == 0 else 12.0 if k < 10 else max(0.0, 12.0 - 0.9 * (k - 9)) if k < 20 else 0.0
        x += v * 0.1
        rows.append(f"{k / 10},a,{x},0,0,{v}")
    found = table("\n".join(["time,id,x,y,heading,speed", *rows]))
    assert not any("motion" in remark for remark in found.remarks)
    assert states(found.recording, "a", State.SPEED)[0] == 0.0


def test_sizes_in_millimetres_are_refused(table) -> None:
    """What is longer than any actor of cortexc is in another unit."""
    with pytest.raises(InterchangeError, match=r"a length of 4500 m is above 100 m") as caught:
        table(FULL.replace(",5,2,car", ",4500,2,car"))
    assert "length [mm]" in caught.value.cure
    assert caught.value.place == "t.csv, line 2, column `length`"
    table(FULL.replace("length", "length [mm]").replace(",5,2,car", ",4500,2,car").replace(",8,2.5,", ",8000,2.5,"))


@pytest.mark.parametrize(("header", "unit"), [("time", 1.0), ("timestamp_ms", 1000.0)])
def test_times_from_1970_have_their_step(table, header: str, unit: float) -> None:
    """To the digits that such large numbers hold, and the first is shown in full."""
    begin = 1_700_000_000.25
    rows = [f"{(begin + k / 10) * unit!r},a,{k},0" for k in range(30)]
    found = table("\n".join([f"{header},id,x,y", *rows]))
    assert found.recording.step == 0.1
    assert found.recording.time == pytest.approx([k / 10 for k in range(30)], abs=1e-12)
    assert any("1700000000.25 s" in remark for remark in found.remarks)


def test_a_time_far_away_is_refused(table) -> None:
    """Differences of 64-bit numbers would come round again."""
    rows = "-8999999999999999999,0,0,0,0,1,0,4,2\n8999999999999999999,0,0,0,0,1,0,4,2"
    with pytest.raises(InterchangeError, match="18,000,000,000 s after the first time") as caught:
        table(f"total_nanos,idx,x,y,yaw,vel_x,vel_y,length,width\n{rows}\n")
    assert caught.value.place == "t.csv, line 3, column `total_nanos`"


@pytest.mark.parametrize("header", ["z [" + " " * 90_000, "z" + "[(" * 45_000, "z" + " " * 60_000 + "x" * 30_000])
def test_long_names_of_columns_take_no_time(table, header: str) -> None:
    """They are those of no column that is read."""
    assert len(table(f'time,id,x,y,"{header}"\n0,a,0,0,0\n').recording) == 1


def test_one_long_name_does_not_make_every_row_long(table) -> None:
    """The memory is that of the file."""
    rows = "".join(f"{k / 10},b,0,0,0\n" for k in range(12_000))
    tracemalloc.start()
    assert len(table(f"time,id,x,y,yaw\n0,{'n' * 9_000},1,1,0\n{rows}").recording.actors) == 2
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 60e6
    with pytest.raises(InterchangeError, match="at most 10,000 letters"):
        table(f"time,id,x,y\n0,{'n' * 10_001},1,1\n")


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", "t.csv", "empty"),
        ("\n\n", "t.csv", "empty"),
        ("time,id,x,y\n", "t.csv", "no rows"),
        ("time\tid\tx\ty\n", "t.csv", "no rows"),
        ("tim,id,x,y\n0,a,1,2\n", "line 1", "call that column `time`"),
        ("time,id,x\n0,a,1\n", "line 1", "no column `y`"),
        ("time,t,id,x,y\n", "line 1", "both"),
        ("total_nanos,idx,x,y,yaw,vel_x,vel_y,length,width,x\n", "line 1", "two columns are called `x`"),
        ("time,id,x,y,speed [knots]\n", "line 1", "knots"),
        ("total_nanos,idx,x,y\n0,0,1,2\n", "line 1", "yaw"),
        ("time,id,x,y\n0,a,1,2\n0,b,one,2\n", "line 3, column `x`", '"one"'),
        ('time,id,x,y\n0,a,"1,5",2\n', "line 2, column `x`", "point"),
        ("time,id,x,y\n0,a,1,\n", "line 2, column `y`", "nothing"),
        ("time,id,x,y\n0,a,1,nan\n", "line 2, column `y`", "nan"),
        ("time,id,x,y\n0,a,1,inf\n", "line 2, column `y`", "inf"),
        ("time,id,x,y\n0,a,1e30,1\n", "line 2, column `x`", "1e30"),
        ("time,id,x,y\n0,a,1_000,1\n", "line 2, column `x`", "1_000"),
        ("time,id,x,y\n0,,1,1\n", "line 2, column `id`", "name"),
        ("time,id,x,y\n0,a,1\n", "line 2", "3 cells"),
        ("time,id,x,y\n0,a,1,2,3\n", "line 2", "5 cells"),
        ("time,id,x,y\n0,a,1,2\n0.1,a,1,2\n0,a,3,2\n", "line 4", "two rows"),
        ("time,id,x,y,length\n0,a,1,2,0\n", "line 2", "length of 0 m"),
        ("total_nanos,idx,x,y,yaw,vel_x,vel_y,length,width\n0.5,0,0,0,0,0,0,1,1\n", "line 2", "whole number"),
        ('time,id,x,y\n0,"a,1,2\n', "t.csv", "not CSV"),
        (b"\xff\xfet\x00i\x00m\x00e\x00", "t.csv", "UTF-8"),
        (b"time,id,x,y\n0,a,\x00,1\n", "t.csv", "zero bytes"),
        ("time,id,x,y" + "z" * 200_000, "t.csv", "letters"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(table, text: str | bytes, place: str, words: str) -> None:
    """Line and column where there are such, and a cure."""
    with pytest.raises(InterchangeError) as caught:
        table(text)
    assert place in caught.value.place
    assert words in f"{caught.value.message} {caught.value.cure}"
    assert caught.value.cure


def test_size_is_bounded(table, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bytes, rows, actors and states, each with what to do."""
    monkeypatch.setattr(cells, "MOST_ROWS", 3)
    with pytest.raises(InterchangeError, match="more than 3 rows"):
        table(FULL)
    monkeypatch.undo()
    monkeypatch.setattr(read, "MOST_STATES", 3)
    with pytest.raises(InterchangeError, match="2 instants of 2 actors"):
        table(FULL)
    monkeypatch.undo()
    monkeypatch.setattr(read, "MOST_BYTES", 50)
    with pytest.raises(InterchangeError, match="MB"):
        table(FULL)
    monkeypatch.undo()
    crowd = "\n".join(["time,id,x,y,yaw", *(f"0,{n},{n},0,0" for n in range(1001))])
    found = table(crowd)
    assert len(found.recording.actors) == 200
    assert any(
        "of 1,001 actors, those are judged who come nearer than 200 m to the ego: 199" in remark
        for remark in found.remarks
    )
    with pytest.raises(InterchangeError, match="1,001 actors"):
        table("\n".join(["time,id,x,y,yaw", *(f"0,{n},{n / 10},0,0" for n in range(1001))]))


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1 and more that is no table PAR1"])
def test_what_is_no_parquet_is_refused(table, content: bytes) -> None:
    """With the reason on one line."""
    with pytest.raises(InterchangeError, match="not a readable Parquet file") as caught:
        table(content, name="t.parquet")
    assert "\n" not in caught.value.message


def test_parquet_with_wrong_cells_is_refused(tmp_path: Path) -> None:
    """Texts for numbers, empty cells, infinities, fractions for whole numbers."""
    import pyarrow
    import pyarrow.parquet

    good = {"time": [0.0, 0.1], "id": ["a", "a"], "x": [0.0, 1.0], "y": [0.0, 0.0]}
    path = tmp_path / "t.parquet"
    pyarrow.parquet.write_table(pyarrow.table(good), path)
    assert states(read_table(path).recording, "a", State.X).tolist() == [0.0, 1.0]
    for column, words in (
        (["0", "1"], "numbers"),
        ([0.0, None], "1 cells are empty"),
        ([0.0, math.inf], "inf"),
    ):
        pyarrow.parquet.write_table(pyarrow.table({**good, "x": column}), path)
        with pytest.raises(InterchangeError, match=words) as caught:
            read_table(path)
        assert "column `x`" in caught.value.place
    for names, words in ((["a", ""], "holds nothing"), ([b"a", b"\xff"], "binary"), (["a", "b" * 10_001], "letters")):
        pyarrow.parquet.write_table(pyarrow.table({**good, "id": names}), path)
        with pytest.raises(InterchangeError, match=words) as caught:
            read_table(path)
        assert "column `id`" in caught.value.place
    for names in ([7, 7], pyarrow.array(["a", "a"]).dictionary_encode()):
        pyarrow.parquet.write_table(pyarrow.table({**good, "id": names}), path)
        assert read_table(path).recording.actors[0].name == str(next(iter(names)))


def test_texts_of_parquet_are_held_once(tmp_path: Path) -> None:
    """However many rows have them: a small file does not unpack to a large one."""
    import pyarrow
    import pyarrow.parquet

    count = 100_000
    names = pyarrow.DictionaryArray.from_arrays(np.zeros(count, dtype=np.int32), ["n" * 9_000])
    zero = np.zeros(count)
    table = pyarrow.table({"time": np.arange(count) * 0.1, "id": names, "x": zero, "y": zero})
    pyarrow.parquet.write_table(table, tmp_path / "t.parquet")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert read_table(tmp_path / "t.parquet").recording.actors[0].name == "n" * 9_000
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000


def test_files_that_cannot_be_read_are_reported(tmp_path: Path) -> None:
    """Missing ones, folders, other kinds."""
    (tmp_path / "folder.csv").mkdir()
    for name, words in (("none.csv", "no such file"), ("folder.csv", "not a file"), ("t.xlsx", "not a table")):
        with pytest.raises(InterchangeError, match=words):
            read_table(tmp_path / name)


# -- the same table in other notations ---------------------------------------------------------------------------------


def one_drive(time, comma: bool = False, header: str = "time,id,x,y") -> str:
    """Two that drive past each other, 10 samples a second."""
    lines = [header]
    for k in range(20):
        for name, x, y in (("ego", k / 1.0, 0.5), ("b", 40 - 0.75 * k, 3.25)):
            cells = [time(k), name, f"{x:.3f}", f"{y:.3f}"]
            lines.append(",".join(cells) if not comma else ";".join(cell.replace(".", ",") for cell in cells))
    return "\n".join(lines) + "\n"


PLAIN = one_drive(lambda k: f"{k / 10}")
EPOCH = 1_700_000_000
NOTATIONS = {
    "us from 1970": (one_drive(lambda k: str(EPOCH * 10**6 + k * 10**5)), "`time` counts us, by its size"),
    "us from 0": (one_drive(lambda k: str(k * 10**5)), "`time` counts us, by its size"),
    "ms from 1970": (one_drive(lambda k: str(EPOCH * 10**3 + k * 10**2)), "`time` counts ms, by its size"),
    "ns from 1970": (one_drive(lambda k: str(EPOCH * 10**9 + k * 10**8)), "`time` counts ns, by its size"),
    "us, said": (one_drive(lambda k: str(EPOCH * 10**6 + k * 10**5), header="time [us],id,x,y"), "times count from"),
    "dates": (one_drive(lambda k: f"2026-11-28T12:00:0{k // 10}.{k % 10}00Z"), "`time` is written as dates"),
    "dates of a zone": (one_drive(lambda k: f"2026-11-28 23:59:5{8 + k // 10}.{k % 10}+01:00"), "written as dates"),
    "semicolons": (
        one_drive(lambda k: f"{k / 10}", True, "time;id;x;y"),
        "separated by semicolons, and numbers have decimal commas",
    ),
    "tabs": (PLAIN.replace(",", "\t"), "columns are separated by tabs"),
}


@pytest.mark.parametrize("notation", NOTATIONS)
def test_notations_of_one_table_are_one_recording(table, notation: str) -> None:
    """Each with a remark that says how it was read."""
    text, remark = NOTATIONS[notation]
    found, plain = table(text), table(PLAIN)
    assert found.recording.time == pytest.approx(plain.recording.time, abs=1e-6)
    assert found.recording.step == pytest.approx(0.1, abs=1e-7)
    assert found.recording.states[:, :, :3] == pytest.approx(plain.recording.states[:, :, :3], abs=1e-12)
    assert any(remark in each for each in found.remarks), found.remarks


def test_parquet_has_instants(tmp_path: Path) -> None:
    """Of any resolution."""
    import pyarrow
    import pyarrow.parquet

    for unit, factor in (("ms", 100), ("us", 100_000), ("ns", 100_000_000)):
        times = pyarrow.array([EPOCH * 10 * factor + k * factor for k in range(9)], pyarrow.timestamp(unit))
        columns = {"time": times, "id": ["a"] * 9, "x": [float(k) for k in range(9)], "y": [0.0] * 9}
        pyarrow.parquet.write_table(pyarrow.table(columns), tmp_path / "t.parquet")
        assert read_table(tmp_path / "t.parquet").recording.time == pytest.approx([k / 10 for k in range(9)])


NAMED = {"time": "zeit", "actor": "objekt", "x": "px", "y": "py"}


def test_columns_may_be_named(tmp_path: Path) -> None:
    """By what they are, with a unit if theirs does not say it; what is named is read in place of what is called so."""
    path = tmp_path / "t.csv"
    for header, named in (
        ("zeit,objekt,px,py", NAMED),
        ("zeit [s],objekt,px,py", {**NAMED, "time": "zeit [s]"}),
        ("x,y,px,py", {**NAMED, "time": "x", "actor": "y"}),
    ):
        path.write_text(PLAIN.replace("time,id,x,y", header))
        (tmp_path / "plain.csv").write_text(PLAIN)
        found = read.read_tracks(path, named=named).tracks
        for one, other in zip(found, read.read_tracks(tmp_path / "plain.csv").tracks, strict=True):
            assert one.positions.tolist() == other.positions.tolist()
            assert one.time.tolist() == other.time.tolist()
    path.write_text(PLAIN.replace("time,id,x,y", "zeit,objekt,px,py"))
    halved = read.read_tracks(path, named={"time [ms]": "zeit", **{key: NAMED[key] for key in ("actor", "x", "y")}})
    assert halved.tracks[0].time[1] == pytest.approx(1e-4)
    with pytest.raises(InterchangeError, match="none of its columns is called `zeitt`") as caught:
        read.read_tracks(path, named={**NAMED, "time": "zeitt"})
    assert "`zeit`" in caught.value.cure
    with pytest.raises(InterchangeError, match='no column is read as "tim"') as caught:
        read.read_tracks(path, named={"tim": "zeit"})
    assert "`time`" in caught.value.cure
    with pytest.raises(InterchangeError, match="no column `time`") as caught:
        read.read_tracks(path)
    assert "--columns time=COLUMN" in caught.value.cure


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("time;id;x;y\n0;a;1,5;2\n0,1;a;1.6;2\n", "line 3, column `x`", "with a point"),
        ("time;id;x;y\n0;a;1,5,1;2\n", "line 2, column `x`", '"1,5,1"'),
        ("time,id,x,y\n2026-11-28T12:00:00Z,a,1,2\n0.1,a,1,2\n", "line 3, column `time`", "a date"),
        ("time,id,x,y\n0,a,1,2\n2026-11-28T12:00:00Z,a,1,2\n", "line 3, column `time`", "2026"),
        ("time,id,x,y\n2026-13-28T12:00:00Z,a,1,2\n", "line 2, column `time`", "2026-13"),
    ],
)
def test_mixed_notations_are_refused(table, text: str, place: str, words: str) -> None:
    """At the cell that is written otherwise."""
    with pytest.raises(InterchangeError) as caught:
        table(text)
    assert place in caught.value.place
    assert words in f"{caught.value.message} {caught.value.cure}"
