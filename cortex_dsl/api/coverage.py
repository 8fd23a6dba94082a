"""Coverage of the `domain` lines of a file: a state for each cell of their t-way products, with its proof.

Independent runs fill the cells, or the scenes of a covering array. What no run reached is analysed: by intervals, over
the program with the cell as one more requirement, and by the instants at which the runs ended. Prints nothing.
"""

import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from shlex import join
from typing import Any

import numpy as np

from cortex_dsl import ir
from cortex_dsl.api import arguments
from cortex_dsl.api.concrete import map_copies
from cortex_dsl.api.domain_cells import DIRECTED, DomainPrograms
from cortex_dsl.api.limits import Budget, budget_of
from cortex_dsl.api.rare_cells import Effort, sought
from cortex_dsl.api.scenario import Scenario, load
from cortex_dsl.api.seeded_runs import (
    BLOCK,
    check_mistake,
    check_seed,
    draw_scenes,
    drive,
    fitting_driver,
    only_scene,
    seeds_of,
    touched,
)
from cortex_dsl.api.tway_scenes import OnStep, TwayScenes, tway_scenes
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.coverage_report import (
    INDEPENDENT,
    LEVEL,
    TWAY,
    CellResult,
    CoverageReport,
    DomainInfo,
    DomainTotal,
    State,
    Worst,
)
from cortex_dsl.report.findings.story import end_of, end_text
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import read_source
from engine.dependence import leaves_nothing_to_chance
from engine.driving.blocks import Driver
from engine.driving.named import driver_of
from engine.errors import ArgumentError
from engine.gates.coverage import MISSING, MOST_CELLS, OUTSIDE, Counted, cells_in, count_cells, counted, products
from engine.outcomes import Outcomes
from engine.risk import PROFILES, assess
from engine.sampling import draw_genomes
from engine.scenes import Scenes
from engine.search.probability.subset_simulation import LEAST
from engine.search.statistics import clopper_pearson
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import EndReason, Sense, Verdict

RUNS = 2_000
"""Runs by default."""
MOST_SCENES = 100_000
"""Maximum number of scenes of a covering array by default."""
MOST_SOUGHT = 100
"""Maximum number of cells for which a directed search is made."""
MANY = 100
"""Number of cells without a run from which on scenes are drawn to find the possible ones among them."""
EVENTS = 3
"""Maximum number of events that are listed for a blocked cell."""
METHODS = (INDEPENDENT, TWAY)
RARE, ROW = "rare", "tway"
"""Beginnings of the names of files with scenes."""


@dataclass(frozen=True)
class CoveragePlan:
    """Settings of a coverage."""

    ways: int | None = None
    """Number of domains in a product; None: two, or one if there is one domain only."""
    budget: Budget | None = None
    """Runs; None: `RUNS` independent ones, or as many as the covering array has."""
    seed: int = 0
    joint: bool = False
    rare: int = 0
    """Runs of the directed search for an untried cell, and of each level of its probability; 0: no search."""
    method: str = INDEPENDENT
    """A row of `METHODS`."""
    driver: Driver | None = None
    replay: tuple[str, ...] = ()
    """Words of a replay command that name the driver, and params."""
    driver_words: tuple[str, ...] = ()
    """Those of them that name the driver."""
    verdict: Callable[[Mapping[str, Any]], str] | None = None
    """Verdict (a row of `VERDICTS`) on the values of a run by domain, None for no value; None: no verdicts."""
    folder: Path | None = None
    """Folder in which the files of the scenes are to be placed; None: no files are made."""
    jobs: int = 1

    @property
    def limit(self) -> Budget:
        """Return the budget."""
        return self.budget or budget_of(RUNS if self.method == INDEPENDENT else MOST_SCENES)


def cover(scenario: Scenario, source: Source, plan: CoveragePlan, on_step: OnStep | None = None) -> CoverageReport:
    """Return the coverage of a file; `source` is its text, from which programs with its domains are compiled.

    Raises:
        ArgumentError: the file has no domains, fewer than `ways`, or too many cells, or none at the start for a
            covering array.
        CompileError: no scene is possible, or a run met a mistake of the file.
        ControllerError: the driver cannot be asked.
    """
    return _Coverage(scenario, source, plan, on_step).report()


