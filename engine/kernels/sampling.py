"""Rejection sampling: attempts at one scene until every requirement holds.

The registers of an attempt: literals | variant values | genes (SI) | uniform draws | temporaries. Literals are written
once a thread, genes once a scene, the rest every attempt. Draws are made when the first requirement that reads them
is reached, which changes no number: a draw's value depends on its address alone.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.kernels.evaluate import execute, run_segment
from engine.kernels.geometry import Box, box_distance
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.philox import (
    ATTEMPT_CHANNEL,
    COIN_CHANNEL,
    JUMP_CHANNEL,
    Stream,
    open_stream,
    uniform,
    uniform_pair,
)
from engine.kernels.region import region_contains_box
from engine.tables import ROAD_REGION, CodeTables, Floats, Ints, RoadTables
from engine.vocabulary import Column, Purpose, Verdict

VALUES_PER_ACTOR = len(Column)
EPSILON = 2.0**-53
LINEAR_SEARCH = 16
"""Groups of up to so many variants are searched without a branch that could be mispredicted."""


class Layout(NamedTuple):
    """Where things lie in a register file, and counts that kernels need."""

    variant_values: int
    genes: int
    draws: int
    draw_count: int
    blocks: int
    """Blocks of random numbers that one attempt owns."""
    requirements: int
    """The file's own requirements; rejections and the two built-in ones follow."""
    reasons: int
    """The file's own and the variant rejections: index of the first built-in."""


class Recipe(NamedTuple):
    """Everything about a program that an attempt reads."""

    code: CodeTables
    road: RoadTables
    draws_needed: Ints
    """(templates, requirements): how many draws must be made before a requirement is tested."""
    by_genes: Ints
    """(requirements,): 1 where the genome alone decides: what fails once fails in every attempt."""
    layout: Layout


class Confinement(NamedTuple):
    """Where a row's attempts may pass at all (see `engine.feasibility.pruning`). Without rows: anywhere."""

    mass: Floats
    """(n,) probability that an attempt falls there."""
    cumulative: Floats
    """(n, options) of the variants of the row's group."""
    low: Floats
    """(n, options, draws)"""
    span: Floats
    """(n, options, draws)"""
    culprit: Ints
    """(n,) the requirement that fails in every attempt of a row without mass."""


class Request(NamedTuple):
    """What to sample, row by row."""

    genes: Floats
    """(n, d) SI"""
    group: Ints
    """(n,): group of variants that the discrete genes pick."""
    keys: Ints
    """(n, 6) int64 `StreamKey` rows."""
    max_attempts: int
    confinement: Confinement


class Ledger(NamedTuple):
    """Where results go; the arrays of `engine.scenes.Scenes` under their names there."""

    verdict: Ints
    variant: Ints
    values: Floats
    draws: Floats
    attempts: Ints
    tested: Ints
    failed: Ints


class Draws(NamedTuple):
    """The random numbers of one attempt."""

    stream: Stream
    block: np.uint64
    """The attempt's first block."""
    first: float
    """Draw 0, which came with the number that picked the variant."""


class Scratch(NamedTuple):
    """Working memory of one thread."""

    registers: Floats
    enforced: Ints
    """(requirements,): 0 where the coin of a soft requirement spares this scene."""


@kernel
def sample_rows(recipe: Recipe, request: Request, begin: int, end: int, scratch: Scratch, out: Ledger) -> None:
    """Sample the scenes of rows `begin` to `end` (exclusive)."""
    _copy(recipe.code.literals, scratch.registers, 0)
    for row in range(begin, end):
        _copy(request.genes[row], scratch.registers, recipe.layout.genes)
        _toss_coins(recipe.code.requirement_probability, request.keys[row], scratch.enforced)
        _sample_scene(recipe, request, row, scratch, out)
        _count_rejections(recipe.layout, out.attempts[row], out.tested[row], out.failed[row])


@inlined
def _copy(source: Floats, target: Floats, offset: int) -> None:
    for i in range(len(source)):
        target[offset + i] = source[i]


