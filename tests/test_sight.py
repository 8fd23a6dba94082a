"""Everything that looks sees past nobody who hides: in scenes, behaviours, drivers of the library and results, in both
hosts.
"""

import numpy as np
import pytest
import shapely

from cortex_dsl import CompileError, compile_text
from engine import world
from engine.outcomes import Outcomes
from engine.vocabulary import State
from tests.sight_polygon import visible_area

SCENE = """
map intersection(approach=100 m)
behavior Watch():
    try:
        do FollowLaneBehavior(12 m/s)
    interrupt when {condition}:
        take SetBrakeAction(1)
{before}
ego = new Car at (-80, -1.75), facing 0 deg, with speed 12 m/s, with behavior Watch()
wall = new {kind} at (-60, -5), facing 0 deg, with regionContainedIn None{hiding}
child = new Pedestrian at (-53, -5), facing 90 deg, with behavior Go(){child}
behavior Go():
    while distance from self to ego > 12.5 m:
        wait
    do WalkForwardBehavior(3 m/s)
{after}
terminate after 6 s
"""


def scene(condition="self can see child", kind="Truck", hiding="", child="", before="", after=""):
    return SCENE.format(condition=condition, kind=kind, hiding=hiding, child=child, before=before, after=after)


def run(text: str) -> Outcomes:
    """The one scene of a text; both hosts agree on it."""
    scenario = compile_text(text)
    scenes = scenario.sample(1)
    assert scenes.valid[0]
    outcomes = scenario.simulate(scenes)
    slow = world.simulate(scenario.program, scenes, scenario.config)
    for name in ("first_seen", "ttc_at_first_sight", "hidden_time", "min_distance", "end_time"):
        np.testing.assert_allclose(getattr(slow, name), getattr(outcomes, name), rtol=0.0, atol=1e-9, err_msg=name)
    assert bool(slow.collided[0]) == bool(outcomes.collided[0])
    return outcomes


def is_valid(text: str) -> bool:
    return bool(compile_text(text).sample(1).valid[0])


# -- in behaviours -----------------------------------------------------------------------------------------------------


def test_a_truck_hides_a_child():
    """Who sees the child brakes in time; who cannot hits it."""
    assert run(scene()).collided[0]
    assert not run(scene(hiding=", with occluding False")).collided[0]


@pytest.mark.parametrize("kind", ["Truck", "Bus"])
def test_first_sight(kind):
    """The child is seen late, near to the contact, and was hidden until then."""
    outcomes = run(scene(kind=kind))
    first, hidden = outcomes.first_seen[0, 1], outcomes.hidden_time[0, 1]
    assert 0.5 < first < outcomes.end_time[0] - 0.2
    assert hidden == pytest.approx(first, abs=1e-9)
    assert outcomes.first_seen[0, 0] == 0.0
    assert outcomes.hidden_time[0, 0] == 0.0


@pytest.mark.parametrize(("kind", "hides"), [("Car", True), ("Motorcycle", False), ("Bicycle", False), ("Cone", False),
                                             ("Obstacle", True), ("Bench", False), ("Kiosk", True)])  # fmt: skip
def test_what_occludes_by_default(kind, hides):
    text = scene(kind=kind, hiding=", with length 9 m, with width 2.4 m")
    assert (run(text).hidden_time[0, 1] > 0.0) == hides


def test_everything_occludes_in_files_of_scenic():
    """There an angle counts from the north."""
    text = scene(kind="Bicycle", hiding=", with length 9 m, with width 2.4 m")
    theirs = text.replace("facing 0 deg", "facing -90 deg").replace("facing 90 deg", "facing 0 deg")
    assert run(text).hidden_time[0, 1] == 0.0
    assert run("model scenic.domains.driving.model\n" + theirs).hidden_time[0, 1] > 0.0


def test_conditions_on_who_is_near():
    """They look as `can see` does."""
    condition = "withinDistanceToAnyPedestrians(self, 30)"
    assert not run(scene(condition=condition, hiding=", with occluding False")).collided[0]
    assert run(scene(condition=condition)).collided[0]


def test_places():
    """A place is hidden by what stands before it."""
    asked = "require {}(ego can see (-53, -5))\nrequire ego can see (-53, 5)"
    assert is_valid(scene(after=asked.format("not ")))
    assert not is_valid(scene(after=asked.format("")))
    assert is_valid(scene(after=asked.format(""), hiding=", with occluding False"))
    watching = "require eventually (ego can see (-53, -5))\n"
    assert np.isfinite(run(scene(after=watching, condition="ego can see (-53, -5)")).end_time[0])


# -- drivers of the library --------------------------------------------------------------------------------------------

