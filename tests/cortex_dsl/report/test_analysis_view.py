"""What is said of a search's failures, in words and with numbers that hold as they are printed."""

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cortex_dsl.report.findings.analysis_report import condition_text, lost_text, margin_text, struck_text, system_lines
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.insight.analysis import Avoided, SystemShare, _system_shares
from engine.search.insight.clusters import Condition
from engine.vocabulary import GeneKind


@dataclass(frozen=True)
class Kind:
    conditions: tuple[Condition, ...]


@pytest.fixture
def space() -> ParamSpace:
    fields: dict[str, Any] = dict.fromkeys(ParamSpace.__dataclass_fields__)
    fields |= {
        "names": ("SPEED", "BRAKE"),
        "units": ("km/h", ""),
        "low": np.array([5.0, 0.0]),
        "high": np.array([80.0, 1.0]),
        "kinds": np.array([GeneKind.CONTINUOUS, GeneKind.CONTINUOUS]),
        "options": ((), ()),
        "system": ("BRAKE",),
    }
    return ParamSpace(**fields)


def bounds(text: str) -> tuple[float, float]:
    low, high = text.split(" ")[1], text.split(" ")[3]
    return float(low), float(high)


@pytest.mark.parametrize(("low", "high"), [(15.748, 47.141), (15.7, 47.1), (5.0, 80.0), (33.3349, 33.3351)])
def test_printed_bounds_leave_nothing_out(space: ParamSpace, low: float, high: float) -> None:
    """What the rule lets in, the rule as printed lets in, too, and little else."""
    printed = bounds(condition_text(space, Kind((Condition(0, low, high),))))  # type: ignore[arg-type]
    assert printed[0] <= low + 1e-6
    assert printed[1] >= high - 1e-6
    assert low - printed[0] < 0.1
    assert printed[1] - high < 0.1
    one = condition_text(space, Kind((Condition(1, -math.inf, 0.38921),)))  # type: ignore[arg-type]
    assert one.startswith("BRAKE ≤ 0.")
    assert float(one.split()[-1]) >= 0.38921


def test_the_avoidable_are_described_by_what_the_search_chose(space: ParamSpace) -> None:
    """Thirds of the range of each param of the system; edges belong to the range."""
    genomes = np.array([[10.0, 0.0], [10.0, 0.1], [10.0, 0.5], [10.0, 1.0]])
    (share,) = _system_shares(space, genomes)
    assert share == SystemShare("BRAKE", (2, 1, 1))
    lines = system_lines(Avoided(9, {Avoidance.AVOIDABLE: 4}, (share,)))
    assert "of the 4 avoidable" in lines[0]
    assert "BRAKE 2, 1, 1" in lines[0]
    assert "with these settings" in lines[1]
    assert system_lines(Avoided(9, {Avoidance.UNAVOIDABLE: 9}, (SystemShare("BRAKE", (0, 0, 0)),))) == []
    assert system_lines(Avoided(9, {Avoidance.AVOIDABLE: 4})) == []


def test_collisions_that_no_driving_explains_are_said_apart() -> None:
    """Of the scene drawn, and of others: neither speaks of how the ego drove."""
    assert lost_text(Avoided(9, {})) == struck_text(Avoided(9, {})) == ""
    assert lost_text(Avoided(9, {Avoidance.LOST: 2})).startswith("2 of them are lost from the start")
    struck = {Avoidance.STRUCK_FROM_BEHIND: 2, Avoidance.STRUCK_STANDING: 1}
    assert struck_text(Avoided(9, struck)).startswith("3 of them are no failure of the ego")


def test_a_margin_says_early_or_late() -> None:
    """Too early is possible, where only who brakes later passes before the other."""
    late = Avoidability(Avoidance.UNAVOIDABLE, 3.0, 0.4, 1.15, -0.3)
    assert margin_text(late) == "0.30 s too late"
    assert margin_text(SimpleNamespace(margin=0.4, avoidable=False)).startswith("0.40 s too early")  # type: ignore[arg-type]
    assert margin_text(SimpleNamespace(margin=0.4, avoidable=True)) == "0.40 s to spare"  # type: ignore[arg-type]
