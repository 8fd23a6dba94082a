"""Bounds on the results of a run: `min_distance >= 1`, in SI units.

A result is a row of `engine.outcomes` that is a number, or of `engine.judged`. A result of several pairs or actors must
keep the bound for each of them; a result that does not exist in a run (NaN) keeps every bound. `delta_v` is 0 in a run
without a contact of the ego, in which its velocity does not change by one.
"""

import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import IntEnum
from types import MappingProxyType

import numpy as np

from engine.batch import simulate
from engine.config import Config
from engine.frozen import frozen
from engine.judged import NAMED_RESULTS, Judged, Objective, Reading
from engine.outcomes import RESULTS, Outcomes, Per, Result, Retention
from engine.program import Program
from engine.risk import PROFILES, assess
from engine.scenes import Scenes
from engine.tables import Bools, Floats, ObjectiveTables, Segment, Size
from engine.vocabulary import Reducer, Sense, Verdict

COMPARISONS: Mapping[str, Callable[[Floats, float], Bools]] = MappingProxyType(
    {"<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt}
)
"""Relations of a bound, the longer ones first."""
OF_RISK = ("score", "continuous")
"""Results that `engine.risk` computes from the others."""


def _is_bounded(row: Result) -> bool:
    """Return True for a number or a truth of a run; numbers of actors, rules and words are none."""
    counted = row.name in (*OF_RISK, "attempts") or row.name in Outcomes.__dataclass_fields__
    return counted and not row.parts and not issubclass(row.kind, IntEnum) and row.name != "end_rule"


UNITS: Mapping[str, str] = MappingProxyType(
    {
        **{row.name: row.unit for row in RESULTS if _is_bounded(row)},
        **{row.name: row.unit for row in NAMED_RESULTS},
    }
)
"""SI unit words of all results that may have a bound."""
_ROWS = {row.name: row for row in RESULTS}
_COMPUTED = frozenset(row.name for row in NAMED_RESULTS) - _ROWS.keys()
"""Results of `engine.judged` that no array of `Outcomes` holds."""


@frozen
class Bound:
    """A bound on one result."""

    name: str
    comparison: str
    """A row of `COMPARISONS`."""
    limit: float
    """SI units."""
    text: str
    """The bound as its author wrote it."""
    unit: str = ""
    """Unit in which values are shown."""
    scale: float = 1.0
    """SI value = shown value * scale."""

    def holds(self, values: Floats) -> Bools:
        """Return True for values that keep the bound; NaN does."""
        return np.isnan(values) | COMPARISONS[self.comparison](values, self.limit)

    def worst(self, values: Floats) -> Floats:
        """Return (n,) the value of each run that is farthest on the wrong side; NaN if it has none."""
        wrong = -np.inf if self.comparison.startswith("<") else np.inf
        filled = np.where(np.isnan(values), wrong, values)
        farthest = (np.max if wrong < 0.0 else np.min)(filled, axis=1, initial=wrong)
        return np.where(np.isnan(values).all(axis=1), np.nan, farthest)


def bounded_values(bound: Bound, program: Program, scenes: Scenes, outcomes: Outcomes, config: Config) -> Floats:
    """Return (n,) the value of each run that the bound judges; NaN for an invalid run."""
    if bound.name in _COMPUTED:
        values = _computed(bound.name, program, scenes, config)
        values = np.where(outcomes.collided | (bound.name != "delta_v"), values, 0.0)
    elif bound.name in OF_RISK:
        values = np.asarray(getattr(assess(outcomes, PROFILES["paper"]), bound.name), dtype=np.float64)
    else:
        values = np.asarray(getattr(outcomes if hasattr(outcomes, bound.name) else scenes, bound.name), np.float64)
    row = _ROWS.get(bound.name)
    if row is not None and row.per is Per.ACTOR and row.retention is Retention.EGO:
        values = values[:, :1]
    found = bound.worst(values.reshape(len(values), -1))
    return np.where(outcomes.verdict == Verdict.VALID, found, np.nan)


def _computed(name: str, program: Program, scenes: Scenes, config: Config) -> Floats:
    """Return (n,) a result that runs compute only if an objective of the file names it: of the runs once more."""
    if len(program.actors) == 1:
        return np.full(len(scenes), np.nan)
    unit = UNITS[name]
    first, templates = int(program.code.sizes[Size.LOCALS]), len(program.code.rule_segment)
    segment = np.zeros((templates, 1, len(Segment)), np.int32)
    segment[:, :, Segment.RESULT] = first
    sizes = program.code.sizes.copy()
    sizes[Size.STEP_REGISTERS] = max(int(sizes[Size.STEP_REGISTERS]), first + 1)
    judged = Judged(
        (Objective(name, Sense.MAXIMIZE, unit, 0),),
        (Reading(Reducer.RESULT, result=name),),
        ObjectiveTables(np.full(1, -1, np.int32), segment),
    )
    asking = replace(program, judged=judged, code=program.code._replace(sizes=sizes))
    return simulate(asking, scenes, config.simulation, config.search.jobs, config.contact).sought[:, 0]
