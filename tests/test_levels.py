"""Roads that pass over one another: actors on different levels never meet, and those on one level do as in a plane."""

import csv
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl import compile_text
from cortex_dsl.api.scenario import load
from cortex_dsl.pipeline import compile_source
from cortex_dsl.report.page.scene_svg import road_layer
from cortex_dsl.source import Source
from engine import batch, world
from engine.avoidability import avoidability
from engine.config import Config
from engine.counterfactuals import counterfactuals
from engine.fairness import fair_starts
from engine.host import memory, plan, requested
from engine.interchange.recording import recorded_run
from engine.kernels.crossing import Foresight
from engine.kernels.crossing import crossing as crossing_of
from engine.kernels.levels import hide_levels
from engine.kernels.rollout import advance, begin
from engine.kernels.run_state import RUNNING, Memory, Status
from engine.road import build_network
from engine.road.opendrive.network import map_file
from engine.road.outline import outline
from engine.verdicts import answers_and_margins
from engine.vocabulary import LEVEL, Column, State
from engine.world.bodies import physiques
from engine.world.pymunk_host import FreeBodies

ROAD = """<road name="" length="{length}" id="{id}" junction="-1">
  <planView>{geometry}</planView>
  <elevationProfile>{elevation}</elevationProfile>
  <lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center>
    <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></right>
  </laneSection></lanes>
</road>"""
LINE = '<geometry s="{s}" x="{x}" y="{y}" hdg="{hdg}" length="{length}"><line/></geometry>'
HEIGHT = '<elevation s="0" a="{a}" b="{b}" c="0" d="0"/>'


def crossing(height: float) -> str:
    """Return a file with a road from west to east, and one from south to north at a height above it [m]."""
    ways = ((0, -60.0, 2.0, 0.0, 0.0), (1, -2.0, -60.0, np.pi / 2, height))
    roads = [
        ROAD.format(
            id=number,
            length=120,
            geometry=LINE.format(s=0, x=x, y=y, hdg=hdg, length=120),
            elevation=HEIGHT.format(a=a, b=0),
        )
        for number, x, y, hdg, a in ways
    ]
    return f'<OpenDRIVE><header revMajor="1" revMinor="6"/>{"".join(roads)}</OpenDRIVE>'


def ramp(slope: float) -> str:
    """Return a file with one road that turns by 270 degrees and crosses itself, after 20 m and 154 m."""
    turn = 20.0 * 1.5 * np.pi
    geometry = LINE.format(s=0, x=0, y=0, hdg=0, length=40)
    geometry += f'<geometry s="40" x="40" y="0" hdg="0" length="{turn}"><arc curvature="0.05"/></geometry>'
    geometry += LINE.format(s=40 + turn, x=20, y=20, hdg=1.5 * np.pi, length=60)
    road = ROAD.format(id=0, length=100 + turn, geometry=geometry, elevation=HEIGHT.format(a=0, b=slope))
    return f'<OpenDRIVE><header revMajor="1" revMinor="6"/>{road}</OpenDRIVE>'


SCENE = """
map opendrive("map.xodr")
ego = new Car following roadDirection from network.lanes[0].centerline[0] for {first} m, with speed 10 m/s,
    with behavior {driver}
other = new Car following roadDirection from network.lanes[{lane}].centerline[0] for {second} m, with speed 10 m/s,
    with behavior FollowLaneBehavior(10 m/s)
terminate after 6 s
"""
TURN = 22.0 * 1.5 * np.pi
"""Length of the turn along the middle of the lane [m]."""
OVER = 4.0 + 40.0 + TURN + 22.0 - 18.0
"""Place from which a car comes to the crossing of the ramp with the car that begins at 4 m [m]."""
DRIVERS = ("FollowLaneBehavior(10 m/s)", "CarFollowingBehavior(10 m/s)", "GivingWayBehavior(10 m/s)",
           "EmergencyBrakeBehavior(FollowLaneBehavior(10 m/s))", "DriveAvoidingCollisions(10 m/s)")  # fmt: skip


