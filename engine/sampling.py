"""Rejection sampling: genomes and stream keys to concrete scenes, or to a verdict with the counts per requirement.

For each genome up to `max_attempts` attempts draw a variant and the nuisance values and test every requirement; the
first attempt that passes is the scene. The draws of an attempt are a pure function of its key and its number, so a
row's result never depends on the other rows, their order or the number of threads.

Counts are conditional: an impossible variant is rejected first, then come the file's requirements in order, last the
built-in ones. If the file requests fair starts, an attempt that passes all of these is simulated once
(`engine.fairness`), and attempts continue if that fails. An attempt ends at its first failure, so `attempts` is the sum
of all failures, plus one if valid.

With `config.prune`, where `FREE_ATTEMPTS` attempts gave no scene, attempts that surely fail are skipped from then on
(`engine.feasibility.pruning` describes how, and why the distribution of accepted scenes is unchanged). They count
against `max_attempts`, but in no other count.

Genomes come from stream keys, too: from the genes' own distributions (plain runs), or uniform over the search's box.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from engine.config import SimulationConfig
from engine.errors import ArgumentError
from engine.kernels.attempts import sample_rows
from engine.kernels.evaluate import geometry_kernels
from engine.kernels.jit import need
from engine.kernels.random_numbers import GENE_CHANNEL, fill_uniform, truncated_normals
from engine.kernels.recipe import Confinement, Layout, Ledger, Recipe, Request, Scratch
from engine.opcodes import Op
from engine.program import ParamSpace, Program
from engine.scenes import Scenes, groups_of
from engine.streams import check_keys
from engine.tables import PLAIN, CodeTables, Floats, Ints, RoadTables, Size
from engine.vocabulary import Distribution, GeneKind, Purpose, Verdict

if TYPE_CHECKING:
    from engine.feasibility.pruning import Pruner

__all__ = ["draw_genomes", "sample", "uniform_genomes"]

# -- genomes -----------------------------------------------------------------------------------------------------------


def draw_genomes(space: ParamSpace, keys: Ints) -> Floats:
    """Return (n, d) gene values in file units, each from its own distribution; row i depends on key i alone."""
    return from_uniforms(space, uniforms_of(space, keys))


def from_uniforms(space: ParamSpace, uniforms: Floats) -> Floats:
    """Return (n, d) gene values in file units: quantiles of each gene's own distribution at numbers of [0, 1)."""
    genomes = np.empty_like(uniforms)
    for gene in range(len(space)):
        genomes[:, gene] = _from_distribution(space, gene, uniforms[:, gene])
    return genomes


def uniform_genomes(space: ParamSpace, keys: Ints) -> Floats:
    """Return (n, d) gene values in file units, uniform over the box of the search; row i depends on key i alone."""
    genomes = uniforms_of(space, keys)
    for gene in range(len(space)):
        genomes[:, gene] = _from_box(space, gene, genomes[:, gene])
    return genomes


def uniforms_of(space: ParamSpace, keys: Ints) -> Floats:
    """Return (n, d) the uniform numbers of [0, 1) that the genes of each key come from."""
    check_keys(keys)
    uniforms = np.empty((len(keys), len(space)))
    fill_uniform(keys, int(Purpose.SCENE), GENE_CHANNEL, uniforms)
    return uniforms


def _from_distribution(space: ParamSpace, gene: int, uniforms: Floats) -> Floats:
    match Distribution(space.distribution[gene]):
        case Distribution.UNIFORM:
            return _from_box(space, gene, uniforms)
        case Distribution.NORMAL | Distribution.TRUNCATED_NORMAL:
            values = np.empty(len(uniforms))
            mean, deviation = space.shape[gene]
            truncated_normals(
                np.ascontiguousarray(uniforms), space.low[gene], space.high[gene], mean, deviation, values
            )
            return values
        case Distribution.DISCRETE:
            return space.low[gene] + _pick(space.weights[gene], uniforms)


def _from_box(space: ParamSpace, gene: int, uniforms: Floats) -> Floats:
    low, high = space.low[gene], space.high[gene]
    if space.kinds[gene] == GeneKind.CONTINUOUS:
        return np.minimum(low + uniforms * (high - low), high)
    return low + np.floor(uniforms * (high - low + 1.0))