@kernel
def _toss_coins(probabilities: Floats, key: Ints, enforced: Ints) -> None:
    """One coin a soft requirement and scene: heads, and the requirement counts."""
    coins = open_stream(key, Purpose.SCENE, COIN_CHANNEL)
    for requirement in range(len(probabilities)):
        probability = probabilities[requirement]
        enforced[requirement] = 1 if probability >= 1.0 or uniform(coins, requirement) < probability else 0


@inlined
def _sample_scene(recipe: Recipe, request: Request, row: int, scratch: Scratch, out: Ledger) -> None:
    """Attempts until the row's verdict is settled."""
    code, blocks = recipe.code, recipe.layout.blocks
    confined = len(request.confinement.mass) > 0
    start = int(code.group_start[request.group[row]])
    if confined and request.confinement.mass[row] == 0.0:
        _rule_out(row, request.confinement.culprit[row], out)
        return
    stream = open_stream(request.keys[row], Purpose.SCENE, ATTEMPT_CHANNEL)
    choice, first_draw = uniform_pair(stream, np.uint64(0))
    made, left = 0, float(request.max_attempts)
    for attempt in range(request.max_attempts):
        if confined:
            left -= _jump(request.confinement.mass[row], request.keys[row], attempt)
        if left <= 0.0:
            break
        made, left = attempt + 1, left - 1.0
        # The next attempt's numbers are under way while this one is interpreted: Philox is long but independent.
        next_choice, next_first_draw = uniform_pair(stream, np.uint64((attempt + 1) * blocks))
        if confined:
            variant = start + _option(request.confinement.cumulative[row], choice)
        else:
            variant = _pick_variant(code.group_start, code.variant_cumulative, request.group[row], choice)
        draws = Draws(stream, np.uint64(attempt * blocks), first_draw)
        if _attempt(recipe, request.confinement, variant, variant - start, draws, row, scratch, out):
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
def _rule_out(row: int, culprit: int, out: Ledger) -> None:
    """One attempt that stands for all: the culprit would fail in each."""
    out.verdict[row] = Verdict.INFEASIBLE
    out.attempts[row] = 1
    out.tested[row, culprit] += 1
    out.failed[row, culprit] += 1


@kernel
def _jump(mass: float, key: Ints, attempt: int) -> float:
    """How many attempts fall outside before the next one inside: geometric, by inversion (Devroye 1986, X.2.2)."""
    if mass >= 1.0:
        return 0.0
    chance = uniform(open_stream(key, Purpose.SCENE, JUMP_CHANNEL), attempt)
    return np.floor(math.log1p(-chance) / math.log1p(-mass))


@kernel
def _option(cumulative: Floats, choice: float) -> int:
    """The first option whose share of [0, 1) ends above the uniform number `choice`."""
    option = 0
    while option + 1 < len(cumulative) and choice >= cumulative[option]:
        option += 1
    return option


@inlined
def _pick_variant(group_start: Ints, cumulative: Floats, group: int, choice: float) -> int:
    """The variant of a group whose share of [0, 1) holds the uniform number `choice`."""
    start, last = group_start[group], group_start[group + 1] - 1
    if last - start < LINEAR_SEARCH:
        position = start
        for candidate in range(start, last):
            position += 1 if choice >= cumulative[candidate] else 0
        return position
    while start < last:
        middle = (start + last) // 2
        if choice >= cumulative[middle]:
            start = middle + 1
        else:
            last = middle
    return start