def driven(folder: Path, road: str, **scene: object):
    """Return outcomes and states of the scene in both hosts, which agree, and the world's run."""
    (folder / "map.xodr").write_text(road)
    (folder / "scene.scn").write_text(SCENE.format(**scene))
    scenario = load(folder / "scene.scn")
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    outcomes = batch.simulate(scenario.program, scenes, scenario.config.simulation)
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config)
    count = len(fast.time)
    np.testing.assert_allclose(slow.trajectory.states[:count, :, :3], fast.states[:, :, :3], rtol=0.0, atol=1e-9)
    assert outcomes.collided[0] == slow.outcomes.collided[0]
    assert outcomes.min_distance[0, 0] == pytest.approx(slow.outcomes.min_distance[0, 0], abs=1e-9)
    return outcomes, fast


@pytest.mark.parametrize("height", [0.0, LEVEL - 0.1, LEVEL, 8.0, -8.0])
def test_cars_meet_on_one_level_only(tmp_path: Path, height: float) -> None:
    """Roads that cross at less than a headroom are one plane; else there is no contact and no distance."""
    outcomes, _ = driven(tmp_path, crossing(height), first=20, lane=1, second=20, driver=DRIVERS[0])
    apart = abs(height) >= LEVEL
    assert outcomes.collided[0] != apart
    assert np.isinf(outcomes.min_distance[0, 0]) == apart


@pytest.mark.parametrize("driver", DRIVERS)
def test_drivers_ignore_actors_on_another_level(tmp_path: Path, driver: str) -> None:
    """Each driver goes under a bridge as if it were alone, with the bits of that run."""
    outcomes, together = driven(tmp_path, crossing(6.0), first=20, lane=1, second=20, driver=driver)
    _, apart = driven(tmp_path, crossing(6.0), first=20, lane=1, second=100, driver=driver)
    assert not outcomes.collided[0]
    count = min(len(together.time), len(apart.time))
    np.testing.assert_array_equal(together.states[:count, 0], apart.states[:count, 0])
    assert together.states[-1, 0, State.X] > 0.0


@pytest.mark.parametrize("driver", DRIVERS[:1])
@pytest.mark.parametrize("slope", [0.0, 0.05, -0.06])
def test_a_ramp_that_crosses_itself(tmp_path: Path, slope: float, driver: str) -> None:
    """Two cars of one road that pass its crossing at once touch only if it is flat; heights follow the road."""
    outcomes, run = driven(tmp_path, ramp(slope), first=4, lane=0, second=OVER, driver=driver)
    assert outcomes.collided[0] == (slope == 0.0)
    if slope:
        assert run.heights is not None
        way = np.array([4.0, OVER]) + 10.0 * run.time[:, None]
        along = np.interp(way, [0, 40, 40 + TURN, 100 + TURN], [0, 40, 40 + TURN / 1.1, 100 + TURN / 1.1])
        early = run.time < 3.0  # before the bend, which it takes slower
        np.testing.assert_allclose(run.heights[early], slope * along[early], atol=0.03)


def test_overlap_at_the_start_counts_on_one_level(tmp_path: Path) -> None:
    """Two cars may begin at one place of the plane if a bridge is between them."""
    for height, valid in ((0.0, False), (6.0, True)):
        (tmp_path / "map.xodr").write_text(crossing(height))
        text = SCENE.format(first=58, lane=1, second=62, driver=DRIVERS[0])
        (tmp_path / "scene.scn").write_text(text)
        scenario = load(tmp_path / "scene.scn")
        assert scenario.sample(1, seed=1).valid[0] == valid


BELOW = """
map opendrive("map.xodr")
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 20 m, with speed 10 m/s,
    with behavior FollowLaneBehavior(10 m/s)
other = new {kind} ahead of ego by {gap} m, facing {heading} deg, with regionContainedIn None
terminate after 8 s
"""


