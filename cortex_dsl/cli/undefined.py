"""A scene or run that holds a number which does not exist, such as a root of -1: a mistake of the file.

What cannot be excluded when the file is compiled is told here, once it happened: with the genes and draws of the very
scene, the first operation on the way to the value that has no finite result.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass

import numpy as np

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.lowering.groups import group_variants
from cortex_dsl.report.findings.readable import significant
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.quantities.algebra import Numbers, closed_value, operands, parts
from cortex_dsl.session import Scenario
from cortex_dsl.source import Source, Span
from engine.scenes import Scenes
from engine.vocabulary import Column, Op

_WHY = {
    Op.DIV: "it divides by {1:.6g}",
    Op.MOD: "it divides by {1:.6g}",
    Op.FLOORDIV: "it divides by {1:.6g}",
    Op.SQRT: "it is the square root of {0:.6g}",
    Op.POW: "it is {0:.6g} to the power of {1:.6g}",
    Op.LOG: "it is the logarithm of {0:.6g}",
    Op.ASIN: "it is the arc sine of {0:.6g}",
    Op.ACOS: "it is the arc cosine of {0:.6g}",
    Op.EXP: "it is e to the power of {0:.6g}",
}
"""Operations that do not have a finite result everywhere, and what to say of their operands."""


@dataclass(frozen=True)
class _Culprit:
    part: ir.Apply
    why: str


def undefined_value(scenario: Scenario, scenes: Scenes, row: int = 0) -> Diagnostic | None:
    """What to tell of a row whose scene or run failed over a value that is no number; None if the file has no part."""
    variant = group_variants(scenario.compiled.scenario).variants[max(0, int(scenes.variant[row]))]
    space, source = scenario.program.space, scenario.compiled.source
    genes = dict(enumerate((scenes.genomes[row] * space.scale).tolist()))
    draws = dict(enumerate(scenes.draws[row].tolist()))
    for what, expression in _values(variant, scenes.values[row], source):
        if (culprit := _culprit(expression, genes, draws)) is not None:
            return _diagnostic(what, culprit, _drawn(scenario, expression, scenes, row))
    return None


def _values(variant: ir.Variant, values: np.ndarray, source: Source) -> Iterator[tuple[str, ir.Expr]]:
    """Expressions to look at, with what they are: properties that are no number, then all that a run computes."""
    for i, actor in enumerate(variant.actors):
        for column, expression in zip(Column, actor.columns, strict=True):
            if not math.isfinite(values[i * len(Column) + column]):
                yield f"a number of `{actor.name}`", expression
    for node in (*(actor.behaviour for actor in variant.actors), *(rule.condition for rule in variant.rules)):
        for expression in _expressions(node):
            yield f"`{_shortened(source, expression.span)}`", expression


def _expressions(node: object) -> Iterator[ir.Expr]:
    """All expressions in a block of acts."""
    if isinstance(node, ir.Expr):
        yield node
    elif isinstance(node, tuple):
        for item in node:
            yield from _expressions(item)
    elif is_dataclass(node):
        for part in fields(node):
            yield from _expressions(getattr(node, part.name))


def _culprit(expression: ir.Expr, genes: Numbers, draws: Numbers) -> _Culprit | None:
    """The first operation without a finite result; of what changes during the run, the first that may have none."""
    suspect = None
    for part in parts(expression):
        if not (isinstance(part, ir.Apply) and part.op in _WHY):
            continue
        known = [closed_value(operand, genes=genes, draws=draws) for operand in operands(part)]
        result = closed_value(part, genes=genes, draws=draws)
        if result is not None and not math.isfinite(result):
            return _Culprit(part, _WHY[part.op].format(*known))
        if result is None and suspect is None and not _divides_safely(part, known):
            suspect = _Culprit(part, "it has no value for every number")
    return suspect


def _divides_safely(part: ir.Apply, known: list[float | None]) -> bool:
    return part.op in (Op.DIV, Op.MOD, Op.FLOORDIV) and known[1] not in (None, 0.0)


def _drawn(scenario: Scenario, expression: ir.Expr, scenes: Scenes, row: int) -> str:
    """The params that the value depends on, as they were drawn."""
    space = scenario.program.space
    indices = sorted({part.index for part in parts(expression) if isinstance(part, ir.Gene)})
    return ", ".join(
        f"{space.names[i]} = {significant(float(scenes.genomes[row, i]))} {space.units[i]}".rstrip() for i in indices
    )


def _diagnostic(what: str, culprit: _Culprit, drawn: str) -> Diagnostic:
    return errors.UNDEFINED.at(
        culprit.part.span,
        label=culprit.why,
        what=what,
        reason=f"it happened with {drawn}" if drawn else "it happens with some of the numbers that can be drawn",
    )


def _shortened(source: Source, span: Span, width: int = 40) -> str:
    text = " ".join(source.slice(span).split())
    return text if len(text) <= width else text[: width - 3] + "..."
