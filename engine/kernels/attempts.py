"""Attempts at scenes: repeated until every requirement holds (rejection sampling), or a single one that tests all of
them.

Draws are made when the first requirement that reads them is reached, which changes no number: a draw's value depends on
its address alone. `recipe` defines inputs and outputs. A single attempt evaluates every requirement, even after an
earlier one failed, and the margin of each.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.handles import handle
from engine.kernels.evaluate import execute, run_segment
from engine.kernels.jit import inlined, kernel
from engine.kernels.random_numbers import ATTEMPT_CHANNEL, JUMP_CHANNEL, open_stream, uniform, uniform_pair
from engine.kernels.recipe import (
    Confinement,
    Draws,
    Layout,
    Ledger,
    Recipe,
    Request,
    Scratch,
    copy,
    draw_soft_requirements,
    inside_road,
    make_draws,
    overlap,
    pick_variant,
    unbounded,
)
from engine.tables import Floats, Ints, Segment
from engine.vocabulary import Purpose, Verdict

EPSILON = 2.0**-53
"""Half the distance from 1 to the next number above it."""


@kernel
def sample_rows(recipe: Recipe, request: Request, begin: int, end: int, scratch: Scratch, out: Ledger) -> None:
    """Sample the scenes of rows `begin` to `end` (exclusive)."""
    copy(recipe.code.literals, scratch.registers, 0)
    for row in range(begin, end):
        copy(request.genes[row], scratch.registers, recipe.layout.genes)
        draw_soft_requirements(recipe.code.requirement_probability, request.keys[row], scratch.enforced)
        _sample_scene(recipe, request, row, scratch, out)
        _count_rejections(recipe.layout, out.attempts[row], out.tested[row], out.failed[row])


@inlined
def _sample_scene(recipe: Recipe, request: Request, row: int, scratch: Scratch, out: Ledger) -> None:
    """Repeat attempts until the row's verdict is final."""
    code, blocks = recipe.code, recipe.layout.blocks
    confined = len(request.confinement.mass) > 0
    start = int(code.group_start[request.group[row]])
    if confined and request.confinement.mass[row] == 0.0:
        _rule_out(row, request.confinement.culprit[row], int(request.begun[row]), out)
        return
    stream = open_stream(request.keys[row], Purpose.SCENE, ATTEMPT_CHANNEL)
    begun = int(request.begun[row])
    choice, first_draw = uniform_pair(stream, np.uint64(begun * blocks))
    made, left = 0, float(request.max_attempts)
    for attempt in range(request.max_attempts):
        if confined and attempt >= request.free:
            left -= _jump(request.confinement.mass[row], request.keys[row], attempt)
        if left <= 0.0:
            break
        made, left = attempt + 1, left - 1.0
        if attempt < begun:
            continue
        # Compute the next attempt's numbers while this one is interpreted: Philox is long but independent.
        next_choice, next_first_draw = uniform_pair(stream, np.uint64((attempt + 1) * blocks))
        if confined:
            variant = start + _option(request.confinement.cumulative[row], choice)
        else:
            variant = pick_variant(code.group_start, code.variant_cumulative, request.group[row], choice)
        draws = Draws(stream, np.uint64(attempt * blocks), first_draw)
        if _attempt(recipe, request, variant, draws, row, scratch, out):
            out.attempts[row] = attempt + 1
            if out.verdict[row] != Verdict.INFEASIBLE:
                out.variant[row] = variant
            return
        choice, first_draw = next_choice, next_first_draw
    out.attempts[row] = made
    out.verdict[row] = Verdict.EXHAUSTED
    out.values[row, :] = np.nan
    out.draws[row, :] = np.nan


@kernel
def _rule_out(row: int, culprit: int, begun: int, out: Ledger) -> None:
    """Record a single attempt after those that were made: the same requirement would fail in all."""
    out.verdict[row] = Verdict.INFEASIBLE
    out.attempts[row] = begun + 1
    out.tested[row, culprit] += 1
    out.failed[row, culprit] += 1


