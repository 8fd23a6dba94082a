"""Does continuous contact search miss a collision? Random crossing pairs, held against sampling every 0.1 ms.

    python benchmarks/missed_contacts.py --pairs 10000 [--json]

Both use the engine's motion between samples: centres and headings move linearly within a step of 0.05 s. `missed` and
`false` must be 0; `sampled_at_steps` counts what looking at the steps alone would have missed.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.kernels.approach import TOUCH, first_contact
from engine.kernels.geometry import Box, box_distance

STEP = 0.05
"""[s]"""
STEPS = 80
SAMPLES_A_STEP = 500
"""0.1 ms apart."""


@dataclass(frozen=True)
class Contacts:
    """What became of the pairs."""

    pairs: int
    contacts: int
    """Pairs that overlap at one of the fine samples."""
    missed: int
    """Of these, without contact or with a later one in the continuous search."""
    false: int
    """Contacts found where no fine sample is nearer than what can happen in between."""
    sampled_at_steps: int
    """Of the contacts, those that do not overlap at any end of a step."""
    seconds: float


def missed_contacts(pairs: int, seed: int = 0) -> Contacts:
    """Compare the two searches on random pairs of cars whose arcs cross at about the same time."""
    start = time.perf_counter()
    poses = crossing_poses(pairs, np.random.default_rng(seed))
    found, sampled, nearest, at_steps = _search_all(poses, 4.508, 1.610)
    touches = sampled >= 0.0
    early = found <= sampled + 1.0 / SAMPLES_A_STEP
    # Within half a sample nothing moves nearer than 0.05 ms at 60 m/s.
    false = (found >= 0.0) & (nearest > TOUCH + 0.003)
    return Contacts(
        pairs=pairs,
        contacts=int(touches.sum()),
        missed=int((touches & ~((found >= 0.0) & early)).sum()),
        false=int(false.sum()),
        sampled_at_steps=int((touches & ~at_steps).sum()),
        seconds=time.perf_counter() - start,
    )


def crossing_poses(pairs: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """(pairs, steps + 1, 2, 3): x, y, heading of two cars on arcs that pass near the origin at mid-time."""
    time_left = (np.arange(STEPS + 1) - STEPS / 2) * STEP
    shape = (pairs, 1, 2)
    speed, turn = rng.uniform(1.0, 25.0, shape), rng.normal(0.0, 0.25, shape)
    heading = rng.uniform(-np.pi, np.pi, shape) + turn * time_left[:, None]
    chord = speed * STEP
    x, y = (np.cumsum(chord * trig(heading), axis=1) for trig in (np.cos, np.sin))
    middle = STEPS // 2
    x += rng.uniform(-3.0, 3.0, shape) - x[:, middle : middle + 1]
    y += rng.uniform(-3.0, 3.0, shape) - y[:, middle : middle + 1]
    return np.stack([x, y, heading], axis=-1)


@njit
def _search_all(poses, length, width):
    """Per pair, in steps: first contact of the continuous search and of fine sampling (-1: none); then the least
    sampled distance, and whether the outlines overlap at the end of a step.
    """
    pairs = poses.shape[0]
    found, sampled = np.full(pairs, -1.0), np.full(pairs, -1.0)
    nearest, at_steps = np.full(pairs, np.inf), np.zeros(pairs, np.bool_)
    reach = np.hypot(length, width)
    for pair in range(pairs):
        for k in range(poses.shape[1] - 1):
            a0, a1 = _box(poses[pair, k, 0], length, width), _box(poses[pair, k + 1, 0], length, width)
            b0, b1 = _box(poses[pair, k, 1], length, width), _box(poses[pair, k + 1, 1], length, width)
            if found[pair] < 0.0:
                part = first_contact(a0, a1, b0, b1)
                if part >= 0.0:
                    found[pair] = k + part
            far = np.hypot(b0.x - a0.x, b0.y - a0.y)
            way = np.hypot(a1.x - a0.x, a1.y - a0.y) + np.hypot(b1.x - b0.x, b1.y - b0.y)
            if far > reach + way + 0.1 or sampled[pair] >= 0.0:
                continue
            if box_distance(a1, b1) == 0.0:
                at_steps[pair] = True
            for sample in range(SAMPLES_A_STEP + 1):
                part = sample / SAMPLES_A_STEP
                distance = box_distance(_between(a0, a1, part), _between(b0, b1, part))
                nearest[pair] = min(nearest[pair], distance)
                if distance == 0.0:
                    sampled[pair] = k + part
                    break
    return found, sampled, nearest, at_steps


@njit
def _box(pose, length, width):
    return Box(pose[0], pose[1], pose[2], length, width)


@njit
def _between(start, end, part):
    return Box(
        start.x + part * (end.x - start.x),
        start.y + part * (end.y - start.y),
        start.heading + part * (end.heading - start.heading),
        start.length,
        start.width,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    result = asdict(missed_contacts(arguments.pairs, arguments.seed))
    print(json.dumps(result) if arguments.json else "\n".join(f"{name:18} {value}" for name, value in result.items()))


if __name__ == "__main__":
    main()
