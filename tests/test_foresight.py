"""Drivers decide the same whether or not their predictions end where no decision depends on them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.lowering import instructions
from cortex_dsl.semantics.acting import braking, giving_way, partners
from cortex_dsl.semantics.acting.foreseeing import foreseen
from engine.opcodes import Op
from engine.outcomes import OUTCOMES
from tests.laws import share
from tests.test_symmetry import View, text

SCENES = share(100)
CALLS = {
    "EmergencyBrakeBehavior": ("", "threshold=3 s, ", "latency=0.3 s, ", "reference_deceleration=3, delay=1 s, "),
    "GivingWayBehavior": ("", "max_acceleration=0.5, "),
    "RSSBehavior": ("", "response=0.4 s, least_braking=2, "),
    "CarefulDriverBehavior": ("", "perception=0.1 s, "),
    "FuzzySafetyBehavior": ("",),
}


def results(name: str, more: str) -> Iterator[tuple[str, np.ndarray]]:
    """Every outcome of encounters with three cars and a parked object on an intersection."""
    source = text(name, View())
    assert f"{name}(" in source
    scenario = cx.compile_text(source.replace(f"{name}(", f"{name}({more}"))
    assert (scenario.program.code.step_code[:, 0] == Op.CROSSING).any()
    outcomes = scenario.simulate(scenario.sample(SCENES, seed=21))
    for row in OUTCOMES:
        yield row.name, np.asarray(getattr(outcomes, row.name))


@pytest.mark.parametrize(("name", "more"), [(name, more) for name, calls in CALLS.items() for more in calls])
def test_what_is_too_far_away_changes_nothing(name: str, more: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All results have the same bits if every prediction searches the whole way."""
    found = dict(results(name, more))

    def everywhere(*arguments: Any) -> Any:
        return foreseen(*arguments[:6])

    for module in (braking, giving_way, partners):
        monkeypatch.setattr(module, "foreseen", everywhere)
    for key, values in results(name, more):
        np.testing.assert_array_equal(found[key], values, err_msg=key)


@pytest.mark.parametrize("name", CALLS)
def test_skipped_operands_change_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All results have the same bits if every operand is computed."""
    found = dict(results(name, ""))
    monkeypatch.setattr(instructions, "FEW", np.inf)  # results() compiles the text again
    for key, values in results(name, ""):
        np.testing.assert_array_equal(found[key], values, err_msg=key)


UNDEFINED = """
map intersection(approach=100 m)
behavior Going():
    try:
        do FollowLaneBehavior(10 m/s)
    interrupt when sqrt(10 - self.speed / (1 m/s)) > 1.5 and {other}:
        take SetBrakeAction(1)
lane = intersection.incomingLanes[0]
ego = new Car on lane.centerline, with speed 12 m/s, with behavior Going()
other = new Car ahead of ego by 10 m
terminate after 6 s
"""
OTHER = "(self can see other) and (distance from self to other) * 2 > {} and other.speed * 3 + 1 m/s < 5 m/s"


@pytest.mark.parametrize(("least", "is_decided"), [("70 m", True), ("7 m", False)])
def test_an_undefined_operand_decides_nothing_beside_a_false_one(
    least: str, is_decided: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Above 10 m/s the square root is undefined; the condition is false where another operand is."""
    found = []
    for few in (instructions.FEW, np.inf):
        monkeypatch.setattr(instructions, "FEW", few)
        scenario = cx.compile_text(UNDEFINED.format(other=OTHER.format(least)))
        skips = bool((scenario.program.code.step_code[:, 0] == Op.JUMP_IF_FALSE).any())
        outcomes = scenario.simulate(scenario.sample(1, seed=0))
        found.append((skips, outcomes.steps[0] > 0, int(outcomes.verdict[0])))
    (_, *first), (_, *second) = found
    assert [skips for skips, *_ in found] == [True, False]
    assert first == second
    assert first[0] == is_decided
