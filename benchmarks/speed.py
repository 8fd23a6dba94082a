"""How fast the engine is, measured against the hand-written limit in one run: `python -m benchmarks.speed [--json]`.

Every figure is the median over rounds; a round measures everything once, in turn, so that a ratio compares what ran
within the same second of the same machine. Times are CPU times; those of two threads are wall times. Before anything is
timed, the outcomes of limit and batch host are asserted equal, bit for bit, on the very scenes that are timed.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import limit
from cortex_dsl import Scenario, load
from engine import batch, world
from engine.assessment import take
from engine.outcomes import Outcomes
from engine.sampling import sample, uniform_genomes
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Method

SCENARIO = Path(__file__).parent.parent / "examples" / "left_turn.scn"
TARGETS = {
    "batch / limit": ("at most", 2.5),
    "two threads / one": ("at least", 1.8),
    "world, scenes a second": ("at least", 500.0),
    "sampler, attempts a second": ("at least", 10e6),
}


def main() -> None:
    """Measure and print a table, or with --json one document."""
    parser = argparse.ArgumentParser(description="Measure batch host, world host and sampler against the limit.")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--scenes", type=int, default=20_000, help="valid scenes for limit and batch host")
    parser.add_argument("--world-scenes", type=int, default=1_000)
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    scenario = load(SCENARIO)
    scenes = _valid_scenes(scenario, arguments.scenes)
    steps = _assert_equal(scenario, scenes)
    report = _measure(scenario, scenes, steps, arguments.world_scenes, arguments.rounds)
    if arguments.json:
        print(json.dumps(report, indent=2))
    else:
        _show(report)


def _valid_scenes(scenario: Scenario, count: int) -> Scenes:
    """Scenes of uniformly random genomes, as a random search draws them; the invalid ones left out."""
    config = replace(scenario.config.simulation, max_attempts=100_000)
    keys = key_rows(1, Method.SAMPLE, 0, 0, range(2 * count))
    scenes = sample(scenario.program, uniform_genomes(scenario.program.space, keys), keys, config)
    return take(scenes, np.flatnonzero(scenes.valid)[:count])


def _assert_equal(scenario: Scenario, scenes: Scenes) -> int:
    """The limit and the batch host agree on every scene; returns the actor-steps that both make."""
    by_hand = limit.simulate(scenario.program, limit.inputs(scenario.program, scenes), scenario.config.simulation)
    general = batch.simulate(scenario.program, scenes, scenario.config.simulation)
    pairs: list[tuple[np.ndarray, np.ndarray]] = [
        (by_hand.collided, general.collided),
        (by_hand.end_time, general.end_time),
        (by_hand.steps, general.steps),
        (by_hand.metrics, np.concatenate(_metrics(general), axis=1)),
        (by_hand.left_road, general.left_road_time),
    ]
    for hand, host in pairs:
        np.testing.assert_array_equal(hand, host)
    return int(2 * general.steps.sum())


def _metrics(outcomes: Outcomes) -> list[np.ndarray]:
    return [outcomes.min_distance, outcomes.max_closing_speed, outcomes.distance_at_ms, outcomes.ttc_at_ms]


def _measure(scenario: Scenario, scenes: Scenes, steps: int, world_count: int, rounds: int) -> dict:
    program, config = scenario.program, scenario.config
    given = limit.inputs(program, scenes)
    some = take(scenes, slice(world_count))
    keys = key_rows(2, Method.SAMPLE, 0, 0, range(5_000))
    genomes = uniform_genomes(program.space, keys)
    attempts = int(sample(program, genomes, keys, config.simulation).attempts.sum())
    work: dict[str, Callable[[], object]] = {
        "limit": lambda: limit.simulate(program, given, config.simulation),
        "batch": lambda: batch.simulate(program, scenes, config.simulation),
        "batch, two threads": lambda: batch.simulate(program, scenes, config.simulation, jobs=2),
        "world": lambda: world.simulate(program, some, config),
        "sampler": lambda: sample(program, genomes, keys, config.simulation),
    }
    times: dict[str, list[float]] = {name: [] for name in work}
    waits: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(rounds):
        for name, run in work.items():
            wall, cpu = time.perf_counter(), time.process_time()
            run()
            times[name].append(time.process_time() - cpu)
            waits[name].append(time.perf_counter() - wall)
    times["batch, two threads"] = waits["batch, two threads"]
    median = {name: statistics.median(values) for name, values in times.items()}
    return {
        "scenes": len(scenes),
        "actor_steps": steps,
        "rounds": rounds,
        "ns per actor-step": {name: 1e9 * median[name] / steps for name in ("limit", "batch", "batch, two threads")},
        "scenes a second": {
            "limit": len(scenes) / median["limit"],
            "batch": len(scenes) / median["batch"],
            "batch, two threads": len(scenes) / median["batch, two threads"],
            "world": len(some) / median["world"],
        },
        "ratios": {
            "batch / limit": _ratio(times["batch"], times["limit"]),
            "two threads / one": _ratio(waits["batch"], waits["batch, two threads"]),
            "world, scenes a second": len(some) / median["world"],
            "sampler, attempts a second": attempts / median["sampler"],
        },
    }


def _ratio(above: list[float], below: list[float]) -> float:
    """Median of the ratios round by round."""
    return statistics.median(a / b for a, b in zip(above, below, strict=True))


def _show(report: dict) -> None:
    console = Console()
    table = Table(title=f"{report['scenes']:,} scenes of scenario A, {report['rounds']} rounds", title_justify="left")
    table.add_column("host")
    table.add_column("ns per actor-step", justify="right")
    table.add_column("scenes a second", justify="right")
    for name, scenes_a_second in report["scenes a second"].items():
        cost = report["ns per actor-step"].get(name)
        table.add_row(name, "" if cost is None else f"{cost:.0f}", f"{scenes_a_second:,.0f}")
    console.print(table)
    for name, (bound, value) in TARGETS.items():
        console.print(f"{name:28} {report['ratios'][name]:>14,.2f}   ({bound} {value:,g})")


if __name__ == "__main__":
    main()
