"""What `filter` keeps of the elements of a road; each condition on them is worked out once in a file."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir

Compiled = Callable[..., ir.Scenario]


@pytest.mark.parametrize(
    "lines",
    [
        pytest.param(
            "def pick(f):\n    return filter(f, network.maneuvers)\n"
            "found = [pick(lambda m: m.type is ManeuverType.STRAIGHT),\n"
            "    pick(lambda m: m.type is ManeuverType.LEFT_TURN)]\n",
            id="handed to a function",
        ),
        pytest.param(
            "found = [filter(lambda m: m.type is kind, network.maneuvers) for kind in kinds]\n", id="of a variable"
        ),
        pytest.param(
            "def such(kind):\n    return lambda m: m.type is kind\n"
            "found = [filter(such(kind), network.maneuvers) for kind in kinds]\n",
            id="made by a function",
        ),
        pytest.param(
            "def such(ManeuverType):\n    return lambda m: m.type is ManeuverType\n"
            "found = [filter(such(kind), network.maneuvers) for kind in kinds]\n",
            id="of a name that hides another",
        ),
    ],
)
def test_each_condition_keeps_its_own(lines: str, compiled: Compiled) -> None:
    kinds = "kinds = [ManeuverType.STRAIGHT, ManeuverType.LEFT_TURN]\n"
    checked = (
        "for i in range(2):\n    assert len(found[i]) > 0\n    assert all([m.type is kinds[i] for m in found[i]])\n"
    )
    assert compiled(kinds + lines + checked).variants


def test_a_condition_keeps_of_other_items_others(compiled: Compiled) -> None:
    lines = (
        "def straight(items):\n    return filter(lambda m: m.type is ManeuverType.STRAIGHT, items)\n"
        "few = [m for l in network.lanes[:2] for m in l.maneuvers]\n"
        "assert len(straight(few)) < len(straight(network.maneuvers))\n"
    )
    assert compiled(lines).variants
