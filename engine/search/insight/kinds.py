"""Kinds of failures, defined by the collision alone and not by its genome.

Two collisions are of one kind if these agree: the actor that the ego met; the side of the ego on which it was; its
heading relative to the ego (a sector of 45 degrees); for each of both, whether it stood or its range of speed; and the
verdict of the reference drivers: avoidable, disputed, unavoidable, covered by no model, or no failure of the ego. There
are a few hundred kinds at most, so their number is bounded, unlike the number of genomes.

The speeds that separate kinds are those of zones with pedestrians, of towns, and of rural roads: *a choice of cortexc*.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from types import EllipsisType

import numpy as np

from engine.kernels.fault import STANDING
from engine.outcomes import Assessment
from engine.search.evaluations import Evaluations
from engine.search.insight.diversity import KMH, SECTORS, sector
from engine.search.probability.unseen import NO_KIND
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import BLAMEWORTHY, Blame, Side, Verdict

SPEEDS = (30.0, 50.0, 70.0)
"""Speeds that separate the kinds of moving actors [km/h]."""
EDGES = (STANDING, *(speed * KMH for speed in SPEEDS))
"""Edges of all ranges of speed [m/s]; the first separates standing from moving actors."""
PACES = ("stands", f"< {SPEEDS[0]:g}", *(f"{a:g} .. {b:g}" for a, b in pairwise(SPEEDS)), f"> {SPEEDS[-1]:g}")
"""Labels of the ranges of speed [km/h]."""

Blaming = Callable[[Floats, Ints], Ints]
"""(genomes (n, d), stream keys (n, 6)) -> (n,) `Blame` of each of these runs."""


@dataclass(frozen=True)
class Kind:
    """One kind of run. Without a contact, it describes the closest approach and its blame is `NONE`."""

    pair: int
    """The ego and actor `pair` + 1."""
    side: Side
    """Side of the ego on which the other actor was."""
    sector: int
    """Heading of the other actor relative to the ego, as an index of `SECTORS`."""
    ego_speed: int
    """Speed of the ego, as an index of `PACES`."""
    other_speed: int
    blame: Blame

    @property
    def heading(self) -> str:
        return SECTORS[self.sector]


@dataclass(frozen=True)
class FoundKind:
    """One kind of collision that a search found."""

    kind: Kind
    count: int
    """Distinct simulations."""
    row: int
    """Row of its first collision in the evaluations."""
    rollout: int
    """Rollout of its first collision."""


@dataclass(frozen=True)
class Failures:
    """Outcome counts of the distinct simulations of a search."""

    valid: int
    """Valid simulations."""
    collisions: int
    """Valid simulations in which the ego collided."""
    avoidable: int
    """Collisions that all reference drivers avoid, among those whose range covers them."""
    disputed: int
    """Collisions that some of them avoid."""
    unavoidable: int
    """Collisions that none of them avoids."""
    no_model: int
    """Collisions that no reference driver covers."""
    struck: int
    """Collisions in which the ego was struck from behind or while it stood: no failure of the ego."""
    unknown: int
    """Collisions without a verdict, because no reference driver was run."""
    without_ego: int
    """Simulations in which two actors other than the ego touched."""
    lost: int
    """Simulations in which a controller failed, so that their outcome is unknown."""
    kinds: int
    """Number of kinds of collisions."""
    avoidable_kinds: int

    @property
    def judged(self) -> bool:
        """Return True if a reference driver was run for a collision, or if there is no collision.

        Otherwise the counts by blame are unknown, not zero.
        """
        return self.unknown < self.collisions or not self.collisions


def estimated_share(count: int, valid: int) -> float:
    """Return the estimated share of an event with this count among valid simulations: (n + 1) / (N + 2).

    It is positive without an event, as none in N simulations does not prove a share of zero. Source: Laplace's rule of
    succession.
    """
    return (count + 1) / (valid + 2)


def blamed(evaluations: Evaluations, blaming: Blaming | None) -> Ints:
    """Return (n, k) `Blame` of each rollout; `NONE` if it was not simulated here, and everywhere without `blaming`."""
    said = np.full(evaluations.rollouts.verdict.shape, int(Blame.NONE), dtype=np.int32)
    hit = collisions_of(evaluations)
    if blaming is not None and hit.any():
        rows = np.nonzero(hit)[0]
        said[hit] = blaming(evaluations.genomes[rows], evaluations.keys[hit])
    return said


def codes(runs: Assessment, blame: Ints, at: tuple[Ints, Ints] | EllipsisType = ...) -> Ints:
    """Return (…, 6) the kind of every run, in the order of `Kind`'s fields; `blame` has the shape of the runs.

    `at`: the chosen runs, as (m,) rows and (m,) rollouts.
    """
    ego, other = (
        np.searchsorted(EDGES, np.abs(np.nan_to_num(speed[at])), side="right")
        for speed in (runs.ego_speed, runs.other_speed)
    )
    return np.stack([runs.pair[at], runs.side[at], sector(runs.approach_angle[at]), ego, other, blame[at]], axis=-1)


def codes_of_draws(runs: Assessment, failed: Bools) -> Ints:
    """Return (valid runs, 6) the kinds of the valid runs, without a verdict; `NO_KIND` for one that did not fail."""
    valid = runs.verdict == Verdict.VALID
    every = codes(runs, np.full(len(valid), int(Blame.NONE), dtype=np.int32))
    return np.where(failed[:, np.newaxis], every, NO_KIND)[valid].astype(np.int16)


def kinds(evaluations: Evaluations, blame: Ints) -> tuple[FoundKind, ...]:
    """Return the kinds of a search's collisions: avoidable and disputed ones first, then the most frequent."""
    rows, rollouts = np.nonzero(collisions_of(evaluations))
    every = codes(evaluations.rollouts, blame, (rows, rollouts))
    _, first, counts = np.unique(numbered(every), return_index=True, return_counts=True)
    made = [
        FoundKind(kind_of(*code), int(count), int(rows[at]), int(rollouts[at]))
        for code, at, count in zip(every[first].tolist(), first.tolist(), counts.tolist(), strict=True)
    ]
    return tuple(sorted(made, key=lambda each: (int(blame_order(each.kind.blame)), -each.count, each.row)))


