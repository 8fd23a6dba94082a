"""Temporal formulas over the finitely many samples of a run, judged when it is over, with two meanings.

The formulas are rows `(TemporalOp, a, b)`, operands above their operators. What is true is worth 1 and what is false
-1; or what holds is worth by how much it does, and what does not by how much it fails, with a minus. In both the worth
of a conjunction is the lesser of its operands', of a disjunction the greater, of a negation the opposite, so there is
one table of operators. One pass from the last sample to the first suffices, for what a formula is worth at a sample
follows from its operands there and from itself a sample later:

    always f = f and (last or always f later)       eventually f = f or eventually f later
    f until g = g or (f and f until g later)         next f = there is a later sample, and f holds there

After the last sample nothing holds: `next` is worth minus infinity there.

A number that does not exist is no truth. An atom that is NaN is worth NaN, and so is all that depends on it: of truths
what no other operand decides (`false and NaN` is false), of numbers everything.

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
"""Column of an atom's row that names the rule from which it takes its worth."""


KEPT, UNKNOWN = -1, -2


class Broken(NamedTuple):
    """A requirement that does not hold, `KEPT` if all do, and the sample at which that was decided; `UNKNOWN` where
    none is broken, and whether one is depends on a NaN.
    """

    temporal: int
    sample: int


@kernel
def find_broken(
    formula: Ints, roots: Ints, watched: Floats, last: int, formula_values: Floats, formula_decided: Ints
) -> Broken:
    """The requirement that is broken first; of equally early ones the first.

    `roots` (temporals,): rows of `formula` that must be true at sample 0. `watched` (samples, rules): the atoms' values
    at samples 0 to `last`. `always f` is decided where f is false first, any other formula at the last sample.
    `formula_values` (2, rows) and `formula_decided` (temporals,) are working memory.
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
    """The worth of all rows at a sample into `now`; `later` knows them a sample later."""
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
    """What an operator is worth whose operands are worth a and b; itself a sample later it was worth `later`. Nothing
    is worth more than `most`, nor less than its opposite, which `next` may fall below.
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
    """NaN where one of them is, unless the other is the least there is."""
    if a != a:
        return b if b <= -most else a
    return b if b < a or (b != b and a > -most) else a


@inlined
def _greater(a: float, b: float, most: float) -> float:
    """NaN where one of them is, unless the other is the most there is."""
    return -_lesser(-a, -b, most)
