"""Objects that appear during a run: where and when they do, in both hosts, in copies, journals and parallel runs."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl import Scenario, compile_text
from cortex_dsl.diagnostics import CompileError
from engine import batch
from engine.scenes import Trajectory
from engine.vocabulary import State, Verdict
from tests.laws import examples

ROAD = "map road(length=600 m, lanes=2, one_way=True)\nlane = network.lanes[0]\n"
EGO = (
    "ego = new Car following roadDirection from lane.centerline[0] for {at} m, with speed {speed} m/s, "
    "with behavior {behavior}\n"
)
DROPS = """
behavior Drops():
    do FollowLaneBehavior({speed} m/s) for {after} s
    {made}
    do FollowLaneBehavior({speed} m/s)
"""


def dropping(made: str, *, speed: float = 10.0, after: float = 1.0, before: str = "", behind: str = "") -> Scenario:
    """Return a scenario whose ego lets objects appear."""
    text = ROAD + before + DROPS.format(speed=speed, after=after, made=made)
    return compile_text(text + EGO.format(at=20, speed=speed, behavior="Drops()") + behind + "terminate after 4 s\n")


def watched(scenario: Scenario, seed: int = 1) -> Trajectory:
    """Return the only run of a scenario, which both hosts agree on."""
    scenes = scenario.sample(1, seed=seed)
    assert scenes.valid.all()
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = scenario.watch(scenes)
    count = min(len(fast.time), len(slow.trajectory.time))
    np.testing.assert_allclose(slow.trajectory.states[:count], fast.states[:count], rtol=0.0, atol=1e-9)
    outcomes = scenario.simulate(scenes)
    assert outcomes.verdict[0] == slow.outcomes.verdict[0]
    assert outcomes.collided[0] == slow.outcomes.collided[0]
    return fast


def aborted(scenario: Scenario) -> str:
    """Return the rule that aborts a run, the same in both hosts."""
    scenes = scenario.sample(1)
    outcomes, world = scenario.simulate(scenes), scenario.simulate(scenes, engine="world")
    assert outcomes.verdict[0] == world.verdict[0] != Verdict.VALID
    assert outcomes.end_rule[0] == world.end_rule[0]
    return scenario.program.rules[int(outcomes.end_rule[0])].name


@examples(15)
@given(
    st.integers(0, 30), st.floats(4.0, 40.0), st.floats(0.0, 20.0), st.sampled_from(["ahead of", "behind", "left of"])
)
def test_an_object_appears_where_it_is_asked_to(steps: int, gap: float, speed: float, side: str) -> None:
    """Absent before, then at that place beside the ego as it is by then, with the heading and speed asked for."""
    gap = min(gap, 18.0) if side == "behind" else gap if side == "ahead of" else 1.0
    made = f"new Car {side} self by {gap} m, with speed {speed} m/s, with regionContainedIn None"
    scenario = dropping(made, after=steps * 0.05)
    run = watched(scenario)
    there = run.states[:, 1, State.PRESENT] != 0.0
    begins = int(there.argmax())
    assert there[begins:].all()
    assert begins == steps
    ego, made_state = run.states[begins, 0], run.states[begins, 1]
    length, width = run.outlines[:, 0].mean(), run.outlines[:, 1].mean()
    along = {"ahead of": gap + length, "behind": -gap - length, "left of": 0.0}[side]
    across = gap + width if side == "left of" else 0.0
    heading = ego[State.HEADING]
    place = ego[:2] + along * np.array([np.cos(heading), np.sin(heading)])
    place += across * np.array([-np.sin(heading), np.cos(heading)])
    np.testing.assert_allclose(made_state[:2], place, atol=1e-9)
    assert made_state[State.HEADING] == pytest.approx(heading)
    assert made_state[State.SPEED] == pytest.approx(speed)


def test_it_acts_from_its_step_on() -> None:
    """With a behavior whose arguments are those of that moment."""
    made = "new Car ahead of self by 20 m, with speed self.speed, with behavior ConstantSpeedBehavior(self.speed * 0.5)"
    run = watched(dropping(made))
    begins = int((run.states[:, 1, State.PRESENT] != 0.0).argmax())
    assert run.states[begins, 1, State.SPEED] == pytest.approx(10.0, abs=0.1)
    assert run.states[begins + 1, 1, State.SPEED] < run.states[begins, 1, State.SPEED] - 0.1
    assert run.states[-1, 1, State.SPEED] == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize(
    ("made", "behind", "name"),
    [
        ("new Car ahead of self by 5 m", "b = new Car ahead of ego by 7 m, with speed 10 m/s\n", "is free of b"),
        ("new Car left of self by 9 m", "", "appears on the road"),
        ("new Car ahead of self by 5 m, with regionContainedIn intersection", "", ""),
    ],
)
def test_an_impossible_place_aborts_the_run(made: str, behind: str, name: str) -> None:
    """By name: an occupied place, or one off the road; not where the file allows it."""
    if not name:
        with pytest.raises(CompileError):
            dropping(made, behind=behind)
        return
    assert name in aborted(dropping(made, behind=behind))
    allowed = dropping(f"{made}, with allowCollisions True, with regionContainedIn None", behind=behind)
    assert (allowed.simulate(allowed.sample(1)).verdict == Verdict.VALID).all()


@pytest.mark.parametrize("late", [1, 3, 5])
def test_a_loop_has_as_many_objects_as_the_file_says(late: int) -> None:
    """Each pass lets another one appear; one more aborts the run."""
    loop = "while True:\n        new Obstacle behind self by 1 m, with length 1 m, with width 1 m\n"
    loop += "        do FollowLaneBehavior(10 m/s) for 0.5 s"
    scenario = dropping(loop, before=f"simulation(late={late})\n", after=0.5)
    assert len(scenario.program.actors) == 1 + late
    run = watched(scenario)
    begins = [int((run.states[:, each, State.PRESENT] != 0.0).argmax()) for each in range(1, 1 + late)]
    np.testing.assert_allclose(run.time[begins], 0.5 * np.arange(1, late + 1), atol=0.051)
    assert f"at most {late} objects" in aborted(scenario)


def test_others_notice_what_behaviors_let_appear() -> None:
    """A driver whose behavior is written first brakes for an object that a later one makes."""
    text = ROAD + DROPS.format(speed=10, after=1, made="new Obstacle behind self by 1 m, with width 2 m")
    text += EGO.format(at=20, speed=10, behavior="EmergencyBrakeBehavior(FollowLaneBehavior(10 m/s))")
    text += "truck = new Truck ahead of ego by 15 m, with speed 10 m/s, with behavior Drops()\nterminate after 8 s\n"
    text += "require always withinDistanceToAnyObjs(ego, 1000)\n"
    run = watched(compile_text(text))
    assert run.states[-1, 0, State.SPEED] == pytest.approx(0.0, abs=0.01)
    plain = text.replace("    new Obstacle behind self by 1 m, with width 2 m\n", "")
    assert watched(compile_text(plain)).states[-1, 0, State.SPEED] > 5.0


SCENARIOS = """
scenario Cut(gap):
    setup:
        box = new Car ahead of ego by gap, with speed 3 m/s, with behavior FollowLaneBehavior(3 m/s)
        cone = new Obstacle left of box by 0.5 m
    compose:
        wait for 1 s
