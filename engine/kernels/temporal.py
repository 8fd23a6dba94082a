"""Temporal formulas over the samples of a run, evaluated when it is over, with two meanings.

The formulas are rows `(TemporalOp, a, b)`, operands above their operators. The value of a formula is its truth, 1 or
-1; or its margin, positive by how much it holds, negative by how much it fails. In both the value of a conjunction is
the lesser of its operands' values, of a disjunction the greater, of a negation the opposite, so there is one table of
operators. One pass from the last sample to the first suffices, because the value of a formula at a sample follows from
its operands there and from its own value a sample later:

    always f = f and (last or always f later)       eventually f = f or eventually f later
    f until g = g or (f and f until g later)         next f = there is a later sample, and f holds there

After the last sample nothing holds: `next` has the value minus infinity there.

A number that does not exist is no truth. An atom that is NaN has the value NaN, and so has every formula that depends
on it: as a truth unless another operand decides it (`false and NaN` is false), as a margin always.

Sources: De Giacomo and Vardi, "Linear Temporal Logic and Linear Dynamic Logic on Finite Traces", IJCAI 2013; Fainekos
and Pappas, "Robustness of temporal logic specifications for continuous-time signals", Theoretical Computer Science 410,
2009.
"""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined, kernel
from engine.tables import Floats, Ints
from engine.vocabulary import TemporalOp

TRUTH, MARGIN = 1, 2
"""Column of an atom's row with the rule that provides its value."""


KEPT, UNKNOWN = -1, -2


class Broken(NamedTuple):
    """A requirement that does not hold, `KEPT` if all hold, and the sample at which that was decided; `UNKNOWN` if none
    is known to be broken, and one depends on a NaN.
    """

    temporal: int
    sample: int


@kernel
def find_broken(
    formula: Ints, roots: Ints, watched: Floats, last: int, formula_values: Floats, formula_decided: Ints
) -> Broken:
    """Return the requirement that is broken first; of equally early ones the first.

    `roots` (temporals,): rows of `formula` that must be true at sample 0. `watched` (samples, rules): the atoms' values
    at samples 0 to `last`. `always f` is decided at the first sample at which f is false, any other formula at the last
    sample. `formula_values` (2, rows) and `formula_decided` (temporals,) are working memory.
    """
    now, later = formula_values[0], formula_values[1]
    formula_decided[:] = last
    for sample in range(last, -1, -1):
        _at_sample(formula, now, later, watched, sample, sample == last, TRUTH)
        for temporal in range(len(roots)):
            root = roots[temporal]
            if formula[root, 0] == TemporalOp.ALWAYS and now[formula[root, 1]] < 0.0:
                formula_decided[temporal] = sample
        now, later = later, now
    broken, at = KEPT, last + 1
    for temporal in range(len(roots)):
        if later[roots[temporal]] < 0.0 and formula_decided[temporal] < at:
            broken, at = temporal, formula_decided[temporal]
        elif broken == KEPT and math.isnan(later[roots[temporal]]):
            broken = UNKNOWN
    return Broken(broken, at)


@kernel
def work_out(formula: Ints, watched: Floats, last: int, column: int, formula_values: Floats) -> None:
    """Write the value of each row at sample 0, of samples 0 to `last`, into row 0 of `formula_values` (2, rows).

    Row 1 is working memory. NaN where an atom that counts is NaN. `column`: `TRUTH` or `MARGIN`; only atoms of
    objectives have a margin.
    """
    now, later = formula_values[0], formula_values[1]
    for sample in range(last, -1, -1):
        _at_sample(formula, now, later, watched, sample, sample == last, column)
        now, later = later, now
    for row in range(len(formula)):
        formula_values[0, row] = later[row]


@inlined
def _at_sample(
    formula: Ints, now: Floats, later: Floats, watched: Floats, sample: int, is_last: bool, column: int
) -> None:
    """Write the value of all rows at a sample into `now`; `later` holds their values a sample later."""
    most = 1.0 if column == TRUTH else math.inf
    for row in range(len(formula)):
        op, a, b = int(formula[row, 0]), int(formula[row, 1]), int(formula[row, 2])
        if op != TemporalOp.ATOM:
            now[row] = _joined(op, now[a], now[b], later[a], later[row], is_last, most)
        elif column == TRUTH:
            value = watched[sample, a]
            now[row] = -1.0 if value == 0.0 else math.nan if math.isnan(value) else 1.0
        else:
            now[row] = watched[sample, b] if b >= 0 else 0.0


@inlined
def _joined(op: int, a: float, b: float, a_later: float, later: float, is_last: bool, most: float) -> float:
    """Return the value of an operator from its operands' values a and b, and its own value `later` a sample later.

    Values are at most `most` and at least -`most`, except for `next`, which may be less.
    """
    if op == TemporalOp.NOT:
        return -a
    if op == TemporalOp.AND:
        return _lesser(a, b, most)
    if op == TemporalOp.OR:
        return _greater(a, b, most)
    if op == TemporalOp.IMPLIES:
        return _greater(-a, b, most)
    if op == TemporalOp.NEXT:
        return -math.inf if is_last else a_later
    if op == TemporalOp.ALWAYS:
        return a if is_last else _lesser(a, later, most)
    if op == TemporalOp.EVENTUALLY:
        return a if is_last else _greater(a, later, most)
    return b if is_last else _greater(b, _lesser(a, later, most), most)


@inlined
def _lesser(a: float, b: float, most: float) -> float:
    """Return the lesser; NaN if either is NaN, unless the other is the least possible value."""
    if a != a:
        return b if b <= -most else a
    return b if b < a or (b != b and a > -most) else a


@inlined
def _greater(a: float, b: float, most: float) -> float:
    """Return the greater; NaN if either is NaN, unless the other is the greatest possible value."""
    return -_lesser(-a, -b, most)