@pytest.mark.parametrize("kind", ["Pedestrian", "Obstacle"])
@pytest.mark.parametrize("heading", [0, 45, 90, -90, 180])
def test_who_stands_below_a_bridge_is_on_the_level_of_the_ego(tmp_path: Path, kind: str, heading: int) -> None:
    """Whatever it faces, contact is that of a crossing in one plane: across the road below is along the bridge."""
    for gap in range(15, 36, 4):
        ends = list[float]()
        for height in (0.0, 8.0):
            (tmp_path / "map.xodr").write_text(crossing(height))
            (tmp_path / "scene.scn").write_text(BELOW.format(kind=kind, gap=gap, heading=heading))
            scenario = load(tmp_path / "scene.scn")
            outcomes = scenario.simulate(scenario.sample(1, seed=1))
            assert outcomes.collided[0]
            ends.append(float(outcomes.end_time[0]))
        assert ends[0] == ends[1]


def test_a_flat_map_has_no_heights() -> None:
    """Without bridges nothing is stored, so that programs and digests are those of a plane."""
    program = compile_text("ego = new Car on road").program
    assert not len(program.road.heights)


def test_exports_have_the_heights_of_the_road(tmp_path: Path) -> None:
    """A table and a trajectory of the standards hold the height of a bridge, and 0 on a road without bridges."""
    for height in (0.0, 6.0):
        (tmp_path / "map.xodr").write_text(crossing(height))
        (tmp_path / "scene.scn").write_text(SCENE.format(first=20, lane=1, second=100, driver=DRIVERS[0]))
        scenario = load(tmp_path / "scene.scn")
        out = tmp_path / f"out{height:g}"
        cx.export(scenario, ["csv", "xosc"], out)
        rows = list(csv.DictReader(next(out.glob("**/*.csv")).read_text().splitlines()))
        assert {float(row["z"]) - 0.5 * float(row["height"]) for row in rows if row["idx"] == "1"} == {height}
        assert {float(row["z"]) - 0.5 * float(row["height"]) for row in rows if row["idx"] == "0"} == {0.0}
        places = re.findall(r"<WorldPosition [^>]*>", next(out.glob("**/*.xosc")).read_text())
        assert sum('z="6"' in place for place in places) == (
            len(places) - sum('y="0"' in place for place in places) if height else 0
        )


@pytest.mark.parametrize(("height", "decks"), [(0.0, 0), (LEVEL - 0.1, 0), (6.0, 1), (-6.0, 1)])
def test_bridges_are_drawn_above_the_other_roads(tmp_path: Path, height: float, decks: int) -> None:
    """The upper road has a deck over the lower one and a little beyond it, of its own width, and no other place."""
    (tmp_path / "map.xodr").write_text(crossing(height))
    (tmp_path / "scene.scn").write_text(SCENE.format(first=20, lane=1, second=100, driver=DRIVERS[0]))
    drawn = outline(build_network(load(tmp_path / "scene.scn").program.road_spec))
    assert len(drawn.decks) == decks
    for line, width in drawn.decks:
        upper = line[:, 0 if height > 0.0 else 1]
        along = line[:, 1 if height > 0.0 else 0]
        assert width == 4.0
        np.testing.assert_allclose(upper, 0.0, atol=1e-9)
        assert -14.0 < along.min() <= -2.0
        assert 2.0 <= along.max() < 14.0
    assert ("stroke-opacity:.3" in str(road_layer(drawn))) is bool(decks)


@pytest.mark.parametrize("slope", [0.0, 0.05, -0.12])
def test_slopes_have_one_note_with_the_steepest(tmp_path: Path, slope: float) -> None:
    """Slopes are not simulated: the note about unread parts names the steepest, and none without slopes."""
    (tmp_path / "map.xodr").write_text(ramp(slope))
    found = build_network(map_file(tmp_path / "map.xodr", "map.xodr")).unread
    assert (f"slopes of up to {100 * abs(slope):.1f} %, on road `0`" in found) is (slope != 0.0)


