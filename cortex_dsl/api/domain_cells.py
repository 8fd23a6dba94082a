"""Programs in which the domains of a file have an effect: the cells of scenes, proofs that no scene lies in a cell, and
scenes that are drawn in cells of domains at the start.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cortex_dsl import ir
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.files import DISK, Files
from cortex_dsl.pipeline import compile_module
from cortex_dsl.report.findings.coverage_report import CellResult, RequirementInfo, State
from cortex_dsl.semantics.acting.domains import OBJECTIVE, SIGHT, requirement_name
from cortex_dsl.source import Source
from engine.batch import trajectory
from engine.config import SimulationConfig
from engine.feasibility.explanation import conflict_of, gene_boxes, slices_of
from engine.feasibility.slices import EVERY, MOST, Sliced, bit
from engine.gates.coverage import places_of
from engine.gates.directed import genomes_between, quantiles_of
from engine.host import coasting
from engine.outcomes import Outcomes
from engine.program import Program
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.tables import Floats, Ints
from engine.vocabulary import Method, Verdict

WORK = 20_000_000
"""Values that the analysis of one program may compute."""
ALONE = 400
"""Maximum number of cells with a program of their own, whose proofs are stronger than those of a program for many."""
DIRECTED_RUN = 0xFFFC
"""Number of the run in the stream keys of directed draws: no search, estimate or design has it."""
FIRST, BLOCK = 256, 4096
"""Draws of the first block, and of each further one."""
BLOCKS_SHARED, BLOCKS = 2, 16
"""Blocks for one scene: with the bounds of a program for many cells, and of one for its cells alone."""
DIRECTED = sum(FIRST + (blocks - 1) * BLOCK for blocks in (BLOCKS_SHARED, BLOCKS))
"""Draws for one scene at most."""
POOL = 16_384
"""Scenes that show without a proof which cells are possible."""
MEASURED = 8
"""Scenes of a block that are measured, as the requirement on a scene and the value in its run may round otherwise."""

StartCells = tuple[tuple[int, int], ...]
"""(domain, cell) of domains at the start."""


class DomainPrograms:
    """Programs of one file; `source` is its text, `files` the source of its imports."""

    def __init__(self, scenario: Scenario, source: Source, seed: int = 0, jobs: int = 1, files: Files = DISK) -> None:
        self.scenario = replace(scenario, config=replace(scenario.config, driver=None))
        self.source, self.seed, self.jobs, self.files = source, seed, jobs, files
        self.program = scenario.program
        self.domains = scenario.compiled.scenario.domains
        self.sizes = [len(each.cells) for each in self.domains]
        self.draws = 0
        """Number of directed draws so far, which numbers their streams."""

    def compiled(self, use: ir.DomainUse) -> Program:
        """Return the program of the file in which its domains have an effect."""
        scenario, module = self.scenario, self.scenario.compiled.module
        chosen = scenario.chosen
        return compile_module(
            module, self.source, scenario.overrides, scenario=chosen, files=self.files, domains=use
        ).program

    @cached_property
    def measuring(self) -> Scenario:
        """Return the scenario whose objectives are the values of the domains."""
        compiled = replace(self.scenario.compiled, program=self.compiled(ir.DomainUse()))
        return replace(self.scenario, compiled=compiled)

    @property
    def starts(self) -> tuple[int, ...]:
        """Return the domains at the start."""
        return tuple(number for number, each in enumerate(self.domains) if each.when == "start")

    def values_of_runs(self, scenes: Scenes) -> Floats:
        """Return (n, domains) the values of the runs of driven scenes, which are run once more, SI; NaN for none."""
        measured = self._measured(scenes, self.measuring.config.simulation)
        measured = replace(measured, actions=scenes.actions)
        outcomes = self.measuring.simulate(measured, jobs=self.jobs)
        values = self.values(outcomes)
        late = [number for number, each in enumerate(self.domains) if each.when == SIGHT]
        if late:
            values[:, late] = self._at_first_sight(measured, outcomes, late)
        return values

    def _at_first_sight(self, scenes: Scenes, outcomes: Outcomes, domains: Sequence[int]) -> Floats:
        """Return (n, domains) the values in the first sample in which the ego sees another actor; NaN for none."""
        program, config = self.measuring.program, self.measuring.config
        rules = {each.name: number for number, each in enumerate(program.rules)}
        columns = [rules[f"{OBJECTIVE}{domain}"] for domain in domains]
        found = np.full((len(scenes), len(domains)), math.nan)
        first = np.min(outcomes.first_seen, axis=1, initial=math.inf, where=~np.isnan(outcomes.first_seen))
        for row in np.flatnonzero(np.isfinite(first) & (outcomes.verdict == Verdict.VALID)).tolist():
            watched = trajectory(program, scenes, row, config.simulation, config.contact).watched
            sample = round(float(first[row]) / config.simulation.time_step)
            if sample < len(watched):
                found[row] = watched[sample, columns]
        return found

    def start_places(self, scenes: Scenes) -> Ints:
        """Return (n, domains) the cells of scenes; only those of domains at the start mean something."""
        return self.places(self.start_values(scenes))

    def start_values(self, scenes: Scenes) -> Floats:
        """Return (n, domains) the values of scenes, SI; only those of domains at the start mean something."""
        config = self.measuring.config.simulation
        measured = self._measured(scenes, config)
        brief = replace(config, max_time=config.time_step)
        measuring = replace(self.measuring, config=replace(self.measuring.config, simulation=brief))
        if self.program.controls:
            measured = coasting(self.program, measured)
        return self.values(measuring.simulate(measured, jobs=self.jobs))

    def _measured(self, scenes: Scenes, config: SimulationConfig) -> Scenes:
        """Return the same scenes of the measuring program, which have more values."""
        return sample(self.measuring.program, scenes.genomes, scenes.keys, config, self.jobs)

    def places(self, values: Floats) -> Ints:
        """Return (n, domains) the cells of values (n, domains; SI)."""
        columns = list[Ints]()
        for number, each in enumerate(self.domains):
            ends = np.array([(cell.low, cell.high, cell.closed) for cell in each.cells])
            columns.append(places_of(values[:, number], ends[:, 0], ends[:, 1], ends[:, 2] == 1.0))
        return np.stack(columns, axis=1)

    def values(self, outcomes: Outcomes) -> Floats:
        """Return (n, domains) the values of runs of the measuring program, SI; NaN for none."""
        numbers = {each.name: number for number, each in enumerate(self.measuring.program.judged.objectives)}
        chosen = [numbers[f"{OBJECTIVE}{domain}"] for domain in range(len(self.domains))]
        valid = (outcomes.verdict == Verdict.VALID)[:, np.newaxis]
        return np.where(valid, outcomes.sought[:, chosen], np.nan)

    def scenes(self, genomes: Floats, keys: Ints) -> Scenes:
        """Return the scenes of genomes and keys."""
        return sample(self.program, genomes, keys, self.scenario.config.simulation, self.jobs)

    def keys(self, count: int) -> Ints:
        """Return (count, 6) stream keys that nothing else uses."""
        first, self.draws = self.draws, self.draws + count
        return key_rows(self.seed, Method.SAMPLE, DIRECTED_RUN, 0, np.arange(first, first + count))

    @cached_property
    def pool(self) -> "Pool":
        """Return independent scenes with their cells. A cell of one of them needs no proof that it can be."""
        keys = self.keys(POOL)
        genomes = draw_genomes(self.program.space, keys)
        return Pool(genomes, keys, self.start_places(self.scenes(genomes, keys)))

    @cached_property
    def proofs(self) -> "Proofs":
        return Proofs(self)

    # -- scenes in cells

    def drawn_in(self, cells: StartCells) -> tuple[Floats, Ints] | None:
        """Return genome (1, d) and key (1, 6) of a scene in these cells; None if no directed draw gave one.

        A draw is the first attempt at a scene, with params from the part of their ranges that intervals allow. If it
        meets all requirements, the unchanged program accepts it, too.
        """
        found = self._drawn_by(self.proofs.holding(cells), cells, BLOCKS_SHARED)
        return found or self._drawn_by(self.proofs.alone(cells), cells, BLOCKS)

    def _drawn_by(self, analysed: "Analysed", cells: StartCells, blocks: int) -> tuple[Floats, Ints] | None:
        program, space = analysed.requiring(cells), self.program.space
        low, high = analysed.gene_boxes(cells)
        if not len(low):
            return None
        below, above = quantiles_of(space, low, high)
        simulation = replace(self.scenario.config.simulation, max_attempts=1, prune=False)
        for block in range(blocks):
            keys = self.keys(BLOCK if block else FIRST)
            genomes = genomes_between(space, keys, below, above)
            rows = np.flatnonzero(sample(program, genomes, keys, simulation, self.jobs).valid)[:MEASURED]
            if not len(rows):
                continue
            places = self.start_places(self.scenes(genomes[rows], keys[rows]))
            inside = np.flatnonzero(np.all([places[:, domain] == cell for domain, cell in cells], axis=0))
            if len(inside):
                row = rows[inside[0]]
                return genomes[row : row + 1], keys[row : row + 1]
        return None

    def quantiles(self, cells: StartCells) -> tuple[Floats, Floats]:
        """Return (1, genes) ends of the uniform numbers that the params of each scene in these cells come from; (0,
        genes) if there is none.
        """
        low, high = self.proofs.alone(cells).gene_boxes(cells)
        if len(low):
            low, high = low.min(axis=0, keepdims=True), high.max(axis=0, keepdims=True)
        return quantiles_of(self.program.space, low, high)


@dataclass(frozen=True)
class Pool:
    """Independent scenes."""

    genomes: Floats
    """(n, d) file units"""
    keys: Ints
    """(n, 6)"""
    places: Ints
    """(n, domains) Cells; only those of domains at the start mean something."""

    def cells(self, domains: Sequence[int]) -> set[tuple[int, ...]]:
        """Return the cells of a product of domains at the start that scenes lie in."""
        return set(map(tuple, np.unique(self.places[:, list(domains)], axis=0).tolist()))


# -- proofs ------------------------------------------------------------------------------------------------------------


class Proofs:
    """Proofs that no scene lies in a cell."""

    def __init__(self, programs: DomainPrograms) -> None:
        self.programs = programs
        self.room = MOST - len(programs.program.requirements)
        """Number of cells that one program can have as requirements, each with a bit of its own."""
        self.reasons: dict[StartCells, str] = {}
        """Reasons why cells are not analysed, or not alone."""
        self._known: dict[StartCells, CellResult | None] = {}
        self._shared: dict[int, tuple[frozenset[tuple[int, int]], Analysed]] = {}
        """The last program of each number of cells, as the cells of a product are asked for with those of its parts."""
        self._left = ALONE

    def of(self, cells: StartCells) -> CellResult | None:
        """Return the state that is proved for cells of domains at the start, without its place; None if none is."""
        if not cells:
            return None
        if cells not in self._known:
            parts = (self.of((*cells[:i], *cells[i + 1 :])) for i in range(len(cells)))
            part = next((each for each in parts if each is not None), None) if len(cells) > 1 else None
            self._known[cells] = part or self._proved(cells)
        return self._known[cells]

    def _proved(self, cells: StartCells) -> CellResult | None:
        if self.room < len(cells):
            self.reasons[cells] = "not analysed: the file has too many requirements"
            return None
        analysed = self.holding(cells)
        proof = analysed.conflict(cells)
        if not proof and self._left > 0:
            self._left -= 1
            analysed = self.alone(cells)
            proof = analysed.conflict(cells)
        elif not proof:
            self.reasons[cells] = "analysed together with other cells only"
        return self._result(cells, proof, analysed.program) if proof else None

    def holding(self, cells: StartCells) -> "Analysed":
        """Return a program with these cells among others, so that many cells share one analysis."""
        if self.room < len(cells):
            return self.alone(cells)
        group = self.room // len(cells)
        wanted: set[tuple[int, int]] = set()
        for domain, cell in cells:
            first = cell // group * group
            last = min(first + group, self.programs.sizes[domain])
            wanted |= {(domain, each) for each in range(first, last)}
        key = frozenset(wanted)
        last = self._shared.get(len(cells))
        if last is None or last[0] != key:
            last = self._shared[len(cells)] = key, self._analysed(key)
        return last[1]

    def alone(self, cells: StartCells) -> "Analysed":
        """Return the program with these cells as its only ones."""
        return self._analysed(frozenset(cells))

    def _analysed(self, cells: frozenset[tuple[int, int]]) -> "Analysed":
        """Return the program with these cells as requirements."""
        program = self.programs.compiled(ir.DomainUse(cells))
        places = {requirement.name: number for number, requirement in enumerate(program.requirements)}
        numbers = {cell: places[name] for cell in cells if (name := requirement_name(*cell)) in places}
        return Analysed(program, slices_of(program, WORK) or (), numbers)

    def _result(self, cells: StartCells, proof: Sequence[int], program: Program) -> CellResult:
        names = {requirement_name(*cell): cell for cell in cells}
        involved = [names[name] for r in proof if (name := program.requirements[r].name) in names]
        others = [program.requirements[r] for r in proof if program.requirements[r].name not in names]
        state = State.EXCLUDED if others else State.IMPOSSIBLE
        named = tuple(RequirementInfo(each.name, program.place(each.line) if each.line else "") for each in others)
        return CellResult((), (), state, requirements=named, culprits=tuple(domain for domain, _ in involved))


@dataclass(frozen=True)
class Analysed:
    """A program with cells as requirements, sliced."""

    program: Program
    sliced: tuple[Sliced, ...]
    """() if it is too large to be analysed."""
    numbers: Mapping[tuple[int, int], int]
    """Requirement of each cell."""

    def conflict(self, cells: StartCells) -> tuple[int, ...]:
        """Return requirements that exclude the cells; () if there is no proof."""
        if not self.sliced:
            return ()
        added = [self.numbers[cell] for cell in cells if cell in self.numbers]
        return conflict_of(self.program, self.sliced, added, frozenset(self.numbers.values()))

    def gene_boxes(self, cells: StartCells) -> tuple[Floats, Floats]:
        """Return (n, genes) ends of boxes that hold the genes of all scenes in the cells, file units."""
        space = self.program.space
        if not self.sliced:
            return space.low[np.newaxis].copy(), space.high[np.newaxis].copy()
        others = sum(bit(number) for number in self._others(cells))
        return gene_boxes(self.program, self.sliced, EVERY & ~others if others else EVERY)

    def requiring(self, cells: StartCells) -> Program:
        """Return the program that requires these cells and no others."""
        code = self.program.code
        probability = code.requirement_probability.copy()
        probability[list(self._others(cells))] = 0.0
        return replace(self.program, code=code._replace(requirement_probability=probability))

    def _others(self, cells: StartCells) -> tuple[int, ...]:
        return tuple(number for cell, number in self.numbers.items() if cell not in cells)


def distance_to(values: Floats, cell: ir.Cell) -> Floats:
    """Return (n,) the distances of values from a cell, in widths of the cell; infinite for no number."""
    width = cell.high - cell.low if cell.high > cell.low else 1.0
    outside = np.maximum(np.maximum(cell.low - values, values - cell.high), 0.0) / width
    return np.where(np.isnan(values), math.inf, outside)
