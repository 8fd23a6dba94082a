"""Drivers decide the same whether or not their predictions end where no decision depends on them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
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
