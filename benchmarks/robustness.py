"""Is robustness what its definition says? `python -m benchmarks.robustness [--formulas 10000]`

Random temporal formulas on random traces: the one backward pass of `engine.kernels.temporal` against infima and suprema
over all later samples, written out as they are defined. Both must be equal bit for bit, and the sign of a robustness
that is not 0 must be the verdict. Exit code 1 if one is not.
"""

import argparse
import math
import sys

import numpy as np

from engine.kernels.temporal import MARGIN, TRUTH, work_out
from engine.vocabulary import TemporalOp

ATOMS = 4
Row = tuple[TemporalOp, int, int]
UNARY = (TemporalOp.NOT, TemporalOp.NEXT, TemporalOp.ALWAYS, TemporalOp.EVENTUALLY)
BINARY = (TemporalOp.AND, TemporalOp.OR, TemporalOp.IMPLIES, TemporalOp.UNTIL)


def formula(rng: np.random.Generator) -> list[Row]:
    """Rows with operands above their operators, the last the root; atom i is true by rule i, by how much says i + 4."""
    rows: list[Row] = [(TemporalOp.ATOM, atom, ATOMS + atom) for atom in range(ATOMS)]
    for _ in range(int(rng.integers(1, 9))):
        op = (*UNARY, *BINARY)[int(rng.integers(8))]
        first, second = (int(number) for number in rng.integers(len(rows), size=2))
        rows.append((op, first, second if op in BINARY else -1))
    return rows


def trace(rng: np.random.Generator) -> np.ndarray:
    """(samples, 2 ATOMS): truths, then numbers that are above 0 where they hold; some of them 0 or infinite."""
    numbers = rng.normal(size=(int(rng.integers(1, 12)), ATOMS))
    special = rng.random(numbers.shape)
    numbers[special < 0.05], numbers[special > 0.97] = 0.0, math.inf
    return np.concatenate([(numbers > 0.0).astype(np.float64), numbers], axis=1)


def defined(rows: list[Row], row: int, signal: np.ndarray, k: int) -> float:
    """Robustness at sample k, by its definition (Fainekos and Pappas 2009, finite traces)."""
    op, a, b = rows[row]
    later = range(k, len(signal))

    def at(operand: int, sample: int) -> float:
        return defined(rows, operand, signal, sample)

    match op:
        case TemporalOp.ATOM:
            return float(signal[k, b])
        case TemporalOp.NOT:
            return -at(a, k)
        case TemporalOp.AND:
            return min(at(a, k), at(b, k))
        case TemporalOp.OR:
            return max(at(a, k), at(b, k))
        case TemporalOp.IMPLIES:
            return max(-at(a, k), at(b, k))
        case TemporalOp.NEXT:
            return at(a, k + 1) if k + 1 < len(signal) else -math.inf
        case TemporalOp.ALWAYS:
            return min(at(a, j) for j in later)
        case TemporalOp.EVENTUALLY:
            return max(at(a, j) for j in later)
    return max(min([at(b, j), *(at(a, i) for i in range(k, j))]) for j in later)


def agrees(rows: list[Row], signal: np.ndarray) -> bool:
    """Whether the pass finds the defined number of the root, and its sign is the verdict."""
    memory, table = np.zeros((2, len(rows))), np.array(rows, dtype=np.int32)
    work_out(table, signal, len(signal) - 1, MARGIN, memory)
    number = float(memory[0, -1])
    work_out(table, signal, len(signal) - 1, TRUTH, memory)
    verdict = memory[0, -1] > 0.0
    return number == defined(rows, len(rows) - 1, signal, 0) and (number == 0.0 or (number > 0.0) == verdict)


def main() -> int:
    """Try all formulas, print how many differ, and fail if any does."""
    parser = argparse.ArgumentParser(description="Compare robustness with its definition.")
    parser.add_argument("--formulas", type=int, default=10_000)
    count = parser.parse_args().formulas
    rng = np.random.default_rng(0)
    differ = sum(not agrees(formula(rng), trace(rng)) for _ in range(count))
    print(f"{count:,} formulas on random traces: {differ} differ from the definition")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
