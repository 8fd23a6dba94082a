"""Kinds of failures, in the space of what happened, whatever led to it.

Two collisions are of one kind when the ego met the same other on the same side of itself, heading the same way as seen
from it (a sector of 45 degrees), when each of the two stood or was about as fast, and when the reference driver says
the same of both: it avoids them, it does not, or they are no failure of the ego. There are a few hundred kinds at most,
so that their number has an end, as the number of genomes has not.

The speeds that part kinds are those of zones where people walk, of towns, and of roads outside: *ours*.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.kernels.fault import STANDING
from engine.search.evaluations import Evaluations
from engine.search.insight.diversity import KMH, SECTORS, sector
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Blame, Side, Verdict

SPEEDS = (30.0, 50.0, 70.0)
"""What parts those that move [km/h] …"""
EDGES = (STANDING, *(speed * KMH for speed in SPEEDS))
"""… and all [m/s]."""
PACES = ("stands", f"< {SPEEDS[0]:g}", *(f"{a:g} .. {b:g}" for a, b in pairwise(SPEEDS)), f"> {SPEEDS[-1]:g}")
"""How fast either is [km/h]."""

Blaming = Callable[[Floats, Ints], Ints]
"""(genomes (n, d), stream keys (n, 6)) -> (n,) `Blame` of each of these runs."""


@dataclass(frozen=True)
class Kind:
    """One kind; that of a run without contact is of where the two were closest, and its blame `NONE`."""

    pair: int
    """The ego and actor `pair` + 1."""
    side: Side
    """Of the ego, on which the other was."""
    sector: int
    """Of `SECTORS`: heading of the other as seen from the ego."""
    ego_speed: int
    """Of `PACES`."""
    other_speed: int
    blame: Blame

    @property
    def heading(self) -> str:
        return SECTORS[self.sector]


@dataclass(frozen=True)
class FoundKind:
    """One kind of collisions that a search found."""

    kind: Kind
    count: int
    """Distinct simulations."""
    row: int
    """Of the evaluations, of the first of them …"""
    rollout: int
    """… and which of its rollouts."""


@dataclass(frozen=True)
class Failures:
    """What the distinct simulations of a search came to."""

    valid: int
    """Valid simulations …"""
    collisions: int
    """… those of them in which the ego collided …"""
    avoidable: int
    """… those of these that the reference driver avoids …"""
    struck: int
    """… those that are no failure of the ego: it was struck from behind, or while it stood …"""
    unknown: int
    """… and those of which nothing is known: the reference driver was not asked."""
    without_ego: int
    """Simulations in which two others touched."""
    lost: int
    """Simulations over which a controller failed, so that nothing is known of them."""
    kinds: int
    """Of the collisions."""
    avoidable_kinds: int

    @property
    def judged(self) -> bool:
        """Whether the reference driver was asked about a collision; also where there is no collision to ask about.

        Otherwise nothing is known of the counts by blame: they are no zeros.
        """
        return self.unknown < self.collisions or not self.collisions

    def share(self, count: int) -> float:
        """What share of valid simulations a count stands for: (n + 1) / (N + 2), Laplace's rule of succession, as none
        found in N is not never.
        """
        return (count + 1) / (self.valid + 2)


def blamed(evaluations: Evaluations, blaming: Blaming | None) -> Ints:
    """(n, k) `Blame` of each rollout; `NONE` also of what was not simulated again, and of all where nobody is asked."""
    said = np.full(evaluations.rollouts.verdict.shape, int(Blame.NONE), dtype=np.int32)
    hit = _collisions(evaluations)
    if blaming is not None and hit.any():
        rows = np.nonzero(hit)[0]
        said[hit] = blaming(evaluations.genomes[rows], evaluations.keys[hit])
    return said


def codes(evaluations: Evaluations, blame: Ints) -> Ints:
    """(n, k, 6) the kind of every rollout, in the order of `Kind`'s fields."""
    runs = evaluations.rollouts
    ego, other = (
        np.searchsorted(EDGES, np.abs(np.nan_to_num(speed)), side="right")
        for speed in (runs.ego_speed, runs.other_speed)
    )
    return np.stack([runs.pair, runs.side, sector(runs.approach_angle), ego, other, blame], axis=-1)


def kinds(evaluations: Evaluations, blame: Ints) -> tuple[FoundKind, ...]:
    """The kinds of a search's collisions: those that can be avoided first, then the most frequent."""
    rows, rollouts = np.nonzero(_collisions(evaluations))
    every = codes(evaluations, blame)[rows, rollouts]
    found, first, counts = np.unique(every, axis=0, return_index=True, return_counts=True)
    made = [
        FoundKind(_kind(*code), int(count), int(rows[at]), int(rollouts[at]))
        for code, at, count in zip(found.tolist(), first.tolist(), counts.tolist(), strict=True)
    ]
    return tuple(sorted(made, key=lambda each: (each.kind.blame != Blame.AVOIDABLE, -each.count, each.row)))


def _kind(pair: int, side: int, direction: int, ego: int, other: int, blame: int) -> Kind:
    return Kind(pair, Side(side), direction, ego, other, Blame(blame))


def failures(evaluations: Evaluations, blame: Ints) -> Failures:
    """The counts of a search."""
    hit, new = _collisions(evaluations), evaluations.simulated
    said = blame[hit]
    found = kinds(evaluations, blame)
    return Failures(
        valid=int((evaluations.rollouts.verdict[new] == 0).sum()),
        collisions=int(hit.sum()),
        avoidable=int((said == Blame.AVOIDABLE).sum()),
        struck=int((said == Blame.STRUCK).sum()),
        unknown=int((said == Blame.NONE).sum()),
        lost=int((evaluations.rollouts.verdict[new] == Verdict.CONTROLLER).sum()),
        without_ego=int(np.isfinite(evaluations.rollouts.others_contact_time[new]).sum()),
        kinds=len(found),
        avoidable_kinds=sum(each.kind.blame == Blame.AVOIDABLE for each in found),
    )


def _collisions(evaluations: Evaluations) -> Bools:
    """(n, k) distinct simulations in which the ego collided."""
    return np.asarray(evaluations.rollouts.collided & evaluations.simulated[:, np.newaxis])