@kernel
def _jump(mass: float, key: Ints, attempt: int) -> float:
    """Return the number of attempts outside the box before the next one inside: geometric (Devroye 1986, X.2.2)."""
    if mass >= 1.0:
        return 0.0
    chance = uniform(open_stream(key, Purpose.SCENE, JUMP_CHANNEL), attempt)
    return np.floor(math.log1p(-chance) / math.log1p(-mass))


@kernel
def _option(cumulative: Floats, choice: float) -> int:
    """Return the first option whose share of [0, 1) ends above the uniform number `choice`."""
    option = 0
    while option + 1 < len(cumulative) and choice >= cumulative[option]:
        option += 1
    return option


@inlined
def _attempt(
    recipe: Recipe, request: Request, variant: int, draws: Draws, row: int, scratch: Scratch, out: Ledger
) -> bool:
    """Test the file's requirements in order up to the first failure, then the rest; true when the row is settled.

    A requirement that is NaN settles it as an error: it neither holds nor fails.
    """
    code, layout, registers = recipe.code, recipe.layout, scratch.registers
    template = code.variant_template[variant]
    if template < 0:
        out.failed[row, code.variant_rejection[variant]] += 1
        return False
    for value in range(code.variant_values.shape[1]):
        registers[layout.variant_values + value] = code.variant_values[variant, value]
    if layout.draw_count > 0:
        registers[layout.draws] = draws.first
    known = 1
    if len(request.confinement.mass) > 0:
        known = make_draws(layout, draws, known, layout.draw_count, registers)
        option = variant - int(code.group_start[request.group[row]])
        _confine(layout, request.confinement, row, option, registers)
    for requirement in range(layout.requirements):
        if scratch.enforced[requirement] == 0:
            continue
        known = make_draws(layout, draws, known, recipe.draws_needed[template, requirement], registers)
        start = code.requirement_segment[template, requirement, Segment.START]
        end = code.requirement_segment[template, requirement, Segment.END]
        execute(code.scene_code, start, end, registers, code.pool, recipe.road)
        out.tested[row, requirement] += 1
        holds = registers[code.requirement_segment[template, requirement, Segment.RESULT]]
        if math.isnan(holds):
            make_draws(layout, draws, known, layout.draw_count, registers)
            _note_draws(layout, row, registers, out)
            out.values[row, :] = math.nan
            out.verdict[row] = Verdict.ERROR
            return True
        if holds == 0.0:
            out.failed[row, requirement] += 1
            if recipe.by_genes[requirement] != 0:
                out.verdict[row] = Verdict.INFEASIBLE
                return True
            return False
    make_draws(layout, draws, known, layout.draw_count, registers)
    return _finish(recipe, template, row, registers, out)


@inlined
def _confine(layout: Layout, confinement: Confinement, row: int, option: int, registers: Floats) -> None:
    """Move the draws of an attempt, all of them made, into the box of the row's variant."""
    for draw in range(layout.draw_count):
        low, span = confinement.low[row, option, draw], confinement.span[row, option, draw]
        # Rounding must not carry a draw to the open end of its interval, least of all to 1.
        confined = min(low + registers[layout.draws + draw] * span, (low + span) * (1.0 - EPSILON))
        registers[layout.draws + draw] = max(confined, low)


@kernel
def _finish(recipe: Recipe, template: int, row: int, registers: Floats, out: Ledger) -> bool:
    """Compute the scene values and test the built-in requirements; true when the row's verdict is settled.

    A value that is NaN or infinite settles it as an error: built-in requirements would only report it under a wrong
    name.
    """
    code, layout, values = recipe.code, recipe.layout, out.values[row]
    run_segment(
        code.scene_code,
        code.output_segment[template, Segment.START],
        code.output_segment[template, Segment.END],
        registers,
        code.pool,
        recipe.road,
    )
    for value in range(len(values)):
        values[value] = registers[code.output_register[template, value]]
    _note_draws(layout, row, registers, out)
    if unbounded(values):
        out.verdict[row] = Verdict.ERROR
        return True
    out.tested[row, layout.reasons] += 1
    if not inside_road(recipe.road, code.road_check, values):
        out.failed[row, layout.reasons] += 1
        return False
    out.tested[row, layout.reasons + 1] += 1
    if overlap(recipe.road, code.overlap_check, code.actor_kind, values):
        out.failed[row, layout.reasons + 1] += 1
        return False
    out.verdict[row] = Verdict.VALID
    return True