def blame_order(blame: Ints | int) -> Ints:
    """Return the place of verdicts in an order of failures: 0 avoidable, 1 disputed, 2 all others."""
    order = np.full(len(Blame), len(BLAMEWORTHY))
    order[list(BLAMEWORTHY)] = range(len(BLAMEWORTHY))
    return order[blame]


def numbered(codes: Ints) -> Ints:
    """Return (n,) a number for each row of whole numbers (n, m) from small ranges, in the order of the rows."""
    number = np.zeros(len(codes), dtype=np.int64)
    for column in codes.T:
        least = int(column.min(initial=0))
        number = number * (int(column.max(initial=0)) - least + 1) + (column - least)
    return number


def kind_of(pair: int, side: int, direction: int, ego: int, other: int, blame: int) -> Kind:
    """Return the kind of a row of `codes`."""
    return Kind(pair, Side(side), direction, ego, other, Blame(blame))


def failures(evaluations: Evaluations, blame: Ints) -> Failures:
    """Return the counts of failures in a search."""
    hit, new = collisions_of(evaluations), evaluations.simulated
    said = blame[hit]
    found = kinds(evaluations, blame)
    return Failures(
        valid=int((evaluations.rollouts.verdict[new] == 0).sum()),
        collisions=int(hit.sum()),
        avoidable=int((said == Blame.AVOIDABLE).sum()),
        disputed=int((said == Blame.DISPUTED).sum()),
        unavoidable=int((said == Blame.UNAVOIDABLE).sum()),
        no_model=int((said == Blame.NO_MODEL).sum()),
        struck=int((said == Blame.STRUCK).sum()),
        unknown=int((said == Blame.NONE).sum()),
        lost=int((evaluations.rollouts.verdict[new] == Verdict.CONTROLLER).sum()),
        without_ego=int(np.isfinite(evaluations.rollouts.others_contact_time[new]).sum()),
        kinds=len(found),
        avoidable_kinds=sum(each.kind.blame == Blame.AVOIDABLE for each in found),
    )


def collisions_of(evaluations: Evaluations) -> Bools:
    """Return (n, k) True for distinct simulations in which the ego collided."""
    return np.asarray(evaluations.rollouts.collided & evaluations.simulated[:, np.newaxis])
