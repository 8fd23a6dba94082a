"""Coverage of the `domain` lines of a file: a state for each cell of their t-way products, with its proof.

Independent runs fill the cells. What no run reached is analysed: by intervals, over the program with the cell as one
more requirement, and by the instants at which the runs ended. Prints nothing.
"""

import math
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from shlex import join

import numpy as np

from cortex_dsl import ir
from cortex_dsl.api.limits import Budget, budget_of
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.api.seeded_runs import (
    BLOCK,
    OnRuns,
    check_mistake,
    draw_scenes,
    drive,
    fitting_driver,
    only_scene,
    seeds_of,
    touched,
)
from cortex_dsl.files import DISK
from cortex_dsl.pipeline import compile_source
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.coverage_report import (
    LEVEL,
    CellResult,
    CoverageReport,
    DomainInfo,
    RequirementInfo,
    State,
    Worst,
)
from cortex_dsl.report.findings.probability_report import withheld_text
from cortex_dsl.report.findings.story import end_of, end_text
from cortex_dsl.semantics.acting.domains import OBJECTIVE, condition_text, requirement_name
from cortex_dsl.source import Source
from engine.dependence import leaves_nothing_to_chance
from engine.driving.blocks import Driver
from engine.errors import ArgumentError
from engine.feasibility.explanation import conflict_of, slices_of
from engine.feasibility.slices import MOST, Sliced
from engine.gates.coverage import MISSING, MOST_CELLS, Counted, cells_in, count_cells, counted, places_of, products
from engine.outcomes import Outcomes
from engine.program import Program
from engine.risk import PROFILES, assess
from engine.scenes import Scenes
from engine.search.probability.estimates import Withheld
from engine.search.probability.monte_carlo import LEAST_SUBSET, estimate
from engine.search.statistics import clopper_pearson
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import EndReason, Sense, Verdict

RUNS = 2_000
"""Runs by default."""
WAYS = (1, 2, 3)
WORK = 20_000_000
"""Values that the analysis of one program may compute."""
ALONE = 400
"""Maximum number of cells with a program of their own, whose proofs are stronger than those of a program for many."""
MOST_SOUGHT = 100
"""Maximum number of cells for which a directed search is made."""
SEARCH, POPULATION = "differential_evolution", 25
"""Method of such a search, and its individuals of a generation."""
EVENT = "no value in the cell"
"""Name of the `expect` that such a search breaks."""
EVENTS = 3
"""Maximum number of events that are listed for a blocked cell."""


@dataclass(frozen=True)
class CoveragePlan:
    """Settings of a coverage."""

    ways: int | None = None
    """Number of domains in a product; None: two, or one if there is one domain only."""
    budget: Budget = field(default_factory=lambda: budget_of(RUNS))
    seed: int = 0
    joint: bool = False
    rare: int = 0
    """Runs of the directed search for an untried cell, and of each level of its probability; 0: no search."""
    driver: Driver | None = None
    replay: tuple[str, ...] = ()
    """Words of a replay command that name the driver, and params."""
    jobs: int = 1


def cover(scenario: Scenario, source: Source, plan: CoveragePlan, on_runs: OnRuns | None = None) -> CoverageReport:
    """Return the coverage of a file; `source` is its text, from which programs with its domains are compiled.

    Raises:
        ArgumentError: the file has no domains, fewer than `ways`, or too many cells.
        CompileError: no scene is possible, or a run met a mistake of the file.
        ControllerError: the driver cannot be asked.
    """
    return _Coverage(scenario, source, plan).report(on_runs)


