"""Paths of lines, arcs and clothoids: their geometry, and vehicles that follow them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import fresnel

from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from engine import batch
from engine.opendrive.curves import Pose
from engine.road.alignment import STEP, Segment, aligned
from engine.road.paths import PathBook
from engine.tables import Floats
from engine.vocabulary import Column, State

from .laws import examples

CURVATURE = st.one_of(st.just(0.0), st.floats(0.001, 0.15), st.floats(-0.15, -0.001))


@st.composite
def segments(draw: st.DrawFn) -> list[Segment]:
    """Return segments each of which begins with the curvature at which the one before it ends."""
    nodes = draw(st.lists(CURVATURE, min_size=2, max_size=6))
    lengths = draw(st.lists(st.floats(0.5, 40.0), min_size=len(nodes) - 1, max_size=len(nodes) - 1))
    return [Segment(*each) for each in zip(lengths, nodes[:-1], nodes[1:], strict=True)]


def by_fresnel(segment: Segment) -> tuple[float, float, float]:
    """Return the end of a segment in the frame of its start, by the Fresnel integrals of scipy."""
    length, first, last = segment.length, segment.start, segment.end
    turn, rate = 0.5 * (first + last) * length, (last - first) / length
    if abs(rate) < 1e-9:
        middle = 0.5 * (first + last)
        if middle == 0.0:
            return length, 0.0, 0.0
        return math.sin(middle * length) / middle, (1.0 - math.cos(middle * length)) / middle, turn
    # The heading is rate / 2 (s + first / rate)^2 - first^2 / (2 rate): a part of the clothoid from its middle.
    scale = math.sqrt(math.pi / abs(rate))
    ends = np.array([first / rate, first / rate + length]) / scale
    sines, cosines = fresnel(ends)
    x, y = scale * float(cosines[1] - cosines[0]), math.copysign(scale, rate) * float(sines[1] - sines[0])
    back = -first * first / (2.0 * rate)
    return x * math.cos(back) - y * math.sin(back), x * math.sin(back) + y * math.cos(back), turn


@examples(200)
@given(segments(), st.floats(-3.0, 3.0))
def test_the_end_of_a_path_is_that_of_the_fresnel_integrals(parts: list[Segment], heading: float) -> None:
    """To 1e-6 m and rad, whatever lines, arcs and clothoids follow one another."""
    start = end = Pose(3.0, -2.0, heading)
    book = PathBook()
    path = book.draw(aligned(start, parts))
    for part in parts:
        end = end.moved(*by_fresnel(part))
    found = book.pose(path, book.length(path))
    assert (found.x, found.y) == pytest.approx((end.x, end.y), abs=1e-6)
    assert math.remainder(found.heading - end.heading, math.tau) == pytest.approx(0.0, abs=1e-6)
    assert book.length(path) == pytest.approx(sum(part.length for part in parts), abs=1e-4)


@examples(100)
@given(segments(), st.floats(0.0, 1.0))
def test_heading_and_curvature_are_continuous(parts: list[Segment], share: float) -> None:
    """The chain is that of `Primitive`s without a corner; its curvature is within `STEP` of the linear one."""
    chain = aligned(Pose(0.0, 0.0, 0.0), parts)
    book = PathBook()
    path = book.draw(chain)
    for before, after in pairwise(chain):
        end = before.pose(before.length)
        assert math.hypot(end.x - after.x, end.y - after.y) < 1e-9
        assert math.remainder(end.heading - after.heading, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert abs(before.curvature - after.curvature) <= 2.0 * STEP
    first, place = 0.0, Pose(0.0, 0.0, 0.0)
    for part in parts:
        s = share * part.length
        wanted = part.start + (part.end - part.start) * share
        if 1e-3 < s < part.length - 1e-3:
            assert book.curvature(path, first + s) == pytest.approx(wanted, abs=1.05 * STEP)
        exact, found = place.moved(*part.pose(s)), book.pose(path, first + s)
        assert math.hypot(exact.x - found.x, exact.y - found.y) < 1e-3
        first, place = first + part.length, place.moved(*part.pose(part.length))


SCENE = """
map road(lanes=1, length=600 m)
start = new OrientedPoint at (-250, 0), facing {heading} deg
way = Path(start, [20 m, Clothoid(none, {radius} m, length={length} m), Arc({radius} m, angle={angle} deg),
    Clothoid({radius} m, none, length={length} m), 40 m])
ego = new {kind} at start, facing {heading} deg, with speed {speed} m/s, with regionContainedIn None,
    with behavior FollowTrajectoryBehavior({speed} m/s, way)
