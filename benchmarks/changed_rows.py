"""Which rows of the examples does a change of the code change? In two checkouts, then on both answers:

    python -m benchmarks.changed_rows --write before.npz
    python -m benchmarks.changed_rows --write after.npz
    python -m benchmarks.changed_rows before.npz after.npz

Ten thousand random scenes of every example run in the batch host. A row counts as changed in a result that is not the
same to the last bit; results that only one of the two has are left out.
"""

import argparse
from dataclasses import fields
from pathlib import Path

import numpy as np

from cortex_dsl import load
from engine import batch
from engine.sampling import sample, uniform_genomes
from engine.streams import key_rows
from engine.tables import Bools
from engine.vocabulary import Method

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scn"))


def write(target: Path, count: int) -> None:
    """Run all examples and keep every result by the name `file/result`."""
    found: dict[str, np.ndarray] = {}
    for file in EXAMPLES:
        scenario = load(file)
        keys = key_rows(1, Method.SAMPLE, 0, 0, range(count))
        genomes = uniform_genomes(scenario.program.space, keys)
        scenes = sample(scenario.program, genomes, keys, scenario.config.simulation)
        outcomes = batch.simulate(scenario.program, scenes, scenario.config.simulation)
        found |= {f"{file.stem}/{field.name}": getattr(outcomes, field.name) for field in fields(outcomes)}
    np.savez_compressed(target, **found)


def compare(before: Path, after: Path) -> None:
    """Print, for each example, how many rows changed in which results."""
    with np.load(before) as one, np.load(after) as other:
        for file in EXAMPLES:
            names = [name for name in one.files if name.startswith(f"{file.stem}/") and name in other.files]
            changed = {name.partition("/")[2]: _changed(one[name], other[name]) for name in names}
            rows = np.logical_or.reduce(list(changed.values()))
            columns = ", ".join(f"{name} {int(mask.sum())}" for name, mask in changed.items() if mask.any())
            print(f"{file.stem:28} {int(rows.sum()):6} of {len(rows)} rows{': ' if columns else ''}{columns}")


def _changed(one: np.ndarray, other: np.ndarray) -> Bools:
    """Whether each row differs; two NaN do not."""
    same = (one == other) | ((one != one) & (other != other))
    return ~same.reshape(len(same), -1).all(axis=1)


def main() -> None:
    """Write the results of this checkout, or compare those of two."""
    parser = argparse.ArgumentParser(description="Count the rows of the examples that differ between two checkouts.")
    parser.add_argument("files", nargs="*", type=Path, help="two files of results")
    parser.add_argument("--write", type=Path, help="run the examples and keep their results here")
    parser.add_argument("--scenes", type=int, default=10_000, help="of each example")
    arguments = parser.parse_args()
    if arguments.write:
        write(arguments.write, arguments.scenes)
    else:
        compare(*arguments.files)


if __name__ == "__main__":
    main()
