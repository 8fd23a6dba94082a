"""Bounds for the draws of given genomes, which `--prune` passes to the sampler.

For a genome and a variant v, every attempt that passes has its draws in the box B(v). Let p(v) be the variant's
probability and |B(v)| the box's volume: an attempt falls among the boxes with probability m, the sum of p(v) |B(v)|,
and all others surely fail. Attempts are independent, so the number of attempts outside before the next attempt inside
is geometric with parameter m, and the attempt inside has variant v with probability p(v) |B(v)| / m and draws uniform
over B(v). The sampler draws exactly these: it jumps over the geometric number, which counts against `max_attempts`, and
makes the attempt inside. Verdict, variant and draws of each genome have the same distribution as without pruning, for
any limit on attempts. Only a genome with m = 0 changes its verdict, from exhausted to infeasible. Genes are never
changed.

Bounds cost more than a few attempts: only genomes that some attempts gave no scene are bounded
(`engine.sampling.FREE_ATTEMPTS`). As attempts are independent, those made before change no law.
"""

from collections.abc import Iterator, Sequence
from threading import Lock

import numpy as np

from engine.feasibility.contraction import ALIVE
from engine.feasibility.explanation import slices_of
from engine.feasibility.slices import Sliced, narrow
from engine.frozen import frozen
from engine.program import Program
from engine.scenes import groups_of
from engine.tables import Bools, Floats, Ints, Size

WORK_LIMIT = 100_000_000
"""Values that slicing a program may compute before many scenes are sampled: seconds."""
SLICES = 128
"""Number of slices. More slices discard fewer boxes but take longer: half a slice is lost at either end of a window."""
BLOCK = 1 << 12
"""Boxes that are narrowed together."""
KEPT = 8
"""Number of programs whose slices are kept."""
MANY = 32
"""Number of genomes of one variant from which on they are narrowed separately."""


@frozen
class Bounds:
    """Bounds of the attempts for n genomes. The axis `options` runs over the variants of a row's group."""

    mass: Floats
    """(n,) probability that an attempt falls among the boxes."""
    cumulative: Floats
    """(n, options) cumulative probability of the variants, restricted to their boxes."""
    low: Floats
    """(n, options, draws)"""
    span: Floats
    """(n, options, draws)"""
    culprit: Ints
    """(n,) Requirement that excludes a genome with mass 0, else -1."""


@frozen
class Pruner:
    """A program prepared for pruning."""

    program: Program
    sliced: tuple[Sliced, ...]
    """() if the program is too large for an analysis; then nothing is pruned."""

    def bounds(self, genomes: Floats, groups: Ints) -> Bounds:
        """Return the bounds for genomes (n, d; file units) whose discrete genes select these groups (n,)."""
        with np.errstate(all="ignore"):
            return _bounds(self.program, self.sliced, genomes, groups)


def pruner(program: Program) -> Pruner:
    """Return a program sliced for all its genomes; the last `KEPT` programs are kept."""
    with _PREPARING:
        if (found := _prepared.get(program.digest)) is None:
            while len(_prepared) >= KEPT:
                del _prepared[next(iter(_prepared))]
            found = _prepared[program.digest] = Pruner(program, slices_of(program, WORK_LIMIT, SLICES) or ())
        return found


_PREPARING = Lock()
_prepared: dict[str, Pruner] = {}


def infeasible(program: Program, genomes: Floats) -> tuple[np.ndarray, Ints]:
    """Return (n,) True for genomes that provably allow no scene, and (n,) the requirement that excludes them (-1:
    none).
    """
    found = pruner(program).bounds(genomes, groups_of(program, genomes))
    return found.mass == 0.0, found.culprit


def _bounds(program: Program, sliced: Sequence[Sliced], genomes: Floats, groups: Ints) -> Bounds:
    code, draws = program.code, int(program.code.sizes[Size.DRAWS])
    starts, sizes = code.group_start[groups], np.diff(code.group_start)[groups]
    options = int(np.diff(code.group_start).max(initial=1))
    shape = len(genomes), options
    low, high = np.zeros((*shape, draws)), np.ones((*shape, draws))
    possible = np.less(np.arange(options), sizes[:, np.newaxis])
    variants = np.where(possible, starts[:, np.newaxis] + np.arange(options), starts[:, np.newaxis])
    killer = np.where(possible & (code.variant_template[variants] < 0), code.variant_rejection[variants], ALIVE)
    inside = np.asarray(((genomes >= program.space.low) & (genomes <= program.space.high)).all(axis=1))
    killer = np.where(inside[:, np.newaxis], killer, ALIVE)
    for part in sliced:
        here = possible & inside[:, np.newaxis] & (killer == ALIVE)
        for chosen in _batches(variants, here & np.isin(variants, part.variants)):
            found = narrow(part, *_boxes(part, variants[chosen], genomes[chosen[0]]))
            low[chosen], high[chosen] = found.low[:, len(program.space) :], found.high[:, len(program.space) :]
            killer[chosen] = found.killer
    return _assembled(program, variants, possible, low, high, killer)


def _batches(variants: Ints, chosen: np.ndarray) -> Iterator[tuple[Ints, Ints]]:
    """Yield rows and options that are narrowed together: many genomes of one variant, or a few genomes of many
    variants.
    """
    rows, options = np.nonzero(chosen)
    numbers = variants[rows, options]
    if len(rows) >= MANY * len(np.unique(numbers)):
        order = np.argsort(numbers, kind="stable")
        parts = np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1)
    else:
        parts = [np.arange(len(rows))]
    for part in parts:
        for start in range(0, len(part), BLOCK):
            block = part[start : start + BLOCK]
            yield rows[block], options[block]


def _boxes(part: Sliced, variants: Ints, genomes: Floats) -> tuple[Ints, Floats, Floats]:
    """Return one box per genome and variant: genes are known, draws are free."""
    genes = genomes * part.program.space.scale
    draws = int(part.program.code.sizes[Size.DRAWS])
    low = np.hstack([genes, np.zeros((len(genes), draws))])
    return np.searchsorted(part.variants, variants), low, np.hstack([genes, np.ones((len(genes), draws))])


def _assembled(program: Program, variants: Ints, possible: Bools, low: Floats, high: Floats, killer: Ints) -> Bounds:
    """Return the bounds with the weights of the restricted variants; an impossible variant has weight 0."""
    cumulative = program.code.variant_cumulative[variants]
    before = np.where(np.arange(int(variants.shape[1])) > 0, np.roll(cumulative, 1, axis=1), 0.0)
    span = np.clip(high - low, 0.0, 1.0)
    weight = np.where(possible & (killer == ALIVE), (cumulative - before) * span.prod(axis=2), 0.0)
    total = weight.cumsum(axis=1)
    mass = np.minimum(total[:, -1], 1.0)
    shares = total / np.where(mass > 0.0, total[:, -1], 1.0)[:, np.newaxis]
    shares[total >= total[:, -1:]] = 1.0
    ruled_out = np.where(possible & (killer != ALIVE), killer, np.iinfo(np.int32).max).min(axis=1)
    culprit = np.where(mass > 0.0, ALIVE, ruled_out)
    return Bounds(mass, shares, low, span, culprit.astype(np.int32))
