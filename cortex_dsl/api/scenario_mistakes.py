"""Mistakes of a scenario that show only after it compiled, as diagnostics like any other.

Before sampling it may be proved that objects do not fit at their places. A draw or a run may meet an undefined number,
or a behaviour that never acts. `report.findings.impossible` has the proof that no scene exists.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import combinations, islice
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.lowering.code_tables import group_variants
from cortex_dsl.pipeline import Compiled
from cortex_dsl.report.findings.impossible import line_span
from cortex_dsl.report.findings.readable import significant
from cortex_dsl.semantics.errors.runs import NO_NUMBER
from cortex_dsl.semantics.errors.values import OFF_THE_ROAD, ON_TOP, STUCK, UNDEFINED
from cortex_dsl.semantics.quantities.bounds import Numbers, closed_value, operands, parts
from cortex_dsl.source import Source, Span
from engine.config import SimulationConfig
from engine.feasibility import conflicts
from engine.feasibility.distances import boundary_distance, region_edges
from engine.operators import OPERATORS
from engine.operators.bounds import DIVISIONS
from engine.program import ParamSpace, checking
from engine.tables import ROAD_REGION
from engine.vocabulary import Column, EndReason

if TYPE_CHECKING:
    from engine.outcomes import Outcomes
    from engine.scenes import Scenes


# -- objects that cannot stand where the file puts them: which they are, where the proof only says that some are -------

MOST_PAIRS = 50
"""Pairs of objects that are looked at."""
EDGE = 0.05
"""Metres from the road that would be shown as 0.0."""


def misplaced(compiled: Compiled, conflict: Sequence[int]) -> list[Diagnostic]:
    """Objects off the road and pairs that overlap, wherever chance puts them.

    `conflict` are requirements of which it is proved that they cannot hold together; objects without a known place are
    looked at only if all of them are built in.
    """
    found = list(_at_known_places(compiled))
    requirements = compiled.program.requirements
    if not found and conflict and all(requirements[r].line == 0 for r in conflict):
        found = [*_off_the_road(compiled), *_overlapping(compiled)]
    return found


def _actors(compiled: Compiled) -> tuple[ir.Actor, ...]:
    """Return the actors of the first possible variant; all variants have the same actors."""
    return next((v.actors for v in compiled.scenario.variants if v.rejection is None), ())


def _at_known_places(compiled: Compiled) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each object with constant coordinates off the road."""
    edges = region_edges(compiled.program.road, ROAD_REGION)
    possible = [variant.actors for variant in compiled.scenario.variants if variant.rejection is None]
    for number, actor in enumerate(_actors(compiled)):
        place = _known_place([actors[number] for actors in possible])
        if place is None or not (actor.inside_road and actor.present):
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            (distance,), (inside,) = boundary_distance(edges, np.array(place[:1]), np.array(place[1:]))
        if not inside:
            where = "on the edge of" if distance < EDGE else f"{distance:.1f} m off"
            label = f"({place[0]:g}, {place[1]:g}) is {where} the road"
            yield OFF_THE_ROAD.at(actor.span, name=actor.name, label=label)


def _known_place(versions: Sequence[ir.Actor]) -> tuple[float, float] | None:
    """X and y of an object, if they are the same two numbers in every variant."""
    numbers = [version.columns[column] for version in versions for column in (Column.X, Column.Y)]
    known = [number.value for number in numbers if isinstance(number, ir.Literal)]
    if len(known) == len(numbers) and len(places := set(zip(known[::2], known[1::2], strict=True))) == 1:
        return places.pop()
    return None


def _off_the_road(compiled: Compiled) -> Iterator[Diagnostic]:
    for number, actor in enumerate(_actors(compiled)):
        program = checking(compiled.program, road=[number], overlap=[])
        if actor.inside_road and conflicts(program, [program.first_built_in]):
            yield OFF_THE_ROAD.at(actor.span, name=actor.name, label="part of its outline is off the road")


def _overlapping(compiled: Compiled) -> Iterator[Diagnostic]:
    for (i, one), (j, other) in islice(combinations(enumerate(_actors(compiled)), 2), MOST_PAIRS):
        program = checking(compiled.program, road=[], overlap=[i, j])
        together = one.overlap_group != 0 and one.overlap_group == other.overlap_group
        if together and conflicts(program, [program.first_built_in + 1]):
            secondary = (Label(one.span, f"`{one.name}`"),)
            yield ON_TOP.at(other.span, name=other.name, other=one.name, secondary=secondary)


# -- a behaviour that was caught looping without an action while it ran ------------------------------------------------


def never_acts(compiled: Compiled, budget: int, row: int, time: float) -> Diagnostic:
    """The diagnostic for a run stuck at this row of step code, after `time` seconds and `budget` instructions."""
    return STUCK.at(
        line_span(compiled.source, int(compiled.program.step_lines[row])),
        label=f"still here after {budget:,} instructions, at {time:.2f} s",
    )


