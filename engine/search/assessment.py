"""What became of simulations, as a campaign keeps it: verdict, counts, metrics and risk, one row a simulation.

`to_columns` and `from_columns` turn the rows into flat named columns, for the journal and for result files, and back.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from engine.scenes import Bools
from engine.tables import Floats, Ints

Table = TypeVar("Table")

RISK_PARTS = ("c", "md", "d_ms", "ttc_ms")
"""Columns of `Assessment.parts`."""


@dataclass(frozen=True)
class Assessment:
    """Row-aligned results; every array may carry more leading axes (a campaign has (individuals, rollouts)).

    Where a simulation was invalid or failed, floats are NaN, integers -1 and `collided` is False. SI units.
    """

    verdict: Ints
    """(n,) `Verdict`"""
    variant: Ints
    """(n,) the finite choices of the accepted attempt."""
    attempts: Ints
    """(n,) attempts that sampling took."""
    tested: Ints
    """(n, requirements): how often each requirement was tested …"""
    failed: Ints
    """(n, requirements): … and failed. Conditional on the earlier ones."""
    score: Ints
    """(n,) the integer risk, -1 invalid."""
    continuous: Floats
    """(n,) the continuous risk."""
    parts: Ints
    """(n, 4) what C, MD, D_MS and TTC_MS add to the score."""
    pair: Ints
    """(n,) the pair (ego, actor pair + 1) that decides the risk."""
    collided: Bools
    """(n,) the ego touched another actor."""
    end_reason: Ints
    """(n,) `EndReason`"""
    end_rule: Ints
    """(n,) index into `Program.rules`."""
    end_time: Floats
    """(n,) [s]"""
    min_distance: Floats
    """(n,) MD of the scene: the least over its pairs [m]."""
    min_distance_time: Floats
    """(n,) [s]"""
    max_closing_speed: Floats
    """(n,) MS of the deciding pair [m/s]."""
    max_closing_time: Floats
    """(n,) [s]"""
    distance_at_ms: Floats
    """(n,) D_MS of the deciding pair [m]."""
    ttc_at_ms: Floats
    """(n,) TTC_MS of the deciding pair [s]."""
    ego_speed: Floats
    """(n,) at the deciding pair's instant of MD, or of contact [m/s]; as the next four."""
    other_speed: Floats
    """(n,) [m/s]"""
    approach_angle: Floats
    """(n,) the other's heading seen from the ego's, -pi .. pi [rad]."""
    closing_speed: Floats
    """(n,) of the centres [m/s]."""
    side: Ints
    """(n,) `Side` of the ego on which the other is, -1 where there is none."""
    left_road_time: Floats
    """(n,) when the first actor left the road, NaN if none did [s]."""

    def __len__(self) -> int:
        return len(self.verdict)


Evaluate = Callable[[Floats, Ints], Assessment]
"""(genomes (n, d) in file units, stream keys (n, 6)) -> n rows. Row i may depend on row i of both alone."""


def map_arrays(table: Table, function: Callable[[Any], Any]) -> Table:
    """The same frozen table with every field (array or nested table) replaced by `function` of it."""
    return type(table)(**{field.name: function(getattr(table, field.name)) for field in fields(table)})  # type: ignore[arg-type]


def take(table: Table, rows: Any) -> Table:
    """Rows of every array: an index array, a mask or a slice."""
    return map_arrays(table, lambda value: value[rows] if isinstance(value, np.ndarray) else take(value, rows))


def concatenate(tables: Sequence[Table]) -> Table:
    """Tables of one kind under one another."""
    first = tables[0]
    columns = {}
    for field in fields(first):  # type: ignore[arg-type]
        parts = [getattr(table, field.name) for table in tables]
        columns[field.name] = np.concatenate(parts) if isinstance(parts[0], np.ndarray) else concatenate(parts)
    return type(first)(**columns)


# -- flat columns ------------------------------------------------------------------------------------------------------

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