def _pick(weights: tuple[float, ...], uniforms: Floats) -> Floats:
    """Return the index of the weight whose share of [0, 1) contains each number; weight 0 is never picked."""
    cumulative = np.cumsum(weights) / np.sum(weights)
    last = np.flatnonzero(weights)[-1]
    return np.minimum(np.searchsorted(cumulative, uniforms, side="right"), last).astype(np.float64)


# -- scenes ------------------------------------------------------------------------------------------------------------

DEFAULTS = SimulationConfig()
BLOCK_LIMIT = 1 << 32
"""Blocks of random numbers that one stream can address."""
PACKED = 6
"""Registers that a packed operand reads at most."""
WIDEST = 3
"""Registers that a geometry instruction may write."""
CHUNK_ATTEMPTS = 500_000
"""Attempts per uninterruptible call: 50 ms, so that Ctrl-C takes effect at once."""
NUMBERS = 25_000_000
"""Maximum number of scene values in memory, 200 MB; ten thousand scenes of a hundred actors have as many."""
BOUNDED_ROWS = 256, 2048
"""Least and largest number of scenes whose bounds are computed together under `prune`."""
FREE_ATTEMPTS = 300
"""Attempts at a scene before its draws are confined: bounds of a genome cost as much as 140 attempts where 2,000
genomes are bounded together, and as 660 where 100 are (`left_turn`, see `benchmarks.prune`).
"""

ANYWHERE = Confinement(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0, 0)), np.zeros(0, np.int32))
"""No pruning."""

Tables = TypeVar("Tables", CodeTables, RoadTables)


def sample(
    program: Program,
    genomes: Floats,
    keys: Ints,
    config: SimulationConfig = DEFAULTS,
    jobs: int = 1,
) -> Scenes:
    """Draw one scene for each genome (n, d; file units) from the stream of its key (n, 6), and return them all."""
    recipe, limit = recipe_of(program), attempt_limit(program)
    if not 1 <= config.max_attempts <= limit:
        raise ArgumentError(
            f"max_attempts is {config.max_attempts}; this scenario allows 1 .. {limit}", "take a number between these"
        )
    request = request_of(program, genomes, keys, config.max_attempts)
    ledger = _empty_ledger(program, recipe.layout, len(keys))
    genomes = np.ascontiguousarray(genomes, dtype=np.float64)
    confiner = None
    if config.prune:
        from engine.feasibility.pruning import pruner

        confiner = _Confiner(pruner(program), genomes)
    _draw(recipe, request, ledger, jobs, confiner)
    if program.settings.fair:
        from engine.fairness import draw_until_fair

        draw_on = partial(_draw_on, recipe, request, ledger, jobs, confiner)
        draw_until_fair(program, config, request.keys, ledger, draw_on, jobs)
    return Scenes(genomes=genomes, keys=request.keys, actions=np.zeros((len(keys), 0, 0)), **ledger._asdict())


def request_of(program: Program, genomes: Floats, keys: Ints, max_attempts: int) -> Request:
    """Return the checked request to the kernels."""
    genomes = np.ascontiguousarray(genomes, dtype=np.float64)
    keys = np.require(keys, requirements=PLAIN)
    check_keys(keys)
    check_genomes(program.space, genomes, len(keys))
    begun = np.zeros(len(keys), dtype=np.int64)
    groups = groups_of(program, genomes)
    return Request(genomes * program.space.scale, groups, keys, max_attempts, FREE_ATTEMPTS, ANYWHERE, begun)


@dataclass(frozen=True)
class _Confiner:
    """Bounds of the passing attempts of some rows."""

    prune: "Pruner"
    genomes: Floats

    def confinement(self, request: Request, rows: slice) -> Confinement:
        bounds = self.prune.bounds(self.genomes[rows], request.group)
        arrays = (getattr(bounds, name) for name in Confinement._fields)
        return Confinement._make(np.require(array, requirements=PLAIN) for array in arrays)


