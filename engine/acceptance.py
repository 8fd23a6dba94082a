"""Acceptance by requirement: every requirement evaluated on each of many independent attempts.

Rejection sampling stops an attempt at its first failure, so its counts contain little about later requirements. Here no
attempt stops: each has its own genome and draws, and for each requirement its truth and, if defined, its margin. The
acceptance without a requirement, the requirement to relax with its amount, and contradictions are then counts over one
table of truths.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from engine.config import SimulationConfig
from engine.fairness import fair_starts, undecided
from engine.feasibility import conflicts
from engine.kernels.attempts import Weighed, weigh_rows
from engine.program import Program, checking
from engine.sampling import draw_genomes, recipe_of, request_of, rows_at_once, scratch_of
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

DRAWS = 10_000
ENOUGH = 0.5
"""Acceptance from which on no relaxation is suggested."""
LEAST_TARGET = 0.01
BLOCK = 50_000
"""Attempts made in one uninterruptible call; fewer for many actors."""
PAIRS = 1_000_000_000
"""Maximum number of pairs of actors that are compared; ten thousand attempts with three hundred actors have as many."""


LOOKED_AT = 50
"""Maximum number of objects whose departures from the road are counted."""
LOOKS = 2_000
"""Maximum number of attempts in which they are counted."""


@dataclass(frozen=True)
class OffRoad:
    """An object whose outline leaves the road."""

    actor: int
    share: float
    """Share of the rejected attempts in which it does."""


@dataclass(frozen=True)
class AcceptanceStatistics:
    """Evaluation of every requirement on n attempts. Requirements are those of `Program.requirements`, in order."""

    program: Program
    genomes: Floats
    """(n, genes) file units."""
    variant: Ints
    """(n,)"""
    holds: np.ndarray
    """(n, requirements) bool. In an attempt with a rejected variant only the rejection fails; a soft requirement holds
    if its random draw exempts the attempt.
    """
    margins: Floats
    """(n, requirements) Margin by which each holds, in the unit of `Requirement.unit`; NaN if undefined."""
    off_road: tuple[OffRoad, ...] = ()
    """Objects that leave the road in some of its first attempts, the most frequent first."""

    def __len__(self) -> int:
        return len(self.holds)

    @property
    def accepted(self) -> np.ndarray:
        """Return (n,) bool: True where an attempt passes."""
        return np.asarray(self.holds.all(axis=1))

    @property
    def acceptance(self) -> float:
        """Return the share of the attempts that pass."""
        return _share(self.accepted)


@dataclass(frozen=True)
class Blame:
    """Effect of one requirement on acceptance."""

    requirement: int
    alone: float
    """Share of all attempts in which it holds."""
    tested: int
    """Attempts in which all earlier requirements hold; rejected variants come first, as in sampling."""
    failed: int
    """Tested attempts in which it fails."""
    only: int
    """Attempts in which it alone fails."""
    without: float
    """Acceptance without it."""
    nearest: int
    """Attempt with its smallest violation, among those with the fewest further failures; -1 if it never fails or has no
    margin.
    """
    others: int
    """Number of further failures in that attempt."""

    @property
    def given_earlier(self) -> float:
        """Return the share of the tested attempts in which it holds; NaN without any."""
        return 1.0 - self.failed / self.tested if self.tested else math.nan


@dataclass(frozen=True)
class Relaxation:
    """A requirement that, relaxed alone, brings acceptance to a target."""

    requirement: int
    amount: float
    """Amount of the relaxation, in the unit of its margin; infinite if only its removal suffices, or if unknown."""
    acceptance: float
    """Acceptance of these attempts after the relaxation."""


@dataclass(frozen=True)
class Conflict:
    """A smallest set of requirements that no attempt met."""

    requirements: tuple[int, ...]
    proved: bool
    """True if intervals prove that no attempt can; else it is an observation."""


@dataclass(frozen=True)
class Account:
    """All results of an evaluation, for reports."""

    weighing: AcceptanceStatistics
    blames: tuple[Blame, ...]
    target: float | None
    """Target acceptance; None if there is no need."""
    relaxations: tuple[Relaxation, ...]
    conflict: Conflict | None


def account(weighing: AcceptanceStatistics, target: float | None = None) -> Account:
    """Return all results of an evaluation, for the given target or the default target."""
    found = blames(weighing)
    target = _default_target(weighing, found) if target is None else target
    relaxed = () if target is None else relaxations(weighing, target)
    return Account(weighing, found, target, relaxed, smallest_conflict(weighing))


def _default_target(weighing: AcceptanceStatistics, found: Sequence[Blame]) -> float | None:
    """Return twice the present acceptance and at least 1 %, or half of the possible value if that is less.

    None if half of the attempts pass already, or no single requirement changes acceptance.
    """
    acceptance, best = weighing.acceptance, max((blame.without for blame in found), default=0.0)
    if not acceptance < min(ENOUGH, best):
        return None
    return min(max(LEAST_TARGET, 2.0 * acceptance), 0.5 * (acceptance + best))


def measure_acceptance(
    program: Program, count: int = DRAWS, seed: int = 0, genome: Floats | None = None
) -> AcceptanceStatistics:
    """Make `count` attempts, with genes from their own distributions, or all from one genome (d,)."""
    count = max(1, min(rows_at_once(program, count), PAIRS // len(program.actors) ** 2))
    block = max(1, min(BLOCK, PAIRS // 50 // len(program.actors) ** 2))
    starts = [*range(0, count, block), count]
    blocks = [_weigh_block(program, np.arange(*ends), seed, genome) for ends in pairwise(starts)]
    genomes, variants, holds, margins = (np.concatenate(arrays) for arrays in zip(*blocks, strict=True))
    off_road = _off_road(program, holds[:LOOKS], seed, genome)
    return AcceptanceStatistics(program, genomes, variants, holds, margins, off_road)


def _off_road(program: Program, holds: np.ndarray, seed: int, genome: Floats | None) -> tuple[OffRoad, ...]:
    """Repeat the attempts for each object, with the road requirement for that object alone."""
    rejected, road = ~holds.all(axis=1), program.first_built_in
    if holds[:, road].all():
        return ()
    found: list[OffRoad] = []
    for actor in np.flatnonzero(program.code.road_check)[:LOOKED_AT].tolist():
        alone = replace(checking(program, road=[actor], overlap=[]), settings=replace(program.settings, fair=False))
        _, _, there, _ = _weigh_block(alone, np.arange(len(holds)), seed, genome)
        if share := _share(~there[rejected, road]):
            found.append(OffRoad(actor, share))
    return tuple(sorted(found, key=lambda each: (-each.share, each.actor)))


def _weigh_block(
    program: Program, indices: Ints, seed: int, genome: Floats | None
) -> tuple[Floats, Ints, np.ndarray, Floats]:
    keys = key_rows(seed, Method.SAMPLE, 0, 0, indices)
    genomes = draw_genomes(program.space, keys) if genome is None else np.tile(genome, (len(keys), 1))
    recipe, request = recipe_of(program), request_of(program, genomes, keys, 1)
    rows, file = len(keys), recipe.layout.requirements
    out = Weighed(
        variant=np.zeros(rows, dtype=np.int32),
        holds=np.ones((rows, len(program.requirements)), dtype=np.int32),
        margins=np.full((rows, file), np.nan),
        values=np.zeros((rows, program.code.output_register.shape[1])),
    )
    weigh_rows(recipe, request, scratch_of(recipe), out)
    if program.settings.fair:
        out.holds[:, -1] = _fair(program, out, keys)
    margins = np.full((rows, len(program.requirements)), np.nan)
    margins[:, :file] = out.margins
    return genomes, out.variant, out.holds.astype(bool), margins


def _fair(program: Program, weighed: Weighed, keys: Ints) -> Bools:
    """Return (n,) True for fair starts; an attempt without a run counts as fair."""
    drawn = (program.code.variant_template[weighed.variant] >= 0) & ~np.isnan(weighed.values).any(axis=1)
    verdict = np.where(drawn, Verdict.VALID, Verdict.ERROR).astype(np.int32)
    starts = undecided(verdict, weighed.variant, weighed.values, keys)
    step = program.settings.time_step or SimulationConfig().time_step
    return ~drawn | fair_starts(program, starts, SimulationConfig(time_step=step))


def blames(weighing: AcceptanceStatistics) -> tuple[Blame, ...]:
    """Return the effect of each requirement, in the order of `Program.requirements`."""
    holds = weighing.holds
    earlier = np.ones(len(holds), dtype=bool)
    tested: dict[int, tuple[int, int]] = {}
    for requirement in testing_order(weighing.program):
        tested[requirement] = int(earlier.sum()), int((earlier & ~holds[:, requirement]).sum())
        earlier &= holds[:, requirement]
    failures = (~holds).sum(axis=1)
    return tuple(
        Blame(
            requirement,
            _share(holds[:, requirement]),
            *tested[requirement],
            only=int(((failures == 1) & ~holds[:, requirement]).sum()),
            without=_share(failures - ~holds[:, requirement] == 0),
            **_nearest(weighing, requirement, failures),
        )
        for requirement in range(holds.shape[1])
    )


def testing_order(program: Program) -> list[int]:
    """Return the order of tests; rejected variants come first."""
    file = program.code.requirement_segment.shape[1]
    reasons = program.first_built_in
    return [*range(file, reasons), *range(file), *range(reasons, len(program.requirements))]


def _nearest(weighing: AcceptanceStatistics, requirement: int, failures: Ints) -> dict[str, int]:
    margins = weighing.margins[:, requirement]
    rows = np.flatnonzero(~weighing.holds[:, requirement] & np.isfinite(margins))
    if not len(rows):
        return {"nearest": -1, "others": 0}
    best = rows[np.lexsort((-margins[rows], failures[rows]))[0]]
    return {"nearest": int(best), "others": int(failures[best]) - 1}


def _share(chosen: np.ndarray) -> float:
    return float(chosen.mean()) if len(chosen) else math.nan


def relaxations(weighing: AcceptanceStatistics, target: float) -> tuple[Relaxation, ...]:
    """Return every single requirement of the file that can bring acceptance to the target, cheapest first.

    With the requirement removed, k = ceil(target n) attempts must pass: the amount is the deficit of the k-th best
    margin among the attempts in which all others hold. Known amounts come first, then requirements that affect few
    attempts.
    """
    count = len(weighing)
    wanted = min(count, max(1, math.ceil(target * count - 1e-9)))
    if weighing.accepted.sum() >= wanted:
        return ()
    failures = (~weighing.holds).sum(axis=1)
    found: list[Relaxation] = []
    for requirement in range(weighing.program.code.requirement_segment.shape[1]):
        others = failures - ~weighing.holds[:, requirement] == 0
        if others.sum() >= wanted:
            found.append(_relaxation(weighing, requirement, others, wanted))
    return tuple(sorted(found, key=lambda r: (math.isinf(r.amount), -r.acceptance, r.requirement)))


def _relaxation(weighing: AcceptanceStatistics, requirement: int, others: np.ndarray, wanted: int) -> Relaxation:
    holds = weighing.holds[others, requirement]
    margins = np.where(holds, np.inf, weighing.margins[others, requirement])
    ordered = np.sort(np.where(np.isnan(margins), -np.inf, margins))[::-1]
    limit = float(ordered[wanted - 1])
    reached = int((ordered >= limit).sum()) / len(weighing)
    return Relaxation(requirement, math.inf if math.isinf(limit) else -limit, reached)


def smallest_conflict(weighing: AcceptanceStatistics) -> Conflict | None:
    """Return a smallest set of requirements that no attempt meets; None if an attempt meets all requirements."""
    if not len(weighing) or weighing.accepted.any():
        return None
    failed = _minimal({frozenset(np.flatnonzero(row).tolist()) for row in np.unique(~weighing.holds, axis=0)})
    size = 1
    while (found := next(_hitting(failed, frozenset(), size), None)) is None:
        size += 1
    requirements = tuple(sorted(found))
    return Conflict(requirements, conflicts(weighing.program, requirements))


def _minimal(sets: set[frozenset[int]]) -> list[frozenset[int]]:
    """Return the sets that contain no other set: a set that intersects these intersects all."""
    minimal: list[frozenset[int]] = []
    for candidate in sorted(sets, key=lambda s: (len(s), sorted(s))):
        if not any(other <= candidate for other in minimal):
            minimal.append(candidate)
    return minimal


def _hitting(sets: list[frozenset[int]], chosen: frozenset[int], left: int) -> Iterator[frozenset[int]]:
    """Yield sets with at most `left` more members that intersect each of `sets`, by members of the first missed set."""
    missed = next((s for s in sets if s.isdisjoint(chosen)), None)
    if missed is None:
        yield chosen
    elif left:
        for member in sorted(missed):
            yield from _hitting(sets, chosen | {member}, left - 1)
