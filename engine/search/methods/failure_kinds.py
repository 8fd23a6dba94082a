"""Failures bred kind by kind: best-first search until something fails, then from what failed, too.

    archive = everything that was run, with the step by which it was made
    for each generation
        a part of it at random
        of the rest a part as best-first search would have it
        for each other place
            half of the time one kind of failures, that with the fewest runs and children; else all of them
            of these a run whose children fail often, or of which few are known
            a child of it: on the line to another run that touched, between them or beyond either, a little aside;
                or some genes moved by a step, which the child draws near its parent's and keeps

As long as there are few failures, whatever touched is bred from, too, with as much hope as there are failures among it.

What fails is often a small place in the box, and a scene draws the rest: of the children of a failure few fail. How
many do is counted for each that was stepped from, and drawn from what that says (Thompson sampling), so that a search
stays where failures come again and leaves where one was chance. Kinds are those that people are told
(`engine.search.insight.kinds`): whom the ego met, on which side, from where, and how fast both were. The rare ones lie
beside others: they get as many children as the frequent ones, and what is beside them is found from there. Runs that
touch differ in several genes at once, as who is faster starts farther away: lines through two of them say how.

Sources of the parts: cells of behaviour that are filled evenly from what is in them, Mouret and Clune (2015),
"Illuminating search spaces by mapping elites"; lines through two of them, Vassiliades and Mouret (2018), "Discovering
the elite hypervolume by leveraging interspecies correlation"; sampling by what is believed of each arm, Thompson
(1933), "On the likelihood that one unknown probability exceeds another".
"""

from collections.abc import Sequence
from math import isnan

import numpy as np
from numpy.random import Generator

from engine.search.insight.kinds import EDGES
from engine.search.methods.best_first import NONE, BestFirst, sector_of
from engine.search.methods.cube import reflected
from engine.search.protocol import Box, Result, StreamAt, measure
from engine.tables import Floats, Ints

BRED = 0.75
"""Share of what is not run at random that is bred from failures, once there are some."""
EVENLY = 0.5
"""Share of these that goes to all kinds alike."""
FEW = 10
"""With fewer failures than this, whatever touched is bred from, too."""
SPOT = 0.03
"""Standard deviation of a step from a failure whose parent was none: most of the box around it holds none."""
ALONG = 0.8
"""Share of children of what touched that lie on a line to another that did."""
STRETCH, ASIDE = 0.6, 0.02
"""Standard deviations: of where on that line a child lies, 0 its parent and 1 the other, and of how far aside."""

FailureKind = tuple[int, int, int, int, int]


class FailureKinds(BestFirst):
    """As best-first search, an invalid or failed result counts as a try."""

    exploring = 0.2

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._fails, self._touched = np.empty(0, dtype=bool), np.empty(0, dtype=bool)
        self._children_of, self._failures_of = np.empty(0), np.empty(0)
        self._failure_kinds: dict[FailureKind, int] = {}
        self._failure_kind = np.empty(0, dtype=np.int64)

    def _chosen(self, count: int) -> Ints:
        known = self._fails if self._fails.sum() >= FEW else self._fails | self._touched
        sources = np.flatnonzero(known)
        bred = round((BRED if self._fails.any() else BRED / 2.0) * count) if len(sources) else 0
        rows = self._bred_from(sources, bred, self._streams(self._generation, 1))
        return np.concatenate([rows, super()._chosen(count - bred)])

    def _children(self, stream: Generator) -> tuple[Floats, Floats]:
        points, steps = super()._children(stream)
        met = self._fails | self._touched
        along = met[self._stepped_from] & (stream.random(len(points)) < ALONG)
        parents = self._archive[self._stepped_from[along]]
        others = stream.choice(np.flatnonzero(met), size=len(parents))
        self._second[along] = np.where(others == self._stepped_from[along], NONE, others)
        ways = self._archive[others] - parents
        where = STRETCH * stream.standard_normal((len(parents), 1))
        points[along] = reflected(parents + where * ways + ASIDE * stream.standard_normal(parents.shape))
        return points, steps

    def _bred_from(self, sources: Ints, count: int, stream: Generator) -> Ints:
        """(count,) rows to step from, of failures and what else touched."""
        kinds, kind = np.unique(self._failure_kind[sources], return_inverse=True)
        spent = np.bincount(kind, 1.0 + self._children_of[sources], minlength=len(kinds))
        doubt = np.where(self._fails, 1.0, 1.0 + self._touched.sum() / (1.0 + self._fails.sum()))
        rows = np.empty(count, dtype=np.int64)
        for place in range(count):
            evenly = stream.random() < EVENLY
            here = np.flatnonzero(kind == np.argmin(spent)) if evenly else np.arange(len(sources))
            those = sources[here]
            again = self._failures_of[those]
            best = here[np.argmax(stream.beta(1.0 + again, doubt[those] + self._children_of[those] - again))]
            spent[kind[best]] += 1.0
            rows[place] = sources[best]
        return rows

    def _learn(self, results: Sequence[Result]) -> None:
        rows = self._stepped_from
        np.add.at(self._children_of, rows, 1.0)
        np.add.at(self._failures_of, rows, [float(results[slot].failure) for slot in range(len(rows))])
        super()._learn(results)
        slots = [slot for slot, result in enumerate(results) if result.selectable]
        known = [results[slot] for slot in slots]
        failed = np.array([each.failure for each in known], dtype=bool)
        led = np.array([slot < len(rows) and bool(self._fails[rows[slot]]) for slot in slots], dtype=bool)
        steps = self._archived_steps[len(self._fails) :]
        steps[failed & ~led] = np.minimum(steps[failed & ~led], SPOT)
        self._fails = np.append(self._fails, failed)
        self._touched = np.append(self._touched, [measure(each, "min_distance") <= 0.0 for each in known]).astype(bool)
        blank = np.zeros(len(known))
        self._children_of, self._failures_of = (np.append(a, blank) for a in (self._children_of, self._failures_of))
        kinds = [self._failure_kinds.setdefault(failure_kind(each), len(self._failure_kinds)) for each in known]
        self._failure_kind = np.append(self._failure_kind, np.array(kinds, dtype=np.int64))


def failure_kind(result: Result) -> FailureKind:
    """Whom the ego met, on which side, the sector from which the other came, and both speeds; -1 of what is unknown."""
    pair, side = (-1 if isnan(number) else int(number) for number in (measure(result, n) for n in ("pair", "side")))
    ego, other = (measure(result, name) for name in ("ego_speed", "other_speed"))
    return pair, side, sector_of(result), _pace(ego), _pace(other)


def _pace(speed: float) -> int:
    return -1 if isnan(speed) else int(np.searchsorted(EDGES, abs(speed), side="right"))