def coverage(
    file: str | Path,
    *,
    ways: int | None = None,
    budget: int | str | None = None,
    seed: int = 0,
    method: str = INDEPENDENT,
    joint: bool = False,
    rare: int = 0,
    ego: object = None,
    jobs: int = 1,
) -> CoverageReport:
    """Return the state of each cell of the `domain` lines of a file and of their products, with its proof.

    Args:
        file: a file with `domain` lines.
        ways: domains in a product, 1, 2 or 3; None: two, or one if there is one domain only.
        budget: runs, or a time such as `"90s"`; None: 2,000, or as many as a covering array has scenes.
        seed: seed of the first run.
        method: `independent` draws, or `tway`, a covering array of the cells at the start.
        joint: whether all intervals hold together.
        rare: runs of the search for each untried cell at the start; 0: no search.
        ego: driver, as for `Scenario.driven_by`.
        jobs: threads; the result does not depend on it.

    Raises:
        ArgumentError: the file has no domains or too many cells, or a number cannot be.
        CompileError: the file has errors, or no scene is possible.
        ControllerError: the driver cannot drive the file.
    """
    arguments.one_of("method", method, METHODS)
    plan = CoveragePlan(
        ways=None if ways is None else arguments.whole("ways", ways, 1),
        budget=None if budget is None else budget_of(budget),
        seed=arguments.whole("seed", seed, 0),
        joint=joint,
        rare=arguments.whole("rare", rare, 0),
        method=method,
        driver=driver_of(ego),
        jobs=arguments.whole("jobs", jobs, 1),
    )
    check_seed(plan.seed)
    return cover(load(file), read_source(file), plan)


def check_domains(scenario: Scenario, plan: CoveragePlan) -> int:
    """Return the number of domains in a product.

    Raises:
        ArgumentError: the file has no domains, fewer than `ways`, or too many cells, `rare` is too small, or a covering
            array is asked of a file that leaves nothing to chance.
    """
    domains, ways = scenario.compiled.scenario.domains, plan.ways
    if not domains:
        cure = 'add one, such as `domain "speed" ego.speed in 10 km/h steps from 0 km/h to 60 km/h`'
        raise ArgumentError(f"`{scenario.compiled.source.name}` has no `domain` lines", cure)
    if ways is not None and ways > len(domains):
        have = len(domains)
        raise ArgumentError(f"--ways is {ways}, but the file has {have} `domain` lines", f"give at most {have}")
    ways = min(2, len(domains)) if ways is None else ways
    if 0 < plan.rare < LEAST:
        raise ArgumentError(f"--rare is {plan.rare}", f"give at least {LEAST:,} runs")
    if plan.method == TWAY and leaves_nothing_to_chance(scenario.program):
        raise ArgumentError("--method tway needs params or random values: the file has one scene only", "leave it out")
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
    genomes: Floats
    """(n, d) file units"""
    keys: Ints
    """(n, 6)"""
    values: Floats
    """(n, domains) SI; NaN for none."""
    places: Ints
    """(n, domains)"""
    failed: Bools
    severity: Floats
    events: Ints
    """(n, 2) reason of the end, and its rule."""
    texts: Mapping[int, str]
    """Event at the end of each valid run, by its row."""
    lost: int
    lost_by_driver: int
    is_kept: bool
    """True if the file leaves nothing to chance."""


