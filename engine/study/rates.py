"""Rates of random sampling, each individual an independent draw: exact intervals, and a test against the paper.

Nothing of the kind is said of any other method: what it draws depends on what it found before.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from engine.paper.numbers import FILES, RANDOM, RUNS
from engine.search.statistics import Interval, OddsRatio, clopper_pearson, fisher
from engine.study.plan import BASELINE, Plan
from engine.study.records import RunRecord

NOTHING = OddsRatio(float("nan"), float("nan"))


@dataclass(frozen=True)
class RandomRates:
    """What a uniformly random genome of a scenario comes to, over all runs."""

    scenario: str
    individuals: int
    valid: int
    valid_rate: Interval
    """95 %, Clopper and Pearson."""
    collisions: int
    collision_rate: Interval
    """Of valid individuals, 95 %."""
    against_paper: OddsRatio
    """Collisions among valid ones: our odds to the paper's; NaN where the scenario is not one of its six."""


def random_rates(plan: Plan, records: Sequence[RunRecord]) -> tuple[RandomRates, ...]:
    """One row a scenario; () where the study has no random sampling."""
    if BASELINE not in plan.methods:
        return ()
    return tuple(_rates(plan, records, number) for number in range(len(plan.subjects)))


def _rates(plan: Plan, records: Sequence[RunRecord], number: int) -> RandomRates:
    runs = [r.figures.individuals for r in records if r.address[:2] == (number, BASELINE)]
    individuals = sum(figures.individuals - figures.errors for figures in runs)
    valid, collisions = (sum(getattr(figures, name) for figures in runs) for name in ("valid", "nc"))
    name = plan.subjects[number].name
    return RandomRates(
        scenario=name,
        individuals=individuals,
        valid=valid,
        valid_rate=clopper_pearson(valid, individuals),
        collisions=collisions,
        collision_rate=clopper_pearson(collisions, valid),
        against_paper=_against_paper(name, collisions, valid),
    )


def _against_paper(name: str, collisions: int, valid: int) -> OddsRatio:
    if name not in FILES:
        return NOTHING
    letter = FILES.index(name)
    return fisher((collisions, RANDOM.nc[letter]), (valid, RUNS - RANDOM.nis[letter]))
