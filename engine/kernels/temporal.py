"""Temporal requirements, judged when a run is over: linear temporal logic over its finitely many samples.

The formulas are rows `(TemporalOp, a, b)`, operands above their operators. One pass from the last sample to the first
suffices, for what a formula is at a sample follows from its operands there and from itself a sample later:

    always f = f and (last or always f later)       eventually f = f or eventually f later
    f until g = g or (f and f until g later)         next f = there is a later sample, and f holds there

Source: De Giacomo and Vardi, "Linear Temporal Logic and Linear Dynamic Logic on Finite Traces", IJCAI 2013.
"""

from typing import NamedTuple

from engine.kernels.jit import inlined, kernel
from engine.kernels.stage import Flags
from engine.tables import Floats, Ints
from engine.vocabulary import TemporalOp


class Broken(NamedTuple):
    """A requirement that does not hold, -1 if all do, and the sample at which that was decided."""

    temporal: int
    sample: int


@kernel
def find_broken(formula: Ints, roots: Ints, watched: Floats, last: int, truth: Flags, decided: Ints) -> Broken:
    """The requirement that is broken first; of equally early ones the first.

    `roots` (temporals,): rows of `formula` that must be true at sample 0. `watched` (samples, rules): the atoms' values
    at samples 0 to `last`. `always f` is decided where f is false first, anything else at the last sample. `truth`
    (2, rows) and `decided` (temporals,) are working memory.
    """
    now, later = truth[0], truth[1]
    later[:] = False
    decided[:] = last
    for sample in range(last, -1, -1):
        for row in range(len(formula)):
            now[row] = _holds(formula, row, now, later, watched, sample, sample == last)
        for temporal in range(len(roots)):
            root = roots[temporal]
            if formula[root, 0] == TemporalOp.ALWAYS and not now[formula[root, 1]]:
                decided[temporal] = sample
        now, later = later, now
    broken, at = -1, last + 1
    for temporal in range(len(roots)):
        if not later[roots[temporal]] and decided[temporal] < at:
            broken, at = temporal, decided[temporal]
    return Broken(broken, at)


@inlined
def _holds(formula: Ints, row: int, now: Flags, later: Flags, watched: Floats, sample: int, is_last: bool) -> bool:
    """Whether one row holds at a sample; `now` knows the rows above, `later` all rows a sample later."""
    op, a, b = formula[row, 0], formula[row, 1], formula[row, 2]
    if op == TemporalOp.ATOM:
        return bool(abs(watched[sample, a]) > 0.0)  # NaN is not true
    if op == TemporalOp.NOT:
        return not now[a]
    if op == TemporalOp.AND:
        return bool(now[a]) and bool(now[b])
    if op == TemporalOp.OR:
        return bool(now[a]) or bool(now[b])
    if op == TemporalOp.IMPLIES:
        return bool(now[b]) or not now[a]
    if op == TemporalOp.NEXT:
        return bool(later[a]) and not is_last
    if op == TemporalOp.ALWAYS:
        return bool(now[a]) and (is_last or bool(later[row]))
    if op == TemporalOp.EVENTUALLY:
        return bool(now[a]) or bool(later[row])
    return bool(now[b]) or (bool(now[a]) and bool(later[row]))
