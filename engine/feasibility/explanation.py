"""Feasibility of a file: the possible variants, and the possible part of each gene's range.

Proofs are stored in the user's cache, so a second check of a file needs no second proof. A proof is a pure function of
the program's digest and of this code, so both name the entry.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from engine.atomic import write_one
from engine.feasibility.contraction import ALIVE
from engine.feasibility.slices import MOST, Bench, Sliced, bit, narrow, slice_template
from engine.frozen import frozen
from engine.program import Program
from engine.tables import Floats, Ints, Size
from engine.user_cache import cached_file, fingerprint
from engine.vocabulary import GeneKind

WORK_LIMIT = 2_000_000
"""Values that the analysis of a file may compute: about 50 ms. Beyond it slices are fewer, and at last there are none.
"""
SLICES = 32
FEWEST = 4
ROUNDS = 2
LEAST_CUT = 1e-3
"""Share of a range below which a cut is not reported."""


@frozen
class Cut:
    """A part of a gene's range that cannot hold, in the file's unit."""

    gene: int
    above: bool
    """True if the part above `value` cannot hold; else the part below."""
    value: float
    requirements: tuple[int, ...]
    """Requirements of the proof, all of them needed; () if it rests on rejected variants."""


@frozen
class Feasibility:
    """Proved facts of a file, over the declared ranges of its genes. They are sound, but may be weak."""

    looked_at: bool
    """False if the file is too large to be analysed in time."""
    infeasible: bool
    """True if no attempt can pass, for any genes."""
    conflict: tuple[int, ...]
    """Requirements of an infeasible file that cannot hold together, all of them needed for the proof."""
    impossible: Ints
    """(variants,) Requirement (or rejection) that excludes the variant; -1 if it may be possible."""
    low: Floats
    """(genes,) Hull of the possible values, file units."""
    high: Floats
    cuts: tuple[Cut, ...]


def slices_of(program: Program, limit: int = WORK_LIMIT, count: int = SLICES) -> tuple[Sliced, ...] | None:
    """Return all templates in `count` slices, or as many as the work limit allows; None if it allows none."""
    while _work(program, count) > limit:
        count //= 2
        if count < FEWEST:
            return None
    with np.errstate(all="ignore"):
        return tuple(slice_template(program, t, count) for t in range(len(program.code.output_segment)))


def _work(program: Program, count: int) -> int:
    """Return the number of values that slicing computes; a geometric instruction counts by the edges of a region."""
    code = program.code
    variables = len(program.space) + int(code.sizes[Size.DRAWS])
    geometry = int((code.scene_code[:, 0] >= 40).sum()) + 5 * len(program.actors)
    templates = max(1, len(code.output_segment))
    edges = len(program.road.edges) // max(1, len(program.road.region_start) - 1)
    rows = len(code.scene_code) + geometry * max(4, edges // 8)
    return len(code.variant_template) * variables * (count + 2) * rows // templates


def explain(program: Program) -> Feasibility:
    """Return the facts of a file that can be proved within the work limit."""
    sliced = slices_of(program)
    return nothing(program) if sliced is None else explain_sliced(program, sliced)


def nothing(program: Program) -> Feasibility:
    """Return the result without an analysis."""
    rejected = np.where(program.code.variant_template < 0, program.code.variant_rejection, ALIVE)
    return Feasibility(
        False, False, (), rejected.astype(np.int32), program.space.low.copy(), program.space.high.copy(), ()
    )


def explain_sliced(program: Program, sliced: Sequence[Sliced]) -> Feasibility:
    """Return the facts of a file from templates that are sliced already."""
    impossible = nothing(program).impossible
    low, high = np.full(len(program.space), np.inf), np.full(len(program.space), -np.inf)
    for part in sliced:
        found = narrow(part, *_whole(part), ROUNDS)
        impossible[part.variants] = found.killer
        alive = found.killer == ALIVE
        low = np.minimum(low, found.low[alive, : len(low)].min(axis=0, initial=np.inf))
        high = np.maximum(high, found.high[alive, : len(low)].max(axis=0, initial=-np.inf))
    if (impossible != ALIVE).all():
        space = program.space
        conflict = _proof(program, sliced, _whole)
        return Feasibility(True, True, conflict, impossible, space.low.copy(), space.high.copy(), ())
    low, high = _in_file_units(program, low, high)
    return Feasibility(True, False, (), impossible, low, high, tuple(_cuts(program, sliced, low, high)))


def conflicts(program: Program, requirements: Sequence[int]) -> bool:
    """Return True if provably no attempt meets all `requirements`: of the file, rejections, built-in ones."""
    sliced = slices_of(program)
    allowed = 0
    for requirement in requirements:
        allowed |= bit(requirement)
    rejected = program.code.variant_rejection[program.code.variant_template < 0]
    return sliced is not None and set(rejected.tolist()) <= set(requirements) and _empty(sliced, _whole, allowed)


Boxes = tuple[Ints, Floats, Floats]
"""Rows, and ends of all variables in SI units."""


def gene_boxes(program: Program, sliced: Sequence[Sliced], allowed: int) -> tuple[Floats, Floats]:
    """Return (n, genes) ends of boxes, file units: the genes of each scene that meets the allowed requirements (bits)
    lie in one of them.
    """
    genes, found = len(program.space), [narrow(part, *_whole(part), ROUNDS, allowed) for part in sliced]
    low, high = (
        np.concatenate([getattr(each, end)[each.killer == ALIVE, :genes] for each in found]) for end in ("low", "high")
    )
    return _in_file_units(program, low, high)


def _whole(part: Sliced) -> Boxes:
    """Return every variant over the whole box of the genes."""
    with np.errstate(all="ignore"):
        low, high = Bench(part.program, part.tape, part.variants).ranges()
    return np.arange(len(part.variants)), low, high


def _empty(sliced: Sequence[Sliced], boxes: Callable[[Sliced], Boxes], allowed: int) -> bool:
    """Return True if the allowed requirements exclude every box."""
    return all((narrow(part, *boxes(part), ROUNDS, allowed).killer != ALIVE).all() for part in sliced)


def _proof(program: Program, sliced: Sequence[Sliced], boxes: Callable[[Sliced], Boxes]) -> tuple[int, ...]:
    """Return requirements that exclude every box, all of them needed; () if there is no such proof."""
    file = program.code.requirement_segment.shape[1]
    hard = [r for r in range(file) if program.code.requirement_probability[r] >= 1.0]
    return _minimal(sliced, boxes, [r for r in (*hard, program.first_built_in, program.first_built_in + 1) if r < MOST])


def conflict_of(
    program: Program, sliced: Sequence[Sliced], added: Sequence[int], left_out: Collection[int]
) -> tuple[int, ...]:
    """Return requirements, all of them needed, that exclude every scene in which the requirements `added` hold; () if
    there is no such proof. Requirements in `left_out` are not used; the proof holds as few of the others as it can.
    """
    hard = [r for r in range(program.first_built_in) if program.code.requirement_probability[r] >= 1.0]
    others = [r for r in (*hard, program.first_built_in, program.first_built_in + 1) if r not in left_out]
    return _minimal(sliced, _whole, [*added, *(r for r in others if r < MOST and r not in added)])


def _minimal(sliced: Sequence[Sliced], boxes: Callable[[Sliced], Boxes], tried: Sequence[int]) -> tuple[int, ...]:
    """Return requirements out of `tried` that exclude every box, all of them needed; () if there is no such proof. The
    last ones are left out first.

    Source: the deletion filter of Chinneck and Dravnieks (1991), "Locating minimal infeasible constraint sets in linear
    programs", ORSA Journal on Computing 3(2).
    """
    allowed = sum(bit(requirement) for requirement in tried)
    if not _empty(sliced, boxes, allowed):
        return ()
    for requirement in reversed(tried):
        if _empty(sliced, boxes, allowed & ~bit(requirement)):
            allowed &= ~bit(requirement)
    return tuple(requirement for requirement in tried if allowed & bit(requirement))


def _in_file_units(program: Program, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the ends clipped to the declared ranges, those of discrete genes as whole numbers."""
    space = program.space
    low = np.maximum(space.low, np.nextafter(low / space.scale, -np.inf))
    high = np.minimum(space.high, np.nextafter(high / space.scale, np.inf))
    discrete = space.kinds != GeneKind.CONTINUOUS
    return np.where(discrete, np.ceil(low - 1e-9), low), np.where(discrete, np.floor(high + 1e-9), high)


