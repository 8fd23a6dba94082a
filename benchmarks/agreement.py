"""Do the two hosts agree? `python -m benchmarks.agreement [--scenes 10000] [FILES...]`

By default the six examples and the scenarios of `tests/agreement`, which use every construct of the language.

Random scenes of every file run in the batch host and in the pymunk world. States before first contact must lie within
1e-9 m, and both must always agree on whether, when and between whom there is contact. Exit code 1 if they do not.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cortex_dsl import Scenario, load
from engine import batch, world
from engine.assessment import take
from engine.metrics import recorded
from engine.sampling import sample, uniform_genomes
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Method, State, Verdict

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.scn"))
CONSTRUCTS = sorted((ROOT / "tests" / "agreement").glob("*.scn"))
"""Scenarios that use everything else that the language has."""
TOLERANCE = 1e-9
POSE = [State.X, State.Y, State.HEADING, State.PRESENT]


class Agreement(NamedTuple):
    """How far the hosts are apart on some scenes of one file."""

    scenes: int
    collisions: int
    aborted: int
    """Runs that a requirement on the run made invalid."""
    ends: int
    """In how many ways the runs ended: reason and rule."""
    flags_differ: int
    """Scenes in which verdict, reason, rule, number of steps or contact are not the same."""
    metrics_differ: float
    """Largest difference of MD, MS, D_MS, TTC_MS and of what the file's objectives come to [SI]."""
    states_differ: float
    """Largest difference of a position [m], heading [rad], presence or recorded value before first contact."""


def compare(scenario: Scenario, count: int, seed: int = 0) -> Agreement:
    """Run `count` valid random scenes in both hosts, without the aftermath of contacts."""
    contact = replace(scenario.config.contact, aftermath=0.0)
    scenario = replace(scenario, config=replace(scenario.config, contact=contact))
    return held(scenario, _valid_scenes(scenario, count, seed))


def held(scenario: Scenario, scenes: Scenes) -> Agreement:
    """Run scenes, all valid, in both hosts."""
    program, config = scenario.program, scenario.config
    fast, slow = (
        batch.simulate(program, scenes, config.simulation, contact=config.contact),
        world.simulate(program, scenes, config),
    )
    flags = (fast.contact_actors != slow.contact_actors).any(axis=1)
    for name in ("verdict", "collided", "end_reason", "end_rule", "steps"):
        flags |= getattr(fast, name) != getattr(slow, name)
    metrics = [
        _largest(getattr(fast, name), getattr(slow, name))
        for name in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms", "end_time", "sought", "broken")
    ]
    states = [_states_apart(scenario, scenes, row) for row in range(len(scenes))]
    return Agreement(
        scenes=len(scenes),
        collisions=int(fast.collided.sum()),
        aborted=int((fast.verdict == Verdict.ABORTED).sum()),
        ends=len(set(zip(fast.end_reason.tolist(), fast.end_rule.tolist(), strict=True))),
        flags_differ=int(flags.sum()),
        metrics_differ=max(metrics),
        states_differ=max(states, default=0.0),
    )


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
    planned = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation, scenario.config.contact)
    lived = world.run(scenario.program, scenes, row, scenario.config)
    samples = min(len(planned.states), len(lived.trajectory.states))
    states = planned.states[:samples][..., POSE], lived.trajectory.states[:samples][..., POSE]
    records = zip(recorded(scenario.program, planned), lived.records, strict=True)
    return max([_largest(*states), *(_largest(one.values, other.values) for one, other in records)])


def main() -> int:
    """Compare, print a line for each file, and fail if any disagrees."""
    parser = argparse.ArgumentParser(description="Compare the batch host with the pymunk world.")
    parser.add_argument("files", nargs="*", type=Path, default=[*EXAMPLES, *CONSTRUCTS])
    parser.add_argument("--scenes", type=int, default=10_000, help="in all, shared by the files")
    arguments = parser.parse_args()
    agree = True
    for file in arguments.files:
        found = compare(load(file), -(-arguments.scenes // len(arguments.files)))
        agree &= found.flags_differ == 0 and found.states_differ <= TOLERANCE
        print(
            f"{file.stem:26} {found.scenes:6} scenes, {found.collisions:5} collisions, {found.aborted:5} aborted;"
            f" flags differ in {found.flags_differ}, states by at most {found.states_differ:.1e},"
            f" metrics by {found.metrics_differ:.1e}"
        )
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
