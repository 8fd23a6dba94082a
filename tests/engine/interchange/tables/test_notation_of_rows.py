"""Laws of how a table is written and of what its rows leave unsaid: comments, spaces, heights, long steps, rows between
steps.
"""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import string
from pyarrow.csv import ConvertOptions, ParseOptions, read_csv

from engine.interchange.every_pair import rank_pairs
from engine.interchange.measuring import measure
from engine.interchange.sources import read_recording, read_traffic
from engine.interchange.tables.cells import read_csv_cells

TEXTS = ConvertOptions(column_types={"id": string()}, strings_can_be_null=False)

COLUMNS = "time,actor,x,y,heading,speed"
ROWS = [row for k in range(21) for row in (f"{k / 10},ego,{k},0,0,10", f"{k / 10},c,{40 - k},3.5,3.1416,10")]
WRITTEN = {
    "comments": ["# by hand", "#", "", COLUMNS, *ROWS[:5], "# a remark, with a comma", *ROWS[5:], "# end"],
    "a row that is left out": [COLUMNS, "#0.05,ego,0,0,0,10", *ROWS],
    "names in a comment": [f"# {COLUMNS}", *ROWS],
    "spaces": [row.replace(",", "  ") for row in [COLUMNS, *ROWS]],
    "spaces at both ends": [f"  {row.replace(',', ' ')} " for row in [COLUMNS, *ROWS]],
    "savetxt": [f"# {COLUMNS}".replace(",", " "), *(row.replace(",", " ") for row in ROWS)],
}


def saved(folder: Path, lines: list[str]) -> Path:
    (folder / "t.csv").write_text("\n".join(lines) + "\n")
    return folder / "t.csv"


@pytest.mark.parametrize("written", WRITTEN)
def test_the_notation_of_a_table_changes_nothing(tmp_path: Path, written: str) -> None:
    """Comments and spaces give the recording of the plain table."""
    plain = read_recording(saved(tmp_path, [COLUMNS, *ROWS])).recording
    other = read_recording(saved(tmp_path, WRITTEN[written])).recording
    assert (plain.states == other.states).all()
    assert (plain.time == other.time).all()


def test_a_place_counts_comments(tmp_path: Path) -> None:
    """The line is that of the file."""
    lines = ["# one", "# two", COLUMNS, *ROWS[:3], "# three", "0.15,ego,oh,0,0,10"]
    with pytest.raises(Exception, match="line 8, column `x`"):
        read_recording(saved(tmp_path, lines))
    with pytest.raises(Exception, match="line 3"):
        read_recording(saved(tmp_path, ["# one", "# two", COLUMNS.replace("x,", "east,"), *ROWS[:3]]))


def test_an_actor_may_be_called_with_a_mark(tmp_path: Path) -> None:
    """Of a table whose first column holds names, whole rows are no comments."""
    rows = [f"#{name},{time},{x},{y},{h},{v}" for time, name, x, y, h, v in (row.split(",") for row in ROWS)]
    text = ["actor,time,x,y,heading,speed", "# a comment", *rows]
    assert {track.name for track in read_traffic(saved(tmp_path, text)).tracks} == {"#ego", "#c"}


def with_heights(rows: list[str], heights: dict[str, float], slope: float = 0.0) -> list[str]:
    cells = [row.split(",") for row in rows]
    return [f"{COLUMNS},z", *(",".join([*row, str(heights[row[1]] + slope * float(row[2]))]) for row in cells)]


CROSSING = [row for k in range(31) for row in (f"{k / 10},ego,{k},0,0,10", f"{k / 10},c,20,{k - 20},1.5708,10")]
"""Rows of two that collide after 2 s."""


