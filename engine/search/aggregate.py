"""How the k rollouts of one genome become one number: mean, max or a quantile over the valid ones."""

import re

import numpy as np

from engine.scenes import Bools
from engine.tables import Floats


def aggregate(values: Floats, valid: Bools, how: str) -> Floats:
    """(n,) from (n, k): `mean`, `max` or `qNN` over the valid rollouts, NaN where none is.

    A quantile interpolates linearly between order statistics (Hyndman and Fan 1996, type 7).
    """
    level = quantile_level(how)
    result = np.full(len(values), np.nan)
    rows = valid.any(axis=1)
    known = np.where(valid[rows], values[rows], np.nan)
    if values.shape[1] == 1:
        result[rows] = known[:, 0]
    elif how == "mean":
        result[rows] = np.nanmean(known, axis=1)
    elif rows.any():
        result[rows] = np.nanmax(known, axis=1) if level is None else np.nanquantile(known, level, axis=1)
    return result


def quantile_level(how: str) -> float | None:
    """0.9 for `q90`, None for `mean` and `max`; ValueError for anything else."""
    if how in ("mean", "max"):
        return None
    match = re.fullmatch(r"q(\d+(?:\.\d+)?)", how)
    if match is None or not 0.0 <= float(match[1]) <= 100.0:
        raise ValueError(f"aggregate: expected mean, max or a quantile such as q90, got `{how}`")
    return float(match[1]) / 100.0
