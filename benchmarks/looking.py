"""What does it cost that outlines and buildings hide, and how many collisions does it make?

    python -m benchmarks.looking [--scenes 4000] [--rounds 5] [--json]

Cost: columns of 8 and of 16 cars that drive between buildings, everybody looking at everybody, against the same files
without buildings and with nobody that occludes. Scenes of the two differ in what happens, so the time of an actor-step
is compared, in rounds that take turns. Collisions: a walker who steps out from behind a parked truck, with occlusion
and with the hiding written by hand, from the same genomes and keys.
"""

import argparse
import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np

import cortex_dsl as cx
from engine.outcomes import Outcomes
from engine.scenes import Scenes

FILES = Path(__file__).parent / "looking"
COLUMNS = (8, 16)


def seen(text: str) -> cx.Scenario:
    return cx.compile_text(text)


def blind(text: str) -> cx.Scenario:
    """The same without buildings and with nobody that occludes."""
    return cx.compile_text(text.replace(", buildings=6 m", "").replace("occluding: True", "occluding: False"))


def timed(scenario: cx.Scenario, scenes: Scenes) -> tuple[float, Outcomes]:
    """Nanoseconds an actor-step on one thread, and what happened."""
    start = time.perf_counter()
    outcomes = scenario.simulate(scenes)
    seconds = time.perf_counter() - start
    steps = int(outcomes.steps[outcomes.verdict == 0].sum()) * len(scenario.program.actors)
    return 1e9 * seconds / steps, outcomes


def cost(actors: int, scenes: int, rounds: int) -> dict[str, float]:
    text = (FILES / f"column_{actors}.scn").read_text()
    pairs = [(scenario, scenario.sample(scenes)) for scenario in (seen(text), blind(text))]
    for scenario, drawn in pairs:  # the first run compiles
        scenario.simulate(drawn)
    taken = [[timed(scenario, drawn)[0] for scenario, drawn in pairs] for _ in range(rounds)]
    with_, without = (statistics.median(each[k] for each in taken) for k in (0, 1))
    hidden = timed(*pairs[0])[1].hidden_time
    return {
        "actors": actors,
        "with_ns": round(with_, 1),
        "without_ns": round(without, 1),
        "ratio": round(statistics.median(each[0] / each[1] for each in taken), 3),
        "pairs_hidden_at_some_time": round(float(np.mean(hidden[~np.isnan(hidden)] > 0.0)), 3),
    }


def collisions(name: str, scenes: int) -> tuple[int, int]:
    """How many runs collide, of how many valid ones."""
    scenario = cx.load(FILES / f"{name}.scn")
    outcomes = scenario.simulate(scenario.sample(scenes))
    return int(outcomes.collided.sum()), int((outcomes.verdict == 0).sum())


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.looking", description=__doc__)
    parser.add_argument("--scenes", type=int, default=4000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    costs = [cost(actors, max(1, options.scenes // actors), options.rounds) for actors in COLUMNS]
    names = ("truck_and_walker", "truck_and_walker_by_hand")
    counted = {name: collisions(name, options.scenes) for name in names}
    if options.json:
        print(json.dumps({"costs": costs, "collisions": counted}))
        return 0
    for each in costs:
        print("  ".join(f"{name} {value}" for name, value in each.items()))
    for name, (hits, valid) in counted.items():
        print(f"{name:28} {hits:>6,} of {valid:,} collide")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
