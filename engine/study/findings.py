"""Everything that a study says, computed from its records, and its verdict in plain words."""

from collections.abc import Sequence
from dataclasses import dataclass

from engine.paper.numbers import Study as StudyRow
from engine.study.against_paper import Beside, beside_paper, studies
from engine.study.comparisons import LEVEL, MEDIUM, Comparison, compare_all
from engine.study.measures import DISTINCT_FAILURES, PRIMARY, Measure
from engine.study.plan import RUNS, Plan
from engine.study.rates import RandomRates, random_rates
from engine.study.records import RunRecord


@dataclass(frozen=True)
class Findings:
    """What the finished runs of a study show."""

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
    """What may be claimed, and with how much caution."""
    if not comparisons:
        return ("one method alone: there is nothing to compare it with",)
    sentences = [_about(plan, comparisons, method) for method in plan.contenders]
    if plan.shares_draws:
        sentences.append("scenarios share their random numbers: they are no independent repetitions of one another")
    runs = min(row.runs for row in comparisons if row.measure is PRIMARY)
    if runs < RUNS:
        count = f"{runs} run{'' if runs == 1 else 's'}"
        sentences.append(f"with {count} of each this is a hint at most; a claim asks for {RUNS}")
    return tuple(sentences)


def _about(plan: Plan, comparisons: Sequence[Comparison], method: str) -> str:
    """One contender, by the primary outcome and by variety."""
    collisions, failures = (_tally(method, comparisons, measure) for measure in (PRIMARY, DISTINCT_FAILURES))
    return f"{method} against {plan.baseline}: {PRIMARY.name} {collisions}; {DISTINCT_FAILURES.name} {failures}"


def _tally(method: str, comparisons: Sequence[Comparison], measure: Measure) -> str:
    """`more in 5 of 6 scenarios, fewer in 1`, where each count is of differences that are sure and not small."""
    rows = [row for row in comparisons if row.method == method and row.measure.name == measure.name]
    more, fewer = sum(row.beats for row in rows), sum(row.loses for row in rows)
    scenarios = f"{len(rows)} scenario{'' if len(rows) == 1 else 's'}"
    parts = [f"{word} in {count}" for word, count in (("more", more), ("fewer", fewer)) if count]
    if not all(row.decided for row in rows):
        return f"undecided in {scenarios}"
    if not parts:
        return f"no clear difference in {scenarios}"
    return f"{', '.join(parts)} of {scenarios}"


RULE = (
    f"beats: at least {RUNS} runs of each, better median, Holm-corrected Mann-Whitney p < {LEVEL:g}, A12 > {MEDIUM:g}; "
    "A12: how often a run of the method is better than one of the baseline; one run is one observation; 95 %: "
    "bootstrap, and no narrower than Newcombe's (2006), which is no single point where every run of one is better; "
    "a run without a number, such as one that never collided, ranks last"
)
"""What the words of a verdict mean."""
FAMILIES = (
    "colliding genomes (yield: they differ in a bit) and distinct failures (variety) were named first and are one "
    "family of tests; RL, MDG, MDEC and NIS are the second; all else is exploratory, each way of counting a family of "
    "its own, and who picks one of them afterwards has not corrected for that"
)
"""Which tests may carry a claim."""
