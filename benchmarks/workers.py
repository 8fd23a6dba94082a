"""What do more workers gain? `python -m benchmarks.workers [--jobs 2] [--rows 40000] [--world-rows 4000] [FILE]`.

The same scenes are drawn and run by one worker and by several: threads, processes, and a local Dask cluster where it is
installed. Workers are started, and have run a batch, before the clock starts; every result is compared bit for bit.
"""

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from cortex_dsl import Scenario, load
from engine.extras import MissingExtraError
from engine.outcomes import Assessment
from engine.risk import PROFILES
from engine.sampling import draw_genomes
from engine.search.evaluator import make_evaluator
from engine.search.workers import Workers, open_workers, spread
from engine.streams import key_rows
from engine.vocabulary import Method

EXAMPLE = Path(__file__).parent.parent / "examples" / "left_turn.scn"
PROFILE = "paper"


def timed(scenario: Scenario, engine: str, workers: Workers, rows: int) -> tuple[float, Assessment]:
    """Seconds for so many scenes, and what became of them."""
    search = replace(scenario.config.search, engine=engine, jobs=workers.jobs)
    config, program = replace(scenario.config, search=search), scenario.program
    keys = key_rows(1, Method.RANDOM, 0, 0, range(rows))
    genomes = draw_genomes(program.space, keys)
    with open_workers(workers) as executor:
        here = make_evaluator(program, config, PROFILES[PROFILE])
        evaluate = spread(executor, workers, program, config, PROFILE) if executor else here
        evaluate(genomes[:200], keys[:200])
        start = time.perf_counter()
        found = evaluate(genomes, keys)
        return time.perf_counter() - start, found


def lines(scenario: Scenario, engine: str, jobs: int, rows: int) -> Iterator[str]:
    """One for each kind of worker."""
    alone, expected = timed(scenario, engine, Workers("threads", 1), rows)
    yield f"{engine:<6} {'one worker':<16} {rows / alone:9,.0f} scenes/s"
    for kind in ("threads", "processes", "dask"):
        try:
            seconds, found = timed(scenario, engine, Workers(kind, jobs), rows)
        except MissingExtraError as error:
            yield f"{engine:<6} {kind:<16} {error}"
            continue
        same = all(getattr(found, name).tobytes() == column.tobytes() for name, column in vars(expected).items())
        name = f"{jobs} by {kind}"
        pace = f"{rows / seconds:9,.0f} scenes/s   x {alone / seconds:.2f}"
        yield f"{engine:<6} {name:<16} {pace}   {'the same results' if same else 'OTHER RESULTS'}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", type=Path, default=EXAMPLE)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--rows", type=int, default=40_000)
    parser.add_argument("--world-rows", type=int, default=4_000)
    options = parser.parse_args()
    scenario = load(options.file)
    for engine, rows in (("batch", options.rows), ("world", options.world_rows)):
        for line in lines(scenario, engine, options.jobs, rows):
            print(line, flush=True)


if __name__ == "__main__":
    main()
