"""Every `require` is weighed at once."""

import re
import time

from .conftest import LEFT_TURN, Talk

FOLLOWING = (
    "map intersection(approach=200 m)",
    "lane = intersection.incomingLanes[0]",
    "param V = Range(5, 10) m/s",
    "param GAP = Range(5, 30) m",
    "way = [lane, lane.successors[0]]",
    "ego = new Car before intersection by 150 m along way,\n    with speed V, with behavior FollowLaneBehavior(V)",
    "truck = new Truck ahead of ego by GAP, with speed 8 m/s, with behavior FollowLaneBehavior(8 m/s)",
    "terminate after 4 s",
)
"""A car behind a truck."""
PARAMS = ("param V = Range(0, 100) m/s", "param D = Range(0, 50) m")


def test_acceptance_before_and_after(talk: Talk) -> None:
    """Also without an ego: the shares are those of the params, and what is left of a range is shown."""
    talk(*PARAMS)
    said = talk("require V > 40 m/s")
    before, after = map(float, re.findall(r"([\d.]+) %", said.out)[:2])
    assert before == 100.0
    assert 58.0 < after < 62.0
    assert "left of V 40 .. 100 m/s" in said.out
    assert re.search(r"V > 40 m/s .* 6\d\.\d %|V > 40 m/s .* 59\.\d %", said.out)


def test_nothing_passes_any_more(talk: Talk) -> None:
    """The smallest conflicting set is named."""
    talk(*PARAMS, "require V > 60 m/s", "require D < 40 m")
    said = talk("require V < 50 m/s")
    assert "0.00 % of draws accepted" in said.out
    assert "never together: `V > 60 m/s` (line 3) and `V < 50 m/s` (line 5); proved" in said.out


def test_what_to_relax(talk: Talk) -> None:
    """One requirement and its amount."""
    talk(*PARAMS, "require V > 60 m/s")
    said = talk(":relax 50%")
    assert re.search(r"relax `V > 60 m/s` by (9|10)\.?\d* m/s", said.out)


def test_what_is_owed_is_weighed_by_runs(talk: Talk) -> None:
    """An `expect`, a number and a requirement on the run, each as it is typed; what was there is not said again."""
    talk(*FOLLOWING)
    said = talk('expect always (distance from ego to truck) > 15 m as "room"').out
    found = re.search(r"room .* kept in (\d+) of (\d+) runs; least robustness -[\d.]+", said)
    assert found
    kept, runs = map(int, found.groups())
    assert runs == 400
    assert 0 < kept < runs
    said = talk('maximize largest(ego.speed) as "top speed"').out
    assert re.search(r"top speed .* 5\.\d+ \.\. 9\.9\d+ m/s, median 7\.\d+", said)
    assert "room" not in said
    said = talk('require always (distance from ego to truck) > 10 m as "far"').out
    assert "far" in said
    assert "room" not in said
    said = talk('require eventually (distance from ego to truck) > 25 m as "gets away"').out
    assert re.search(r"gets away .* met in \d+ of \d+ runs; the others are thrown away", said)


def test_what_never_and_always_breaks(talk: Talk) -> None:
    """It is said in words; a changed expectation is weighed again."""
    talk(*FOLLOWING)
    assert "kept in all 400 runs" in talk('expect always ego.speed < 50 m/s as "slow"').out
    said = talk('expect always ego.speed < V - 1 m/s as "slow"').out
    assert "replaced `slow`" in said
    assert "broken in all 400 runs" in said


def test_nothing_is_run_without_an_ego(talk: Talk) -> None:
    """What is owed is weighed when there is somebody to owe it, and not again by what does not change it."""
    talk("param V = Range(1, 9) m/s")
    assert talk('expect V > 3 m/s as "fast"').out == ""
    talk(*FOLLOWING)
    assert not talk("x = 3 m").out


def test_a_run_that_fails_is_told(talk: Talk) -> None:
    """A number that does not exist is a mistake in the file, with its place."""
    talk(*FOLLOWING)
    said = talk('expect always sqrt((distance from ego to truck) / 1 m - 20) > 1 as "root"')
    assert "error[SCN" in said.err
    assert not said.out


def test_how_long_a_weighing_takes(talk: Talk) -> None:
    """Printed, not judged: machines differ. Ten thousand draws of the worked example, view included."""
    talk(LEFT_TURN.read_text())
    talk("require EGO_SPEED > 20 km/h")
    start = time.perf_counter()
    talk("require EGO_SPEED > 30 km/h")
    print(f"entering and weighing a `require`: {time.perf_counter() - start:.3f} s")  # noqa: T201
