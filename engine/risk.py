"""The risk score of the CORTEX-AVD paper (its Table 2): 0 .. 22 for a run, and -1 for an invalid scene.

Each pair (ego, other) scores 10 for contact (C) and 0 .. 4 for each of MD, D_MS and TTC_MS by its band. Bands are
closed below and open above, and nothing is rounded before banding. A scene has the largest risk of its pairs, and the
pair with this risk decides it; see `deciding_pair` for ties. It follows that a collision, with MD = 0, scores at least
14, that 13 cannot occur, and that a score of 14 or more is a collision.

The printed table contradicts itself once (the row "[3780, 4255[" of D_MS overlaps the next; the widths say 4020) and
names no units; `PAPER` is the interpretation that fits the paper's own numbers, `PAPER_MM` the alternative. Thresholds
are data.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from engine.errors import ArgumentError
from engine.kernels.fault import STANDING
from engine.outcomes import Outcomes
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

COLLISION_POINTS = 10
BANDS = 4
HIGHEST_RISK = COLLISION_POINTS + 3 * BANDS
INVALID = -1

Edges = tuple[float, float, float, float]
"""Upper ends of the bands that score 4, 3, 2 and 1, ascending; two equal ends leave the later band empty."""


@dataclass(frozen=True)
class RiskProfile:
    """Upper ends of the bands of each metric. SI units."""

    name: str
    min_distance: Edges
    """Bands of MD [m]."""
    distance_at_ms: Edges
    """Bands of D_MS [m]."""
    ttc_at_ms: Edges
    """Bands of TTC_MS [s]."""

    def __post_init__(self) -> None:
        for metric, edges in (("MD", self.min_distance), ("D_MS", self.distance_at_ms), ("TTC_MS", self.ttc_at_ms)):
            if len(edges) != BANDS or not all(0.0 < edge < np.inf for edge in edges) or list(edges) != sorted(edges):
                raise ArgumentError(
                    f"{metric}: expected {BANDS} positive thresholds in ascending order, got {edges}", "sort them"
                )


PAPER = RiskProfile(
    "paper",
    min_distance=(8.20, 11.00, 13.76, 16.55),
    distance_at_ms=(37.80, 40.20, 42.55, 44.90),
    ttc_at_ms=(3.59, 3.94, 4.29, 4.64),
)
"""Table 2 in centimetres and hundredths of a second: D_MS / TTC_MS at the edges is then 9.7 to 10.5 m/s, the speed of
its scenes."""

PAPER_MM = RiskProfile(
    "paper-mm",
    min_distance=(0.820, 1.100, 1.376, 1.655),
    distance_at_ms=(3.780, 4.020, 4.255, 4.490),
    ttc_at_ms=(0.359, 0.394, 0.429, 0.464),
)
"""Table 2 in millimetres and milliseconds."""

LITERATURE = RiskProfile(
    "literature",
    min_distance=(0.91, 0.91, 1.5, 2.0),
    distance_at_ms=(12.0, 23.0, 36.0, 53.0),
    ttc_at_ms=(1.0, 1.5, 3.0, 4.0),
)
"""Thresholds in common use, from different sources:

- MD: 0.91 m, the three feet of passing laws such as California Vehicle Code 21760; 1.5 m and 2.0 m, the Highway Code of
  Great Britain (2022), rule 163, room for cyclists and pedestrians. None splits the nearest band.
- D_MS: 12, 23, 36 and 53 m, the Highway Code's rule 126, stopping distances from 20, 30, 40 and 50 mph.
- TTC_MS: 1.0 s, the highest severity of Sayed, Brown & Navin (1994), Accid. Anal. Prev. 26(5); 1.5 s, the critical
  value of van der Horst & Hogema (1993), ICTCT workshop; 3.0 s, Minderhoud & Bovy (2001), Accid. Anal. Prev. 33(1); 4.0
  s, Hirst & Graham (1997), in "Ergonomics and Safety of Intelligent Driver Interfaces".
