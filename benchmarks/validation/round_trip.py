"""The way back: what a file says when it is read again must score as the run did that it was written from."""

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.validation.items import Item

if TYPE_CHECKING:
    from engine.interchange import Recording
    from engine.outcomes import Outcomes
    from engine.risk import Risk

NEAR = 1e-6
"""Of metrics in SI units."""
METRICS = ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms", "end_time")


def round_trip(item: Item) -> list[str]:
    """Where a case that is read and measured again scores otherwise than it did."""
    assert item.case is not None
    from engine.interchange.measuring import measure

    case = item.case
    again = measure(_read(item.file, case.recording), case.profile)
    before = case.scenario.assess(case.outcomes, case.profile)
    return _other_metrics(case.outcomes, again.outcomes) + _other_risk(before, again.risk)


def _read(file: Path, case: "Recording") -> "Recording":
    """As `measure` reads it; beside the buildings of the case where the file is CSV, which has no place for them."""
    from engine.interchange.sources import read_recording

    read = read_recording(file).recording
    return replace(read, buildings=case.buildings) if file.suffix == ".csv" else read


def _other_metrics(before: "Outcomes", after: "Outcomes") -> list[str]:
    found = []
    if before.collided[0] != after.collided[0]:
        found.append(f"collided is {bool(after.collided[0])}, was {bool(before.collided[0])}")
    for name in METRICS:
        old, new = np.atleast_1d(getattr(before, name)[0]), np.atleast_1d(getattr(after, name)[0])
        if old.shape != new.shape:
            found.append(f"{name} is of {new.size} pairs, was of {old.size}")
        elif not np.allclose(new, old, rtol=0.0, atol=NEAR, equal_nan=True):
            off = np.nanmax(np.abs(new - old))
            found.append(f"{name} is off by {off:.3g}")
    return found


def _other_risk(before: "Risk", after: "Risk") -> list[str]:
    if before.score[0] != after.score[0]:
        return [f"the risk is {int(after.score[0])}, was {int(before.score[0])}"]
    if not math.isclose(before.continuous[0], after.continuous[0], abs_tol=NEAR):
        return [f"the continuous risk is {after.continuous[0]:.9g}, was {before.continuous[0]:.9g}"]
    return []
