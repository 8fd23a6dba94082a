"""Two cars on a straight road, and what our kernels say of them: for CommonRoad-CriMe to say the same.

CriMe takes a direction of exactly east for an unknown one, and shifts outlines along x and y at once whatever the
direction: so the road leads a thousandth of a radian off east, where neither shows. It rounds to two decimals.
"""

import json
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.validation.items import Item
from engine.kernels.conflict import Snapshot, time_gap, time_to_collision
from engine.kernels.evasion import braking_needed, swerving_needed, time_to_brake
from engine.kernels.geometry import Box
from engine.kernels.pair import Rate
from engine.kernels.safe_distance import worst_time_to_collision
from engine.metrics.bodies import usual_body
from engine.metrics.values import change_of_velocity
from engine.vocabulary import ActorKind

LENGTH, WIDTH = 4.0, 2.0
STEP = 0.05
SAMPLES = 100
TAU = 2.0
"""CriMe's threshold of TET and TIT [s]."""
BRAKING, LONGITUDINAL, LATERAL = 8.0, 11.5, 8.0
"""What CriMe's default vehicle reaches [m/s^2]: braking to a stop; the limits in BTN and WTTC; in STN."""
GAPS, SPEEDS = (8.0, 16.0, 30.0, 45.0), ((15.0, 10.0), (12.0, 0.0), (8.0, 6.0), (20.0, 5.0))


def encounters(folder: Path) -> Iterator[Item]:
    """A file for each."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, (gap, (mine, theirs)) in enumerate(product(GAPS, SPEEDS)):
        file = folder / f"encounter{number:02}.json"
        scene = {"gap": gap, "ego": mine, "other": theirs, "length": LENGTH, "width": WIDTH}
        told = {"scene": scene, "step": STEP, "samples": SAMPLES, "expected": expected(gap, mine, theirs)}
        file.write_text(json.dumps(told, indent=1), encoding="utf-8")
        yield Item("encounter", file)


def at(gap: float, mine: float, theirs: float, time: float = 0.0, length: float = LENGTH) -> Snapshot:
    """The ego and the other ahead of it, after both kept their speeds for a time."""
    x, other = mine * time, gap + LENGTH + theirs * time
    return Snapshot(
        Box(x, 0.0, 0.0, length, WIDTH), Box(other, 0.0, 0.0, length, WIDTH), Rate(mine, 0.0), Rate(theirs, 0.0)
    )


def expected(gap: float, mine: float, theirs: float) -> dict[str, float]:
    """By CriMe's names for them. Its circles are of a third of the outline; TET and TIT leave out the last sample."""
    now, car = at(gap, mine, theirs), usual_body(ActorKind.CAR, LENGTH, WIDTH)
    times = [time_to_collision(at(gap, mine, theirs, STEP * k)) for k in range(SAMPLES - 1)]
    below = np.array([ttc for ttc, k in zip(times, range(len(times)), strict=True) if gap > (mine - theirs) * STEP * k])
    below = below[below <= TAU + 1e-9]
    found = {
        "TTC": time_to_collision(now),
        "WTTC": worst_time_to_collision(at(gap, mine, theirs, length=LENGTH / 3), 2 * LONGITUDINAL),
        "TET": len(below) * STEP,
        "TIT": float((TAU - below).sum()) * STEP,
        "ALongReq": -braking_needed(now),
        "BTN": braking_needed(now) / LONGITUDINAL,
        "ALatReq": swerving_needed(now),
        "STN": swerving_needed(now) / LATERAL,
    }
    seen = STEP * (SAMPLES - 2)  # CriMe looks no farther ahead
    if time_gap(now) < seen:
        found["THW"] = time_gap(now)
    if times[0] < seen:
        found["TTB"] = time_to_brake(now, BRAKING)
    return found | ({"DeltaV": change_of_velocity(now, car, car)} if theirs == 0.0 else {})
