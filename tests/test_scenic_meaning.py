"""Where Scenic's meaning is easily missed in silence: what it is, beside what it is not."""

import json

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.cli.entry import main
from engine.vocabulary import EndReason, State

HEAD = "map intersection(approach=60 m)\nmodel scenic.domains.driving.model\n"
SUB = (
    "scenario Sub(x):\n    setup:\n        other = new Car at (x, 1.75), with behavior ConstantSpeedBehavior(0)\n"
    "        terminate after 1 seconds\n"
)


def present(compose: str) -> np.ndarray:
    """How many take part, the ego aside, over the samples of a run (samples,)."""
    text = (
        f"{HEAD}{SUB}scenario Main():\n    setup:\n        ego = new Car at (-30, 1.75)\n"
        f"    compose:\n        {compose}\n"
    )
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=2)
    assert scenes.valid[0]
    run = scenario.watch(scenes)
    return np.sum(run.trajectory.states[:, 1:, State.PRESENT] != 0.0, axis=1)


def test_of_a_choice_only_what_was_chosen_exists() -> None:
    """The places of two options may overlap, for never both are there; not one for each option."""
    assert present("do choose Sub(20), Sub(21)").max() == 1


def test_what_is_shuffled_comes_in_one_after_the_other() -> None:
    """Each scenario brings its object along as it starts, and leaves it behind; not both from the start."""
    count = present("do shuffle Sub(20), Sub(21)")
    assert count[0] <= 1
    assert count.max() == 2


def test_who_begins_together_must_not_overlap() -> None:
    """Two scenarios that surely start with the run place their objects side by side, or the scene is none."""
    text = f"{HEAD}{SUB}scenario Main():\n    setup:\n        ego = new Car at (-30, 1.75)\n    compose:\n"
    assert not compile_text(f"{text}        do Sub(20), Sub(21)\n").sample(1, seed=2).valid[0]


AGAIN = (
    f"{HEAD}m = intersection.maneuvers[0]\nway = [m.startLane, m.connectingLane, m.endLane]\n"
    "behavior Again(t):\n    while True:\n        do FollowTrajectoryBehavior(10, t)\n"
)


def test_who_follows_a_way_to_its_end_again_and_again_leaves() -> None:
    """In Scenic such a loop hangs; here the actor leaves, as it does where the behavior ends with its way."""
    ego = "ego = new Car on m.startLane.centerline, with behavior {behavior}\n"
    ends = []
    for behavior in ("Again(way)", "FollowTrajectoryBehavior(10, way)"):
        scenario = compile_text(AGAIN + ego.format(behavior=behavior))
        outcomes = scenario.simulate(scenario.sample(2, seed=1))
        ends.append((outcomes.end_reason.tolist(), outcomes.end_time.tolist()))
    assert ends[0] == ends[1]
    assert set(ends[0][0]) == {EndReason.ALL_DONE}


def test_a_way_that_is_followed_a_few_times_goes_on() -> None:
    """A loop that ends after its way does is no end of the behavior: what stands behind it is done."""
    text = (
        AGAIN.replace("while True", "for i in range(3)")
        + "    do BrakeBehavior()\nego = new Car on m.startLane.centerline, with behavior Again(way)\n"
        "terminate after 30 s\n"
    )
    scenario = compile_text(text)
    outcomes = scenario.simulate(scenario.sample(1, seed=1))
    assert outcomes.end_reason[0] == EndReason.TIMEOUT


def test_a_loop_without_a_way_is_stuck_all_the_same() -> None:
    """Only who came to the end of a way again and again in one turn leaves."""
    text = (
        AGAIN.replace("while True:\n        do", "do")
        + "    n = 0\n    while n >= 0:\n        n = n + 1\n        if n < 0:\n            wait\n"
        "ego = new Car on m.startLane.centerline, with behavior Again(way)\n"
    )
    scenario = compile_text(text)
    assert scenario.simulate(scenario.sample(1, seed=1)).end_reason[0] == EndReason.STUCK


def test_a_search_of_it_prints_one_document(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:  # type: ignore[no-untyped-def]
    """Under `--json`."""
    file = tmp_path / "again.scn"
    ego = "ego = new Car on m.startLane.centerline, with speed SPEED, with behavior Again(way)\n"
    file.write_text(AGAIN + "param SPEED = Range(5, 8)\n" + ego, encoding="utf-8")
    main([str(file), "--ga", "--json", "--generations", "2", "--population", "4", "--out", str(tmp_path / "run")])
    json.loads(capsys.readouterr().out)


def test_a_table_shows_options_by_their_value() -> None:
    """Numbers as numbers, anything else as its text; not which of the options it is."""
    text = (
        'map intersection()\nparam SPEED = VerifaiOptions(5, 7.5, 12)\nparam LOOK = Uniform("red", "blue")\n'
        "ego = new Car on road, with speed SPEED\n"
    )
    scenario = compile_text(text)
    table = scenario.table(scenario.sample(12, seed=1))
    assert set(table["SPEED"].tolist()) == {5.0, 7.5, 12.0}
    assert set(table["LOOK"].tolist()) == {'"red"', '"blue"'}


PLAIN = "map intersection(approach=60 m)\n"
NORTH = "ego = new Car at (1.75 m, {y}), facing 90 deg, with speed 8 m/s, with viewAngle 90 deg"


def end_of_ego(text: str) -> float:
    """How far north the ego has come at the end [m]."""
    scenario = compile_text(PLAIN + text)
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    return float(scenario.watch(scenes).trajectory.states[-1, 0, State.Y])


def test_velocity_is_speed_with_a_direction() -> None:
    """At the start, and in a run as it moves."""
    ego = NORTH.format(y="-50 m") + ", with behavior BrakeBehavior(0.5)\n"
    rules = "require ego.velocity.y > 7.9 m/s and abs(ego.velocity.x) < 0.01 m/s\n"
    assert end_of_ego(ego + rules + "terminate when ego.velocity.y < 4 m/s\n") == pytest.approx(
        end_of_ego(ego + "terminate when ego.speed < 4 m/s\n")
    )


def test_what_could_be_seen_is_a_region() -> None:
    """A sector before an object, which moves with it; all around a point. Places can be drawn in it."""
    ego = NORTH.format(y="-55 m") + ", with visibleDistance 30 m, with behavior ConstantSpeedBehavior(8 m/s)\n"
    drawn = "box = new Obstacle in ego.visibleRegion, with regionContainedIn None\n"
    seen = "require (distance from ego to box) < 30 m and (1.75, -30) in ego.visibleRegion\n"
    behind = "p = new Point at (1.75, -50)\nrequire not (1.75, -57) in ego.visibleRegion and ego in p.visibleRegion\n"
    end = end_of_ego(ego + drawn + seen + behind + "terminate when (1.75 m, 0 m) in ego.visibleRegion\n")
    assert -32.0 < end < -29.0


def test_a_turn_is_over_where_the_intersection_is() -> None:
    """As Scenic's: while all of the outline is inside."""
    text = (
        "m = filter(lambda m: m.type is ManeuverType.STRAIGHT, network.laneAt((1.75, -50)).maneuvers)[0]\n"
        "behavior Cross():\n    do TurnBehavior([m.startLane, m.connectingLane, m.endLane])\n    terminate\n"
    )
    end = end_of_ego(f"{text}{NORTH.format(y='-2 m')}, with behavior Cross()\n")
    assert end + 4.508 / 2 == pytest.approx(9.5, abs=0.6)
