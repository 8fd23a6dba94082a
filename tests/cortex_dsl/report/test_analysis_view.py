"""What is said of a search's failures, in words and with numbers that hold as they are printed."""

import math
from dataclasses import dataclass, fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cortex_dsl.report.findings.analysis_report import condition_text, lost_text, margin_text, struck_text, system_lines
from cortex_dsl.report.findings.failures import finds_of, kind_text, lead_text, others_text, rate_texts
from cortex_dsl.report.findings.paper_metrics import METRICS, brief_of, meaning_of
from cortex_dsl.report.findings.study_report import Yield
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.insight.analysis import Avoided, SystemShare, _system_shares
from engine.search.insight.clusters import Condition
from engine.search.insight.kinds import Failures, Kind
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.vocabulary import Blame, GeneKind, Side


@dataclass(frozen=True)
class Group:
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
    printed = bounds(condition_text(space, Group((Condition(0, low, high),))))  # type: ignore[arg-type]
    assert printed[0] <= low + 1e-6
    assert printed[1] >= high - 1e-6
    assert low - printed[0] < 0.1
    assert printed[1] - high < 0.1
    one = condition_text(space, Group((Condition(1, -math.inf, 0.38921),)))  # type: ignore[arg-type]
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
    assert struck_text(Avoided(9, struck)).startswith("3 of them are not the ego's failure")


def test_a_margin_says_early_or_late() -> None:
    """Too early is possible, where only who brakes later passes before the other."""
    late = Avoidability(Avoidance.UNAVOIDABLE, 3.0, 0.4, 1.15, -0.3)
    assert margin_text(late) == "0.30 s too late"
    assert margin_text(SimpleNamespace(margin=0.4, avoidable=False)).startswith("0.40 s too early")  # type: ignore[arg-type]
    assert margin_text(SimpleNamespace(margin=0.4, avoidable=True)) == "0.40 s to spare"  # type: ignore[arg-type]


def test_charts_follow_what_is_sought() -> None:
    """The paper's metric and its charts say what they show where something else than the risk is sought."""
    assert [meaning_of(metric, DEFAULT_OBJECTIVES) for metric in METRICS] == [metric.meaning for metric in METRICS]
    assert meaning_of(METRICS[0], ("no contact",)) == "mean of no contact of valid scenes"
    assert brief_of(METRICS[1], ("no contact",)) == METRICS[1].brief
    assert (finds_of(DEFAULT_OBJECTIVES).verb, finds_of(("no contact",)).verb) == (
        "collide",
        "are results of the objective no contact",
    )


def came(**counts: int) -> Failures:
    return Failures(**{field.name: counts.get(field.name, 0) for field in fields(Failures)})


def test_what_speaks_against_the_ego_is_said_first() -> None:
    """Never safe where there are collisions, never avoidable where nobody was asked."""
    assert lead_text(came(valid=9)) == "no collision"
    assert lead_text(came(valid=9, collisions=3, kinds=2)) == "no avoidable collision (3 in all)"
    assert lead_text(came(valid=9, collisions=3, kinds=2, unknown=3)) == "3 collisions"
    every = came(valid=9, collisions=3, kinds=2, avoidable=2, avoidable_kinds=1)
    assert lead_text(every) == "2 avoidable collisions of 1 kind (3 in all)"
    assert lead_text(replace(every, avoidable=3)) == "3 avoidable collisions of 1 kind"
    first, other, second = rate_texts(came(valid=998, collisions=500, kinds=7, disputed=2, unavoidable=9), 2.0)
    assert first == "avoidable: none among 998 valid simulations"
    assert other == "other verdicts: 2 disputed, 9 unavoidable"
    assert second == "collisions: 500 of 7 kinds, 50.1 % of valid simulations, 250 a second"
    assert list(rate_texts(came(valid=998), 2.0)) == []
    unseen, seen = (Yield("ga", 998, avoidable, 500, 2.0).text for avoidable in (0, 10))
    assert unseen == "ga: 0 avoidable of 500 collisions in 998 valid simulations"
    assert (
        seen == "ga: 10 avoidable of 500 collisions in 998 valid simulations; avoidable 1.00 % of these, 5 per second"
    )
    text = others_text(came(struck=1, without_ego=2), "ego")
    assert text == ("without ego's part: 1 collision, struck from behind or while standing; others touched in 2 runs")
    kind = Kind(0, Side.LEFT, 4, 0, 3, Blame.AVOIDABLE)
    assert kind_text(("ego", "van"), kind) == "van at the left, head-on; ego stands, van 50 .. 70 km/h"