def rows_at_once(program: Program, most: int) -> int:
    """Return the number of scenes of a program in memory at once: `most` unless the program is huge."""
    return max(1, min(most, NUMBERS // max(1, program.code.output_register.shape[1])))


def attempt_limit(program: Program) -> int:
    """Return the maximum number of attempts at one scene: its stream of random numbers is finite."""
    return BLOCK_LIMIT // _blocks(int(program.code.sizes[Size.DRAWS]))


def _blocks(draws: int) -> int:
    """Return the blocks of two random numbers per attempt: one number picks the variant, the rest are its draws."""
    return (draws + 2) // 2


def check_genomes(space: ParamSpace, genomes: Floats, rows: int) -> None:
    """Raise ArgumentError unless there is one finite genome per key and discrete genes have one of their options."""
    if genomes.shape != (rows, len(space)):
        raise ArgumentError(
            f"genomes: expected one row of {len(space)} genes a key {(rows, len(space))}, got {genomes.shape}",
            "`draw_genomes` makes some",
        )
    discrete = space.kinds != GeneKind.CONTINUOUS
    whole = (genomes == np.floor(genomes)) & (genomes >= space.low) & (genomes <= space.high)
    wrong = ~np.isfinite(genomes) | (discrete & ~whole)
    if wrong.any():
        row, gene = np.argwhere(wrong)[0]
        allowed = (
            f"a whole number in {space.low[gene]:g} .. {space.high[gene]:g}" if discrete[gene] else "a finite number"
        )
        message = f"genome {row}: {space.names[gene]} is {genomes[row, gene]}; it must be {allowed}"
        raise ArgumentError(message, "name another value")


def recipe_of(program: Program) -> Recipe:
    """Return the data of a program that the kernels read."""
    code = program.code
    need(*geometry_kernels(code.scene_code))
    variant_values = len(code.literals)
    genes = variant_values + code.variant_values.shape[1]
    draw_count = int(code.sizes[Size.DRAWS])
    layout = Layout(
        variant_values=variant_values,
        genes=genes,
        draws=genes + len(program.space),
        draw_count=draw_count,
        blocks=_blocks(draw_count),
        requirements=code.requirement_segment.shape[1],
        reasons=program.first_built_in,
    )
    flat = code._replace(scene_code=code.scene_code.ravel())
    return Recipe(
        _plain(flat), _plain(program.road), _draws_needed(code, layout), decided_by_genes(code, layout), layout
    )


def _plain(tables: Tables) -> Tables:
    """Return contiguous, writable arrays: numba would compile the kernels again for any others."""
    return tables._make(each if each.flags.carray else np.require(each, requirements=PLAIN) for each in tables)


def decided_by_genes(code: CodeTables, layout: Layout) -> Ints:
    """Return (requirements,) 1 for a hard requirement that reads neither draws nor data that differ between variants.

    Sound, not complete: unused operands count as registers, and a program with several templates has none.
    """
    segments = code.requirement_segment
    decided = np.zeros(segments.shape[1], dtype=np.int32)
    if len(segments) != 1:
        return decided
    varying = {*range(layout.variant_values, layout.genes), *range(layout.draws, layout.draws + layout.draw_count)}
    for requirement, (start, end, result) in enumerate(segments[0].tolist()):
        for row in code.scene_code[start:end].tolist():
            geometry = row[0] >= Op.PATH_POSE
            reads = (register + i for register in row[2:] for i in range(PACKED if geometry else 1))
            hidden = row[0] == Op.CAN_SEE and max(varying, default=-1) >= row[4]  # outlines without number may hide
            if hidden or not varying.isdisjoint(reads):
                varying.update(range(row[1], row[1] + (WIDEST if geometry else 1)))
            else:
                varying.discard(row[1])
        decided[requirement] = result not in varying and code.requirement_probability[requirement] >= 1.0
    return decided


def _draws_needed(code: CodeTables, layout: Layout) -> Ints:
    """Return (templates, requirements) one more than the highest draw that a requirement or an earlier one reads."""
    segments = code.requirement_segment
    needed = np.zeros(segments.shape[:2], dtype=np.int32)
    for template, requirement in np.ndindex(needed.shape):
        start, end, result = segments[template, requirement]
        needed[template, requirement] = max(
            _draws_read(code.scene_code[start:end], layout), _highest_draw(np.array([result]), layout)
        )
    return np.maximum.accumulate(needed, axis=1)


def _draws_read(rows: Ints, layout: Layout) -> int:
    """Return an upper bound: integers and unused operands count as registers, which costs draws but changes none."""
    operands = rows[:, 2:]
    packed = (rows[:, 0] >= Op.PATH_POSE)[:, np.newaxis, np.newaxis] * np.arange(PACKED)
    return _highest_draw(operands[:, :, np.newaxis] + packed, layout)


def _highest_draw(registers: Ints, layout: Layout) -> int:
    draws = registers - layout.draws
    return int(np.max(draws + 1, where=(draws >= 0) & (draws < layout.draw_count), initial=0))


def _empty_ledger(program: Program, layout: Layout, rows: int) -> Ledger:
    requirements = len(program.requirements)
    return Ledger(
        verdict=np.zeros(rows, dtype=np.int32),
        variant=np.full(rows, -1, dtype=np.int32),
        values=np.full((rows, program.code.output_register.shape[1]), np.nan),
        draws=np.full((rows, layout.draw_count), np.nan),
        attempts=np.zeros(rows, dtype=np.int64),
        tested=np.zeros((rows, requirements), dtype=np.int64),
        failed=np.zeros((rows, requirements), dtype=np.int64),
    )


def _draw(recipe: Recipe, request: Request, ledger: Ledger, jobs: int, confiner: _Confiner | None) -> None:
    """Sample all rows; with a confiner, those that `FREE_ATTEMPTS` attempts give no scene go on in their bounds."""
    if confiner is None or request.max_attempts <= request.free:
        _run_chunks(recipe, request, ledger, jobs, None)
        return
    free, rows = request.free, np.arange(len(request.keys))
    _draw_rows(recipe, request._replace(max_attempts=free), ledger, jobs, None, rows[request.begun < free])
    goes_on = (request.begun >= free) | (ledger.verdict == Verdict.EXHAUSTED)
    begun = np.maximum(request.begun, free)
    _draw_rows(recipe, request._replace(begun=begun), ledger, jobs, confiner, rows[goes_on])


def _draw_rows(
    recipe: Recipe, request: Request, ledger: Ledger, jobs: int, confiner: _Confiner | None, rows: Ints
) -> None:
    """Make further attempts at the scenes of some rows."""
    if not len(rows):
        return
    found = ledger._make(array[rows] for array in ledger)
    confined = confiner and _Confiner(confiner.prune, confiner.genomes[rows])
    _run_chunks(recipe, _request_of(request, rows), found, jobs, confined)
    for target, new in zip(ledger, found, strict=True):
        target[rows] = new


def _run_chunks(recipe: Recipe, request: Request, ledger: Ledger, jobs: int, confiner: _Confiner | None) -> None:
    """Sample all rows, in chunks; the kernel releases the GIL, so threads run in parallel."""
    rows, jobs = len(request.keys), max(1, jobs)
    least, most = BOUNDED_ROWS if confiner else (1, CHUNK_ATTEMPTS // request.max_attempts)
    size = max(least, min(most, rows if jobs == 1 else -(-rows // (4 * jobs))))
    chunks = list(pairwise([*range(0, rows, size), rows]))

    def run(chunk: tuple[int, int]) -> None:
        part = slice(*chunk)
        rows_request = _request_of(request, part)
        if confiner is not None:
            rows_request = rows_request._replace(confinement=confiner.confinement(rows_request, part))
        sample_rows(
            recipe,
            rows_request,
            0,
            len(rows_request.keys),
            scratch_of(recipe),
            ledger._make(array[part] for array in ledger),
        )

    if jobs == 1 or len(chunks) < 2:
        for chunk in chunks:
            run(chunk)
        return
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(run, chunks))


def _request_of(request: Request, rows: slice | Ints) -> Request:
    arrays = ("genes", "group", "keys", "begun")
    return request._replace(**{name: getattr(request, name)[rows] for name in arrays})


def _draw_on(
    recipe: Recipe, request: Request, ledger: Ledger, jobs: int, confiner: _Confiner | None, rows: Ints
) -> None:
    """Make further attempts at scenes that were found."""
    found = ledger._make(array[rows] for array in ledger)
    found.variant[:] = -1
    rows_request = _request_of(request, rows)._replace(begun=found.attempts.copy())
    _draw(recipe, rows_request, found, jobs, confiner and _Confiner(confiner.prune, confiner.genomes[rows]))
    for target, new in zip(ledger, found, strict=True):
        target[rows] = new


def scratch_of(recipe: Recipe) -> Scratch:
    """Return working memory for one thread."""
    return Scratch(
        np.zeros(recipe.code.sizes[Size.SCENE_REGISTERS]), np.zeros(max(1, recipe.layout.requirements), dtype=np.int32)
    )
