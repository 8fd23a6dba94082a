"""Numbers of a study as people read them: medians, also where the median run has no number; and how the study differs
from the paper.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from cortex_dsl.report.findings.failures import pace_text
from cortex_dsl.report.findings.readable import counted, fixed, percent, ratio, whole
from engine.study.comparisons import FIRST, MEASURES, NAMED_FIRST, PRIMARY, Comparison, Measure, Spread
from engine.study.database import Study
from engine.study.plan import RUNS, Plan
from engine.study.run_records import RunRecord, curve_of
from engine.study.study_files import summary
from engine.study.verdict import REPRODUCED, Beside, Findings, log_error
from engine.tables import Floats


def value_text(value: float, row: Comparison) -> str:
    """A median or quartile; `> 3,000` for the first collision of a run without any, `none` for another number."""
    if math.isinf(value):
        return f"> {whole(row.budget)}" if row.measure.name == FIRST else "none"
    return fixed(value, row.measure.decimals)


def quartiles(spread: Spread, row: Comparison) -> tuple[str, str]:
    """The ends of the middle half."""
    return value_text(spread.quartiles.low, row), value_text(spread.quartiles.high, row)


def p_text(p: float) -> str:
    """Four decimals, and no pretence of more."""
    return "< 0.0001" if p < 1e-4 else fixed(p, 4)


def missing_lines(rows: "tuple[Comparison, ...] | list[Comparison]") -> list[str]:
    """`first collision: ga: 22 of 30 never collided`, for each row where runs have no number."""
    return [f"{row.title}: {row.missing}; such runs rank last" for row in rows if row.missing]


def differences(rows: Sequence[Beside]) -> list[str]:
    """Return lines on differences between our results and the paper's; the first lines summarize them."""
    against = [row for row in rows if not row.same_direction]
    windows = [row for row in rows if row.measure.name.startswith("NIS")]
    others = [row for row in rows if row not in windows]
    same = sum(row.same_direction for row in others)
    alike = sum(row.same_direction for row in windows)
    lines = [
        f"{same} of {len(others)} comparisons of risk, collisions and distances point the same way as in the paper",
        f"{alike} of {len(windows)} of NIS do",
        *(f"opposite direction in {row.letter}: {row.measure.name}" for row in against),
    ]
    reproduced: dict[bool, list[str]] = {True: [], False: []}
    for name in dict.fromkeys(row.measure.name for row in rows):
        of_measure = [row for row in rows if row.measure.name == name]
        ours, paper = (_range([getattr(row, field) for row in of_measure]) for field in _RATIOS)
        error = log_error(of_measure)
        reproduced[error <= REPRODUCED].append(name)
        about = f"mean error {fixed(error, 2)}" if math.isfinite(error) else "one of them is 0"
        lines.append(f"{name}: ga / random is {ours} here, {paper} in the paper; {about}")
    lines.append(
        f"reproduced, mean absolute error of the logarithm of ga / random at most {REPRODUCED:g}: "
        f"{_several(reproduced[True])}; not reproduced: {_several(reproduced[False])}"
    )
    return lines


