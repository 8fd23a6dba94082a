"""Rates of a search: only of the genomes that it drew uniformly, each simulation once."""

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.search.evaluations import Evaluations
from engine.search.insight.independent import DrawsSoFar, independent_draws, runs_of_draws
from engine.search.probability.confidence_sequence import sequence_interval
from engine.search.protocol import Operator
from engine.vocabulary import Verdict
from tests.engine.search.insight.test_kinds import searched

COUNT = 40


def mixed(seed: int) -> Evaluations:
    """Draws and children in turn; of both some collide, some are invalid and some have no known outcome."""
    generator = np.random.default_rng(seed)
    found = searched(generator.uniform(0.0, 3.0, COUNT))
    kinds = [Verdict.VALID, Verdict.EXHAUSTED, Verdict.CONTROLLER]
    verdict = generator.choice(kinds, size=(COUNT, 1), p=[0.8, 0.1, 0.1])
    collided = found.rollouts.collided & (verdict == Verdict.VALID)
    operator = np.where(np.arange(COUNT) % 2, Operator.CROSSOVER, Operator.RANDOM).astype(found.operator.dtype)
    return replace(found, operator=operator, rollouts=replace(found.rollouts, verdict=verdict, collided=collided))


@pytest.mark.parametrize("seed", range(5))
def test_children_do_not_count(seed: int) -> None:
    found = mixed(seed)
    drawn = found.rollouts.verdict[::2, 0]
    valid, lost = int((drawn == Verdict.VALID).sum()), int((drawn == Verdict.CONTROLLER).sum())
    hits = int(found.rollouts.collided[::2].sum())
    draws = independent_draws(found, "ga", ())
    assert draws is not None
    assert (draws.valid, draws.lost) == (valid, lost)
    (collision,) = draws.events
    assert (collision.name, collision.count) == ("collision", hits)
    assert collision.interval == sequence_interval(hits, valid, unknown=lost)


def test_repeated_elites_do_not_count() -> None:
    found = mixed(1)
    again = replace(found, reused=np.ones(COUNT, dtype=bool))
    assert len(runs_of_draws(again, "ga").verdict) == 0
    assert independent_draws(again, "ga", ()) is None


@pytest.mark.parametrize("method", ["sobol", "cma", "mine"])
def test_a_method_that_fills_or_learns_has_none(method: str) -> None:
    """Points of a sequence are not independent, and of a method of another package nothing is known."""
    assert independent_draws(mixed(2), method, ()) is None


def test_counts_so_far_are_those_of_the_whole() -> None:
    whole, so_far = searched(np.linspace(0.0, 3.0, COUNT)), DrawsSoFar("random")
    half = [searched(part) for part in np.split(np.linspace(0.0, 3.0, COUNT), 2)]
    draws = independent_draws(whole, "random", ())
    assert draws is not None
    intervals = [so_far.add(part) for part in half]
    assert intervals[-1] == draws.events[0].interval
    assert math.isnan(DrawsSoFar("").add(whole).low)
