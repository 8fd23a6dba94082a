"""Failures of every kind: a model of all runs predicts how close a new genome comes to a failure, and of which kind.

    archive = every valid run
    for each generation
        a fifth of it is random
        a quarter of the rest is chosen by best-first search
        candidates for the other places, several for each: children of the best runs, of the best of each kind, and of
            failures, equally by kind; on the line to another of these, or a step away in some genes
        a Gaussian process, fitted to the promise of the best runs and of as many others, draws what each candidate is
            worth; its kind is that of the nearest run
        each place takes the best candidate by a rule that is chosen at random
            COARSE   the largest worth - log(1 + places given to its kind so far)
            FINE     the same with the finer kinds of best-first search
            FAILING  the largest worth within the kind of failures that has the fewest runs

The promise of a run is how rare it is: failures rank above other contacts, and these above runs without contact; within
each group the objective decides.

A failure is often a small place in the box, and each scene adds chance, so a single run says little about its genome. A
hundred runs say much: the model separates contacts that were nearly failures from those that were not. A search that
only maximizes predicted worth stays near its first failure, so the kind of a candidate counts as well. Kinds are those
of `engine.search.insight.kinds`, and runs that did not fail have one, too: through them the search gets from failures
of one kind to failures of another.

Until something fails, best-first search has the larger part, as it climbs slopes that few runs lead up; until anything
touches, it has all.

Sources of the parts: the best of each kind of behaviour, predicted by a Gaussian process, Gaier, Asteroth and Mouret
(2018), "Data-efficient design exploration through surrogate-assisted illumination"; lines through two of them,
Vassiliades and Mouret (2018), "Discovering the elite hypervolume by leveraging interspecies correlation"; a draw of
what is believed of each candidate, Thompson (1933), "On the likelihood that one unknown probability exceeds another".
"""

from bisect import bisect_right
from collections.abc import Sequence
from math import isnan, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from engine.portable import exp
from engine.search.insight.kinds import EDGES
from engine.search.methods.best_first import MOVED, NONE, BestFirst, log_tries, rarity, sector_of
from engine.search.methods.cube import reflected
from engine.search.methods.gaussian_process import predicted
from engine.search.protocol import Box, Result, StreamAt, measure
from engine.tables import Bools, Floats, Ints

BEFORE, AFTER = 0.375, 0.75
"""Share of the places not filled at random that are filled with predicted candidates: once a run had a contact, and
once a run failed.
"""
CANDIDATES = 8
"""Candidates per place."""
BEST = 3
"""Runs of each kind that have children."""
TOP, LEAST = 0.05, 20
"""Share of all runs that have children as well, and their least number."""
LINES, STRETCH, ASIDE = 0.5, 0.6, 0.02
"""Share of candidates on a line; standard deviations of their place on it (0: the parent, 1: the other run) and of
their distance from it.
"""
SHORTEST, LONGEST = 0.005, 0.2
"""Standard deviation of a step, of the unit interval; its logarithm is uniform."""
SPOT = 0.03
"""Standard deviation of the first step when best-first search continues from a predicted candidate."""
KNOWN = 200
"""Runs that the model is fitted to; its time grows with their square."""
COARSE, FINE, FAILING = range(3)
"""Rules by which a place takes a candidate."""
LENGTH, NOISE = 0.25, 0.3
"""Correlation length of the model, in units of the root of the number of genes, and the share of variance that no gene
explains.
"""

FailureKind = tuple[int, int, int, int, int]


class Candidates(NamedTuple):
    """Children, one per row."""

    parents: Ints
    """(n,) rows of the archive."""
    others: Ints
    """(n,) Row of the second run, `NONE` if there is none."""
    points: Floats
    """(n, d)"""


def no_candidates(size: int) -> Candidates:
    """Return an empty candidate set for a space of `size` genes."""
    return Candidates(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty((0, size)))