def _cuts(program: Program, sliced: Sequence[Sliced], low: Floats, high: Floats) -> Iterator[Cut]:
    """Yield every end of a range that moved by more than `LEAST_CUT`, with the requirements of the proof."""
    space = program.space
    for gene in range(len(space)):
        trifle = LEAST_CUT * (space.high[gene] - space.low[gene])
        if space.kinds[gene] == GeneKind.INDEX:
            continue
        for above, value in ((False, float(low[gene])), (True, float(high[gene]))):
            cut = space.high[gene] - value if above else value - space.low[gene]
            if cut > trifle:
                beyond = _beyond(program, gene, value + (0.01 * trifle if above else -0.01 * trifle), above=above)
                yield Cut(gene, above, value, _proof(program, sliced, beyond))


def _beyond(program: Program, gene: int, value: float, *, above: bool) -> Callable[[Sliced], Boxes]:
    """Return the boxes of every variant with a gene restricted to its range beyond a value."""
    limit = value * float(program.space.scale[gene])

    def boxes(part: Sliced) -> Boxes:
        rows, low, high = _whole(part)
        if above:
            low[:, gene] = np.maximum(low[:, gene], limit)
        else:
            high[:, gene] = np.minimum(high[:, gene], limit)
        met = low[:, gene] <= high[:, gene]
        return rows[met], low[met], high[met]

    return boxes