@inlined
def _note_draws(layout: Layout, row: int, registers: Floats, out: Ledger) -> None:
    for draw in range(layout.draw_count):
        out.draws[row, draw] = registers[layout.draws + draw]


@kernel
def _count_rejections(layout: Layout, attempts: int, tested: Ints, failed: Ints) -> None:
    """Count the attempts per variant rejection, which precede all requirements; each counts those that earlier ones
    left.
    """
    for reason in range(layout.requirements, layout.reasons):
        tested[reason] = attempts
        attempts -= failed[reason]


# -- single attempts of which every requirement is evaluated -----------------------------------------------------------


@handle
class Weighed(NamedTuple):
    """Results of single attempts, row by row."""

    variant: Ints
    """(n,)"""
    holds: Ints
    """(n, requirements) 1 or 0; 1 for requirements not evaluated because the variant was rejected."""
    margins: Floats
    """(n, the file's own requirements) NaN for a requirement without a margin."""
    values: Floats
    """(n, scene values)"""


@kernel
def weigh_rows(recipe: Recipe, request: Request, scratch: Scratch, out: Weighed) -> None:
    """Evaluate one attempt per row: the first of the row's stream."""
    copy(recipe.code.literals, scratch.registers, 0)
    for row in range(len(request.keys)):
        copy(request.genes[row], scratch.registers, recipe.layout.genes)
        draw_soft_requirements(recipe.code.requirement_probability, request.keys[row], scratch.enforced)
        _evaluate_attempt(recipe, request, row, scratch, out)


@kernel
def _evaluate_attempt(recipe: Recipe, request: Request, row: int, scratch: Scratch, out: Weighed) -> None:
    code, layout, registers = recipe.code, recipe.layout, scratch.registers
    stream = open_stream(request.keys[row], Purpose.SCENE, ATTEMPT_CHANNEL)
    choice, first = uniform_pair(stream, np.uint64(0))
    variant = pick_variant(code.group_start, code.variant_cumulative, request.group[row], choice)
    out.variant[row] = variant
    template = code.variant_template[variant]
    if template < 0:
        out.holds[row, code.variant_rejection[variant]] = 0
        return
    for value in range(code.variant_values.shape[1]):
        registers[layout.variant_values + value] = code.variant_values[variant, value]
    if layout.draw_count > 0:
        registers[layout.draws] = first
    make_draws(layout, Draws(stream, np.uint64(0), first), 1, layout.draw_count, registers)
    for requirement in range(layout.requirements):
        holds = _run(recipe, code.requirement_segment[template, requirement], registers)
        failed = holds == 0.0 or math.isnan(holds)
        out.holds[row, requirement] = 0 if failed and scratch.enforced[requirement] != 0 else 1
        if code.margin_segment[template, requirement, Segment.START] >= 0:
            out.margins[row, requirement] = _run(recipe, code.margin_segment[template, requirement], registers)
    _evaluate_scene(recipe, template, row, registers, out)


@kernel
def _run(recipe: Recipe, segment: Ints, registers: Floats) -> float:
    start, end = segment[Segment.START], segment[Segment.END]
    run_segment(recipe.code.scene_code, start, end, registers, recipe.code.pool, recipe.road)
    return float(registers[segment[Segment.RESULT]])


@kernel
def _evaluate_scene(recipe: Recipe, template: int, row: int, registers: Floats, out: Weighed) -> None:
    """Write the scene values and, if all are finite, the built-in requirements."""
    code, values = recipe.code, out.values[row]
    start, end = code.output_segment[template, Segment.START], code.output_segment[template, Segment.END]
    run_segment(code.scene_code, start, end, registers, code.pool, recipe.road)
    for value in range(len(values)):
        values[value] = registers[code.output_register[template, value]]
    if unbounded(values):
        return
    reasons = recipe.layout.reasons
    out.holds[row, reasons] = 1 if inside_road(recipe.road, code.road_check, values) else 0
    out.holds[row, reasons + 1] = 0 if overlap(recipe.road, code.overlap_check, code.actor_kind, values) else 1
