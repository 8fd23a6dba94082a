"""The findings of a study, computed from its records, and its verdict in plain words.

In addition to comparisons there are two findings. The first compares the study's numbers with the paper's, scenario by
scenario, if the study runs the paper's six scenarios with its two methods and its budget. The simulators differ (the
paper's is Scenic's own), and the paper has one run of each. A metric is reproduced if the ratios of the genetic
algorithm to random search differ from the paper's by no more than a stated mean error (`log_error`). The second are
rates of random sampling, where each individual is an independent draw, with exact intervals and a test against the
paper. No other method has such rates, as its draws depend on earlier results.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from engine.display import counted
from engine.paper import (
    GA,
    GENERATIONS,
    INDIVIDUALS,
    POPULATION,
    RANDOM,
    SCENARIOS,
    STUDIES,
    Printed,
    place_of,
)
from engine.paper import Study as StudyRow
from engine.search.statistics import Interval, OddsRatio, clopper_pearson, fisher
from engine.study.comparisons import (
    LEVEL,
    MEASURES,
    MEDIUM,
    NAMED_FIRST,
    PRIMARY,
    Comparison,
    Measure,
    compare_all,
    ranked,
    spread,
)
from engine.study.plan import BASELINE, RUNS, Plan, Subject
from engine.study.run_records import RunRecord

# -- our numbers compared with the paper's -----------------------------------------------------------------------------

METHODS = ("ga", "random")
CENTIMETRES = 100.0


@dataclass(frozen=True)
class Beside:
    """One metric on one scenario: medians over the study's runs and the paper's single run, for both methods."""

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
        """Return True if both agree on which of the two methods has the larger value."""
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
"""The paper's printed numbers for each scenario, by the name of the measure."""


def beside_paper(plan: Plan, records: Sequence[RunRecord]) -> tuple[Beside, ...]:
    """Return a row for each of the paper's scenarios and metrics that the study repeats; () unless it has both methods
    and the paper's budget.
    """
    search = plan.subjects[0].config.search
    budget = search.generations, search.population, search.rollouts
    if budget != (GENERATIONS, POPULATION, 1) or not set(METHODS) <= set(plan.methods):
        return ()
    return tuple(
        _beside(plan, records, number, place, measure)
        for number, subject in enumerate(plan.subjects)
        if (place := _place(subject)) is not None
        for measure in MEASURES
        if measure.name in _PRINTED
    )


def _place(subject: Subject) -> int | None:
    return place_of(subject.name, subject.program.space.names)


def _beside(plan: Plan, records: Sequence[RunRecord], number: int, place: int, measure: Measure) -> Beside:
    name = plan.subjects[number].name
    ga, random = (spread(ranked(records, number, method, measure)).median for method in METHODS)
    printed = _PRINTED[measure.name]
    return Beside(SCENARIOS[place], name, measure, ga, random, printed(GA, place), printed(RANDOM, place))


REPRODUCED = 0.3
"""Maximum `log_error` of a metric that the study reproduces: a factor of 1.35."""


def log_error(rows: Sequence[Beside]) -> float:
    """Return the mean absolute difference of the logarithms of our ratios and the paper's; infinite if one has none."""
    ratios = np.array([(row.ratio, row.paper_ratio) for row in rows])
    if not (np.isfinite(ratios).all() and (ratios > 0.0).all()):
        return float("inf")
    return float(np.abs(np.diff(np.log(ratios), axis=1)).mean())


def studies(plan: Plan, records: Sequence[RunRecord]) -> tuple[StudyRow, ...]:
    """Return the paper's table of studies with this study as its last row."""
    return (*STUDIES, own_row(plan, records))


@dataclass(frozen=True)
class Totals:
    """Sums over all finished runs of one method."""

    method: str
    individuals: int
    valid: int
    collisions: int


@dataclass(frozen=True)
class OwnTotals:
    """Sums over all finished runs of a study."""

    simulations: int
    seconds_per_simulation: float
    """Seconds per simulation of one worker; NaN without a simulation."""
    methods: tuple[Totals, ...]
    """Totals of each method, the paper's own method first, as in the paper."""


def own_totals(plan: Plan, records: Sequence[RunRecord]) -> OwnTotals:
    """Return the sums over the finished runs."""
    simulations = sum(record.figures.simulations.runs for record in records)
    seconds = sum(record.seconds for record in records)
    methods = sorted(plan.methods, key=lambda name: name != METHODS[0])
    return OwnTotals(simulations, _ratio(seconds, simulations), tuple(_totals(method, records) for method in methods))


def _totals(method: str, records: Sequence[RunRecord]) -> Totals:
    runs = [record.figures.individuals for record in records if record.address.method == method]
    sums = (sum(getattr(figures, field) for figures in runs) for field in ("individuals", "valid", "nc"))
    return Totals(method, *sums)


