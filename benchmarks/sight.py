"""Is anybody seen who is hidden, or hidden who is seen? `python -m benchmarks.sight [--scenes 100000] [--json]`

Random scenes of up to twenty outlines, half of them on a grid, where outlines touch, share sides and cover one another
exactly. The kernel's verdicts are held against one ray in every interval between the directions at which anything can
change, in plain Python, and against the polygons of shadows that shapely makes. Verdicts that hang on less than 1e-9
rad count as right either way.
"""

import argparse
import json
import sys
import time

import numpy as np

from engine.kernels.sight import SEEN, Shades, look
from tests.engine.kernels.sight_reference import agrees, by_rays, drawn, seen_area, table

NO_BUILDINGS = np.zeros((0, 5))
SLIVER = 1e-6
"""Shapely's polygons are not asked about what is thinner [rad]."""


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.sight", description=__doc__)
    parser.add_argument("--scenes", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    random = np.random.default_rng(options.seed)
    verdicts, wrong, against_shapely, asked_shapely, seconds = [0, 0, 0], 0, 0, 0, 0.0
    for number in range(options.scenes):
        scene = drawn(random, int(random.integers(0, 21)), grid=number % 2 == 0)
        shades = table(scene.shades)
        start = time.perf_counter()
        verdict = look(scene.view, scene.target, Shades(shades, 0, len(scene.shades), -1, -1), NO_BUILDINGS)
        seconds += time.perf_counter() - start
        verdicts[verdict] += 1
        wrong += not agrees(verdict, scene)
        far = scene._replace(view=scene.view._replace(distance=1e3))
        if number % 2 and not 0.0 < by_rays(far).seen < SLIVER:
            asked_shapely += 1
            seen = look(far.view, far.target, Shades(shades, 0, len(far.shades), -1, -1), NO_BUILDINGS) == SEEN
            against_shapely += seen != (seen_area(far) > 1e-9)
    figures = {
        "scenes": options.scenes,
        "outside": verdicts[0],
        "hidden": verdicts[1],
        "seen": verdicts[2],
        "differ_from_rays": wrong,
        "asked_shapely": asked_shapely,
        "differ_from_shapely": against_shapely,
        "microseconds_a_look_from_python": round(1e6 * seconds / max(1, options.scenes), 2),
    }
    if options.json:
        print(json.dumps(figures))
    else:
        print("\n".join(f"{name.replace('_', ' '):32} {value:>12,}" for name, value in figures.items()))
    return 1 if wrong or against_shapely else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