class _Coverage:
    """Coverage of one file."""

    def __init__(self, scenario: Scenario, source: Source, plan: CoveragePlan, on_step: OnStep | None) -> None:
        self.scenario, self.plan = scenario, plan
        self.on_step: OnStep = on_step or (lambda _what, _done, _all: None)
        self.program = scenario.program
        self.programs = DomainPrograms(scenario, source, plan.seed, plan.jobs)
        self.proofs = self.programs.proofs
        self.domains, self.sizes = self.programs.domains, self.programs.sizes
        self.path = scenario.compiled.source.name
        self.ways = check_domains(scenario, plan)
        self.expects = [i for i, o in enumerate(self.program.judged.objectives) if o.sense is Sense.EXPECT]
        self.driver = fitting_driver(self.program, plan.driver)
        self.tway: TwayScenes | None = None
        self.files: dict[str, bytes] = {}

    # -- runs

    def drawn(self) -> _Drawn:
        """Return the runs: of independent seeds, or of a covering array."""
        scenario, limit, kept = self.scenario, self.plan.limit, leaves_nothing_to_chance(self.program)
        if self.plan.method == TWAY:
            self.tway = tway_scenes(self.programs, self.ways, limit.runs, self.on_step)
        budget, until = self._runs(kept=kept), time.monotonic() + limit.seconds
        parts: list[tuple[Ints, Floats, Ints, Floats, Bools, Floats, Ints]] = []
        texts: dict[int, str] = {}
        made = valid = by_driver = 0
        while made < budget and (not made or time.monotonic() < until):
            numbers = np.arange(made + 1, made + min(BLOCK, budget - made) + 1)
            done = drive(scenario, self.driver, self._scenes(numbers, kept=kept, hopeful=valid > 0), self.plan.jobs)
            check_mistake(scenario, done, self.path)
            outcomes, values = done.outcomes, self.programs.values_of_runs(done.scenes)
            failed, severity = self._judged(outcomes)
            ends = np.stack([outcomes.end_reason, outcomes.end_rule], axis=1)
            rows = np.flatnonzero(outcomes.verdict == Verdict.VALID)
            texts |= {valid + i: end_of(self.program, outcomes, row).text for i, row in enumerate(rows.tolist())}
            genomes, keys = done.scenes.genomes[rows], done.scenes.keys[rows]
            parts.append((numbers[rows], genomes, keys, values[rows], failed[rows], severity[rows], ends[rows]))
            made, valid = made + len(numbers), valid + len(rows)
            by_driver += int((outcomes.verdict == Verdict.CONTROLLER).sum())
            self.on_step("runs", made, budget)
            if not valid and self.tway is None:
                break
        if not parts:
            raise ArgumentError("no row of the covering array has a scene", "leave --method tway out")
        numbers, genomes, keys, values, failed, severity, ends = (
            np.concatenate(each) for each in zip(*parts, strict=True)
        )
        places = self.programs.places(values)
        lost = made - valid
        return _Drawn(numbers, genomes, keys, values, places, failed, severity, ends, texts, lost, by_driver, kept)

    def _runs(self, *, kept: bool) -> int:
        return len(self.tway.keys) if self.tway is not None else 1 if kept else self.plan.limit.runs

    def _scenes(self, numbers: Ints, *, kept: bool, hopeful: bool) -> Scenes:
        """Draw the scenes of runs with these numbers, from 1, or the only scene."""
        if self.tway is not None:
            return self.programs.scenes(self.tway.genomes[numbers - 1], self.tway.keys[numbers - 1])
        if kept:
            return only_scene(self.scenario)
        return draw_scenes(self.scenario, seeds_of(self.plan.seed, numbers), self.plan.jobs, hopeful=hopeful)

    def _judged(self, outcomes: Outcomes) -> tuple[Bools, Floats]:
        """Return (n,) failures, and how bad each run is."""
        if self.expects:
            failed = (outcomes.broken[:, self.expects] == 1.0).any(axis=1)
            return failed, -outcomes.sought[:, self.expects].min(axis=1)
        return touched(outcomes), np.asarray(assess(outcomes, PROFILES["paper"]).continuous, np.float64)

    # -- cells

    def report(self) -> CoverageReport:
        """Return the report."""
        started = time.monotonic()
        self.scenario.check_possible()
        drawn = self.drawn()
        results = [*self._with_intervals(self._with_rare(self._cells(drawn), drawn))]
        always = [number for number, each in enumerate(self.domains) if each.when in ALWAYS]
        valueless = int((drawn.places[:, always] == MISSING).any(axis=1).sum())
        limit = self.plan.limit
        if self.tway is not None:
            self._keep_rows(drawn)
        return CoverageReport(
            path=self.path,
            digest=self.program.digest,
            seed=self.plan.seed,
            budget=limit.text if self.plan.budget else str(RUNS) if self.tway is None else "",
            timed=math.isfinite(limit.seconds),
            ways=self.ways,
            draws=len(drawn.numbers),
            lost=drawn.lost,
            lost_by_driver=drawn.lost_by_driver,
            valueless=valueless,
            failure="a broken `expect`" if self.expects else "a contact of the ego",
            domains=tuple(self._info(each) for each in self.domains),
            cells=tuple(results),
            method=self.plan.method,
            joint=self.plan.joint,
            remarks=(*self._array_remarks(len(drawn.numbers) + drawn.lost), *self._proof_remarks()),
            totals=tuple(self._total(number, drawn) for number in range(len(self.domains))),
            verdicts=self._verdicts(drawn),
            files=self.files,
            seconds=time.monotonic() - started,
        )

    def _total(self, domain: int, drawn: _Drawn) -> DomainTotal:
        """Return the runs by the cells of a domain."""
        cells, places, values = self.domains[domain].cells, drawn.places[:, domain], drawn.values[:, domain]
        outside = values[places == OUTSIDE]
        runs = np.bincount(places[places >= 0], minlength=len(cells))
        if any(cell.item for cell in cells):
            return DomainTotal(tuple(runs.tolist()), other=len(outside))
        below = int((outside < min(cell.low for cell in cells)).sum())
        above = int((outside > max(cell.high for cell in cells)).sum())
        return DomainTotal(tuple(runs.tolist()), below, above, len(outside) - below - above)

    def _verdicts(self, drawn: _Drawn) -> dict[str, int] | None:
        """Return the numbers of runs by their verdict."""
        if (verdict := self.plan.verdict) is None:
            return None
        found = Counter(verdict(self._named(*row)) for row in zip(drawn.values, drawn.places, strict=True))
        return {name: found[name] for name in VERDICTS}

    def _named(self, values: Floats, places: Ints) -> dict[str, Any]:
        """Return the values of a run by domain, in its unit; None for no value."""
        return {
            each.name: None if place == MISSING else _shown(each, value, place)
            for each, value, place in zip(self.domains, values.tolist(), places.tolist(), strict=True)
        }

    def _proof_remarks(self) -> Iterator[str]:
        yield from (f"some cells are {reason}" for reason in dict.fromkeys(self.proofs.reasons.values()))

    def _array_remarks(self, ran: int) -> Iterator[str]:
        """Yield remarks on the covering array, of which `ran` scenes were run."""
        if (tway := self.tway) is None:
            return
        more = "" if len(tway.keys) == tway.rows else f", {len(tway.keys):,} scenes"
        yield f"covering array of {tway.rows:,} rows{more}: {tway.ways}-way combinations of cells at the start"
        if tway.cut:
            yield f"{tway.cut:,} combinations are cut off by the budget"
        if ran < len(tway.keys):
            yield f"the budget ended before {len(tway.keys) - ran:,} of the scenes were run"
        if tway.missing:
            yield f"{tway.missing:,} combinations are neither proved empty nor met by {DIRECTED:,} directed draws"
        if any(each.when != "start" for each in self.domains):
            yield "cells of later instants are counted; no scene is drawn for them"

    def _keep_rows(self, drawn: _Drawn) -> None:
        """Write each scene of the covering array as a file."""
        for row, number in enumerate(drawn.numbers.tolist()):
            self._keep(f"{ROW}-{number}.scn", drawn.genomes[row : row + 1], drawn.keys[row : row + 1])

    def _keep(self, name: str, genomes: Floats, keys: Ints) -> str:
        """Write a scene as a file, and return its name; "" if files are not asked for."""
        if self.plan.folder is None:
            return ""
        texts = self.scenario.concrete_files(self.programs.scenes(genomes, keys), name=name)
        self.files |= {each: text.encode() for each, text in texts.items()} | map_copies(self.program)
        return name

    def _cells(self, drawn: _Drawn) -> list[CellResult]:
        found: list[CellResult] = []
        total = count_cells(self.sizes, self.ways)
        for domains in products(self.sizes, self.ways):
            for cell in self._product(domains, drawn):
                found.append(cell)
                self.on_step("cells analysed", len(found), total)
        return found

    def _info(self, each: ir.Domain) -> DomainInfo:
        named = any(cell.item for cell in each.cells)  # the numbers behind names of things mean nothing to a reader
        bounds = (each.least, each.greatest)
        ends = [None if named or not math.isfinite(end) else end / each.scale for end in bounds]
        cells = tuple(cell.text for cell in each.cells)
        edges = () if named else tuple((cell.low / each.scale, cell.high / each.scale) for cell in each.cells)
        return DomainInfo(
            each.name, each.when, each.text, self.program.place(each.line), each.unit, cells, edges, *ends
        )

    def _product(self, domains: tuple[int, ...], drawn: _Drawn) -> Iterator[CellResult]:
        """Yield the cells of one product."""
        places = drawn.places[:, domains]
        found = counted(places, drawn.failed, drawn.severity)
        possible = self._possible(domains, len(found), drawn)
        starts = [i for i, domain in enumerate(domains) if self.domains[domain].when == "start"]
        late = [i for i in range(len(domains)) if i not in starts]
        for cells in cells_in(self.sizes, domains):
            if (here := found.get(cells)) is not None:
                yield self._covered(domains, cells, here, drawn)
                continue
            known = tuple(cells[i] for i in starts) in possible
            proved = None if known else self.proofs.of(tuple((domains[i], cells[i]) for i in starts))
            if proved is not None:
                yield replace(proved, domains=domains, cells=cells)
                continue
            yield self._open(domains, cells, starts, late, drawn)

    def _possible(self, domains: tuple[int, ...], reached: int, drawn: _Drawn) -> set[tuple[int, ...]]:
        """Return cells of domains at the start in which scenes lie, so that no proof is tried; none for few cells."""
        cells = count_cells([self.sizes[domain] for domain in domains], len(domains))
        starts = [domain for domain in domains if self.domains[domain].when == "start"]
        if drawn.is_kept or not starts or cells - reached < MANY:
            return set()
        return self.programs.pool.cells(starts)

    def _covered(self, domains: tuple[int, ...], cells: tuple[int, ...], here: Counted, drawn: _Drawn) -> CellResult:
        number = int(drawn.numbers[here.worst])
        seed, replay = None, ""
        if self.tway is not None:
            if self.plan.folder is not None:
                case = as_argument(self.plan.folder / f"{ROW}-{number}.scn")
                replay = join(["cortexc", case, *self.plan.driver_words])
        else:
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
        independent = total if self.tway is None else 0
        begun = (places[:, starts] == np.array([cells[i] for i in starts], dtype=np.int64)).all(axis=1)
        early = (places[:, late] == MISSING).any(axis=1) if late else np.zeros(total, dtype=bool)
        if not late or not begun.any() or not early[begun].all():
            remark = self.proofs.reasons.get(tuple((domains[i], cells[i]) for i in starts), "")
            return CellResult(domains, cells, State.UNTRIED, draws=independent, remark=remark)
        ends = Counter(map(tuple, drawn.events[begun].tolist())).most_common(EVENTS)
        events = tuple((end_text(self.program, EndReason(reason), rule), count) for (reason, rule), count in ends)
        return CellResult(domains, cells, State.BLOCKED, int(begun.sum()), events=events, draws=independent)

    # -- rare cells

    def _with_rare(self, results: Sequence[CellResult], drawn: _Drawn) -> Iterator[CellResult]:
        """Yield the cells, untried ones as rare if a directed search reaches them: the first ones at the start."""
        wanted = [number for number, each in enumerate(results) if self._is_sought(each)][:MOST_SOUGHT]
        if not self.plan.rare or not len(drawn.numbers):
            wanted = []
        for number, each in enumerate(results):
            if not wanted or number not in wanted:
                yield each
                continue
            self.on_step("rare cells searched", wanted.index(number), len(wanted))
            found = sought(each, self.programs, self._effort)
            if found.found is not None:
                found = replace(found, case=self._keep(f"{RARE}-{number + 1}.scn", *found.found))
            yield found

    def _is_sought(self, cell: CellResult) -> bool:
        return cell.state is State.UNTRIED and all(self.domains[domain].when == "start" for domain in cell.domains)

    @cached_property
    def _effort(self) -> Effort:
        """Return the settings of directed searches."""
        settings = replace(self.scenario.config.search, seed=self.plan.seed, jobs=self.plan.jobs)
        config = replace(self.scenario.config, search=settings, driver=self.driver)
        keys = self.programs.keys(self.plan.rare)
        counts, _ = self._count(self.programs.scenes(draw_genomes(self.program.space, keys), keys))
        return Effort(self.plan.rare, config, self._count, int(counts.sum()), len(counts))

    def _count(self, scenes: Scenes) -> tuple[Bools, Ints]:
        """Return (n,) True for scenes whose run counts, and (n, domains) their cells at the start."""
        done = drive(self.scenario, self.driver, scenes, self.plan.jobs)
        check_mistake(self.scenario, done, self.path)
        return done.outcomes.verdict == Verdict.VALID, self.programs.start_places(done.scenes)

    def _with_intervals(self, results: Iterable[CellResult]) -> Iterator[CellResult]:
        """Yield the cells, those that independent runs cover with the interval of their rate."""
        results = tuple(results)
        covered = sum(each.state is State.COVERED for each in results)
        level = 1.0 - (1.0 - LEVEL) / max(1, covered) if self.plan.joint else LEVEL
        interval = cache(lambda failures, runs: clopper_pearson(failures, runs, level))
        for each in results:
            if each.state is not State.COVERED or self.tway is not None:
                yield each
                continue
            low, high = interval(each.failures, each.runs)
            yield replace(each, low=low, high=high)


ALWAYS = ("start", "end")
"""Instants that every run has."""
VERDICTS = ("inside", "outside", "unknown")
"""Verdicts under an operational design domain."""


def _shown(domain: ir.Domain, value: float, place: int) -> Any:
    """Return a value as its author writes it: a number in its unit, a truth, or the text of an item."""
    items = [cell.item for cell in domain.cells]
    if not any(items):
        return value / domain.scale
    if set(items) <= {"True", "False"}:
        return bool(value)
    return items[place].strip("\"'") if place >= 0 else "<other>"
