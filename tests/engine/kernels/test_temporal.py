"""Temporal formulas against what they mean, sample by sample: as truths, and as how far they hold."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.temporal import MARGIN, TRUTH, find_broken, work_out
from engine.vocabulary import TemporalOp

ATOMS = 3
Row = tuple[TemporalOp, int, int]
UNKNOWN = 0.5
"""Truth of a formula that depends on a NaN."""

UNARY = (TemporalOp.NOT, TemporalOp.NEXT, TemporalOp.ALWAYS, TemporalOp.EVENTUALLY)
BINARY = (TemporalOp.AND, TemporalOp.OR, TemporalOp.IMPLIES, TemporalOp.UNTIL)


def holds(rows: list[Row], row: int, trace: np.ndarray, k: int) -> float:
    """Return the truth of a formula at sample k of a finite trace: 1, 0, or UNKNOWN where it depends on a NaN.

    Kleene (1952), "Introduction to Metamathematics", section 64: minimum, maximum and complement.
    """
    op, a, b = rows[row]
    later = range(k, len(trace))

    def at(operand: int) -> Callable[[int], float]:
        return lambda sample: holds(rows, operand, trace, sample)

    return {
        TemporalOp.ATOM: lambda: UNKNOWN if math.isnan(trace[k, a]) else float(trace[k, a] != 0.0),
        TemporalOp.NOT: lambda: 1.0 - at(a)(k),
        TemporalOp.AND: lambda: min(at(a)(k), at(b)(k)),
        TemporalOp.OR: lambda: max(at(a)(k), at(b)(k)),
        TemporalOp.IMPLIES: lambda: max(1.0 - at(a)(k), at(b)(k)),
        TemporalOp.NEXT: lambda: at(a)(k + 1) if k + 1 < len(trace) else 0.0,
        TemporalOp.ALWAYS: lambda: min(map(at(a), later)),
        TemporalOp.EVENTUALLY: lambda: max(map(at(a), later)),
        TemporalOp.UNTIL: lambda: max(min([at(b)(j), *map(at(a), range(k, j))]) for j in later),
    }[op]()


@st.composite
def formulas(draw: st.DrawFn) -> list[Row]:
    """Rows with operands above their operators; the last one is the root."""
    rows: list[Row] = [(TemporalOp.ATOM, atom, -1) for atom in range(ATOMS)]
    for _ in range(draw(st.integers(1, 7))):
        operand = st.integers(0, len(rows) - 1)
        op = draw(st.sampled_from(UNARY + BINARY))
        rows.append((op, draw(operand), draw(operand) if op in BINARY else -1))
    return rows


TRACES = st.lists(
    st.tuples(*(st.sampled_from([0.0, 1.0, -2.5, np.nan]) for _ in range(ATOMS))), min_size=1, max_size=7
).map(np.array)


def judge(rows: list[Row], roots: list[int], trace: np.ndarray) -> tuple[int, int]:
    worth, decided = np.zeros((2, len(rows))), np.zeros(len(roots), dtype=np.int64)
    tables = np.array(rows, dtype=np.int32), np.array(roots, dtype=np.int32)
    return find_broken(*tables, trace, len(trace) - 1, worth, decided)


@given(formulas(), TRACES)
def test_a_formula_means_what_its_definition_says(rows: list[Row], trace: np.ndarray) -> None:
    """One backward pass finds the same as asking every sample anew."""
    broken, _ = judge(rows, [len(rows) - 1], trace)
    assert {-1: 1.0, 0: 0.0, -2: UNKNOWN}[broken] == holds(rows, len(rows) - 1, trace, 0)


@given(formulas(), TRACES)
def test_always_is_decided_where_it_breaks_first_and_all_else_at_the_end(rows: list[Row], trace: np.ndarray) -> None:
    """The returned sample is the one from which nothing later could make it true."""
    root = len(rows) - 1
    broken, sample = judge(rows, [root], trace)
    if broken == 0:
        op, a, _ = rows[root]
        falls = [k for k in range(len(trace)) if holds(rows, a, trace, k) == 0.0] if op == TemporalOp.ALWAYS else []
        assert sample == (falls[0] if op == TemporalOp.ALWAYS else len(trace) - 1)


@given(st.lists(st.integers(0, 12), min_size=1, max_size=4), TRACES)
def test_of_several_the_one_that_is_decided_first_is_returned(breaks: list[int], trace: np.ndarray) -> None:
    """Each `always` over an atom of its own, false from a sample of its own on; of equals the first."""
    samples = len(trace)
    watched = np.array([[float(k < first) for first in breaks] for k in range(samples)])
    rows: list[Row] = [(TemporalOp.ATOM, i, -1) for i in range(len(breaks))]
    rows += [(TemporalOp.ALWAYS, i, -1) for i in range(len(breaks))]
    broken, sample = judge(rows, list(range(len(breaks), 2 * len(breaks))), watched)
    if min(breaks) >= samples:
        assert broken == -1
    else:
        assert (broken, sample) == (breaks.index(min(breaks)), min(breaks))


@pytest.mark.parametrize(
    ("op", "values", "expected"),
    [
        (TemporalOp.NEXT, [0], False),
        (TemporalOp.NEXT, [0, 1], True),
        (TemporalOp.ALWAYS, [1], True),
        (TemporalOp.EVENTUALLY, [0, 0], False),
    ],
)
def test_at_the_last_sample(op: TemporalOp, values: list[float], expected: bool) -> None:
    """There is no next sample after the last; what always held held."""
    broken, _ = judge([(TemporalOp.ATOM, 0, -1), (op, 0, -1)], [1], np.array(values, dtype=float).reshape(-1, 1))
    assert (broken < 0) == expected


# -- how far a formula holds -------------------------------------------------------------------------------------------

MARGIN_ROWS = [(TemporalOp.ATOM, atom, ATOMS + atom) for atom in range(ATOMS)]


def robustness(rows: list[Row], row: int, trace: np.ndarray, k: int) -> float:
    """The definition: infima and suprema over the samples k, k + 1, …, of which there may be none."""
    op, a, b = rows[row]
    later = range(k, len(trace))

    def at(operand: int, sample: int) -> float:
        return robustness(rows, operand, trace, sample)

    return {
        TemporalOp.ATOM: lambda: float(trace[k, b]),
        TemporalOp.NOT: lambda: -at(a, k),
        TemporalOp.AND: lambda: min(at(a, k), at(b, k)),
        TemporalOp.OR: lambda: max(at(a, k), at(b, k)),
        TemporalOp.IMPLIES: lambda: max(-at(a, k), at(b, k)),
        TemporalOp.NEXT: lambda: at(a, k + 1) if k + 1 < len(trace) else -math.inf,
        TemporalOp.ALWAYS: lambda: min(at(a, j) for j in later),
        TemporalOp.EVENTUALLY: lambda: max(at(a, j) for j in later),
        TemporalOp.UNTIL: lambda: max(min([at(b, j), *(at(a, i) for i in range(k, j))]) for j in later),
    }[op]()


def worth(rows: list[Row], trace: np.ndarray, column: int) -> np.ndarray:
    memory = np.zeros((2, len(rows)))
    work_out(np.array(rows, dtype=np.int32), trace, len(trace) - 1, column, memory)
    return memory[0]


@st.composite
def judged_formulas(draw: st.DrawFn) -> list[Row]:
    """As `formulas`, with a number beside each atom."""
    return [*MARGIN_ROWS, *draw(formulas())[ATOMS:]]


NUMBERS = st.floats(-5.0, 5.0) | st.sampled_from([0.0, math.inf, -math.inf])
SIGNALS = st.lists(st.tuples(*(NUMBERS for _ in range(ATOMS))), min_size=1, max_size=7).map(
    lambda values: np.array([[*(float(v > 0.0) for v in row), *row] for row in values])
)
"""Each atom holds where its number is above 0."""


@given(judged_formulas(), SIGNALS)
def test_robustness_means_what_its_definition_says(rows: list[Row], trace: np.ndarray) -> None:
    """One backward pass finds the same infima and suprema, bit for bit."""
    found = worth(rows, trace, MARGIN)
    assert found.tolist() == [robustness(rows, row, trace, 0) for row in range(len(rows))]


@given(judged_formulas(), SIGNALS)
def test_the_sign_of_robustness_is_the_verdict(rows: list[Row], trace: np.ndarray) -> None:
    """Above 0 a formula holds, below 0 it does not; at 0 the verdict of its truths decides."""
    number, truth = worth(rows, trace, MARGIN)[-1], worth(rows, trace, TRUTH)[-1]
    assert (truth > 0.0) == (holds(rows, len(rows) - 1, trace, 0) == 1.0)
    assert number == 0.0 or (number > 0.0) == (truth > 0.0)


@given(judged_formulas(), SIGNALS, st.integers(0, ATOMS - 1))
def test_what_is_no_number_stays_none(rows: list[Row], trace: np.ndarray, atom: int) -> None:
    """NaN in an atom that a formula reads makes its margin NaN, unless an infinite margin decides it."""
    trace[:, ATOMS + atom] = math.nan
    for row, number in enumerate(worth(rows, trace, MARGIN)):
        assert math.isnan(number) == (reads(rows, row, atom, len(trace)) and not math.isinf(number))


def reads(rows: list[Row], row: int, atom: int, samples: int) -> bool:
    """Whether the worth of a formula at the first of so many samples comes from an atom."""
    op, a, b = rows[row]
    if op == TemporalOp.ATOM:
        return a == atom
    if op == TemporalOp.NEXT:
        return samples > 1 and reads(rows, a, atom, samples - 1)
    if op in (TemporalOp.ALWAYS, TemporalOp.EVENTUALLY):
        return any(reads(rows, a, atom, left) for left in range(1, samples + 1))
    if op == TemporalOp.UNTIL:
        within = any(reads(rows, a, atom, left) for left in range(2, samples + 1))
        return within or any(reads(rows, b, atom, left) for left in range(1, samples + 1))
    return any(reads(rows, operand, atom, samples) for operand in (a, b) if operand >= 0)