def check_domains(scenario: Scenario, ways: int | None = None, rare: int = 0) -> int:
    """Return the number of domains in a product.

    Raises:
        ArgumentError: the file has no domains, fewer than `ways`, or too many cells, or `rare` is too small.
    """
    domains = scenario.compiled.scenario.domains
    if not domains:
        cure = 'add one, such as `domain "speed" ego.speed in 10 km/h steps from 0 km/h to 60 km/h`'
        raise ArgumentError(f"`{scenario.compiled.source.name}` has no `domain` lines", cure)
    if ways is not None and ways > len(domains):
        have = len(domains)
        raise ArgumentError(f"--ways is {ways}, but the file has {have} `domain` lines", f"give at most {have}")
    ways = min(2, len(domains)) if ways is None else ways
    if 0 < rare < LEAST_SUBSET:
        raise ArgumentError(f"--rare is {rare}", f"give at least {LEAST_SUBSET:,} runs")
    total = count_cells([len(each.cells) for each in domains], ways)
    if total > MOST_CELLS:
        largest = max(domains, key=lambda each: len(each.cells))
        raise ArgumentError(
            f"the {ways}-way product of the domains has {total:,} cells, more than {MOST_CELLS:,}",
            f"use wider cells or fewer --ways; the largest domain is `{largest.name}` of {len(largest.cells):,} cells",
        )
    return ways


@dataclass(frozen=True)
class _Drawn:
    """All runs that count."""

    numbers: Ints
    """(n,) from 1."""
    places: Ints
    """(n, domains)"""
    failed: Bools
    severity: Floats
    events: Ints
    """(n, 2) reason of the end, and its rule."""
    texts: Mapping[int, str]
    """Event at the end of each valid run, by its row."""
    lost: int
    is_kept: bool
    """True if the file leaves nothing to chance."""