def _several(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


_RATIOS = ("ratio", "paper_ratio")


def _range(values: Sequence[float]) -> str:
    low, high = fixed(min(values), 2), fixed(max(values), 2)
    return low if low == high else f"{low} to {high}"


BOXED = (*(measure.name for measure in NAMED_FIRST), "failing cells", "RL", "MDG", "MDEC", "NIS")
"""Measures with box plots of their own."""


def measure_called(name: str) -> Measure:
    """The measure of a name in `BOXED`."""
    return next(measure for measure in MEASURES if measure.name == name)


def in_layout_of_paper(study: Study, found: Findings) -> tuple[int, ...]:
    """Return the rows of the plan that are scenarios of the paper, for plots in its layout; () for another study."""
    letters = {row.scenario: row.letter for row in found.beside}
    numbers = (k for k, subject in enumerate(study.plan.subjects) if subject.name in letters)
    return tuple(sorted(numbers, key=lambda k: letters[study.plan.subjects[k].name]))


def generation_values(study: Study, scenarios: Sequence[int], method: str, field: str) -> Floats:
    """Return (n,) the value of a metric in each generation of each of these scenarios, medians over the runs."""
    curves = (curve_of(study.plan, study.records, number, method, field).median for number in scenarios)
    return np.concatenate([curve[np.isfinite(curve)] for curve in curves])


def distinct_simulations(study: Study) -> int:
    """Return the number of distinct simulations of all runs."""
    return sum(record.figures.simulations.runs for record in study.records)


@dataclass(frozen=True)
class Yield:
    """Results of a method in all of its runs, per effort: a complement to figures that count individuals."""

    method: str
    valid: int
    """Valid simulations."""
    avoidable: int
    """Those with a collision that a competent driver avoids."""
    colliding: int
    """Those with any."""
    seconds: float

    @property
    def share(self) -> float:
        """Avoidable collisions per valid simulation; NaN without a valid simulation."""
        return self.avoidable / self.valid if self.valid else math.nan

    @property
    def rate(self) -> float:
        """Avoidable collisions per second; NaN without a duration."""
        return self.avoidable / self.seconds if self.seconds > 0.0 else math.nan

    @property
    def text(self) -> str:
        """Return `ga: 61 avoidable of 9,210 collisions in 12,000 valid simulations; …`."""
        counts = (
            f"{self.method}: {self.avoidable:,} avoidable of {counted(self.colliding, 'collision')} in "
            f"{self.valid:,} valid simulations"
        )
        if not self.avoidable:
            return counts
        return f"{counts}; avoidable {percent(self.share, 2)} of these, {pace_text(self.rate)} per second"


def yields(plan: Plan, records: Sequence[RunRecord]) -> tuple[Yield, ...]:
    """One row a method."""
    return tuple(_yield(method, records) for method in plan.methods)


def _yield(method: str, records: Sequence[RunRecord]) -> Yield:
    runs = [record for record in records if record.address.method == method]
    return Yield(
        method,
        sum(record.figures.simulations.valid_runs for record in runs),
        sum(int(record.figures.avoidable) for record in runs),
        sum(record.figures.simulations.colliding_runs for record in runs),
        sum(record.seconds for record in runs),
    )


def verdict_line(plan: Plan, comparisons: Sequence[Comparison]) -> str:
    """Return the verdict of a study in one line, by the primary outcome."""
    rows = [row for row in comparisons if row.measure is PRIMARY]
    if not rows:
        return "Nothing to compare: only one method"
    runs = min(row.runs for row in rows)
    if runs < RUNS:
        return f"Undecided: {counted(runs, 'run')}, {RUNS} are needed"
    better, worse = (
        [method for method in plan.contenders if any(getattr(row, field) for row in rows if row.method == method)]
        for field in ("beats", "loses")
    )
    reported = [
        f"{', '.join(methods)} {word} {PRIMARY.name} than {plan.baseline}"
        for methods, word in ((better, "more"), (worse, "fewer"))
        if methods
    ]
    return f"Decided: {'; '.join(reported)}" if reported else f"Decided: no clear difference from {plan.baseline}"


def yields_text(plan: Plan, records: Sequence[RunRecord]) -> Iterator[str]:
    """Return the text of each method with a valid simulation."""
    return (each.text for each in yields(plan, records) if each.valid)


def study_content(study: Study, found: Findings) -> dict[str, Any]:
    """Return the whole study as a document, with derived values."""
    return {
        **summary(study, found),
        "runs": study.plan.runs,
        "individuals": study.plan.individuals,
        "simulations": distinct_simulations(study),
        "yields": [
            {**asdict(each), "share": each.share, "per_second": each.rate} for each in yields(study.plan, study.records)
        ],
        "shares": [
            {
                "scenario": row.scenario,
                "valid": ratio(row.valid, row.individuals),
                "collision": ratio(row.collisions, row.valid),
            }
            for row in found.rates
        ],
        "missing": missing_lines(found.comparisons),
        "differences": differences(found.beside) if found.beside else [],
    }
