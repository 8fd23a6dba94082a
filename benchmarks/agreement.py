"""Do the two hosts agree? `python -m benchmarks.agreement [--scenes 10000] [FILES...]` (default: the six examples).

Random scenes of every file run in the batch host and in the pymunk world. States before first contact must lie within
1e-9 m, and both must always agree on whether, when and between whom there is contact. Exit code 1 if they do not.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cortex_dsl.session import Scenario, load
from engine import batch, world
from engine.genomes import uniform_genomes
from engine.sampling import sample
from engine.scenes import Scenes
from engine.search.assessment import take
from engine.streams import key_rows
from engine.vocabulary import Method, State

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scn"))
TOLERANCE = 1e-9
POSE = [State.X, State.Y, State.HEADING]


class Agreement(NamedTuple):
    """How far the hosts are apart on some scenes of one file."""

    scenes: int
    collisions: int
    flags_differ: int
    metrics_differ: float
    """Largest difference of MD, MS, D_MS, TTC_MS [SI]."""
    states_differ: float
    """Largest difference of a position [m] or heading [rad] before first contact."""


def compare(scenario: Scenario, count: int, seed: int = 0) -> Agreement:
    """Run `count` valid random scenes in both hosts, without the aftermath of contacts."""
    contact = replace(scenario.config.contact, aftermath=0.0)
    scenario = replace(scenario, config=replace(scenario.config, contact=contact))
    scenes = _valid_scenes(scenario, count, seed)
    program, config = scenario.program, scenario.config
    fast, slow = batch.simulate(program, scenes, config.simulation), world.simulate(program, scenes, config)
    flags = (fast.collided != slow.collided) | (fast.end_reason != slow.end_reason) | (fast.steps != slow.steps)
    flags |= (fast.contact_actors != slow.contact_actors).any(axis=1)
    metrics = [
        _largest(getattr(fast, name), getattr(slow, name))
        for name in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms", "end_time")
    ]
    states = [_states_apart(scenario, scenes, row) for row in range(len(scenes))]
    return Agreement(len(scenes), int(fast.collided.sum()), int(flags.sum()), max(metrics), max(states, default=0.0))


def _valid_scenes(scenario: Scenario, count: int, seed: int) -> Scenes:
    keys = key_rows(seed, Method.SAMPLE, 0, 0, range(2 * count + 50))
    genomes = uniform_genomes(scenario.program.space, keys)
    scenes = sample(scenario.program, genomes, keys, scenario.config.simulation)
    return take(scenes, np.flatnonzero(scenes.valid)[:count])


def _largest(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference; equal infinities and two NaN do not differ."""
    same = (one == other) | (np.isnan(one) & np.isnan(other))
    return float(np.max(np.abs(one[~same] - other[~same]), initial=0.0))


def _states_apart(scenario: Scenario, scenes: Scenes, row: int) -> float:
    planned = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation).states
    lived = world.run(scenario.program, scenes, row, scenario.config).trajectory.states
    samples = min(len(planned), len(lived))
    return float(np.abs(planned[:samples][..., POSE] - lived[:samples][..., POSE]).max(initial=0.0))


def main() -> int:
    """Compare, print a line for each file, and fail if any disagrees."""
    parser = argparse.ArgumentParser(description="Compare the batch host with the pymunk world.")
    parser.add_argument("files", nargs="*", type=Path, default=EXAMPLES)
    parser.add_argument("--scenes", type=int, default=10_000, help="in all, shared by the files")
    arguments = parser.parse_args()
    agree = True
    for file in arguments.files:
        found = compare(load(file), -(-arguments.scenes // len(arguments.files)))
        agree &= found.flags_differ == 0 and found.states_differ <= TOLERANCE
        print(
            f"{file.stem:26} {found.scenes:6} scenes, {found.collisions:5} collisions; flags differ in "
            f"{found.flags_differ}, states by at most {found.states_differ:.1e}, metrics by {found.metrics_differ:.1e}"
        )
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