CROSSING = """
map intersection(approach=80 m{buildings})
turn = filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers)[0]
other_way = filter(lambda m: m.type is ManeuverType.STRAIGHT, turn.conflictingManeuvers)[0]
ego = new Car before intersection by 30 m along turn, with speed 10 m/s, with behavior {driver},
    with viewAngle 360 deg, with visibleDistance 100 m
other = new Car before intersection by {away} m along other_way, with speed 10 m/s,
    with behavior FollowTrajectoryBehavior(10 m/s, other_way)
terminate after 8 s
"""
BRAKE = "EmergencyBrakeBehavior(FollowTrajectoryBehavior(10 m/s, turn))"


def test_buildings_hide_those_who_cross():
    """Behind a corner the other is noticed later than across an open field."""
    open_field = run(CROSSING.format(buildings="", driver=BRAKE, away=30))
    corner = run(CROSSING.format(buildings=", buildings=3 m", driver=BRAKE, away=30))
    assert open_field.first_seen[0, 0] == 0.0
    assert corner.first_seen[0, 0] > 0.3
    assert corner.hidden_time[0, 0] >= corner.first_seen[0, 0]


@pytest.mark.parametrize(("buildings", "waits"), [("", True), (", buildings=2 m", False)])
def test_nobody_waits_for_who_is_hidden(buildings, waits):
    """With a critical gap of 20 s a driver waits for one who is far off, unless a building hides that."""
    driver = "GapAcceptanceBehavior(10 m/s, turn, critical_gap=20 s)"
    scenario = compile_text(CROSSING.format(buildings=buildings, driver=driver, away=70))
    states = scenario.watch(scenario.sample(1)).trajectory.states
    assert (states[:60, 0, State.SPEED].min() < 8.0) == waits


def test_a_follower_heeds_the_nearest_of_those_it_notices():
    """A leader that another car hides does not count; the other one does."""
    text = """
map intersection(approach=200 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 190 m along [lane], with speed 15 m/s, with behavior CarFollowingBehavior(15 m/s)
first = new Car before intersection by 120 m along [lane]
second = new Car before intersection by 100 m along [lane]
terminate after 12 s
"""
    outcomes = run(text)
    assert not outcomes.collided[0]
    assert np.isnan(outcomes.first_seen[0, 1])


# -- at the start ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hiding", ["", ", with occluding False"])
def test_requirements_at_the_start(hiding):
    """Whatever stands below the requirement hides, too."""
    required = "child = new Pedestrian at (-53, -5)\nrequire ego can see child\nwall = new"
    lines = scene(hiding=hiding).replace("wall = new", required, 1).split("\n")
    assert is_valid("\n".join(line for line in lines if not line.endswith("with behavior Go()"))) == bool(hiding)


def test_start_and_run_agree():
    """A requirement at the start holds if and only if its condition does in the first sample."""
    text = """
map intersection(approach=60 m, buildings=4 m)
simulation(max_attempts=1)
ego = new Car on road, with viewAngle 200 deg
one = new Truck on road
two = new Bus on road
child = new Pedestrian at (Range(-30, 30), Range(-30, 30))
terminate after 0.05 s
"""
    free, asked = compile_text(text), compile_text(text + "require ego can see child\n")
    scenes = free.sample(3000, seed=3)
    seen = free.simulate(scenes).first_seen[:, 2] == 0.0
    np.testing.assert_array_equal(asked.sample(3000, seed=3).valid, scenes.valid & seen)
    assert 20 < seen.sum() < scenes.valid.sum() - 20


def test_require_visible():
    """`requireVisible True`: the scene is valid only where the ego sees the object."""
    assert not is_valid(scene(child=", with requireVisible True"))
    assert is_valid(scene(child=", with requireVisible True", hiding=", with occluding False"))
    assert is_valid(scene(child=", with requireVisible False"))
    rejected = compile_text(scene(child=", with requireVisible True"))
    assert [r.name for r in rejected.program.requirements][:1] == ["child is visible from the ego"]


# -- buildings ---------------------------------------------------------------------------------------------------------


def test_nobody_starts_in_a_building():
    text = "map intersection(approach=60 m, buildings=4 m)\nego = new Car on road\nchild = new Pedestrian at ({}, 30)\n"
    assert not is_valid(text.format(30))
    assert is_valid(text.format(5))


@pytest.mark.parametrize("argument", ["buildings=1 m", "buildings=60 m", "buildings=-1 m", "rows=2, buildings=48 m"])
def test_buildings_without_room(argument):
    with pytest.raises(CompileError, match="buildings"):
        compile_text(f"map intersection({argument})\nego = new Car on road\n")


# -- to draw -----------------------------------------------------------------------------------------------------------


def test_the_drawn_area_ends_at_the_truck():
    scenario = compile_text(scene())
    scenes = scenario.sample(1)
    states = scenario.watch(scenes).trajectory.states[0]
    area = shapely.Polygon(visible_area(scenario.program, scenes.values[0], states, 0))
    assert area.contains(shapely.Point(-66.0, -4.0))
    assert not area.contains(shapely.Point(-53.0, -5.0))