class Foreseen(NamedTuple):
    """Predictions for candidates: arrays (n,)."""

    prediction: Floats
    kind: Ints
    """Predicted kind, an index of the kinds of `FailureKind`."""
    fine: Ints
    """Predicted kind of best-first search."""


class FailureKinds(BestFirst):
    """Places of invalid and failed results count as given to their kind."""

    exploring = 0.2

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._fails, self._touched = np.empty(0, dtype=bool), np.empty(0, dtype=bool)
        self._failure_kinds: dict[FailureKind, int] = {}
        self._failure_kind, self._places_given = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        self._bred = no_candidates(len(box))

    def _chosen(self, count: int) -> Ints:
        share = AFTER if self._fails.any() else BEFORE if self._touched.any() else 0.0
        self._bred = self._foreseen(round(share * count), self._streams(self._generation, 1))
        return np.concatenate([self._bred.parents, super()._chosen(count - len(self._bred.parents))])

    def _children(self, stream: Generator) -> tuple[Floats, Floats]:
        points, steps = super()._children(stream)
        here = slice(len(self._bred.parents))
        points[here], self._second[here], steps[here] = self._bred.points, self._bred.others, SPOT
        return points, steps

    def _foreseen(self, count: int, stream: Generator) -> Candidates:
        """Return the `count` candidates that are run."""
        if not count:
            return no_candidates(self._cube.size)
        promise = rarity(order(self._fails, self._touched, self._value))
        candidates = self._candidates(CANDIDATES * count, promise, stream)
        rows = self._placed(count, self._foresee(candidates, promise, stream), stream)
        return Candidates(candidates.parents[rows], candidates.others[rows], candidates.points[rows])

    # -- what there is to choose from

    def _candidates(self, count: int, promise: Floats, stream: Generator) -> Candidates:
        failed = np.flatnonzero(self._fails)
        best, top = self._best_of_each_kind(promise), _first(promise, max(LEAST, round(TOP * len(promise))))
        third = count // 3
        parents = stream.choice(best, size=count)
        parents[:third] = stream.choice(top, size=third)
        if len(failed):
            parents[third : 2 * third] = self._of_all_kinds(failed, third, stream)
        others = stream.choice(np.unique(np.concatenate([best, top, failed])), size=count)
        lined = (stream.random(count) < LINES) & (others != parents)
        points = self._archive[parents] + self._ways(self._archive[others] - self._archive[parents], lined, stream)
        return Candidates(parents, np.where(lined, others, NONE), reflected(points))

    def _ways(self, lines: Floats, lined: Bools, stream: Generator) -> Floats:
        """Return (n, d) the step from each parent to its child: along the line to another parent, or in some genes."""
        count, size = lines.shape
        moved = stream.random((count, size)) < MOVED / size
        moved[np.arange(count), stream.integers(size, size=count)] = True
        step = exp(stream.uniform(log(SHORTEST), log(LONGEST), size=(count, 1)))
        aside, along = stream.standard_normal((count, size)), stream.standard_normal((count, 1))
        return np.where(lined[:, np.newaxis], STRETCH * along * lines + ASIDE * aside, step * aside * moved)

    def _best_of_each_kind(self, promise: Floats) -> Ints:
        """Return the rows of the best runs of every kind."""
        of_each = (np.flatnonzero(self._failure_kind == kind) for kind in range(len(self._places_given)))
        return np.concatenate([rows[_first(promise[rows], BEST)] for rows in of_each])

    def _of_all_kinds(self, rows: Ints, count: int, stream: Generator) -> Ints:
        """Return (count,) of these rows; every kind has the same probability."""
        kinds, kind, number = np.unique(self._failure_kind[rows], return_inverse=True, return_counts=True)
        return stream.choice(rows, size=count, p=1.0 / (len(kinds) * number[kind]))

    # -- choice

    def _foresee(self, candidates: Candidates, promise: Floats, stream: Generator) -> Foreseen:
        from scipy.spatial import KDTree

        best = _first(promise, KNOWN // 2)
        rest = np.setdiff1d(np.arange(len(promise)), best)
        known = np.concatenate([best, stream.choice(rest, size=min(len(rest), KNOWN // 2), replace=False)])
        middle, spread = promise[known].mean(), max(promise[known].std(), 1e-9)
        lengths = np.full(self._cube.size, LENGTH * sqrt(self._cube.size))
        values = (promise[known] - middle) / spread
        mean, deviation = predicted(self._archive[known], values, lengths, NOISE, candidates.points)
        prediction = middle + spread * (mean + deviation * stream.standard_normal(len(mean)))
        nearest = KDTree(self._archive).query(candidates.points)[1]
        return Foreseen(prediction, self._failure_kind[nearest], self._kind[nearest])

    def _placed(self, count: int, foreseen: Foreseen, stream: Generator) -> Ints:
        """Return (count,) the rows of the candidates to run."""
        prediction, kind, fine = foreseen.prediction.copy(), foreseen.kind, foreseen.fine
        failing = np.unique(self._failure_kind[self._fails])
        runs = np.bincount(self._failure_kind, minlength=len(self._places_given))[failing]
        rows = np.empty(count, dtype=np.int64)
        for place, rule in enumerate(stream.choice([FINE, FAILING, COARSE], size=count).tolist()):
            given = self._tries_of_kind[fine] if rule == FINE else self._places_given[kind]
            rival = prediction - log_tries(given)
            if rule == FAILING and len(failing):
                rarest = np.argmin(runs)
                runs[rarest] += 1
                here = (kind == failing[rarest]) & (prediction > -np.inf)
                rival = np.where(here, prediction, -np.inf) if here.any() else rival
            row = np.argmax(rival)
            prediction[row] = -np.inf
            self._places_given[kind[row]] += 1
            self._tries_of_kind[fine[row]] += 1
            rows[place] = row
        return rows

    def _learn(self, results: Sequence[Result]) -> None:
        super()._learn(results)
        known = [result for result in results if result.selectable]
        self._fails = np.append(self._fails, [each.failure for each in known]).astype(bool)
        self._touched = np.append(self._touched, [measure(each, "min_distance") <= 0.0 for each in known]).astype(bool)
        kinds = [self._failure_kinds.setdefault(failure_kind(each), len(self._failure_kinds)) for each in known]
        self._failure_kind = np.append(self._failure_kind, np.array(kinds, dtype=np.int64))
        new = np.zeros(len(self._failure_kinds) - len(self._places_given), dtype=np.int64)
        self._places_given = np.append(self._places_given, new)


def order(fails: Bools, touched: Bools, value: Floats) -> Ints:
    """Return (n,) ranks, larger is better: failures, contacts, the rest; then by value. Equal runs share a rank."""
    rows = np.lexsort((value, touched, fails))
    columns = np.stack([fails, touched, value], axis=1)[rows]
    places = np.empty(len(rows), dtype=np.int64)
    places[rows] = np.cumsum(np.append(0, (columns[1:] != columns[:-1]).any(axis=1)))[: len(rows)]
    return places


def _first(promise: Floats, count: int) -> Ints:
    """Return the rows of the `count` largest values; among equal ones the earliest."""
    return np.argsort(-promise, kind="stable")[:count]


def failure_kind(result: Result) -> FailureKind:
    """Return the kind of a run: the actor that the ego met, its side, its sector, and both speeds; -1 if unknown."""
    pair, side = (-1 if isnan(number) else int(number) for number in (measure(result, n) for n in ("pair", "side")))
    ego, other = (measure(result, name) for name in ("ego_speed", "other_speed"))
    return pair, side, sector_of(result), _pace(ego), _pace(other)


def _pace(speed: float) -> int:
    return -1 if isnan(speed) else bisect_right(EDGES, abs(speed))