def own_row(plan: Plan, records: Sequence[RunRecord]) -> StudyRow:
    """Return the row of this study in the paper's table. Shares are of individuals, as in the paper."""
    own = own_totals(plan, records)

    def share(part: int, of: int) -> str:
        return f"{100.0 * part / of:.1f} %" if of else "none"

    named = [("GA" if each.method == METHODS[0] else each.method, each) for each in own.methods]
    return StudyRow(
        name="this study",
        cases=f"{own.simulations:,}",
        seconds=f"{own.seconds_per_simulation:.2g}" if own.simulations else "none",
        collisions=", ".join(
            f"{name} {each.collisions:,} ({share(each.collisions, each.individuals)})" for name, each in named
        ),
        valid=", ".join(f"{name} {share(each.valid, each.individuals)}" for name, each in named),
        metrics="RL, NC, MD, avoidable collisions, kinds",
    )


# -- rates of random sampling ------------------------------------------------------------------------------------------

NOTHING = OddsRatio(float("nan"), float("nan"))


@dataclass(frozen=True)
class RandomRates:
    """Outcome rates of uniformly random genomes of a scenario, over all runs."""

    scenario: str
    individuals: int
    valid: int
    valid_rate: Interval
    """95 %, Clopper and Pearson."""
    collisions: int
    collision_rate: Interval
    """Collisions among valid individuals, 95 %."""
    against_paper: OddsRatio
    """Collisions among valid individuals: odds of the study to those of the paper; NaN for a scenario that the paper
    lacks.
    """


def random_rates(plan: Plan, records: Sequence[RunRecord]) -> tuple[RandomRates, ...]:
    """Return one row per scenario; () if the study has no random sampling."""
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
        against_paper=_against_paper(plan.subjects[number], collisions, valid),
    )


def _against_paper(subject: Subject, collisions: int, valid: int) -> OddsRatio:
    if (place := _place(subject)) is None:
        return NOTHING
    return fisher((collisions, RANDOM.nc[place]), (valid, INDIVIDUALS - RANDOM.nis[place]))


# -- findings ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Findings:
    """Findings from the finished runs of a study."""

    comparisons: tuple[Comparison, ...]
    rates: tuple[RandomRates, ...]
    beside: tuple[Beside, ...]
    studies: tuple[StudyRow, ...]
    verdict: tuple[str, ...]
    """Sentences."""


def findings(plan: Plan, records: Sequence[RunRecord]) -> Findings:
    comparisons = compare_all(plan, records)
    return Findings(
        comparisons=comparisons,
        rates=random_rates(plan, records),
        beside=beside_paper(plan, records),
        studies=studies(plan, records),
        verdict=verdict(plan, comparisons),
    )


def verdict(plan: Plan, comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    """Return the claims that the study supports, with their reservations."""
    if not comparisons:
        return ("only one method: there is nothing to compare it with",)
    sentences = [_about(plan, comparisons, method) for method in plan.contenders]
    if plan.shares_draws:
        sentences.append("scenarios share their random numbers: they are not independent repetitions of one another")
    runs = min(row.runs for row in comparisons if row.measure is PRIMARY)
    if runs < RUNS:
        sentences.append(f"with {counted(runs, 'run')} of each this is at most a hint; a claim needs {RUNS}")
    return tuple(sentences)


def _about(plan: Plan, comparisons: Sequence[Comparison], method: str) -> str:
    """Return the sentence on one contender, by the primary outcomes."""
    tallies = "; ".join(f"{measure.name} {_tally(method, comparisons, measure)}" for measure in NAMED_FIRST)
    return f"{method} against {plan.baseline}: {tallies}"


def _tally(method: str, comparisons: Sequence[Comparison], measure: Measure) -> str:
    """Return `more in 5 of 6 scenarios, fewer in 1`, which counts significant differences of at least medium size."""
    rows = [row for row in comparisons if row.method == method and row.measure.name == measure.name]
    more, fewer = sum(row.beats for row in rows), sum(row.loses for row in rows)
    scenarios = counted(len(rows), "scenario")
    parts = [f"{word} in {count}" for word, count in (("more", more), ("fewer", fewer)) if count]
    if not all(row.decided for row in rows):
        return f"undecided in {scenarios}"
    if not parts:
        return f"no clear difference in {scenarios}"
    return f"{', '.join(parts)} of {scenarios}"


RULE = (
    f"beats: at least {RUNS} runs of each, better median, Holm-corrected Mann-Whitney p < {LEVEL:g}, A12 > {MEDIUM:g}; "
    "A12: how often a run of the method is better than one of the baseline; one run is one observation; 95 %: "
    "bootstrap, never narrower than Newcombe's (2006), which has a width even where every run of one is better; a run "
    "without a number, such as one that never collided, ranks last"
)
"""Definitions of the words of a verdict."""
FAMILIES = (
    "avoidable collisions and their kinds, colliding genomes (yield: they may differ in a single bit) and kinds "
    "(variety) were named first and are one family of tests; RL, MDG, MDEC and NIS are the second; everything else is "
    "exploratory, each way of counting is its own family, and picking one of them afterwards is not corrected for"
)
"""Tests that may support a claim."""