class _Coverage:
    """Coverage of one file."""

    def __init__(self, scenario: Scenario, source: Source, plan: CoveragePlan) -> None:
        self.scenario, self.source, self.plan = scenario, source, plan
        self.program = scenario.program
        self.domains = scenario.compiled.scenario.domains
        self.path = scenario.compiled.source.name
        self.ways = check_domains(scenario, plan.ways, plan.rare)
        self.sizes = [len(each.cells) for each in self.domains]
        self.expects = [i for i, o in enumerate(self.program.judged.objectives) if o.sense is Sense.EXPECT]
        self.proofs = _Proofs(self)

    def compiled(self, use: ir.DomainUse) -> Program:
        """Return the program of the file in which its domains have an effect."""
        scenario = self.scenario
        compiled = compile_source(self.source, scenario.overrides, scenario=scenario.chosen, files=DISK, domains=use)
        return compiled.program

    # -- runs

    def drawn(self, on_runs: OnRuns | None) -> _Drawn:
        """Return the independent runs."""
        scenario, plan, kept = self.scenario, self.plan, leaves_nothing_to_chance(self.program)
        program = self.compiled(ir.DomainUse())
        measuring = replace(scenario, compiled=replace(scenario.compiled, program=program))
        driver = fitting_driver(self.program, plan.driver)
        budget, until = 1 if kept else plan.budget.runs, time.monotonic() + plan.budget.seconds
        parts: list[tuple[Ints, Ints, Bools, Floats, Ints]] = []
        texts: dict[int, str] = {}
        made = valid = 0
        while made < budget and (not made or time.monotonic() < until):
            numbers = np.arange(made + 1, made + min(BLOCK, budget - made) + 1)
            seeds = None if kept else seeds_of(plan.seed, numbers)
            done = drive(scenario, driver, self._scenes(scenario, seeds, hopeful=valid > 0), plan.jobs)
            check_mistake(scenario, done, self.path)
            outcomes = done.outcomes
            again = replace(self._scenes(measuring, seeds, hopeful=valid > 0), actions=done.scenes.actions)
            places = self._places(_values(program, measuring.simulate(again, jobs=plan.jobs)))
            failed, severity = self._judged(outcomes)
            ends = np.stack([outcomes.end_reason, outcomes.end_rule], axis=1)
            rows = np.flatnonzero(outcomes.verdict == Verdict.VALID)
            texts |= {valid + i: end_of(self.program, outcomes, row).text for i, row in enumerate(rows.tolist())}
            parts.append((numbers[rows], places[rows], failed[rows], severity[rows], ends[rows]))
            made, valid = made + len(numbers), valid + len(rows)
            if on_runs is not None:
                on_runs(made, budget)
            if not valid:
                break
        numbers, places, failed, severity, ends = (np.concatenate(each) for each in zip(*parts, strict=True))
        return _Drawn(numbers, places, failed, severity, ends, texts, made - valid, kept)

    def _scenes(self, scenario: Scenario, seeds: Ints | None, *, hopeful: bool) -> Scenes:
        """Draw the scenes of some seeds, or the only scene."""
        return only_scene(scenario) if seeds is None else draw_scenes(scenario, seeds, self.plan.jobs, hopeful=hopeful)

    def _judged(self, outcomes: Outcomes) -> tuple[Bools, Floats]:
        """Return (n,) failures, and how bad each run is."""
        if self.expects:
            failed = (outcomes.broken[:, self.expects] == 1.0).any(axis=1)
            return failed, -outcomes.sought[:, self.expects].min(axis=1)
        return touched(outcomes), np.asarray(assess(outcomes, PROFILES["paper"]).continuous, np.float64)

    def _places(self, values: Floats) -> Ints:
        """Return (n, domains) the cells of the runs."""
        columns = []
        for number, each in enumerate(self.domains):
            ends = np.array([(cell.low, cell.high, cell.closed) for cell in each.cells])
            columns.append(places_of(values[:, number], ends[:, 0], ends[:, 1], ends[:, 2] == 1.0))
        return np.stack(columns, axis=1)

    # -- cells

    def report(self, on_runs: OnRuns | None) -> CoverageReport:
        """Return the report."""
        started = time.monotonic()
        self.scenario.check_possible()
        drawn = self.drawn(on_runs)
        results = [cell for domains in products(self.sizes, self.ways) for cell in self._product(domains, drawn)]
        results = [*self._with_intervals(self._with_rare(results))]
        always = [number for number, each in enumerate(self.domains) if each.when != "contact"]
        valueless = int((drawn.places[:, always] == MISSING).any(axis=1).sum())
        return CoverageReport(
            path=self.path,
            digest=self.program.digest,
            seed=self.plan.seed,
            budget=self.plan.budget.text,
            timed=math.isfinite(self.plan.budget.seconds),
            ways=self.ways,
            draws=len(drawn.numbers),
            lost=drawn.lost,
            valueless=valueless,
            failure="a broken `expect`" if self.expects else "a contact of the ego",
            domains=tuple(self._info(each) for each in self.domains),
            cells=tuple(results),
            joint=self.plan.joint,
            remarks=tuple(f"some cells are {reason}" for reason in dict.fromkeys(self.proofs.reasons.values())),
            seconds=time.monotonic() - started,
        )

    def _info(self, each: ir.Domain) -> DomainInfo:
        named = any(cell.item for cell in each.cells)  # the numbers behind names of things mean nothing to a reader
        bounds = (each.least, each.greatest)
        ends = [None if named or not math.isfinite(end) else end / each.scale for end in bounds]
        cells = tuple(cell.text for cell in each.cells)
        return DomainInfo(each.name, each.when, each.text, self.program.place(each.line), each.unit, cells, *ends)

    def _product(self, domains: tuple[int, ...], drawn: _Drawn) -> Iterator[CellResult]:
        """Yield the cells of one product."""
        places = drawn.places[:, domains]
        found = counted(places, drawn.failed, drawn.severity)
        starts = [i for i, domain in enumerate(domains) if self.domains[domain].when == "start"]
        late = [i for i in range(len(domains)) if i not in starts]
        for cells in cells_in(self.sizes, domains):
            if (here := found.get(cells)) is not None:
                yield self._covered(domains, cells, here, drawn)
                continue
            proved = self.proofs.of(tuple((domains[i], cells[i]) for i in starts))
            if proved is not None:
                yield replace(proved, domains=domains, cells=cells)
                continue
            yield self._open(domains, cells, starts, late, drawn)

    def _covered(self, domains: tuple[int, ...], cells: tuple[int, ...], here: Counted, drawn: _Drawn) -> CellResult:
        number = int(drawn.numbers[here.worst])
        seed = None if drawn.is_kept else int(seeds_of(self.plan.seed, np.array([number]))[0])
        words = [] if seed is None else ["--seed", str(seed)]
        replay = join(["cortexc", as_argument(Path(self.path)), *words, *self.plan.replay])
        worst = Worst(number, seed, drawn.texts[here.worst], replay)
        return CellResult(domains, cells, State.COVERED, here.runs, here.failures, worst=worst)

    def _open(
        self,
        domains: tuple[int, ...],
        cells: tuple[int, ...],
        starts: Sequence[int],
        late: Sequence[int],
        drawn: _Drawn,
    ) -> CellResult:
        """Return a cell that no run reached and no proof excludes."""
        places, total = drawn.places[:, domains], len(drawn.numbers)
        begun = (places[:, starts] == np.array([cells[i] for i in starts], dtype=np.int64)).all(axis=1)
        early = (places[:, late] == MISSING).any(axis=1) if late else np.zeros(total, dtype=bool)
        if not late or not begun.any() or not early[begun].all():
            remark = self.proofs.reasons.get(tuple((domains[i], cells[i]) for i in starts), "")
            return CellResult(domains, cells, State.UNTRIED, draws=total, remark=remark)
        ends = Counter(map(tuple, drawn.events[begun].tolist())).most_common(EVENTS)
        events = tuple((end_text(self.program, EndReason(reason), rule), count) for (reason, rule), count in ends)
        return CellResult(domains, cells, State.BLOCKED, int(begun.sum()), events=events, draws=total)

    def _with_rare(self, results: Sequence[CellResult]) -> Iterator[CellResult]:
        """Yield the cells, untried ones as rare if a directed search reaches them: the first ones at the start."""
        left = MOST_SOUGHT if self.plan.rare else 0
        for each in results:
            at_start = all(self.domains[domain].when == "start" for domain in each.domains)
            if each.state is not State.UNTRIED or not at_start or not left:
                yield each
                continue
            left -= 1
            yield self._sought(each)

    def _sought(self, cell: CellResult) -> CellResult:
        """Return an untried cell after a directed search, with the probability of a scene in it.

        The event of the search is a broken `expect`, that the values do not lie in the cell.
        """
        places = zip(cell.domains, cell.cells, strict=True)
        conditions = [condition_text(self.domains[d], self.domains[d].cells[c]) for d, c in places]
        text = f'{self.source.text.rstrip()}\nexpect not ({" and ".join(conditions)}) as "{EVENT}"\n'
        source = replace(self.source, text=text)
        compiled = compile_source(source, self.scenario.overrides, scenario=self.scenario.chosen, files=DISK)
        settings = replace(self.scenario.config.search, seed=self.plan.seed)
        config = replace(self.scenario.config, search=settings, driver=fitting_driver(self.program, self.plan.driver))
        searched = replace(self.scenario, compiled=compiled, config=config)
        generations = self.plan.rare // POPULATION
        campaign = searched.search(
            SEARCH, objective=EVENT, generations=generations, population=POPULATION, jobs=self.plan.jobs
        )
        best = next((case for case in campaign.worst if campaign.evaluations.found[case.row]), None)
        if best is None:
            return replace(cell, remark=f"nor of {self.plan.rare:,} runs of a directed search")
        found = estimate(compiled.program, config, "subset", self.plan.rare, self.plan.seed, of=EVENT)
        reason = "" if found.withheld is Withheld.NOTHING else withheld_text(found)
        known = None if reason else (found.value, found.interval.low, found.interval.high)
        case = self.scenario.concrete(self.scenario.scene(best))
        params = tuple(zip(self.program.space.names, best.genome, self.program.space.units, strict=True))
        return replace(
            cell, state=State.RARE, sought=self.plan.rare, probability=known, remark=reason, case=case, params=params
        )

    def _with_intervals(self, results: Iterable[CellResult]) -> Iterator[CellResult]:
        """Yield the cells, the covered ones with the interval of their rate."""
        results = tuple(results)
        covered = sum(each.state is State.COVERED for each in results)
        level = 1.0 - (1.0 - LEVEL) / max(1, covered) if self.plan.joint else LEVEL
        interval = cache(lambda failures, runs: clopper_pearson(failures, runs, level))
        for each in results:
            if each.state is not State.COVERED:
                yield each
                continue
            low, high = interval(each.failures, each.runs)
            yield replace(each, low=low, high=high)