@pytest.mark.parametrize("height", ["1e308", "-1e308", "nan", "inf", "1e-320", "6e0", "6 m"])
def test_heights_of_any_kind_are_read_or_named(tmp_path: Path, height: str) -> None:
    """No height stops a map or puts an actor nowhere: the cars drive, and every height of the run is a number."""
    text = crossing(0.0)
    at = text.rindex('a="0.0"')
    (tmp_path / "map.xodr").write_text(f'{text[:at]}a="{height}"{text[at + len(chr(97)) + 6 :]}')
    (tmp_path / "scene.scn").write_text(SCENE.format(first=20, lane=1, second=60, driver=DRIVERS[0]))
    scenario = load(tmp_path / "scene.scn")
    scenes = scenario.sample(1, seed=1)
    run = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    assert len(run.time) > 40
    assert run.heights is None or np.isfinite(run.heights).all()


# -- heights of earlier samples ----------------------------------------------------------------------------------------

FOLLOWING = """
map opendrive("map.xodr")
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 4 m, with speed {speed} m/s,
    with behavior FollowLaneBehavior({speed} m/s)
other = new Car following roadDirection from network.lanes[0].centerline[0] for {gap} m, with speed {theirs} m/s,
    with behavior {driver}({theirs} m/s)
terminate after 8 s
"""
SLOPE = 0.22
"""Slope with which two cars are on different levels from a distance of 11 m on."""


def on_slope(folder: Path, slope: float, **scene: object):
    """Return a scenario with a car that follows another one along the ramp, and its only scene."""
    (folder / "map.xodr").write_text(ramp(slope))
    (folder / "scene.scn").write_text(FOLLOWING.format(**scene))
    scenario = load(folder / "scene.scn")
    assert bool(len(scenario.program.road.heights)) == (slope != 0.0)
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    return scenario, scenes


@pytest.mark.parametrize("driver", ["FollowLaneBehavior", "CarFollowingBehavior"])
@pytest.mark.parametrize(("gap", "speed"), [(10.0, 20.0), (14.0, 20.0)])
def test_reference_drivers_judge_by_the_heights_of_each_sample(
    tmp_path: Path, gap: float, speed: float, driver: str
) -> None:
    """Cars that leave one another's level after contact have the verdicts of a road without a slope."""
    answers = []
    for slope in (0.0, SLOPE):
        scenario, scenes = on_slope(tmp_path, slope, gap=gap, speed=speed, theirs=5, driver=driver)
        config = scenario.config.simulation
        assert batch.simulate(scenario.program, scenes, config).collided[0]
        (found,) = avoidability(scenario.program, scenes, config)
        drivers, margins = answers_and_margins(scenario.program, scenes, config)
        other_drives = counterfactuals(scenario.program, scenes, config)
        answers.append(repr((found, drivers.tolist(), margins.tolist(), other_drives)))
    assert answers[0] == answers[1]


@pytest.mark.parametrize("seconds", [0.0, 0.3, 0.5])
def test_drivers_see_others_on_the_level_of_the_time_they_see(tmp_path: Path, seconds: float) -> None:
    """A latency shows a driver the others at an earlier sample, on the level that they had then."""
    found, now = [], 12
    for slope in (0.0, SLOPE):
        scenario, scenes = on_slope(tmp_path, slope, gap=10, speed=5, theirs=15, driver=DRIVERS[0].split("(")[0])
        shared, rows = plan(scenario.program, scenario.config.simulation), requested(scenario.program, scenes)
        run = memory(scenario.program, 200)
        begin(shared, run, int(rows.variant[0]), rows.values[0], rows.keys[0], rows.actions[0])
        advance(shared, run, now, run.status[Status.END] == RUNNING)
        heights = run.actors[:, Memory.HEIGHT].copy()
        look = Foresight(-1, math.inf, math.tau, seconds, 10.0, 0.0, 3.0, math.inf, math.inf)
        found.append(crossing_of(shared, run, now, 0, 1, look))
        np.testing.assert_array_equal(run.actors[:, Memory.HEIGHT], heights)
    assert (found[0] == found[1]) == (seconds > 0.0)


