"""Parts of an attempt at a scene: inputs and outputs, coins and draws, the built-in requirements.

`engine.sampling` creates the tuples. The registers of an attempt: literals | variant values | genes (SI) | uniform
draws | temporaries. Literals are written once per thread, genes once per scene, the rest in every attempt. The built-in
requirements are that outlines lie inside the road, and that none overlap at the start.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.handles import handle
from engine.kernels.geometry import Box, box_distance, building
from engine.kernels.jit import inlined, kernel
from engine.kernels.levels import first_height
from engine.kernels.random_numbers import COIN_CHANNEL, Stream, open_stream, uniform, uniform_pair
from engine.kernels.region import region_contains_box
from engine.tables import ROAD_REGION, CodeTables, Floats, Ints, RoadTables
from engine.vocabulary import LEVEL, Column, Purpose


@handle
class Layout(NamedTuple):
    """Places in a register file, and counts that kernels need."""

    variant_values: int
    genes: int
    draws: int
    draw_count: int
    blocks: int
    """Number of blocks of random numbers per attempt."""
    requirements: int
    """Number of the file's own requirements; rejections and the two built-in ones follow."""
    reasons: int
    """The file's own and the variant rejections: index of the first built-in."""


@handle
class Recipe(NamedTuple):
    """Everything about a program that an attempt reads."""

    code: CodeTables
    """Tables of the program; `scene_code` is one array of all rows."""
    road: RoadTables
    draws_needed: Ints
    """(templates, requirements): how many draws must be made before a requirement is tested."""
    by_genes: Ints
    """(requirements,): 1 if the genome alone decides: a failure recurs in every attempt."""
    layout: Layout


@handle
class Confinement(NamedTuple):
    """The box in which a row's attempts can pass (see `engine.feasibility.pruning`). Without rows: everywhere."""

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


@handle
class Request(NamedTuple):
    """Scenes to sample, row by row."""

    genes: Floats
    """(n, d) SI"""
    group: Ints
    """(n,): group of variants selected by the discrete genes."""
    keys: Ints
    """(n, 6) int64 `StreamKey` rows."""
    max_attempts: int
    free: int
    """Attempts before those that are confined."""
    confinement: Confinement
    begun: Ints
    """(n,) attempts made before, which are not made again."""


@handle
class Ledger(NamedTuple):
    """Results of sampling: the arrays of `engine.scenes.Scenes` under the same names."""

    verdict: Ints
    variant: Ints
    values: Floats
    draws: Floats
    attempts: Ints
    tested: Ints
    failed: Ints


class Draws(NamedTuple):
    """Random numbers of an attempt."""

    stream: Stream
    block: np.uint64
    """The attempt's first block."""
    first: float
    """Draw 0, which was computed with the number that selects the variant."""


@handle
class Scratch(NamedTuple):
    """Working memory of a thread."""

    registers: Floats
    enforced: Ints
    """(requirements,): 0 if the coin of a soft requirement exempts this scene."""


# -- coins, the choice of a variant, and the draws of one attempt ------------------------------------------------------

LINEAR_SEARCH = 16
"""Largest number of variants in a group that is searched without a branch that could be mispredicted."""


@inlined
def copy(source: Floats, target: Floats, offset: int) -> None:
    """Write `source` into `target` from `offset` on."""
    for i in range(len(source)):
        target[offset + i] = source[i]


@kernel
def draw_soft_requirements(probabilities: Floats, key: Ints, enforced: Ints) -> None:
    """Toss one coin for each soft requirement of a scene; with heads the requirement is tested."""
    coins = open_stream(key, Purpose.SCENE, COIN_CHANNEL)
    for requirement in range(len(probabilities)):
        probability = probabilities[requirement]
        enforced[requirement] = 1 if probability >= 1.0 or uniform(coins, requirement) < probability else 0


@inlined
def pick_variant(group_start: Ints, cumulative: Floats, group: int, choice: float) -> int:
    """Return the variant of a group whose share of [0, 1) contains the uniform number `choice`."""
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
def make_draws(layout: Layout, draws: Draws, known: int, needed: int, registers: Floats) -> int:
    """Draw until at least `needed` numbers are known; return the number of known ones."""
    while known < needed:
        first, second = uniform_pair(draws.stream, draws.block + np.uint64((known + 1) >> 1))
        registers[layout.draws + known] = first
        if known + 1 < layout.draw_count:
            registers[layout.draws + known + 1] = second
        known += 2
    return known


@kernel
def unbounded(values: Floats) -> bool:
    """Return True if a value is NaN or infinite, such as a width of 1 / 0."""
    count = 0
    for value in values:
        count += 0 if math.isfinite(value) else 1
    return count > 0


# -- the built-in requirements -----------------------------------------------------------------------------------------

VALUES_PER_ACTOR = len(Column)


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
def inside_road(road: RoadTables, checked: Ints, values: Floats) -> bool:
    """Return True if the outlines of all actors that must be on the road are inside it."""
    for actor in range(len(checked)):
        if checked[actor] != 0 and not region_contains_box(road, ROAD_REGION, _outline(values, actor)):
            return False
    return True


@kernel
def overlap(road: RoadTables, checked: Ints, kinds: Ints, values: Floats) -> bool:
    """Return True if two actors of the same group (0: no group) touch on one level, or an actor of any group touches a
    building.
    """
    for one in range(len(checked)):
        if checked[one] != 0 and _touches_building(road.buildings, _outline(values, one)):
            return True
        for other in range(one):
            both = checked[one] != 0 and checked[one] == checked[other]
            touch = both and box_distance(_outline(values, one), _outline(values, other)) == 0.0
            if touch and (len(road.heights) == 0 or _are_level(road, kinds, values, one, other)):
                return True
    return False


@kernel
def _are_level(road: RoadTables, kinds: Ints, values: Floats, one: int, other: int) -> bool:
    """Return True if two actors enter the scene on one level."""
    ego = _height(road, kinds, values, 0, 0.0)
    return abs(_height(road, kinds, values, one, ego) - _height(road, kinds, values, other, ego)) < LEVEL


@kernel
def _height(road: RoadTables, kinds: Ints, values: Floats, actor: int, ego: float) -> float:
    box = _outline(values, actor)
    return first_height(road, actor, int(kinds[actor]), box.x, box.y, box.heading, ego)


@inlined
def _touches_building(buildings: Floats, box: Box) -> bool:
    for number in range(len(buildings)):
        block = building(buildings, number)
        if box_distance(box, block) == 0.0:
            return True
    return False