@inlined
def _attempt(
    recipe: Recipe,
    confinement: Confinement,
    variant: int,
    option: int,
    draws: Draws,
    row: int,
    scratch: Scratch,
    out: Ledger,
) -> bool:
    """Test the file's requirements in order up to the first failure, then the rest; true when the row is settled."""
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
    if len(confinement.mass) > 0:
        known = _make_draws(layout, draws, known, layout.draw_count, registers)
        for draw in range(layout.draw_count):
            low, span = confinement.low[row, option, draw], confinement.span[row, option, draw]
            # Rounding must not carry a draw to the open end of its interval, least of all to 1.
            confined = min(low + registers[layout.draws + draw] * span, (low + span) * (1.0 - EPSILON))
            registers[layout.draws + draw] = max(confined, low)
    for requirement in range(layout.requirements):
        if scratch.enforced[requirement] == 0:
            continue
        known = _make_draws(layout, draws, known, recipe.draws_needed[template, requirement], registers)
        start = code.requirement_segment[template, requirement, 0]
        end = code.requirement_segment[template, requirement, 1]
        execute(code.scene_code, start, end, registers, code.pool, recipe.road)
        out.tested[row, requirement] += 1
        holds = registers[code.requirement_segment[template, requirement, 2]]
        if holds == 0.0 or math.isnan(holds):
            out.failed[row, requirement] += 1
            if recipe.by_genes[requirement] != 0:
                out.verdict[row] = Verdict.INFEASIBLE
                return True
            return False
    _make_draws(layout, draws, known, layout.draw_count, registers)
    return _finish(recipe, template, row, registers, out)


@inlined
def _make_draws(layout: Layout, draws: Draws, known: int, needed: int, registers: Floats) -> int:
    """Make draws until at least `needed` of them are known; the number known then."""
    while known < needed:
        first, second = uniform_pair(draws.stream, draws.block + np.uint64((known + 1) >> 1))
        registers[layout.draws + known] = first
        if known + 1 < layout.draw_count:
            registers[layout.draws + known + 1] = second
        known += 2
    return known


@kernel
def _finish(recipe: Recipe, template: int, row: int, registers: Floats, out: Ledger) -> bool:
    """Compute the scene values and test the built-in requirements; true when the row's verdict is settled.

    A value that is NaN settles it as an error: built-in requirements would only report it under a wrong name.
    """
    code, layout, values = recipe.code, recipe.layout, out.values[row]
    run_segment(
        code.scene_code,
        code.output_segment[template, 0],
        code.output_segment[template, 1],
        registers,
        code.pool,
        recipe.road,
    )
    for value in range(len(values)):
        values[value] = registers[code.output_register[template, value]]
    for draw in range(layout.draw_count):
        out.draws[row, draw] = registers[layout.draws + draw]
    if _has_nan(values):
        out.verdict[row] = Verdict.ERROR
        return True
    out.tested[row, layout.reasons] += 1
    if not _inside_road(recipe.road, code.road_check, values):
        out.failed[row, layout.reasons] += 1
        return False
    out.tested[row, layout.reasons + 1] += 1
    if _overlap(code.overlap_check, values):
        out.failed[row, layout.reasons + 1] += 1
        return False
    out.verdict[row] = Verdict.VALID
    return True


@inlined
def _outline(values: Floats, actor: int) -> Box:
    first = actor * VALUES_PER_ACTOR
    return Box(
        values[first + Column.X],
        values[first + Column.Y],
        values[first + Column.HEADING],
        values[first + Column.LENGTH],
        values[first + Column.WIDTH],
    )


@inlined
def _inside_road(road: RoadTables, checked: Ints, values: Floats) -> bool:
    for actor in range(len(checked)):
        if checked[actor] != 0:
            box = _outline(values, actor)
            if not region_contains_box(road, ROAD_REGION, box.x, box.y, box.heading, box.length, box.width):
                return False
    return True


@kernel
def _overlap(checked: Ints, values: Floats) -> bool:
    """Whether two actors touch that both must not overlap."""
    for one in range(len(checked)):
        for other in range(one):
            both = checked[one] != 0 and checked[other] != 0
            if both and box_distance(_outline(values, one), _outline(values, other)) == 0.0:
                return True
    return False


@kernel
def _has_nan(values: Floats) -> bool:
    count = 0
    for value in values:
        count += 1 if math.isnan(value) else 0
    return count > 0


@kernel
def _count_rejections(layout: Layout, attempts: int, tested: Ints, failed: Ints) -> None:
    """Impossible variants are turned away before any requirement; each reason is conditional on those before it."""
    for reason in range(layout.requirements, layout.reasons):
        tested[reason] = attempts
        attempts -= failed[reason]