terminate after {time} s
"""


@examples(40)
@given(
    kind=st.sampled_from(["Car", "Truck", "Bicycle", "Motorcycle"]),
    radius=st.floats(14.0, 200.0),
    side=st.sampled_from([-1, 1]),
    angle=st.floats(5.0, 120.0),
    heading=st.sampled_from([0, 90, -135]),
    lateral=st.floats(0.3, 2.5),
)
def test_a_follower_stays_within_5_cm(
    kind: str, radius: float, side: int, angle: float, heading: int, lateral: float
) -> None:
    """The rear axle of every vehicle, at lateral accelerations up to those of the rating tests, from a pose on it."""
    speed = min(math.sqrt(lateral * radius), 12.0)
    length = max(6.0, 1.5 * speed)
    way = 60.0 + 2.0 * length + math.radians(angle) * radius
    text = SCENE.format(
        kind=kind, radius=side * radius, length=length, angle=angle, heading=heading, speed=speed, time=way / speed
    )
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=1)
    run = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    bend = 1.0 / (side * radius)
    parts = [Segment(20.0), Segment(length, 0.0, bend), Segment(math.radians(angle) * radius, bend, bend)]
    parts += [Segment(length, bend, 0.0), Segment(40.0)]
    book = PathBook()
    path = book.draw(aligned(Pose(-250.0, 0.0, math.radians(heading)), parts))
    axle = rear_axle(run.states[:, 0], float(scenes.values[0, Column.REAR_TO_CENTER]))
    assert np.hypot(*(axle[-1] - axle[0])) > 20.0
    ahead = book.feet(path, *axle.T)
    assert float(ahead.distance[ahead.s > 0.0].max()) < 0.05


def rear_axle(states: Floats, back: float) -> Floats:
    """Return (n, 2) the places of the rear axle."""
    heading = states[:, State.HEADING]
    return states[:, :2] - back * np.column_stack([np.cos(heading), np.sin(heading)])


def test_a_condition_of_the_scene_chooses_a_path() -> None:
    """The path of a param's value is followed, and places on it depend on the scene."""
    scenario = compile_text(
        "map road(lanes=1, length=600 m)\n"
        "param SIDE = Range(-1, 1)\n"
        "start = new OrientedPoint at (0, 0), facing 0 deg\n"
        "left, right = Path(start, [Arc(30 m, angle=90 deg)]), Path(start, [Arc(-30 m, angle=90 deg)])\n"
        "way = left if SIDE > 0 else right\n"
        "here = way.poseAt(3 m)\n"
        "ego = new Car at here, facing here.heading, with speed 5 m/s, with regionContainedIn None,\n"
        "    with behavior FollowTrajectoryBehavior(5 m/s, way)\n"
        "terminate after 6 s\n"
    )
    scenes = scenario.sample(20, seed=3)
    found = set[bool]()
    for row in range(20):
        run = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation)
        to_left = float(scenes.genomes[row, 0]) > 0.0
        assert (run.states[-1, 0, State.Y] > 5.0) == to_left
        assert (run.states[-1, 0, State.Y] < -5.0) != to_left
        found.add(to_left)
    assert found == {True, False}


START = "start = new OrientedPoint at (0, 0), facing 0 deg\n"


@pytest.mark.parametrize(
    ("segments", "code", "words"),
    [
        ("[]", "SCN517", "1 to 100 segments, and this one 0"),
        ("[Arc(0 m, angle=90 deg)]", "SCN517", "its radius is 0"),
        ("[Arc(9 m)]", "SCN517", "neither an angle nor a length"),
        ("[Arc(9 m, angle=9 deg, length=3 m)]", "SCN517", "both an angle and a length"),
        ("[Arc(9 m, length=0 m)]", "SCN517", "its length is 0 m"),
        ("[Arc(9 m, length=-1 m)]", "SCN402", "`length` is -1 m"),
        ("[Arc(9 m, angle=400 deg)]", "SCN402", "`angle` is"),
        ("[Clothoid(9 m, -9 m, angle=9 deg)]", "SCN517", "its angle does not say how long it is"),
        ("[Clothoid(none, none, angle=9 deg)]", "SCN517", "its angle does not say how long it is"),
        ("[Clothoid(none, 0.001 m, length=20 m)]", "SCN517", "it turns by more than 10 circles"),
        ("[Arc(1e9 m, angle=90 deg)]", "SCN517", "the most"),
        ("[Arc(9 s, angle=90 deg)]", "SCN301", "`radius` must be a length"),
        ("[3 s]", "SCN301", "must be a length"),
        ("[0 m]", "SCN402", "the length of a line is 0 m"),
        ('["left"]', "SCN303", "a segment"),
        ("[Arc(sqrt(-1) * 1 m, angle=90 deg)]", "SCN401", "the square root of -1"),
        ("[Arc(3 m, angle=90 deg)]", "SCN469", "radius of 3 m"),
        ("[Arc(Range(9, 12) m, angle=90 deg)]", "SCN506", "`radius`"),
    ],
)
def test_a_bad_path_says_what_is_wrong(segments: str, code: str, words: str) -> None:
    """With the place of the segment."""
    text = f"{START}ego = new Car at start, with behavior FollowTrajectoryBehavior(5 m/s, Path(start, {segments}))\n"
    with pytest.raises(CompileError) as error:
        compile_text("map road(lanes=1)\n" + text)
    found = [each for each in error.value.diagnostics if each.severity.name == "ERROR"]
    assert any(each.code == code and words in f"{each.message}; {each.reason}" for each in found), found


def test_a_person_walks_any_path() -> None:
    """A radius that no car can turn is no error for somebody on foot."""
    walk = "ego = new Car at (90, -1.75), facing 0 deg\n"
    compile_text(
        f"map road(lanes=1)\n{START}{walk}p = new Pedestrian at start, with regionContainedIn None,\n"
        "    with behavior FollowTrajectoryBehavior(1 m/s, Path(start, [Arc(1 m, angle=90 deg)]))\n"
    )
