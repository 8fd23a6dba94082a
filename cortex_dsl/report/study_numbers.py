"""Numbers of a study as people read them: what the run in the middle has, also where it has none."""

import math

from cortex_dsl.report.numbers import fixed, whole
from engine.study.comparisons import FIRST, Comparison, Spread


def told(value: float, row: Comparison) -> str:
    """A median or quartile; `> 3,000` for the first collision of a run without any, `none` for another number."""
    if math.isinf(value):
        return f"> {whole(row.budget)}" if row.measure.name == FIRST else "none"
    return fixed(value, row.measure.decimals)


def quartiles(spread: Spread, row: Comparison) -> tuple[str, str]:
    """The ends of the middle half."""
    return told(spread.quartiles.low, row), told(spread.quartiles.high, row)


def p_text(p: float) -> str:
    """Four decimals, and no pretence of more."""
    return "< 0.0001" if p < 1e-4 else fixed(p, 4)


def missing_lines(rows: "tuple[Comparison, ...] | list[Comparison]") -> list[str]:
    """`first collision: ga: 22 of 30 never collided`, for each row where runs have no number."""
    return [f"{row.title}: {row.missing}; such runs rank last" for row in rows if row.missing]