@pytest.mark.parametrize(("height", "apart"), [(0.0, False), (1.5, False), (3.0, True), (8.0, True), (-8.0, True)])
@pytest.mark.parametrize("slope", [0.0, 0.1, -0.1])
def test_traffic_on_another_level_is_no_pair(tmp_path: Path, height: float, slope: float, *, apart: bool) -> None:
    """With and without an ego; the outcome is that of the recording without it, and a remark says so."""
    path = saved(tmp_path, with_heights(CROSSING, {"ego": 100.0, "c": 100.0 + height}, slope))
    read, every = read_recording(path), rank_pairs(read_traffic(path))
    assert bool(measure(read.recording).outcomes.collided[0]) is not apart
    assert bool(every.outcomes.collided.any()) is not apart
    side = "above" if height > 0 else "below"
    for remarks in (read.remarks, every.remarks):
        found = [remark for remark in remarks if "not on one level" in remark]
        assert len(found) == apart
        assert not apart or f"{abs(height):.1f} m {side} `ego`" in found[0]


def test_levels_for_a_part_of_the_way_are_named(tmp_path: Path) -> None:
    """Both are judged in one plane."""
    rows = with_heights(CROSSING, {"ego": 0.0, "c": 0.0})
    rows = [f"{row[:-3]}9" if ",c," in row and float(row.split(",")[0]) < 2.0 else row for row in rows]
    read = read_recording(saved(tmp_path, rows))
    assert any("for a part of their way" in remark for remark in read.remarks)
    assert measure(read.recording).outcomes.collided[0]


@pytest.mark.parametrize("step", [2.5, 5.0, 40.0])
def test_no_contact_is_found_between_rows_that_are_far_apart(tmp_path: Path, step: float) -> None:
    """The way between them is not known; a remark says so. An actor that stands needs no rows."""
    rows = [f"{COLUMNS},length,width"]
    for k in range(3):
        rows += [f"{k * step},ego,{100 * k},0,0,10,4.5,1.8", f"{k * step},b,50,0,0,0,4.5,1.8"]
    read = read_recording(saved(tmp_path, rows))
    assert not measure(read.recording).outcomes.collided[0]
    assert [remark for remark in read.remarks if f"`ego` moves between rows {step:g} s apart, at 0 s" in remark]
    every = rank_pairs(read_traffic(tmp_path / "t.csv"))
    assert not every.outcomes.collided.any()
    assert [remark for remark in every.remarks if "`ego` moves between rows" in remark]


def test_rows_between_two_steps_are_named(tmp_path: Path) -> None:
    """Without an ego motion is judged on steps."""
    every = rank_pairs(read_traffic(saved(tmp_path, [COLUMNS, *ROWS, "1.043,b,10.4,0,0,10"])))
    assert [remark for remark in every.remarks if "`b`, at 1.043 s: between two steps of 0.1 s only" in remark]
    assert not [
        remark
        for remark in rank_pairs(read_traffic(saved(tmp_path, [COLUMNS, *ROWS]))).remarks
        if "two steps" in remark
    ]


finite = st.floats(-1e6, 1e6, allow_subnormal=False)
rows = st.lists(st.tuples(st.text("abc #;", min_size=1, max_size=4), finite, finite), min_size=1, max_size=20)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=rows, separator=st.sampled_from([",", ";", "\t", "|"]), quoted=st.booleans())
def test_cells_are_those_of_another_reader(
    rows: list[tuple[str, float, float]], separator: str, quoted: bool, tmp_path: Path
) -> None:
    """Names and numbers are bit for bit those that pyarrow reads, whatever separates them."""
    mark = '"' if quoted or separator == ";" else ""
    named = [(f"n{name}{row}", x, y) for row, (name, x, y) in enumerate(rows)]
    lines = [separator.join([f"{mark}{name}{mark}", "0.0", repr(x), repr(y)]) for name, x, y in named]
    path = saved(tmp_path, [separator.join(["id", "time", "x", "y"]), *lines])
    theirs = read_csv(path, parse_options=ParseOptions(delimiter=separator), convert_options=TEXTS)
    ours = read_csv_cells(path)
    assert list(ours.texts["actor"]) == [name.strip() for name in theirs["id"].to_pylist()]
    for column in ("x", "y"):
        assert np.array_equal(ours.numbers[column], theirs[column].to_numpy())
