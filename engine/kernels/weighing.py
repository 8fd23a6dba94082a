"""Single attempts of which every requirement is evaluated, whether or not an earlier one failed, and by how much."""

import math
from typing import NamedTuple

import numpy as np

from engine.kernels.attempts import copy, has_nan, make_draws, pick_variant, toss_coins
from engine.kernels.built_in import inside_road, overlap
from engine.kernels.evaluate import run_segment
from engine.kernels.jit import kernel
from engine.kernels.philox import ATTEMPT_CHANNEL, open_stream, uniform_pair
from engine.kernels.recipe import Draws, Recipe, Request, Scratch
from engine.tables import Floats, Ints
from engine.vocabulary import Purpose


class Weighed(NamedTuple):
    """Where results go, row by row."""

    variant: Ints
    """(n,)"""
    holds: Ints
    """(n, requirements) 1 or 0; 1 for what was not evaluated because the variant was rejected."""
    margins: Floats
    """(n, the file's own requirements) NaN where there is no such number."""
    values: Floats
    """(n, scene values)"""


@kernel
def weigh_rows(recipe: Recipe, request: Request, scratch: Scratch, out: Weighed) -> None:
    """One attempt a row: the first of the row's stream."""
    copy(recipe.code.literals, scratch.registers, 0)
    for row in range(len(request.keys)):
        copy(request.genes[row], scratch.registers, recipe.layout.genes)
        toss_coins(recipe.code.requirement_probability, request.keys[row], scratch.enforced)
        _weigh_attempt(recipe, request, row, scratch, out)


@kernel
def _weigh_attempt(recipe: Recipe, request: Request, row: int, scratch: Scratch, out: Weighed) -> None:
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
        if code.margin_segment[template, requirement, 0] >= 0:
            out.margins[row, requirement] = _run(recipe, code.margin_segment[template, requirement], registers)
    _weigh_scene(recipe, template, row, registers, out)


@kernel
def _run(recipe: Recipe, segment: Ints, registers: Floats) -> float:
    run_segment(recipe.code.scene_code, segment[0], segment[1], registers, recipe.code.pool, recipe.road)
    return float(registers[segment[2]])


@kernel
def _weigh_scene(recipe: Recipe, template: int, row: int, registers: Floats, out: Weighed) -> None:
    """The scene values, and the built-in requirements where they are all numbers."""
    code, values = recipe.code, out.values[row]
    start, end = code.output_segment[template, 0], code.output_segment[template, 1]
    run_segment(code.scene_code, start, end, registers, code.pool, recipe.road)
    for value in range(len(values)):
        values[value] = registers[code.output_register[template, value]]
    if has_nan(values):
        return
    reasons = recipe.layout.reasons
    out.holds[row, reasons] = 1 if inside_road(recipe.road, code.road_check, values) else 0
    out.holds[row, reasons + 1] = 0 if overlap(code.overlap_check, values) else 1