# -- stored proofs -----------------------------------------------------------------------------------------------------

FAMILY = "proof-*.json"
_ENGINE = Path(__file__).parents[1]
CODE = (
    Path(__file__).parent,
    *(_ENGINE / folder for folder in ("operators", "road", "road/opendrive", "opendrive")),
    *(_ENGINE / name for name in ("kernels/scalars.py", "opcodes.py", "portable.py")),
)
"""Files, and folders of files, that determine proofs."""


def remembered(program: Program) -> Feasibility:
    """Return the cached answer of `explain` for the same program, or compute and store it."""
    entry = cached_file(f"proof-{_key(program)}.json", FAMILY)
    known = None if entry is None else _read(entry)
    if known is not None:
        return known
    found = explain(program)
    if entry is not None:
        _write(entry, found)
    return found


def _key(program: Program) -> str:
    return sha256(f"{program.digest}\0{fingerprint(CODE)}".encode()).hexdigest()[:24]


def _read(entry: Path) -> Feasibility | None:
    """Return the stored answer; None if there is none, or it cannot be read."""
    try:
        stored = json.loads(entry.read_text(encoding="utf-8"))
        return Feasibility(
            looked_at=bool(stored["looked_at"]),
            infeasible=bool(stored["infeasible"]),
            conflict=tuple(stored["conflict"]),
            impossible=np.array(stored["impossible"], dtype=np.int32),
            low=np.array(stored["low"], dtype=np.float64),
            high=np.array(stored["high"], dtype=np.float64),
            cuts=tuple(map(_cut, stored["cuts"])),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _cut(stored: Mapping[str, Any]) -> Cut:
    values: dict[str, Any] = {**stored, "requirements": tuple(stored["requirements"])}
    return Cut(**values)


def _write(entry: Path, found: Feasibility) -> None:
    """Store an answer, replacing the file as a whole; errors of the file system are ignored."""
    stored = asdict(found) | {name: getattr(found, name).tolist() for name in ("impossible", "low", "high")}
    with suppress(OSError):
        write_one(entry, json.dumps(stored, default=lambda value: value.item()).encode())