@pytest.mark.parametrize("height", [0.0, LEVEL - 0.1, 6.0])
def test_a_start_below_a_bridge_is_fair(tmp_path: Path, height: float) -> None:
    """A car that comes across at once makes a start unfair, unless it crosses on a bridge."""
    (tmp_path / "map.xodr").write_text(crossing(height))
    (tmp_path / "scene.scn").write_text(SCENE.format(first=50, lane=1, second=50, driver=DRIVERS[0]))
    scenario = load(tmp_path / "scene.scn")
    starts = requested(scenario.program, scenario.sample(1, seed=1))
    assert fair_starts(scenario.program, starts, scenario.config.simulation)[0] == (height >= LEVEL)


def test_the_time_together_is_that_of_the_contact() -> None:
    """Of two times on one level, the one with the contact is left, also with a smaller distance in the other one."""
    distances, heights = [9.0, 3.5, 9.0, 9.0, 5.0, 4.6], [0.0, 0.0, 6.0, 6.0, 0.0, 0.0]
    for contact, touched, left in ((-1, -1, [0, 1]), (5, 1, [4, 5]), (5, 2, [0, 1])):
        states = np.zeros((6, 2, len(State)))
        states[:, :, State.PRESENT] = 1.0
        states[:, 1, State.X] = distances
        working = np.zeros((7, 4))
        working[:6, 1] = heights
        hide_levels(states, 6, working, touched, contact)
        assert np.flatnonzero(states[:, 1, State.PRESENT]).tolist() == left
        assert working[:6, 3].tolist() == [1.0] * 6


@pytest.mark.parametrize("number", [2, 34, 70])
def test_bodies_of_any_number_pass_those_on_other_levels_only(number: int) -> None:
    """Of bodies that overlap, exactly those on the level of another one are struck, and all by a building."""
    config, heights = Config(), np.where(np.arange(number) % 33 == 0, 0.0, 6.0)
    heights[-1] = 12.0
    kinds, values = np.zeros(number, dtype=np.int32), np.zeros((number, len(Column)))
    values[:, [Column.LENGTH, Column.WIDTH, Column.MASS]] = 4.0, 2.0, 1000.0
    for walls in (0, 1):
        stage = FreeBodies(
            physiques(kinds, values.ravel()), np.array([[0.0, 0.0, 0.0, 4.0, 2.0]] * walls).reshape(-1, 5), config
        )
        for actor in range(number):
            stage.place(actor, np.array([0.01 * actor, 0.0, 0.0]))
            stage.separate(actor, heights)
        stage.go(0.0, 1, 0.001)
        together = [actor for actor in range(number) if walls or (heights == heights[actor]).sum() > 1]
        assert sorted(each for each in stage.recorder.struck if each < number) == together


# -- the level on which an object begins ------------------------------------------------------------------------------

NAMED = """
map opendrive("map.xodr")
ego = new Car at (-20, 0), facing 0 deg, with speed 10 m/s, with behavior FollowLaneBehavior(10 m/s)
other = new {kind} at (0, 0){specifiers}
terminate after 3 s
"""


def named(folder: Path, height: float, specifiers: str, kind: str = "Car"):
    """Return the compiled scene with an object at the crossing of two roads, and its run in both hosts."""
    (folder / "map.xodr").write_text(crossing(height))
    (folder / "scene.scn").write_text(
        NAMED.format(kind=kind, specifiers=specifiers).replace(", with behavior None", "")
    )
    scenario = load(folder / "scene.scn")
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    fast = scenario.simulate(scenes)
    slow = scenario.watch(scenes)
    assert fast.collided[0] == slow.outcomes.collided[0]
    return scenario, fast, slow


@pytest.mark.parametrize("height", [6.0, -6.0])
@pytest.mark.parametrize("kind", ["Car", "Pedestrian", "Obstacle"])
@pytest.mark.parametrize("turned", ["", ", facing 0 deg", ", facing 90 deg", ", facing 200 deg"])
def test_a_named_level_decides_whatever_an_object_faces(tmp_path: Path, height: float, kind: str, turned: str) -> None:
    """On the ego's road there is contact, on the other one none; heights begin on the named road."""
    for road, level in (("road0", 0.0), ("road1", height)):
        _, outcomes, run = named(tmp_path, height, f'{turned}, with level "{road}"', kind)
        assert outcomes.collided[0] == (road == "road0")
        assert run.trajectory.heights is not None
        assert run.trajectory.heights[0, 1] == pytest.approx(level)


