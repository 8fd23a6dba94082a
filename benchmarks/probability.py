"""Plain Monte Carlo, subset simulation and importance sampling of a rare collision: do they agree, at what price?

All also estimate how probable a collision is that a competent driver avoids.

    python -m benchmarks.probability [--samples 1000000]

Two cars cross; their speeds vary by a few percent, and only those who both are far from their means meet.
"""

import argparse
from dataclasses import replace
from time import perf_counter

from cortex_dsl import compile_text
from engine.search.probability.monte_carlo import RARE as RARE_METHODS
from engine.search.probability.monte_carlo import Probability, estimate

RARE = """\
map intersection(ways=4, lanes=1, approach=50 m)
param EGO_SPEED = TruncatedNormal(10, 0.6, 5, 20) m/s, OTHER_SPEED = TruncatedNormal(10, 0.6, 5, 20) m/s
ego = new Car at (1.75, -40), facing 90 deg, with speed EGO_SPEED
other = new Car at (-20, -1.75), facing 0 deg, with speed OTHER_SPEED
terminate after 6 s
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=1_000_000, help="of plain Monte Carlo")
    parser.add_argument(
        "--level-size", type=int, default=10_000, help="runs a level of subset simulation, and all others"
    )
    options = parser.parse_args()
    scenario = compile_text(RARE, "rare.scn")
    scenario = replace(scenario, config=replace(scenario.config, search=replace(scenario.config.search, jobs=2)))
    estimate(scenario.program, scenario.config, "mc", 100)
    found = [_estimated(scenario, "mc", options.samples)]
    found += [_estimated(scenario, method, options.level_size) for method in RARE_METHODS]
    agree = max(each.interval.low for each in found) <= min(each.interval.high for each in found)
    print(f"intervals {'overlap' if agree else 'DO NOT overlap'}")
    for each in found:
        low, high = each.avoidable_interval
        print(f"{each.method:10} avoidable {each.avoidable:.3e}  [{low:.3e}, {high:.3e}]  {each.driven:,} driven again")


def _estimated(scenario, method: str, samples: int) -> Probability:
    start = perf_counter()
    found = estimate(scenario.program, scenario.config, method, samples, seed=1)
    low, high = found.interval
    took = perf_counter() - start
    print(f"{method:10} {found.value:.3e}  [{low:.3e}, {high:.3e}]  {found.simulations:>9,} simulations  {took:.1f} s")
    return found


if __name__ == "__main__":
    main()
