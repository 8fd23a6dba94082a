"""Monitors, records, and `require` while the run goes on."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.acting.yielding import everything
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, SPEED
from engine.opcodes import Op
from engine.vocabulary import RuleKind, Turns

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]

WATCH = """\
monitor Watch(car, limit):
    "Counts."
    seen = 0
    while seen < 3:
        if car.speed > limit:
            seen = seen + 1
        require car.speed < 50 m/s
        wait
    terminate
"""


def inside(block: ir.Block) -> list[str]:
    return [type(act).__name__ for act in everything(block)]


def test_a_monitor_runs_from_the_start(compiled: Compiled) -> None:
    """`require monitor` makes a coroutine of nobody."""
    scenario = compiled(WATCH + "require monitor Watch(ego, 3 m/s)\n")
    (monitor,) = scenario.variants[0].monitors
    assert (monitor.name, monitor.turns) == ("Watch", Turns.FROM_START)
    acts = inside(monitor.body)
    assert [acts.count(kind) for kind in ("Demand", "Wait", "Loop", "Terminate")] == [1, 1, 1, 1]


def test_instances_share_rules_but_no_variables(compiled: Compiled) -> None:
    """Two instances count apart, and break the same requirement."""
    scenario = compiled(WATCH + 'require monitor Watch(ego, 3 m/s) as "a"\nrequire monitor Watch(ego, 4 m/s) as "b"\n')
    first, second = scenario.variants[0].monitors
    assert (first.name, second.name) == ("a", "b")
    set_in = [{act.index for act in everything(each.body) if isinstance(act, ir.SetLocal)} for each in (first, second)]
    assert not set_in[0] & set_in[1]
    rules = [{act.rule for act in everything(each.body) if isinstance(act, ir.Demand)} for each in (first, second)]
    assert rules[0] == rules[1]
    assert [rule.kind for rule in scenario.variants[0].rules] == [RuleKind.ABORT, RuleKind.TERMINATE]


def test_rules_say_whose_they_are(compiled: Compiled) -> None:
    """A broken requirement is named after its monitor and its text."""
    scenario = compiled(WATCH + "require monitor Watch(ego, 3 m/s)\n")
    names = [rule.name for rule in scenario.variants[0].rules]
    assert names == ["require in Watch: car.speed < 50 m/s", "`terminate` in Watch"]


def test_require_in_a_behaviour(compiled: Compiled) -> None:
    """It is tested where it stands, with its own name if it has one."""
    text = 'behavior B():\n    require self.speed < 9 m/s as "calm"\n    wait\n'
    scenario = compiled(text + "other = new Car behind ego by 5 m, with behavior B()\n")
    behaviour = scenario.variants[0].actors[1].behaviour
    assert behaviour is not None
    (demand,) = [act for act in everything(behaviour) if isinstance(act, ir.Demand)]
    rule = scenario.variants[0].rules[demand.rule]
    assert (rule.name, rule.kind, rule.condition) == ("calm", RuleKind.ABORT, None)


def test_soft_require_tosses_a_coin(compiled: Compiled) -> None:
    """`require[p]` in a monitor holds, or is let off with probability 1 - p."""
    text = "monitor M():\n    while True:\n        require[0.25] ego.speed < 9 m/s\n        wait\nrequire monitor M()\n"
    (monitor,) = compiled(text).variants[0].monitors
    (demand,) = [act for act in everything(monitor.body) if isinstance(act, ir.Demand)]
    assert isinstance(demand.condition, ir.Apply)
    assert demand.condition.op == Op.OR
    spared = demand.condition.arguments[0]
    assert isinstance(spared, ir.Apply)
    assert spared.op == Op.LE
    assert isinstance(spared.arguments[0], ir.Literal)
    assert spared.arguments[0].value == 0.25
    assert isinstance(spared.arguments[1], ir.Apply)
    assert spared.arguments[1].op == Op.RANDOM


def test_what_surely_holds_needs_no_test(compiled: Compiled) -> None:
    """A known truth leaves no act behind."""
    text = "monitor M():\n    while True:\n        require 3 m > 2 m\n        wait\nrequire monitor M()\n"
    assert "Demand" not in inside(compiled(text).variants[0].monitors[0].body)


# -- records ----------------------------------------------------------------------------------------------------------


def test_records(compiled: Compiled) -> None:
    """Numbers with their dimension, truths as 0 and 1; names default to the text."""
    text = "record ego.speed\nrecord initial ego.heading as h\nrecord final ego.speed > 3 m/s\n"
    scenario = compiled(text)
    records = [(record.name, record.when, record.dimension) for record in scenario.records]
    assert records == [
        ("ego.speed", "series", SPEED),
        ("h", "initial", ANGLE),
        ("final ego.speed > 3 m/s", "final", PURE),
    ]
    rules = scenario.variants[0].rules
    assert [rules[record.watch].kind for record in scenario.records] == [RuleKind.WATCH] * 3
    assert [record.line for record in scenario.records] == [4, 5, 6]


def test_places_are_recorded_by_coordinate(compiled: Compiled) -> None:
    """A point has two columns, each with a rule of its own."""
    scenario = compiled("record ego.position as p\n")
    assert [(record.name, record.dimension) for record in scenario.records] == [("p.x", LENGTH), ("p.y", LENGTH)]
    conditions = [scenario.variants[0].rules[record.watch].condition for record in scenario.records]
    assert conditions[0] is not conditions[1]
    assert all(isinstance(each, ir.Apply) and each.op == Op.STATE for each in conditions)


@pytest.mark.parametrize("text", ["record ego.speed as a\nrecord ego.heading as a\n", "record ego.speed\n" * 2])
def test_names_of_records_are_unique(said: Said, text: str) -> None:
    """Two columns cannot have one name."""
    assert said(text) == ["SCN210"]


def test_one_value_may_be_kept_in_three_ways(said: Said) -> None:
    """The default names say when a value is taken."""
    assert said("record ego.speed\nrecord initial ego.speed\nrecord final ego.speed\n") == []


def test_records_of_all_variants_agree(compiled: Compiled) -> None:
    """Whatever lane is chosen, the columns are the same."""
    scenario = compiled("goal = Uniform(*network.lanes)\nrecord (distance from ego to goal) as d\n")
    assert len(scenario.records) == 1
    assert all(variant.rules[scenario.records[0].watch].condition is not None for variant in scenario.variants)
