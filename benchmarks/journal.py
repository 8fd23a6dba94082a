"""What does the journal cost? `python -m benchmarks.journal [--rounds 7] [--json] [FILES]`.

The same search, by the genetic algorithm at the paper's budget, without a journal and with one, in turn; the ratio is
taken within a round. Bytes are those of the finished journal, and of the numbers in it: eight for each of a row's.
"""

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from benchmarks.campaigns import EXAMPLES
from cortex_dsl import Scenario, load
from cortex_dsl.api.run_folder import origin_of
from engine.assessment import SCALARS
from engine.paper import FILES
from engine.search.campaign import Campaign
from engine.search.journal import Journal
from engine.search.manifest import make_manifest
from engine.search.run import search

BUDGET = 1.20
"""Most that a search with its journal may take, in times of the bare one."""


def bare(scenario: Scenario) -> Campaign:
    return search(scenario.program, "ga", scenario.config)


def journalled(scenario: Scenario, path: Path) -> Campaign:
    manifest = make_manifest(
        scenario.program, scenario.config, "ga", "paper", scenario.compiled.source.name, (), origin_of(scenario)
    )
    with closing(Journal.create(path, manifest)) as journal:
        campaign = search(scenario.program, "ga", scenario.config, "paper", journal.write)
        journal.complete(campaign)
        journal.finish(campaign)
    return campaign


def timed(work: Callable[[], Campaign]) -> tuple[float, Campaign]:
    start = time.perf_counter()
    done = work()
    return time.perf_counter() - start, done


def measured(file: Path, rounds: int) -> dict[str, float | str]:
    """One scenario's row."""
    scenario = load(file)
    bare(scenario)
    ratios, sizes, simulations = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(rounds):
            path = Path(folder) / f"{number}.sqlite"
            without, _ = timed(lambda: bare(scenario))
            kept, campaign = timed(lambda path=path: journalled(scenario, path))
            ratios.append(kept / without)
            sizes.append(path.stat().st_size)
            simulations = int(campaign.evaluations.simulated.sum())
    numbers = 8 * (len(SCALARS) + len(scenario.program.space))
    return {
        "scenario": file.stem,
        "simulations": simulations,
        "ratio": statistics.median(ratios),
        "lowest": min(ratios),
        "highest": max(ratios),
        "bytes_a_simulation": sizes[-1] / simulations,
        "bytes_of_numbers": numbers,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path, help="scenarios (the six examples)")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    files = options.files or [EXAMPLES / f"{name}.scn" for name in FILES]
    rows = [measured(file, options.rounds) for file in files]
    if options.json:
        print(json.dumps(rows, indent=2))
        return
    for row in rows:
        print(
            f"{row['scenario']:<26}{row['simulations']:>6} simulations, with the journal x {row['ratio']:.2f} "
            f"({row['lowest']:.2f} to {row['highest']:.2f}), {row['bytes_a_simulation']:.0f} bytes a simulation "
            f"of which {row['bytes_of_numbers']} are numbers"
        )
    print(f"asked for: at most x {BUDGET:.2f}, and at most 100 bytes more than the numbers")


if __name__ == "__main__":
    main()
