"""The command line of the suite."""

import argparse
import math
from pathlib import Path

from benchmarks.suite import __doc__ as about
from benchmarks.suite import comparison, tables, truth
from benchmarks.suite.outside import OUTSIDE
from benchmarks.suite.scenarios import HERE, PLANTED, named, runnable

METHODS = f"random,ga,niching,best_first, all other methods of cortexc, {', '.join(OUTSIDE)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(about or "").splitlines()[0])
    parser.add_argument(
        "--scenarios", default="all", help="names with commas between them, or tune, judge, planted, outside, all"
    )
    parser.add_argument("--truth", action="store_true", help="make plain draws, and add them to those that are kept")
    parser.add_argument("--count", type=int, default=200_000, help="of them, for each scenario")
    parser.add_argument("--plain", action="store_true", help="hold the rates against --count plain draws of each file")
    parser.add_argument("--plant", metavar="TEXT", help="write the files with planted defects of this seed")
    parser.add_argument("--folder", type=Path, default=HERE / PLANTED, help="where to")
    parser.add_argument("--methods", default="", help=f"make searches by these: {METHODS}")
    parser.add_argument("--objective", default="conflict", help="what they look for")
    parser.add_argument("--runs", type=int, default=10, help="of each method on each scenario")
    parser.add_argument("--budget", type=int, default=3000, help="simulations of a run")
    parser.add_argument("--jobs", type=int, default=1, help="threads of draws, processes of searches")
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no further run after these")
    options = parser.parse_args()
    if options.plant:
        truth.plant(options.plant, options.folder, options.count, options.jobs)
        return
    names = named(options.scenarios)
    able = runnable(names) if options.plain or options.truth or options.methods else []
    if options.plain:
        print(truth.beside_plain_draws(able, options.count, options.jobs))
        return
    if options.truth:
        truth.add(able, options.count, options.jobs)
    if options.methods:
        methods = options.methods.split(",")
        asked = options.objective, options.runs, options.budget, options.jobs, options.seconds
        comparison.compare(able, methods, *asked)
    truths = {name: row for name, row in truth.kept().items() if name in names}
    print(truth.table(truths))
    found = [each for each in comparison.kept() if each.objective == options.objective]
    found = [each for each in found if each.budget == options.budget and each.scenario in truths]
    for made in () if not found else (tables.table, tables.compact, tables.summaries, tables.curves, tables.ranking):
        print(f"\n{made(found, truths)}")


if __name__ == "__main__":
    main()
