"""Interval versions of the functions. What is not correctly rounded gets a slack far above its error."""

import math
from collections.abc import Callable

import numpy as np

from engine.feasibility.arithmetic import magnitude
from engine.feasibility.intervals import RELATIVE, Forward, Interval, either, infinite, made, slackened
from engine.tables import Floats

NEAR_POLE = 1e-9
"""How far from a jump or pole of a periodic function a branch is still taken for sure [rad]."""
FULL_TURN = 2.0 * math.pi


def root(a: Interval) -> Interval:
    low, high = np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0))
    return Interval(low, high, a.undefined | (a.low < 0.0))


def wave(function: Callable[[Floats], Floats]) -> Forward:
    """Sine and cosine never rise faster than their argument, and never leave [-1, 1]."""

    def forward(a: Interval) -> Interval:
        known = ~infinite(a)
        low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
        middle = function(0.5 * low + 0.5 * high)
        reach = np.where(known, 0.5 * (high - low) + RELATIVE * (1.0 + np.abs(low) + np.abs(high)), 2.0)
        return Interval(np.maximum(middle - reach, -1.0), np.minimum(middle + reach, 1.0), a.undefined | ~known)

    return forward


def tangent(a: Interval) -> Interval:
    known = ~infinite(a)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    branch = np.floor((low - NEAR_POLE) / math.pi + 0.5) == np.floor((high + NEAR_POLE) / math.pi + 0.5)
    branch &= known & (np.abs(low) + np.abs(high) < 1e6)
    ends = np.where(branch, np.tan(low), -np.inf), np.where(branch, np.tan(high), np.inf)
    margin = 1e-9 * (1.0 + np.square(ends[0]) + np.square(ends[1]))
    return made(ends[0] - margin, ends[1] + margin, a.undefined | ~known)


def rising(function: Callable[[Floats], Floats], least: float = -np.inf, greatest: float = np.inf) -> Forward:
    """A function that never falls, defined on [least, greatest]."""

    def forward(a: Interval) -> Interval:
        low, high = function(np.clip(a.low, least, greatest)), function(np.clip(a.high, least, greatest))
        return slackened(low, high, a.undefined | (a.low < least) | (a.high > greatest))

    return forward


def arccosine(a: Interval) -> Interval:
    turned = rising(np.arcsin, -1.0, 1.0)(a)
    return slackened(0.5 * math.pi - turned.high, 0.5 * math.pi - turned.low, turned.undefined)


def direction(a: Interval, b: Interval) -> Interval:
    corners = np.stack([np.arctan2(y, x) for y in (a.low, a.high) for x in (b.low, b.high)])
    ahead = b.low > 0.0
    low, high = np.where(ahead, corners.min(axis=0), -math.pi), np.where(ahead, corners.max(axis=0), math.pi)
    return slackened(low, high, either(a, b))


def exactly_rising(function: Callable[[Floats], Floats]) -> Forward:
    return lambda a: Interval(function(a.low), function(a.high), a.undefined)


def length(a: Interval, b: Interval) -> Interval:
    x, y = magnitude(a), magnitude(b)
    low, high = np.hypot(x.low, y.low), np.hypot(x.high, y.high)
    return made(np.maximum(low * (1.0 - RELATIVE), 0.0), high * (1.0 + RELATIVE), either(a, b))


def wrapped(a: Interval) -> Interval:
    """One turn: where both ends lie on the same one, they are moved back by it."""
    known = ~infinite(a) & (np.abs(a.low) < 1e6) & (np.abs(a.high) < 1e6)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    inside = known & (low >= -math.pi) & (high < math.pi)
    turn = np.floor((low - NEAR_POLE + math.pi) / FULL_TURN)
    same = known & (turn == np.floor((high + NEAR_POLE + math.pi) / FULL_TURN)) & ~inside
    moved = low - FULL_TURN * turn - NEAR_POLE, high - FULL_TURN * turn + NEAR_POLE
    return Interval(
        np.where(inside, low, np.where(same, moved[0], -math.pi)),
        np.where(inside, high, np.where(same, moved[1], math.pi)),
        a.undefined | infinite(a),
    )


def normal_quantile(a: Interval) -> Interval:
    inside = rising(lambda p: np.array([_quantile(float(x)) for x in p]), 0.0, 1.0)(a)
    return slackened(inside.low - 1e-9, inside.high + 1e-9, inside.undefined)


def _quantile(p: float) -> float:
    if not 0.0 < p < 1.0:
        return -math.inf if p <= 0.0 else math.inf
    from statistics import NormalDist  # slow to import, and rarely asked

    return NormalDist().inv_cdf(p)


def normal_cdf(a: Interval) -> Interval:
    values = [np.array([0.5 * math.erfc(-x / math.sqrt(2.0)) for x in end.tolist()]) for end in (a.low, a.high)]
    return slackened(values[0], values[1], a.undefined)
