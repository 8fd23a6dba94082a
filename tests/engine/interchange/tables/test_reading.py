"""Plain tables of other people: names, units, what is missing, and what is wrong."""

import math
from pathlib import Path

import numpy as np
import pytest

from engine.interchange import InterchangeError, Recording
from engine.interchange.reading import Imported
from engine.interchange.tables import cells, read_table, reading
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
    """As it stands, without a remark."""
    found = table(FULL)
    assert found.remarks == ()
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
        ("t,track_id,x,y,yaw_deg,v [km/h]", "{t},ego,0,0,90,36", math.pi / 2, 10.0),
        ("timestamp_ms,agent_id,x,y,psi_rad,vel", "{ms},ego,0,0,1.5,10", 1.5, 10.0),
        ("Time [s],Name,X (m),Y (m),Heading [deg],Speed [mph]", "{t},ego,0,0,180,1", math.pi, 0.44704),
        ("seconds,object_id,pos_x,pos_y,theta,speed_kmh", "{t},ego,0,0,-1,3.6", -1.0, 1.0),
    ],
)
def test_names_and_units_are_understood(table, header: str, row: str, heading: float, speed: float) -> None:
    """Units in brackets or behind an underscore."""
    rows = [row.format(t=t, ms=1000 * t) for t in (0.0, 0.5)]
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
    told = " ".join(found.remarks)
    for word in ("headings", "speeds", "length", "width", "no type", "--ego"):
        assert word in told


def test_headings_are_unwrapped(table) -> None:
    """A turn through the back is no spin."""
    rows = [f"{k / 10},a,{k},0,{h}" for k, h in enumerate((3.0, 3.1, -3.08, -2.98))]
    heading = states(table("\n".join(["time,id,x,y,yaw", *rows])).recording, "a", State.HEADING)
    assert np.abs(np.diff(heading)).max() < 0.2


def test_who_is_the_ego(table) -> None:
    """Who is asked for; else who is called so; else the first, with a remark."""
    text = "time,id,x,y\n0,a,0,0\n0,Ego,50,0\n0,c,90,0\n"
    assert table(text).recording.actors[0].name == "Ego"
    assert [actor.name for actor in table(text, ego="c").recording.actors] == ["c", "a", "Ego"]
    by_role = "time,id,x,y,role\n0,a,0,0,\n0,b,50,0,ego\n"
    assert table(by_role).recording.actors[0].name == "b"
    assert any("`a` is taken" in remark for remark in table(text.replace("Ego", "b")).remarks)
    with pytest.raises(InterchangeError, match="`eggo`") as caught:
        table(text, ego="eggo")
    assert "Ego" in caught.value.cure


def test_uneven_times_are_kept_and_told(table) -> None:
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


def test_degrees_without_a_name_are_not_taken_for_radians(table) -> None:
    """From 350 to 10 is no turn that a car makes in a step."""
    with pytest.raises(InterchangeError, match="radians") as caught:
        table("time,id,x,y,heading\n0,a,0,0,350\n0.1,a,1,0,10\n")
    assert "heading_deg" in caught.value.cure


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", "t.csv", "empty"),
        ("\n\n", "t.csv", "empty"),
        ("time,id,x,y\n", "t.csv", "no rows"),
        ("time;id;x;y\n0;a;1,5;2\n", "line 1", "semicolons"),
        ("time\tid\tx\ty\n", "line 1", "tabs"),
        ("tim,id,x,y\n0,a,1,2\n", "line 1", "call that column `time`"),
        ("time,id,x\n0,a,1\n", "line 1", "no column `y`"),
        ("time,t,id,x,y\n", "line 1", "both"),
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
    monkeypatch.setattr(reading, "MOST_STATES", 3)
    with pytest.raises(InterchangeError, match="2 instants of 2 actors"):
        table(FULL)
    monkeypatch.undo()
    monkeypatch.setattr(reading, "MOST_BYTES", 50)
    with pytest.raises(InterchangeError, match="MB"):
        table(FULL)
    monkeypatch.undo()
    crowd = "\n".join(["time,id,x,y", *(f"0,{n},{n},0" for n in range(1001))])
    with pytest.raises(InterchangeError, match="1,001 actors"):
        table(crowd)


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1 and more that is no table PAR1"])
def test_what_is_no_parquet_is_refused(table, content: bytes) -> None:
    """With the reason on one line."""
    with pytest.raises(InterchangeError, match="no Parquet") as caught:
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


def test_files_that_cannot_be_read_are_told(tmp_path: Path) -> None:
    """Missing ones, folders, other kinds."""
    (tmp_path / "folder.csv").mkdir()
    for name, words in (("none.csv", "no such file"), ("folder.csv", "no file"), ("t.xlsx", "no table")):
        with pytest.raises(InterchangeError, match=words):
            read_table(tmp_path / name)
