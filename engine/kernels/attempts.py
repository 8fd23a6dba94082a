"""What sampling and weighing share: coins, the choice of a variant, and the draws of one attempt."""

import math

import numpy as np

from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.philox import COIN_CHANNEL, open_stream, uniform, uniform_pair
from engine.kernels.recipe import Draws, Layout
from engine.tables import Floats, Ints
from engine.vocabulary import Purpose

LINEAR_SEARCH = 16
"""Groups of up to so many variants are searched without a branch that could be mispredicted."""


@inlined
def copy(source: Floats, target: Floats, offset: int) -> None:
    """Write `source` into `target` from `offset` on."""
    for i in range(len(source)):
        target[offset + i] = source[i]


@kernel
def toss_coins(probabilities: Floats, key: Ints, enforced: Ints) -> None:
    """One coin a soft requirement and scene: heads, and the requirement counts."""
    coins = open_stream(key, Purpose.SCENE, COIN_CHANNEL)
    for requirement in range(len(probabilities)):
        probability = probabilities[requirement]
        enforced[requirement] = 1 if probability >= 1.0 or uniform(coins, requirement) < probability else 0


@inlined
def pick_variant(group_start: Ints, cumulative: Floats, group: int, choice: float) -> int:
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
def make_draws(layout: Layout, draws: Draws, known: int, needed: int, registers: Floats) -> int:
    """Make draws until at least `needed` of them are known; the number known then."""
    while known < needed:
        first, second = uniform_pair(draws.stream, draws.block + np.uint64((known + 1) >> 1))
        registers[layout.draws + known] = first
        if known + 1 < layout.draw_count:
            registers[layout.draws + known + 1] = second
        known += 2
    return known


@kernel
def has_nan(values: Floats) -> bool:
    count = 0
    for value in values:
        count += 1 if math.isnan(value) else 0
    return count > 0
