"""Metrics over the generations: every run, their median and a band, as arrays for figures.

curve = curve_of(study.plan, study.records, 0, "ga", "rl")
curve.median, curve.band()              # (generations,)
smoothed(curve.median)                  # as the paper's figures
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.study.plan import Plan
from engine.study.records import FIELDS, RunRecord
from engine.tables import Floats

WINDOW, ORDER = 7, 2
"""Of the Savitzky-Golay filter; the paper names the filter, not its settings."""


@dataclass(frozen=True)
class Curve:
    """One field of `engine.search.figures.Figures` over the generations of all runs of a cell."""

    scenario: str
    method: str
    field: str
    values: Floats
    """(runs, generations), NaN where a generation has no such number."""

    @property
    def median(self) -> Floats:
        """(generations,) over the runs that have the number; NaN where none has."""
        return self.quantile(0.5)

    def band(self, low: float = 0.25, high: float = 0.75) -> tuple[Floats, Floats]:
        """Two quantiles over the runs, (generations,) each."""
        return self.quantile(low), self.quantile(high)

    def quantile(self, level: float) -> Floats:
        """(generations,)"""
        result = np.full(self.values.shape[1], np.nan)
        known = ~np.isnan(self.values).all(axis=0)
        if known.any():
            result[known] = np.nanquantile(self.values[:, known], level, axis=0)
        return result


def curve_of(
    plan: Plan,
    records: Sequence[RunRecord],
    scenario: int,
    method: str,
    field: str,
    by_simulation: bool = False,
) -> Curve:
    """The course of a field in one cell, over its finished runs.

    Raises:
        ValueError: no such field.
    """
    if field not in FIELDS:
        raise ValueError(f"field: `{field}` is none of {', '.join(FIELDS)}")
    chosen = [record.course for record in records if record.address[:2] == (scenario, method)]
    generations = plan.subjects[scenario].config.search.generations
    row = FIELDS.index(field)
    values = np.array([course[int(by_simulation), row] for course in chosen], dtype=np.float64)
    return Curve(plan.subjects[scenario].name, method, field, values.reshape(len(chosen), generations))


def smoothed(values: Floats, window: int = WINDOW, order: int = ORDER) -> Floats:
    """Each value replaced by that of a polynomial through its neighbours; short courses and gaps are left alone.

    Savitzky and Golay (1964), "Smoothing and differentiation of data by simplified least squares procedures".
    """
    if len(values) < window or np.isnan(values).any():
        return values
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(values, window, order), dtype=np.float64)
