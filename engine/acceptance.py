"""Which requirement rejects attempts: every requirement tested on every one of many independent attempts.

Rejection sampling stops an attempt at its first failure, so its counts say little about what stands further down. Here
nothing stops: each attempt has a genome and draws of its own, and for each requirement its truth and, where there is
such a number, its margin. What acceptance would be without a requirement, which one to relax and by how much, and what
contradicts what, are then plain counts over one table of truths.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from engine.built_in import checking
from engine.config import SimulationConfig
from engine.fairness import fair_starts, undecided
from engine.feasibility import conflicts
from engine.kernels.attempts import Weighed, weigh_rows
from engine.program import Program
from engine.sampling import draw_genomes, recipe_of, request_of, rows_at_once, scratch_of
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

DRAWS = 10_000
ENOUGH = 0.5
"""Acceptance from which no relaxation is suggested."""
LEAST_TARGET = 0.01
BLOCK = 50_000
"""Attempts made in one uninterruptible call, or fewer of many actors."""
PAIRS = 1_000_000_000
"""Pairs of actors that are held against one another; ten thousand attempts at three hundred actors have as many."""


LOOKED_AT = 50
"""Objects of which it is found out how often they leave the road, at most …"""
LOOKS = 2_000
"""… and the attempts in which that is counted."""


@dataclass(frozen=True)
class OffRoad:
    """An object whose outline leaves the road."""

    actor: int
    share: float
    """Share of the rejected attempts in which it does."""


@dataclass(frozen=True)
class Weighing:
    """n attempts, every requirement evaluated on each. Requirements are those of `Program.requirements`, in order."""

    program: Program
    genomes: Floats
    """(n, genes) file units."""
    variant: Ints
    """(n,)"""
    holds: np.ndarray
    """(n, requirements) bool. In an attempt whose variant is rejected only the rejection fails; a soft requirement
    whose coin spares the attempt holds."""
    margins: Floats
    """(n, requirements) by how much each holds, in the unit of `Requirement.unit`; NaN where that is no number."""
    off_road: tuple[OffRoad, ...] = ()
    """The objects that leave the road in some of its first attempts, the most frequent one first."""

    def __len__(self) -> int:
        return len(self.holds)

    @property
    def accepted(self) -> np.ndarray:
        """(n,) bool: whether an attempt passes."""
        return np.asarray(self.holds.all(axis=1))

    @property
    def acceptance(self) -> float:
        """Share of the attempts that pass."""
        return _share(self.accepted)


@dataclass(frozen=True)
class Blame:
    """What one requirement does."""

    requirement: int
    alone: float
    """Share of all attempts in which it holds."""
    tested: int
    """Attempts in which all earlier ones hold; rejected variants come first, as in sampling."""
    failed: int
    """Those among them in which it fails."""
    only: int
    """Attempts in which it alone fails."""
    without: float
    """What acceptance would be without it."""
    nearest: int
    """The attempt that it fails by least, among those in which the fewest others fail; -1 if it never fails or has no
    margin."""
    others: int
    """How many others fail there."""

    @property
    def given_earlier(self) -> float:
        """Share of the tested in which it holds; NaN without any."""
        return 1.0 - self.failed / self.tested if self.tested else math.nan


@dataclass(frozen=True)
class Relaxation:
    """One requirement that, relaxed alone, brings acceptance to a target."""

    requirement: int
    amount: float
    """By how much, in the unit of its margin; infinite where only leaving it out does, or the amount is unknown."""
    acceptance: float
    """What is then accepted, in these attempts."""


@dataclass(frozen=True)
class Conflict:
    """A smallest set of requirements of which no attempt met all."""

    requirements: tuple[int, ...]
    proved: bool
    """Whether intervals prove that none ever can; else it is what was seen."""


@dataclass(frozen=True)
class Account:
    """All that follows from a weighing, ready to be shown."""

    weighing: Weighing
    blames: tuple[Blame, ...]
    target: float | None
    """The acceptance to reach; None where there is no need."""
    relaxations: tuple[Relaxation, ...]
    conflict: Conflict | None


def account(weighing: Weighing, target: float | None = None) -> Account:
    """Return everything that follows from a weighing, for the given target or the default one."""
    found = blames(weighing)
    target = _default_target(weighing, found) if target is None else target
    relaxed = () if target is None else relaxations(weighing, target)
    return Account(weighing, found, target, relaxed, smallest_conflict(weighing))


def _default_target(weighing: Weighing, found: Sequence[Blame]) -> float | None:
    """Twice the present acceptance and at least 1 %, or half of what one requirement can give if that is less.

    None where half of the attempts pass already, or no single requirement makes a difference.
    """
    acceptance, best = weighing.acceptance, max((blame.without for blame in found), default=0.0)
    if not acceptance < min(ENOUGH, best):
        return None
    return min(max(LEAST_TARGET, 2.0 * acceptance), 0.5 * (acceptance + best))


def weigh(program: Program, count: int = DRAWS, seed: int = 0, genome: Floats | None = None) -> Weighing:
    """Make `count` attempts, genes from their own distributions, or all from one genome (d,)."""
    count = max(1, min(rows_at_once(program, count), PAIRS // len(program.actors) ** 2))
    block = max(1, min(BLOCK, PAIRS // 50 // len(program.actors) ** 2))
    starts = [*range(0, count, block), count]
    blocks = [_weigh_block(program, np.arange(*ends), seed, genome) for ends in pairwise(starts)]
    genomes, variants, holds, margins = (np.concatenate(arrays) for arrays in zip(*blocks, strict=True))
    off_road = _off_road(program, holds[:LOOKS], seed, genome)
    return Weighing(program, genomes, variants, holds, margins, off_road)


def _off_road(program: Program, holds: np.ndarray, seed: int, genome: Floats | None) -> tuple[OffRoad, ...]:
    """The same attempts once more for each object, the road being asked of that object alone."""
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
    """Whether each attempt is a fair start; one of which no run can be made is not to blame."""
    drawn = (program.code.variant_template[weighed.variant] >= 0) & ~np.isnan(weighed.values).any(axis=1)
    verdict = np.where(drawn, Verdict.VALID, Verdict.ERROR).astype(np.int32)
    starts = undecided(verdict, weighed.variant, weighed.values, keys)
    step = program.settings.time_step or SimulationConfig().time_step
    return ~drawn | fair_starts(program, starts, SimulationConfig(time_step=step))


def blames(weighing: Weighing) -> tuple[Blame, ...]:
    """What each requirement does, in the order of `Program.requirements`."""
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
    """Rejected variants come before everything else."""
    file = program.code.requirement_segment.shape[1]
    reasons = program.first_built_in
    return [*range(file, reasons), *range(file), *range(reasons, len(program.requirements))]


def _nearest(weighing: Weighing, requirement: int, failures: Ints) -> dict[str, int]:
    margins = weighing.margins[:, requirement]
    rows = np.flatnonzero(~weighing.holds[:, requirement] & np.isfinite(margins))
    if not len(rows):
        return {"nearest": -1, "others": 0}
    best = rows[np.lexsort((-margins[rows], failures[rows]))[0]]
    return {"nearest": int(best), "others": int(failures[best]) - 1}


def _share(chosen: np.ndarray) -> float:
    return float(chosen.mean()) if len(chosen) else math.nan


def relaxations(weighing: Weighing, target: float) -> tuple[Relaxation, ...]:
    """Every single requirement of the file that can bring acceptance to the target, cheapest for the file first.

    With the requirement left out k = ceil(target n) attempts must pass: the amount is what the k-th best margin among
    those in which all others hold lacks. Known amounts come first, the ones that few attempts hang on before others.
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


