"""What does --prune save? `python -m benchmarks.prune [--scenes 10000] [FILES...]` (default: the six examples).

For each file the same genomes are drawn with and without pruning: attempts for each valid scene, scenes valid, genomes
proved infeasible, and the time of both. The distribution of what is drawn is the same, which the tests check.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cortex_dsl import Scenario, load
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Method, Verdict

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scn"))


class Drawn(NamedTuple):
    """One way of drawing the scenes of a file."""

    attempts: float
    """For each valid scene."""
    valid: float
    infeasible: float
    """Share of all genomes."""
    seconds: float


def draw(scenario: Scenario, count: int, seed: int = 0, *, prune: bool) -> Drawn:
    """Draw `count` scenes; the first few before the clock starts, so that kernels are loaded."""
    config = replace(scenario.config.simulation, prune=prune)
    keys = key_rows(seed, Method.SAMPLE, 0, 0, range(count))
    genomes = draw_genomes(scenario.program.space, keys)
    sample(scenario.program, genomes[:2], keys[:2], config)
    start = time.perf_counter()
    scenes = sample(scenario.program, genomes, keys, config)
    return _summed(scenes, time.perf_counter() - start)


def _summed(scenes: Scenes, seconds: float) -> Drawn:
    attempts = float(scenes.attempts.sum()) / max(1, int(scenes.valid.sum()))
    return Drawn(attempts, float(scenes.valid.mean()), float(np.mean(scenes.verdict == Verdict.INFEASIBLE)), seconds)


def line(path: Path, scenario: Scenario, count: int) -> str:
    """One file, before and after."""
    plain, pruned = (draw(scenario, count, prune=prune) for prune in (False, True))
    return (
        f"{path.stem:<26} attempts a scene {plain.attempts:8.1f} -> {pruned.attempts:5.2f}   "
        f"valid {plain.valid:6.1%} -> {pruned.valid:6.1%}   infeasible {pruned.infeasible:6.1%}   "
        f"{plain.seconds:5.2f} s -> {pruned.seconds:5.2f} s"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """A line for each file."""
    parser = argparse.ArgumentParser(description="Attempts per scene with and without --prune.")
    parser.add_argument("files", nargs="*", type=Path, default=EXAMPLES)
    parser.add_argument("--scenes", type=int, default=10_000)
    options = parser.parse_args(arguments)
    for path in options.files:
        print(line(path, load(path), options.scenes))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
