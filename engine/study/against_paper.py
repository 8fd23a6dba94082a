"""Our numbers beside the paper's, scenario by scenario, where a study runs its six with its two methods and
its budget.

The simulators differ (the paper's is Scenic's own), and the paper has one run of each: agreement in size is not
expected, agreement in direction is what can be asked.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from engine.paper.numbers import FILES, GA, GENERATIONS, POPULATION, RANDOM, SCENARIOS, STUDIES, Printed
from engine.paper.numbers import Study as StudyRow
from engine.study.comparisons import ranked, spread
from engine.study.measures import MEASURES, Measure
from engine.study.plan import Plan
from engine.study.records import RunRecord

METHODS = ("ga", "random")
CENTIMETRES = 100.0


@dataclass(frozen=True)
class Beside:
    """One metric on one scenario: medians over our runs, the paper's one run, both methods."""

    letter: str
    scenario: str
    measure: Measure
    ga: float
    random: float
    paper_ga: float
    paper_random: float

    @property
    def ratio(self) -> float:
        return _ratio(self.ga, self.random)

    @property
    def paper_ratio(self) -> float:
        return _ratio(self.paper_ga, self.paper_random)

    @property
    def same_direction(self) -> bool:
        """Whether both say that the genetic algorithm has more, or both less."""
        return bool(np.sign(self.ga - self.random) == np.sign(self.paper_ga - self.paper_random))


def _ratio(first: float, second: float) -> float:
    return first / second if second else float("nan")


_PRINTED: dict[str, Callable[[Printed, int], float]] = {
    "RL": lambda printed, letter: printed.rl[letter],
    "NC": lambda printed, letter: printed.nc[letter],
    "NIS": lambda printed, letter: printed.nis[letter],
    "NC, last 10": lambda printed, letter: printed.nc_last[letter],
    "MDG, last 10": lambda printed, letter: printed.mdg_last[letter] / CENTIMETRES,
    "MDEC, last 10": lambda printed, letter: printed.mdec_last[letter] / CENTIMETRES,
    "NIS, last 10": lambda printed, letter: printed.nis_last[letter],
}
"""What the paper prints for each scenario, by the name of our measure."""


def beside_paper(plan: Plan, records: Sequence[RunRecord]) -> tuple[Beside, ...]:
    """A row for each of the paper's scenarios and metrics that the study repeats; () unless it has both methods and
    the paper's budget.
    """
    search = plan.subjects[0].config.search
    budget = search.generations, search.population, search.rollouts
    if budget != (GENERATIONS, POPULATION, 1) or not set(METHODS) <= set(plan.methods):
        return ()
    return tuple(
        _beside(plan, records, number, measure)
        for number, subject in enumerate(plan.subjects)
        if subject.name in FILES
        for measure in MEASURES
        if measure.name in _PRINTED
    )


def _beside(plan: Plan, records: Sequence[RunRecord], number: int, measure: Measure) -> Beside:
    name = plan.subjects[number].name
    letter = FILES.index(name)
    ga, random = (_median(records, number, method, measure) for method in METHODS)
    printed = _PRINTED[measure.name]
    return Beside(SCENARIOS[letter], name, measure, ga, random, printed(GA, letter), printed(RANDOM, letter))


def _median(records: Sequence[RunRecord], number: int, method: str, measure: Measure) -> float:
    return spread(ranked(records, number, method, measure)).median


def studies(plan: Plan, records: Sequence[RunRecord]) -> tuple[StudyRow, ...]:
    """The paper's table of studies with this one as its last row."""
    return (*STUDIES, own_row(plan, records))


def own_row(plan: Plan, records: Sequence[RunRecord]) -> StudyRow:
    """What the finished runs came to. Shares are of individuals, as in the paper; seconds are those of one worker."""
    simulations = sum(record.figures.simulations.runs for record in records)
    seconds = sum(record.seconds for record in records)
    return StudyRow(
        name="this study",
        cases=f"{simulations:,}",
        seconds=f"{seconds / simulations:.2g}" if simulations else "none",
        collisions=_shares(plan, records, "nc", counted=True),
        valid=_shares(plan, records, "valid", counted=False),
        metrics="RL, NC, MD, distinct failures",
    )


def _shares(plan: Plan, records: Sequence[RunRecord], field: str, *, counted: bool) -> str:
    """`GA 3,249 (18.1 %), random 2,482 (13.8 %)`, or the shares alone."""
    parts = []
    for method in sorted(plan.methods, key=lambda name: name != METHODS[0]):  # the paper names its own first, too
        runs = [record.figures.individuals for record in records if record.address.method == method]
        total, of = sum(getattr(figures, field) for figures in runs), sum(figures.individuals for figures in runs)
        share = f"{100.0 * total / of:.1f} %" if of else "none"
        name = "GA" if method == "ga" else method
        parts.append(f"{name} {total:,} ({share})" if counted else f"{name} {share}")
    return ", ".join(parts)