@pytest.mark.parametrize("height", [0.0, LEVEL - 0.1, 6.0, -6.0])
def test_a_bare_point_takes_the_lower_road(tmp_path: Path, height: float) -> None:
    """With a remark, and with the heading of that road; on one plane there is neither."""
    _, outcomes, run = named(tmp_path, height, "")
    text = Source(str(tmp_path / "scene.scn"), (tmp_path / "scene.scn").read_text())
    remarks = [each for each in compile_source(text).diagnostics if each.code == "SCN467"]
    apart = abs(height) >= LEVEL
    assert len(remarks) == apart
    assert outcomes.collided[0] == (height > -LEVEL)
    if apart:
        assert f"{abs(height):.1f} m below" in remarks[0].message
        heading = run.trajectory.states[0, 1, State.HEADING]
        assert heading == pytest.approx(0.0 if height > 0.0 else math.pi / 2)


def test_a_level_is_that_of_a_road_beside_the_object(tmp_path: Path) -> None:
    """An object farther than 5 m from the road that it names is drawn again, and heads along that road."""
    (tmp_path / "map.xodr").write_text(crossing(6.0))
    text = 'map opendrive("map.xodr")\nego = new Car on road, with level "road0"\n'
    (tmp_path / "scene.scn").write_text(text)
    scenario = load(tmp_path / "scene.scn")
    scenes = scenario.sample(50, seed=1)
    assert scenes.valid.all()
    assert (np.abs(scenes.values[:, Column.Y]) <= 2.0 + 5.0).all()
    assert (np.abs(scenes.values[:, Column.HEADING]) < 0.1).all()


@pytest.mark.parametrize("name", ['"road2"', '"rod1"', "3", "ego"])
def test_a_level_is_a_road_of_the_file(tmp_path: Path, name: str) -> None:
    """Another name or value is refused; so is any level where no road passes over another one."""
    for height, level in ((6.0, name), (0.0, '"road1"')):
        (tmp_path / "map.xodr").write_text(crossing(height))
        text = f'map opendrive("map.xodr")\nego = new Car on road\nb = new Car on road, with level {level}\n'
        (tmp_path / "scene.scn").write_text(text)
        with pytest.raises(cx.CompileError) as refused:
            load(tmp_path / "scene.scn")
        assert refused.value.diagnostics[-1].code in ("SCN450", "SCN303")


def test_distances_between_levels_are_said_in_words(tmp_path: Path) -> None:
    """The terminal names no number for two actors that are never on one level."""
    named(tmp_path, 6.0, ', with level "road1"')
    command = [sys.executable, "-m", "cortex_dsl", "scene.scn", "--metrics"]
    shown = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert re.search(r"apart +not on one level", shown)
    assert re.search(r"MD +not on one level", shown)
    named(tmp_path, 6.0, ', with level "road0"')
    shown = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "not on one level" not in shown


def test_exports_have_the_named_level(tmp_path: Path) -> None:
    """The height in a table is that of the road that the scenario names, not of the one that the car faces along."""
    scenario, _, run = named(tmp_path, 6.0, ', facing 0 deg, with level "road1"')
    scenes, step = scenario.sample(1, seed=1), scenario.config.simulation.time_step
    recording = recorded_run(scenario.program, scenes, run, step=step)
    assert recording.heights is not None
    np.testing.assert_allclose(recording.heights[0], [0.0, 6.0], atol=1e-9)


def test_parked_cars_are_laid_with_optimized_python() -> None:
    """A street with parked cars makes its surfaces at once, also under `python -O`, which drops assertions."""
    code = (
        "from engine.maps import RoadSpec; from engine.road import build_network;"
        "print('surfaces' in vars(build_network(RoadSpec(parking=2.0, parked=0.5))))"
    )
    for options in ((), ("-O",)):
        done = subprocess.run([sys.executable, *options, "-c", code], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == "True"
