"""`:plot` shows any param, choice or expression, and two against each other."""

import re

import pytest

from engine.road import build_network

from .conftest import LEFT_TURN, Talk
from .test_weighing import FOLLOWING, PARAMS


def test_a_param(talk: Talk) -> None:
    """Accepted against drawn; a param that does not exist is answered with the nearest."""
    talk(*PARAMS, "require V > 60 m/s")
    said = talk(":plot V").out
    assert re.search(r"median (79|80|81)", said)
    assert "nine tenths" in said
    assert "did you mean `V`" in talk(":plot v").err
    assert talk.state.mistakes == 1


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("V * 2", r"V \* 2 \[m/s\]  400 accepted scenes"),
        ("distance from ego to truck", r"distance from ego to truck \[m\]  400 accepted scenes"),
        ("ego.heading", r"\[deg\]"),
        ("V > 7 m/s", r"does not hold +\d+ .*\n +holds +\d+ .* %"),
        ("largest(ego.speed) - final(ego.speed)", r"400 instant runs"),
        ("delta_v", r"delta_v \[m/s\]  400 instant runs"),
        ("always (distance from ego to truck) > 15 m", r"robustness of always .*\n[\s\S]*it holds in \d+ of 400 runs"),
        ("V, GAP", r"GAP \[m\] over V \[m/s\]  400 accepted scenes"),
        ("V, delta_v", r"delta_v \[m/s\] over V \[m/s\]  400 instant runs"),
        ("ego.position", r"ego.position.y \[m\] over ego.position.x \[m\]"),
        ("max(V, 3 m/s)", r"max\(V, 3 m/s\) \[m/s\]"),
        ("3 m", "always 3 m"),
    ],
)
def test_an_expression(talk: Talk, expression: str, said: str) -> None:
    """Of the start over scenes, of the run over runs; a comma stands between two."""
    talk(*FOLLOWING)
    shown = talk(f":plot {expression}")
    assert re.search(said, shown.out), shown.out + shown.err
    assert "collided" in shown.out or "always" in shown.out or "holds" in shown.out
    assert not talk.state.mistakes
    assert "plot" not in talk.text


def test_a_choice(talk: Talk) -> None:
    """What chance chooses among finitely many: how often each, and how often it collides."""
    talk(LEFT_TURN.read_text())
    said = talk(":plot egoInitLane").out
    assert len(re.findall(r"^ +\w+\.in\.1 +\d+ +[\d.]+ %", said, re.MULTILINE)) == 4
    assert "EGO_SPEED [km/h] over egoInitLane" in talk(":plot egoInitLane, EGO_SPEED").out


def test_lanes_that_the_scene_draws_are_plotted_as_chosen_ones(talk: Talk) -> None:
    """Of too many variants one remains; its lanes stand in the order of the map, and each as often as it is drawn."""
    talk(
        "map intersection(ways=4, lanes=2)",
        "lanes = [Uniform(*intersection.incomingLanes) for i in range(4)]",
        "ego = new Car in lanes[0].centerline",
        *(f"new Car in lanes[{number}].centerline" for number in (1, 2, 3)),
        "terminate after 0.1 s",
    )
    rows = re.findall(r"^ +(\w+\.in\.\d) +(\d+) +[\d.]+ %", talk(":plot lanes 2").out, re.MULTILINE)
    program = talk.state.checked.weighable
    assert program is not None
    names = [lane.name for lane in build_network(program.road_spec).lanes]
    assert [name for name, _ in rows] == [name for name in names if ".in." in name]
    assert sum(int(count) for _, count in rows) == 400
    assert all(int(count) > 20 for _, count in rows)


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        ("", "plot what?"),
        ("V, GAP, V", "one thing, or two"),
        ("V,", "one thing, or two"),
        ("V GAP", "error[SCN101]"),
        ("V +", "error[SCN1"),
        ("V + GAP", "error[SCN302]"),
        ("ego", "error[SCN470]"),
        ("VV", "did you mean `V`"),
        ("ego.position, V", "a place is two numbers already"),
        ("always V", "error[SCN"),
    ],
)
def test_what_cannot_be_plotted(talk: Talk, argument: str, said: str) -> None:
    """It is said why, at what was typed, and nothing of ours is shown."""
    talk(*FOLLOWING)
    err = talk(f":plot {argument}").err
    assert said in err
    assert ":plot`" not in err.replace("`:plot` shows", "").replace("`:plot ego.speed", "")
    assert "record initial" not in err
    assert talk.state.mistakes == 1


def test_the_mistake_of_the_second_one(talk: Talk) -> None:
    """It is shown in the expression that has it."""
    talk(*FOLLOWING)
    assert "| GAPP\n" in talk(":plot V, GAPP").err
    assert "| VV\n" in talk(":plot VV, GAP").err


def test_without_an_ego(talk: Talk) -> None:
    """Params alone can be plotted; what speaks of the ego or of a run has to wait."""
    talk(*PARAMS)
    assert "400 accepted scenes" in talk(":plot V * 2").out
    for expression in ("ego.speed", "end_time"):
        assert "still to come: an ego" in talk(f":plot {expression}").err


def test_a_name_of_ones_own_hides_a_result(talk: Talk) -> None:
    """`delta_v` is what the file says it is."""
    talk(*FOLLOWING, "delta_v = V * 3")
    assert "accepted scenes" in talk(":plot delta_v").out
