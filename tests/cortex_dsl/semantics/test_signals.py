"""Traffic lights: the statement, and what is said about it. (What they do is in `tests/test_driving_library.py`.)"""

import pytest

from cortex_dsl import ir
from engine.opcodes import Op
from tests.cortex_dsl.semantics.conftest import findings, scenario

OBEY = "with behavior FollowLaneBehavior(obey_signals=True)"
EGO = "ego = new Car on road"


def codes(text: str) -> list[str]:
    return [d.code for d in findings("map intersection()\n" + text)]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (f"{EGO}, {OBEY}\n", "SCN451"),
        (f"{EGO}\nterminate when withinDistanceToRedYellowTrafficLight(ego, 15)\n", "SCN451"),
        (f'signals()\n{EGO}\nterminate when getClosestTrafficLightStatus(ego) == "amber"\n', "SCN452"),
        (f"signals()\n{EGO}\nterminate when getClosestTrafficLightStatus(ego) in (3, 4)\n", "SCN452"),
        (f"signals()\n{EGO}, with behavior FollowLaneBehavior()\n", "SCN453"),
        (f"signals()\nsignals()\n{EGO}, {OBEY}\n", "SCN454"),
        (f"signals(green=0 s)\n{EGO}, {OBEY}\n", "SCN402"),
        (f"signals(yellow=-1 s)\n{EGO}, {OBEY}\n", "SCN402"),
        (f"signals(green=3 m)\n{EGO}, {OBEY}\n", "SCN301"),
        (f"signals(gren=3 s)\n{EGO}, {OBEY}\n", "SCN205"),
        (f"signals(3 s)\n{EGO}, {OBEY}\n", "SCN427"),
        (f"signals()\n{EGO}\nrequire withinDistanceToTrafficLight(ego, 15)\n", "SCN609"),
        (f"signals()\n{EGO}\nfreezeTrafficLights()\n", "SCN609"),
    ],
)
def test_mistakes_are_named(text: str, code: str) -> None:
    """Lights that are not there, colours that are none, plans that cannot be."""
    assert code in codes(text), codes(text)


def test_a_colour_is_looked_up_by_its_near_name() -> None:
    """`gren` is a slip of `green`."""
    text = f'map intersection()\nsignals()\n{EGO}\nterminate when getClosestTrafficLightStatus(ego) == "gren"\n'
    (found,) = findings(text)
    assert found.cure == "did you mean `green`?"


def test_the_offset_may_be_a_gene() -> None:
    """A search may choose the phase; the condition reads it."""
    text = f"map intersection()\nparam PHASE = Range(0, 22) s\nsignals(green=6 s, offset=PHASE)\n{EGO}, {OBEY}\n"
    compiled = scenario(text)
    assert not findings(text)
    assert compiled.genes[0].name == "PHASE"


def test_lights_cost_no_locals_unless_they_are_changed() -> None:
    """Reading is arithmetic over the time; setting needs memory."""
    read = scenario(f"map intersection()\nsignals()\n{EGO}, {OBEY}\n")
    behaviour = "behavior Set():\n    setTrafficLightStatus(lane.signal, 'red')\n    wait\n"
    lane = "lane = intersection.incomingLanes[0]\n"
    text = f"map intersection()\nsignals()\n{lane}{behaviour}{EGO}, with behavior Set()\n"
    changed = scenario(text)
    assert read.variants[0].local_count == 2, "path and progress of the follower"
    assert changed.variants[0].local_count == 2 * 4 + 3
    sets = [act for act in _acts(changed) if isinstance(act, ir.SetLocal)]
    assert len(sets) == 2


def _acts(compiled: ir.Scenario) -> tuple[ir.Act, ...]:
    block = compiled.variants[0].actors[0].behaviour
    assert block is not None
    (act,) = block
    assert isinstance(act, ir.Scope)
    return act.body


def test_a_scenic_map_has_lights_where_a_script_asks_for_them() -> None:
    """One note says which plan; without such a question there is none."""
    head = "param map = localPath('Town01.xodr')\n"
    asked = findings(f"{head}{EGO}\nterminate when withinDistanceToTrafficLight(ego, 10)\n")
    assert [d.code for d in asked] == ["SCN442", "SCN447"]
    assert [d.code for d in findings(f"{head}{EGO}\n")] == ["SCN442"]
    unlit = "here = Uniform(*filter(lambda i: not i.isSignalized, network.intersections))\n"
    assert [d.code for d in findings(f"{head}{unlit}ego = new Car in here.incomingLanes[0]\n")] == ["SCN442"]


def test_the_status_without_a_light_is_none() -> None:
    """Beyond the intersection there is no light; text and None mean the same."""
    text = f"map intersection()\nsignals()\n{EGO}\nterminate when getClosestTrafficLightStatus(ego) == None\n"
    rule = scenario(text).variants[0].rules[0].condition
    assert isinstance(rule, ir.Apply)
    assert rule.op is Op.EQ
