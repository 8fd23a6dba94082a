"""Laws of the column of headings: whatever zero and sense it counts in, the verdict is that of the motion, and a remark
says what is wrong; headings that fit but for noise and slip have none.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.interchange.measuring import measure
from engine.interchange.sources import read_recording, read_traffic
from tests.engine.interchange.test_motion_laws import LEFT_OUT, SCENES, Way, distance, remarks_of, table, way

SENSES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "compass": (lambda h: np.mod(math.pi / 2 - h, 2 * math.pi), "clockwise from north"),
    "clockwise": (lambda h: -h, "clockwise from the x axis"),
    **{
        f"zero at {turn}": (lambda h, turn=turn: h + math.radians(turn), f"{abs(turn)} degrees {side} of it")
        for turn, side in ((-170, "right"), (-90, "right"), (-30, "right"), (-7, "right"), (7, "left"), (44, "left"))
    },
}
TWO_WAYS = (
    way("ego", 0, 0, 0.3, [10.0] * 50),
    way("o", 60, 30, 3.6, [10.0] * 50),
    way("c", -20, 60, -1.0, [8.0] * 50),
    way("p", 25, 12, 1.2, [0.0] * 50),
)


def counted(ways: tuple[Way, ...], sense: str) -> tuple[Way, ...]:
    return tuple(replace(each, heading=SENSES[sense][0](each.heading)) for each in ways)


def written(ways: tuple[Way, ...], shown: tuple[Way, ...]) -> str:
    """A table of `ways` without speeds, with the headings of `shown`."""
    return table([replace(each, heading=other.heading) for each, other in zip(ways, shown, strict=True)], ("speed",))


@pytest.mark.parametrize("sense", SENSES)
def test_headings_of_another_zero_or_sense_are_not_used(tmp_path: Path, sense: str) -> None:
    """The metrics are those of the table without headings, and one remark names the sense."""
    without = table(TWO_WAYS, ("heading", "speed"))
    text = written(TWO_WAYS, counted(TWO_WAYS, sense))
    found = [line for line in remarks_of(tmp_path, text).splitlines() if "do not fit the motion" in line]
    assert len(found) == 1, remarks_of(tmp_path, text)
    assert SENSES[sense][1] in found[0]
    one = measure(read_recording(tmp_path / "t.csv", ego="ego").recording)
    parked = next(track for track in read_traffic(tmp_path / "t.csv").tracks if track.name == "p")
    assert parked.assumed is not None
    assert parked.assumed.all()
    (tmp_path / "t.csv").write_text(without)
    assert distance(one) == distance(measure(read_recording(tmp_path / "t.csv", ego="ego").recording))


def test_some_that_fit_both_senses_do_not_hide_the_wrong_one(tmp_path: Path) -> None:
    """One actor along the x axis, one along y: clockwise headings have the latter drive backwards at 9 m/s."""
    ways = (way("ego", 0, 0, 0.0, [10.0] * 50), way("o", 60, -40, math.pi / 2, [9.0] * 50))
    assert "clockwise from the x axis" in remarks_of(tmp_path, written(ways, counted(ways, "clockwise")))
    slow = (ways[0], way("o", 60, -40, math.pi / 2, [3.0] * 50))  # may drive backwards
    assert "do not fit" not in remarks_of(tmp_path, written(slow, counted(slow, "clockwise")))


@pytest.mark.parametrize("offset", [-30.0, -6.0, 6.0, 30.0, 44.0])
def test_one_actor_of_another_zero_is_named(tmp_path: Path, offset: float) -> None:
    """The headings of the others are believed."""
    ego, *others = TWO_WAYS
    shown = (replace(ego, heading=ego.heading + math.radians(offset)), *others)
    text = written(TWO_WAYS, shown)
    side = "left" if offset > 0 else "right"
    assert f"headings of `ego` lie {abs(offset):.0f} degrees {side} of its motion" in remarks_of(tmp_path, text)
    tracks = read_traffic(tmp_path / "t.csv").tracks
    assert tracks[0].heading == pytest.approx(ego.heading, abs=1e-6)
    assert tracks[3].heading == pytest.approx(others[2].heading)


@pytest.mark.parametrize("scene", SCENES)
def test_headings_that_fit_have_no_remark(tmp_path: Path, scene: str) -> None:
    """Exact ones, with 10 degrees of noise, and shifted by 2 degrees: forwards, backwards, in turns."""
    random = np.random.default_rng(4)
    changes = (lambda h: h, lambda h: h + random.normal(0.0, math.radians(10.0), len(h)), lambda h: h + 0.035)
    for change in changes:
        shown = tuple(replace(each, heading=change(each.heading)) for each in SCENES[scene])
        assert "motion" not in remarks_of(tmp_path, written(SCENES[scene], shown)).replace("taken from motion", "", 1)


@pytest.mark.parametrize("blank", ["all of one", "every third", "a turn"])
def test_blank_headings_are_those_of_motion(tmp_path: Path, blank: str) -> None:
    """As the rule for absent headings has it; the others stay as they are."""
    ways = SCENES["turning"]
    exact = table(ways)
    empty = {"all of one": range(50), "every third": range(0, 50, 3), "a turn": range(10, 30)}[blank]
    rows = exact.splitlines()
    for k in empty:
        cells = rows[51 + k].split(",")
        rows[51 + k] = ",".join([*cells[:4], "", *cells[5:]])
    said = remarks_of(tmp_path, "\n".join(rows))
    assert (
        "without headings" if blank == "all of one" else f"`o` has {len(empty)} of 50 rows without a heading"
    ) in said
    other = read_traffic(tmp_path / "t.csv").tracks[1]
    assert np.degrees(np.abs(other.heading - ways[1].heading).max()) < 2.0


@pytest.mark.parametrize("leave_out", LEFT_OUT, ids="+".join)
def test_blank_sizes_are_the_usual_ones(tmp_path: Path, leave_out: tuple[str, ...]) -> None:
    """Of an actor without any; another row of the same actor decides where one states it."""
    rows = table(SCENES["crossing"], leave_out).splitlines()
    for k in (1, 2):
        rows[k] = rows[k].removesuffix("4.5,1.8") + "," + "1.8"
    for k in range(51, 101):
        rows[k] = rows[k].removesuffix("4.5,1.8") + ","
    assert "no length of a car" in remarks_of(tmp_path, "\n".join(rows))
    ego, other = read_traffic(tmp_path / "t.csv").tracks
    assert (ego.length, ego.width) == (4.5, 1.8)
    assert other.length > 3.0