scenario Main():
    setup:
        {ego}
    compose:
        wait for 0.5 s
        late = new Car behind ego by 5 m
        wait for 0.5 s
        do Cut(9 m)
        wait until ego.x > late.x + 20 m
"""


def test_composed_scenarios_let_objects_appear() -> None:
    """In `compose`, and in a setup at places relative to objects that move, each when it is its turn."""
    text = ROAD + SCENARIOS.format(ego=EGO.format(at=20, speed=5, behavior="FollowLaneBehavior(5 m/s)").strip())
    scenario = compile_text(text)
    run = watched(scenario)
    names = {name: index for index, name in enumerate(scenario.program.actors)}
    begins = {name: int((run.states[:, index, State.PRESENT] != 0.0).argmax()) for name, index in names.items()}
    assert [run.time[begins[name]] for name in ("late", "box", "cone")] == pytest.approx([0.5, 1.0, 1.0], abs=0.051)
    at = begins["box"]
    gap = run.states[at, names["box"], State.X] - run.states[at, 0, State.X] - run.outlines[[0, names["box"]], 0].mean()
    assert abs(gap) == pytest.approx(9.0, abs=1e-6)


@pytest.mark.parametrize(
    ("made", "code"),
    [
        ("new Car on road", "SCN427"),
        ("new Car in lane.centerline", "SCN427"),
        ("new Point ahead of self by 9 m", "SCN427"),
        ("ego = new Car ahead of self by 9 m", "SCN427"),
        ("x = 3 + new Car", ""),
        ("while True:\n        x = new Car ahead of self by 9 m\n        wait", "SCN427"),
        ("new Car ahead of self by 9 m, with width self.speed * 1 s", ""),
        ("new Car ahead of self by 9 m, with behavior Drops()", "SCN661"),
    ],
)
def test_other_news_are_refused(made: str, code: str) -> None:
    """A random place, a place as such, another ego, a name in a loop, a size that the run decides, endless many."""
    with pytest.raises(CompileError) as refused:
        dropping(made)
    assert not code or code in {each.code for each in refused.value.diagnostics}


def test_monitors_make_nothing() -> None:
    """They watch only."""
    text = ROAD + "monitor M():\n    new Car ahead of ego by 9 m\n    wait\nrequire monitor M()\n"
    with pytest.raises(CompileError) as refused:
        compile_text(text + EGO.format(at=20, speed=5, behavior="FollowLaneBehavior(5 m/s)"))
    assert "SCN427" in {each.code for each in refused.value.diagnostics}


LATER = "new Car ahead of self by GAP, with speed V, with behavior FollowLaneBehavior(V)"
SEARCHED = (
    "param GAP = Range(4, 20) m\nparam V = Range(2, 12) m/s\n"
    + DROPS.format(speed=10, after=1, made=LATER)
    + "ego = new Car following roadDirection from lane.centerline[0] for Range(10, 40) m, with speed 10 m/s, "
    + "with behavior Drops()\nterminate after 6 s\n"
)


LENGTHS = "Range(0.5, 1.5)"


def test_copies_run_to_the_same_outcome() -> None:
    """The copy of a scene has the same states, bit for bit, also with a number of objects in a loop."""
    loop = "while True:\n        new Obstacle behind self by 1 m, with length 1 m\n"
    loop += "        do FollowLaneBehavior(9 m/s) for 1 s"
    drawn = loop.replace("with length 1 m", f"with length {LENGTHS} m")
    for scenario in (
        compile_text(ROAD + SEARCHED),
        dropping(loop, before="simulation(late=6)\n"),
        dropping(drawn, behind="b = new Car left of ego by 2 m, with speed 10 m/s, with behavior Drops()\n"),
    ):
        scenes = scenario.sample(3, seed=4)
        for row in range(3):
            copy = compile_text(scenario.concrete(scenes, row))
            again = copy.scene_of_seed()
            one = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation)
            other = batch.trajectory(copy.program, again, 0, copy.config.simulation)
            np.testing.assert_array_equal(one.states, other.states)


@examples(10)
@given(st.integers(0, 10_000))
def test_properties_are_drawn_with_the_scene(seed: int) -> None:
    """Each object has a value of its own from the range, which it keeps over the run."""
    made = f"for i in range(2):\n        new Obstacle behind self by 1 m, with length {LENGTHS} m\n        wait"
    run = watched(dropping(made), seed)
    lengths = run.outlines[1:, 0]
    assert ((lengths >= 0.5) & (lengths <= 1.5)).all()
    assert len({*lengths.tolist()}) == len(lengths) > 1


def test_journals_hold_runs_with_appearing_objects(tmp_path: Path) -> None:
    """A search repeats all its simulations from the journal, and its cases play again."""
    (tmp_path / "late.scn").write_text(ROAD + SEARCHED)
    command = [sys.executable, "-m", "cortex_dsl"]
    options = ["late.scn", "--ga", "--generations", "2", "--population", "6", "--out", "run"]
    subprocess.run([*command, *options], cwd=tmp_path, capture_output=True, check=True)
    done = subprocess.run([*command, "verify", "run"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "the same, bit for bit" in done.stdout


def test_parallel_runs_let_objects_appear() -> None:
    """Stepped from outside, a scene has the states of the batch run: each run has its own places of such objects."""
    other = "other = new Car behind ego by 9 m, with speed 10 m/s, with behavior Drops()\nterminate"
    text = ROAD + SEARCHED.replace("with behavior Drops()", "with behavior ExternalBehavior(every=0.1 s)")
    text = text.replace("terminate", other).replace("ahead of self by GAP", "behind self by GAP")
    scenario = compile_text(text).driven_by("python:examples.own_driver.planner:drive")
    scenes = scenario.sample(5, seed=2)
    together = scenario.simulate(scenes)
    assert (together.verdict == Verdict.VALID).any()
    for row in range(5):
        one = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation)
        begins = int((one.states[:, 2, State.PRESENT] != 0.0).argmax())
        assert one.time[begins] == pytest.approx(1.0)
        assert one.time[-1] == pytest.approx(together.end_time[row], abs=0.051)


def test_exports_have_them_from_their_step(tmp_path: Path) -> None:
    """A table has no row of an object before it appears."""
    scenario = dropping("new Car ahead of self by 20 m, with speed 10 m/s")
    cx.export(scenario, ["csv"], tmp_path)
    rows = next(tmp_path.glob("*.csv")).read_text().splitlines()[1:]
    times = [int(row.split(",")[0]) for row in rows if row.split(",")[1] == "1"]
    assert min(times) == pytest.approx(1e9, abs=1e6)