"""

PROFILES: Mapping[str, RiskProfile] = MappingProxyType({p.name: p for p in (PAPER, PAPER_MM, LITERATURE)})
"""Profiles by name; `PAPER` is the default."""


@dataclass(frozen=True)
class Risk:
    """The judgement of n scenes."""

    score: Ints
    """(n,) 0 .. 22, -1 for an invalid scene."""
    continuous: Floats
    """(n,) 0 .. 22, never lower for a worse metric: the largest over the pairs; -1 for an invalid scene."""
    parts: Ints
    """(n, 4) Contributions of C, MD, D_MS and TTC_MS of the deciding pair to the score; 0 for an invalid scene."""
    pair: Ints
    """(n,) Deciding pair: actor `pair + 1`; -1 for an invalid scene or without a pair. A parked object decides only if
    its score is higher than that of every moving partner (`deciding_pair`).
    """

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        valid = self.score[self.score > INVALID]
        text = f"scores {valid.min()} to {valid.max()}, mean {valid.mean():.1f}" if len(valid) else "no score"
        return f"Risk({len(self.score)}: {text}; {len(self.score) - len(valid)} invalid)"


def scores(outcomes: Outcomes, profile: RiskProfile = PAPER) -> Ints:
    """Return (n,) the score of every row, as `assess` computes it."""
    valid = outcomes.verdict == Verdict.VALID
    if outcomes.min_distance.shape[1] == 0:
        return np.where(valid, 0, INVALID)
    return np.where(valid, _parts(outcomes, profile).sum(axis=-1).max(axis=1), INVALID)


def assess(outcomes: Outcomes, profile: RiskProfile = PAPER) -> Risk:
    """Score every row of the outcomes and return its risk."""
    valid = outcomes.verdict == Verdict.VALID
    rows, pairs = map(int, outcomes.min_distance.shape)
    if pairs == 0:
        nothing = np.where(valid, 0, INVALID).astype(np.int32)
        none = np.full(rows, -1, np.int32)
        return Risk(nothing, nothing.astype(np.float64), np.zeros((rows, 4), np.int32), none)
    parts = _parts(outcomes, profile)
    metrics = _metrics(outcomes, profile)
    banded = sum(continuous_score(values, edges) for values, edges in metrics)
    continuous = np.asarray(parts[..., 0] + banded, dtype=np.float64)
    per_pair = parts.sum(axis=-1)
    deciding = deciding_pair(per_pair, continuous, outcomes)
    every = np.arange(rows)
    return Risk(
        score=np.where(valid, per_pair[every, deciding], INVALID).astype(np.int32),
        continuous=np.where(valid, continuous.max(axis=1), float(INVALID)),
        parts=np.where(valid[:, None], parts[every, deciding], 0).astype(np.int32),
        pair=np.where(valid, deciding, -1).astype(np.int32),
    )


def deciding_pair(per_pair: Ints, continuous: Floats, outcomes: Outcomes) -> Ints:
    """Return (n,) the pair that decides the risk of each scene, for any order of the actors: among the pairs with the
    highest score, a pair with a moving partner, then with the highest continuous score, then with the least distance.

    A pair in contact has the highest score (see above). The score precedes motion for two reasons: the four parts of
    the deciding pair add up to the score of the scene, and a further actor never lowers that score. If a moving partner
    with a lower score decided, a distant car would hide a near miss with a parked object. Motion precedes the
    continuous score: of two near misses with equal scores, the conflict with a road user is the one that both sides can
    influence.
    """
    leading = np.ones(per_pair.shape, dtype=np.bool_)
    moving = np.abs(outcomes.other_speed) > STANDING
    for key in (per_pair.astype(np.float64), moving.astype(np.float64), continuous, -outcomes.min_distance):
        value = np.where(leading & ~np.isnan(key), key, -np.inf)
        leading &= value == value.max(axis=1, keepdims=True)
    return leading.argmax(axis=1)


def _metrics(outcomes: Outcomes, profile: RiskProfile) -> tuple[tuple[Floats, Edges], ...]:
    """Return the banded metrics, (n, pairs) each, with their edges."""
    return (
        (outcomes.min_distance, profile.min_distance),
        (outcomes.distance_at_ms, profile.distance_at_ms),
        (outcomes.ttc_at_ms, profile.ttc_at_ms),
    )


def _parts(outcomes: Outcomes, profile: RiskProfile) -> Ints:
    """Return (n, pairs, 4) the contributions of C, MD, D_MS and TTC_MS of each pair to its score."""
    contact = np.where(pairs_in_contact(outcomes), COLLISION_POINTS, 0).astype(np.int32)
    bands = (band_score(values, edges) for values, edges in _metrics(outcomes, profile))
    return np.stack([contact, *bands], axis=-1)


def pairs_in_contact(outcomes: Outcomes) -> Bools:
    """Return (n, pairs) True where this pair (ego, other) touched."""
    others = np.arange(1, int(outcomes.min_distance.shape[1]) + 1)
    with_ego = outcomes.collided & (outcomes.contact_actors[:, 0] == 0)
    return with_ego[:, None] & (outcomes.contact_actors[:, 1:2] == others)


def band_score(values: Floats, edges: Edges) -> Ints:
    """Return 4 below the first edge, 3 from there to below the second, …, 0 from the last edge on, and for NaN."""
    return (BANDS - np.searchsorted(np.asarray(edges), values, side="right")).astype(np.int32)


def continuous_score(values: Floats, edges: Edges) -> Floats:
    """Return a piecewise linear score: 4 at 0 and 3, 2, 1, 0 at the edges; non-increasing, within 1 of the band's
    score.
    """
    score = np.full(np.shape(values), float(BANDS))
    for low, high in zip((0.0, *edges), edges, strict=False):
        if high > low:
            score -= np.clip((values - low) / (high - low), 0.0, 1.0)
        else:
            score -= values >= high
    return np.where(np.isnan(values), 0.0, score)