def undefined_objective(compiled: Compiled, number: int, space: ParamSpace, genome: Sequence[float]) -> Diagnostic:
    """The diagnostic for a run that an objective broke, as it was NaN."""
    objective = compiled.program.judged.objectives[number]
    drawn = ", ".join(
        f"{name} = {significant(value)} {unit}".rstrip()
        for name, value, unit in zip(space.names, genome, space.units, strict=True)
    )
    reason = f"it happened with {drawn}" if drawn else "it happens with some of the numbers that can be drawn"
    return NO_NUMBER.at(line_span(compiled.source, objective.line), name=objective.name, reason=reason)


# -- a scene or run that holds a number which does not exist, such as a root of -1 -------------------------------------
# Errors that cannot be excluded at compile time are shown after they occur: with the genes and draws of the scene,
# the first operation on the way to the value that has no finite result.


@dataclass(frozen=True)
class _Culprit:
    part: ir.Apply
    why: str


def undefined_value(compiled: Compiled, scenes: "Scenes", row: int = 0) -> Diagnostic | None:
    """Return the diagnostic for a row that failed over a value that is no number, or None if the file has no part."""
    variant = group_variants(compiled.scenario).variants[max(0, int(scenes.variant[row]))]
    space, source = compiled.program.space, compiled.source
    genes = dict(enumerate((scenes.genomes[row] * space.scale).tolist()))
    draws = dict(enumerate(scenes.draws[row].tolist()))
    for what, expression in _values(variant, scenes.values[row], source):
        known_value = closed_value(expression, genes=genes, draws=draws)
        if known_value is not None and math.isfinite(known_value):
            continue
        if (culprit := _culprit(expression, genes, draws)) is not None:
            return _diagnostic(what, culprit, _drawn(compiled.program.space, expression, scenes, row))
    return None


def failure_of(
    compiled: Compiled, config: SimulationConfig, scenes: "Scenes", outcomes: "Outcomes", row: int = 0
) -> Diagnostic | None:
    """Return the diagnostic for a failed run: a behaviour that never acts, or a number that does not exist; None if the
    file has no part.
    """
    reason, rule = int(outcomes.end_reason[row]), int(outcomes.end_rule[row])
    if reason == EndReason.STUCK:
        return never_acts(compiled, config.instruction_budget, rule, float(outcomes.end_time[row]))
    if reason == EndReason.BROKEN and rule >= 0:
        return undefined_objective(compiled, rule, compiled.program.space, scenes.genomes[row].tolist())
    return undefined_value(compiled, scenes, row)


def _values(variant: ir.Variant, values: np.ndarray, source: Source) -> Iterator[tuple[str, ir.Expr]]:
    """Yield expressions to evaluate, with their descriptions.

    For a scene without values, the requirements, as one of them is undefined; then properties that are no number; then
    all expressions of a run.
    """
    if np.isnan(values).all():
        for requirement in variant.requirements:
            yield f"`{requirement.name}`", requirement.condition
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
    """Return the first operation without a finite result; for run-time values, the first that may have none."""
    suspect = None
    for part in parts(expression):
        if not (isinstance(part, ir.Apply) and part.op in OPERATORS and (reason := OPERATORS[part.op].reason)):
            continue
        known = [closed_value(operand, genes=genes, draws=draws) for operand in operands(part)]
        result = closed_value(part, genes=genes, draws=draws)
        if result is not None and not math.isfinite(result):
            return _Culprit(part, reason.format(*known))
        if result is None and suspect is None and not _divides_safely(part, known):
            suspect = _Culprit(part, "it has no value for every number")
    return suspect


def _divides_safely(part: ir.Apply, known: list[float | None]) -> bool:
    return OPERATORS[part.op].domain is DIVISIONS and known[1] not in (None, 0.0)


def _drawn(space: ParamSpace, expression: ir.Expr, scenes: "Scenes", row: int) -> str:
    """The params that the value depends on, as they were drawn."""
    indices = sorted({part.index for part in parts(expression) if isinstance(part, ir.Gene)})
    return ", ".join(
        f"{space.names[i]} = {significant(float(scenes.genomes[row, i]))} {space.units[i]}".rstrip() for i in indices
    )


def _diagnostic(what: str, culprit: _Culprit, drawn: str) -> Diagnostic:
    return UNDEFINED.at(
        culprit.part.span,
        label=culprit.why,
        what=what,
        reason=f"it happened with {drawn}" if drawn else "it happens with some of the numbers that can be drawn",
    )


def _shortened(source: Source, span: Span, width: int = 40) -> str:
    text = source.words(span)
    return text if len(text) <= width else text[: width - 3] + "..."
