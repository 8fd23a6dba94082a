"""Assessments as flat named columns, for the journal and for exports; and back."""

from typing import Any

import numpy as np

from engine.search.assessment import RISK_PARTS, Assessment
from engine.tables import Ints

INTEGERS = ("verdict", "variant", "attempts", "score", "pair", "collided", "end_reason", "end_rule", "side")
FLOATS = (
    "continuous",
    "end_time",
    "min_distance",
    "min_distance_time",
    "max_closing_speed",
    "max_closing_time",
    "distance_at_ms",
    "ttc_at_ms",
    "ego_speed",
    "other_speed",
    "approach_angle",
    "closing_speed",
    "left_road_time",
)
PARTS = tuple(f"risk_{part}" for part in RISK_PARTS)
SCALARS = (*INTEGERS, *PARTS, *FLOATS)
"""Every number of a simulation but the counts per requirement."""


def to_columns(runs: Assessment) -> dict[str, list[float | int]]:
    """Lists (n,) by the names of `SCALARS`, from arrays (n, …)."""
    columns = {name: getattr(runs, name).tolist() for name in FLOATS}
    columns |= {name: getattr(runs, name).astype(np.int64).tolist() for name in INTEGERS}
    columns |= {name: runs.parts[:, number].astype(np.int64).tolist() for number, name in enumerate(PARTS)}
    return {name: columns[name] for name in SCALARS}


def from_columns(columns: dict[str, list[float | int | None]], tested: Ints, failed: Ints) -> Assessment:
    """Inverse of `to_columns`; None is NaN."""
    arrays: dict[str, Any] = {name: np.array(columns[name], dtype=np.int32) for name in INTEGERS}
    arrays |= {name: np.array(columns[name], dtype=np.float64) for name in FLOATS}
    arrays["collided"] = arrays["collided"].astype(bool)
    return Assessment(
        tested=tested,
        failed=failed,
        parts=np.array([columns[name] for name in PARTS], dtype=np.int32).T.copy(),
        **arrays,
    )