def _values(program: Program, outcomes: Outcomes) -> Floats:
    """Return (n, domains) the values of all domains in runs of a program that measures them; NaN for none."""
    columns = {each.name: number for number, each in enumerate(program.judged.objectives)}
    count = sum(name.startswith(OBJECTIVE) for name in columns)
    chosen = [columns[f"{OBJECTIVE}{domain}"] for domain in range(count)]
    valid = (outcomes.verdict == Verdict.VALID)[:, np.newaxis]
    return np.where(valid, outcomes.sought[:, chosen], np.nan)


# -- proofs ------------------------------------------------------------------------------------------------------------

StartCells = tuple[tuple[int, int], ...]
"""(domain, cell) of domains at the start."""


class _Proofs:
    """Proofs that no scene lies in a cell."""

    def __init__(self, coverage: _Coverage) -> None:
        self.coverage = coverage
        program = coverage.program
        self.room = MOST - len(program.requirements)
        """Number of cells that one program can have as requirements, each with a bit of its own."""
        self.reasons: dict[StartCells, str] = {}
        """Reasons why cells are not analysed, or not alone."""
        self._known: dict[StartCells, CellResult | None] = {}
        self._shared: dict[int, tuple[frozenset[tuple[int, int]], _Analysed | None]] = {}
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
        shared = self._shared_program(cells)
        proof = shared.conflict(cells) if shared is not None else ()
        if not proof and self._left > 0:
            self._left -= 1
            alone = _analysed(self.coverage, frozenset(cells))
            proof = alone.conflict(cells) if alone is not None else ()
            shared = alone or shared
        elif not proof:
            self.reasons[cells] = "analysed together with other cells only"
        return self._result(cells, proof, shared.program) if proof and shared is not None else None

    def _shared_program(self, cells: StartCells) -> "_Analysed | None":
        """Return a program with these cells among others, so that many cells share one analysis."""
        group = self.room // len(cells)
        wanted: set[tuple[int, int]] = set()
        for domain, cell in cells:
            first = cell // group * group
            last = min(first + group, self.coverage.sizes[domain])
            wanted |= {(domain, each) for each in range(first, last)}
        key = frozenset(wanted)
        last, analysed = self._shared.get(len(cells), (frozenset[tuple[int, int]](), None))
        if last != key:
            analysed = _analysed(self.coverage, key)
            self._shared[len(cells)] = key, analysed
        return analysed

    def _result(self, cells: StartCells, proof: Sequence[int], program: Program) -> CellResult:
        names = {requirement_name(*cell): cell for cell in cells}
        involved = [names[name] for r in proof if (name := program.requirements[r].name) in names]
        others = [program.requirements[r] for r in proof if program.requirements[r].name not in names]
        state = State.EXCLUDED if others else State.IMPOSSIBLE
        named = tuple(RequirementInfo(each.name, program.place(each.line) if each.line else "") for each in others)
        return CellResult((), (), state, requirements=named, culprits=tuple(domain for domain, _ in involved))


@dataclass(frozen=True)
class _Analysed:
    """A program with cells as requirements, sliced."""

    program: Program
    sliced: tuple[Sliced, ...]
    numbers: Mapping[tuple[int, int], int]
    """Requirement of each cell."""

    def conflict(self, cells: StartCells) -> tuple[int, ...]:
        """Return requirements that exclude the cells; () if there is no proof."""
        added = [self.numbers[cell] for cell in cells if cell in self.numbers]
        return conflict_of(self.program, self.sliced, added, frozenset(self.numbers.values()))


def _analysed(coverage: _Coverage, cells: frozenset[tuple[int, int]]) -> _Analysed | None:
    """Return the program with these cells as requirements; None if it is too large to be analysed."""
    program = coverage.compiled(ir.DomainUse(cells))
    sliced = slices_of(program, WORK)
    places = {requirement.name: number for number, requirement in enumerate(program.requirements)}
    numbers = {cell: places[name] for cell in cells if (name := requirement_name(*cell)) in places}
    return None if sliced is None else _Analysed(program, sliced, numbers)