def _relaxation(weighing: Weighing, requirement: int, others: np.ndarray, wanted: int) -> Relaxation:
    holds = weighing.holds[others, requirement]
    margins = np.where(holds, np.inf, weighing.margins[others, requirement])
    ordered = np.sort(np.where(np.isnan(margins), -np.inf, margins))[::-1]
    limit = float(ordered[wanted - 1])
    reached = int((ordered >= limit).sum()) / len(weighing)
    return Relaxation(requirement, math.inf if math.isinf(limit) else -limit, reached)


def smallest_conflict(weighing: Weighing) -> Conflict | None:
    """A smallest set of requirements of which no attempt meets all; None where some attempt meets all there are."""
    if not len(weighing) or weighing.accepted.any():
        return None
    failed = _minimal({frozenset(np.flatnonzero(row).tolist()) for row in np.unique(~weighing.holds, axis=0)})
    size = 1
    while (found := next(_hitting(failed, frozenset(), size), None)) is None:
        size += 1
    requirements = tuple(sorted(found))
    return Conflict(requirements, conflicts(weighing.program, requirements))


def _minimal(sets: set[frozenset[int]]) -> list[frozenset[int]]:
    """Return the sets that contain no other set: what meets these meets all."""
    kept: list[frozenset[int]] = []
    for candidate in sorted(sets, key=lambda s: (len(s), sorted(s))):
        if not any(other <= candidate for other in kept):
            kept.append(candidate)
    return kept


def _hitting(sets: list[frozenset[int]], chosen: frozenset[int], left: int) -> Iterator[frozenset[int]]:
    """Sets of at most `left` more members that meet each of `sets`: some member of the first one missed is in it."""
    missed = next((s for s in sets if s.isdisjoint(chosen)), None)
    if missed is None:
        yield chosen
    elif left:
        for member in sorted(missed):
            yield from _hitting(sets, chosen | {member}, left - 1)
