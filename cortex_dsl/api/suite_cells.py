"""Runs of the cells of one group of a suite: tests within tolerances, searches of ranges, the least deviation.

The result of a cell depends on the cell, the driver and the plan only: its random numbers follow from its place in the
whole table. Params that no cell holds are deviations, in units of their tolerance; the nominal test has 0.
"""

import math
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from operator import itemgetter
from pathlib import Path
from shlex import join

import numpy as np

from cortex_dsl.api.concrete import map_copies
from cortex_dsl.api.contenders import Contender, NotComparableError, Side, SideKind, contender
from cortex_dsl.api.limits import MOST_RUNS, Budget, budget_of
from cortex_dsl.api.seeded_runs import KMH, OnRuns, check_mistake, drive, end_numbers, touched
from cortex_dsl.api.suite_tables import IMPACTS, WARNING, Cell, Group, SuiteError
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.suite_report import (
    CellResult,
    Deviation,
    GroupResult,
    Outcome,
    SearchedRange,
)
from engine.control import NO_WARNINGS
from engine.errors import ControllerError
from engine.gates.ranges import largest_ranges, spread
from engine.gates.ratings import COLOURS, RED, Rule, colours
from engine.references import NAMES, answer_counts
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.search.statistics import clopper_pearson
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.verdicts import answers_and_margins
from engine.vocabulary import Answer, Method, Sense, Verdict

RUNS = 200
"""Runs of a cell by default."""
EGO_SPEED = "EGO_SPEED"
"""Name of the speed of the ego in the scenarios of a suite, in which a behavior can be named without arguments."""
NO_WARNING = "the driver gives no warning, after which a person brakes"
EGO_PATH = "EGO_PATH"
"""Name of the path of the ego there: its lane, or, where a scenario has a path of its own, a turn."""
BLIND = f"ConstantSpeedBehavior({EGO_SPEED})"
BLIND_TURN = f"FollowTrajectoryBehavior({EGO_SPEED}, {EGO_PATH}, max_lateral=none)"
"""Egos whose runs reference drivers judge, straight on and along a path."""
FEWEST, USUAL_RATE, SHARE_OF_DRAWS = 16, 500.0, 0.7
"""Budget of time: fewest runs of a cell, runs in a second before any was measured, and share of the time for the
runs within the tolerances; the search for the least deviation has the rest.
"""
CORNERS = 6
"""Number of deviations up to which every corner of the tolerances is tried."""
RAYS = 16
"""Failing runs from which a search goes back towards the nominal test."""
HALVINGS = 10
ROUNDS, NEARBY = 3, 64
"""Rounds of draws within the least deviation so far, and their number."""


@dataclass(frozen=True)
class SuitePlan:
    """Settings of a run of a suite."""

    side: Side
    budget: Budget = field(default_factory=lambda: budget_of(RUNS))
    seed: int = 0
    jobs: int = 1
    folder: Path | None = None
    """Folder of the results, in which cases are kept; None: none is kept."""


def cell_result(cell: Cell, outcome: Outcome, **known: object) -> CellResult:
    parts = {
        name: getattr(cell, name) for name in ("id", "group", "range", "params", "rule", "limit", "source", "status")
    }
    return CellResult(**parts, outcome=outcome, **known)  # type: ignore[arg-type]


def not_run(cell: Cell, reason: str) -> CellResult:
    return cell_result(cell, Outcome.NOT_RUN, reason=reason)


@dataclass(frozen=True)
class _Judged:
    """Judged runs of one cell."""

    scenes: Scenes
    genomes: Floats
    valid: Bools
    contact: Bools
    impact: Floats
    """(n,) Impact speed [km/h]; NaN without contact."""
    colour: Ints
    """(n,) Place in `COLOURS`."""
    events: Callable[[int], str]

    @property
    def failed(self) -> Bools:
        return self.valid & (self.colour == RED)


_Failing = tuple[float, _Judged, int]
"""Size of a deviation, with the judged runs and the row that fails at it."""


class GroupRuns:
    """Runs of the cells of a group."""

    def __init__(self, group: Group, plan: SuitePlan, side: Contender, until: float, on_runs: OnRuns | None) -> None:
        self.group, self.plan, self.side = group, plan, side
        self.started, self.until, self.on_runs = time.monotonic(), until, on_runs
        self.cells_left = len(group.cells)
        self.space = side.program.space
        self.blind = None if group.file is None else _blind(group.file)
        self.runs = 0
        self.files: dict[str, bytes] = {}
        self.repeated = 0
        self.otherwise: list[str] = []

    def finished(self) -> GroupResult:
        """Return the results of all cells.

        Raises:
            CompileError: a run met a mistake of the file.
            SuiteError: a cell does not fit the scenario.
        """
        genomes = [self._nominal(cell) for cell in self.group.cells]
        if self.group.needs == WARNING and self.side.driver is not None and not self._warns(genomes[0]):
            cells_without = tuple(not_run(cell, NO_WARNING) for cell in self.group.cells)
            return GroupResult(self.group.name, cells_without, self.group.points)
        cells = list[CellResult]()
        for number, (cell, genome) in enumerate(zip(self.group.cells, genomes, strict=True)):
            before = self.runs if cells else 0  # the run that shows whether the driver warns is one of the first cell
            cells.append(replace(self._cell(cell, genome), simulations=self.runs - before))
            self.cells_left -= 1
            if self.on_runs is not None:
                self.on_runs(self.runs, round(self.runs / (number + 1) * len(genomes)))
        return GroupResult(
            self.group.name,
            tuple(cells),
            self.group.points,
            runs=self.runs,
            files=self.files,
            repeated=self.repeated,
            otherwise=tuple(self.otherwise),
        )

    def _warns(self, genome: Floats) -> bool:
        """Return True if the driver tells whether it warns, as its first run shows."""
        cell = self.group.cells[0]
        try:
            actions = self._run(cell, genome[np.newaxis]).scenes.actions
        except ControllerError:
            return True  # its cells say how it fails
        return not bool((actions[:, :, -1] == NO_WARNINGS).all())

    def _nominal(self, cell: Cell) -> Floats:
        """Return (d,) the genome of the nominal test.

        Raises:
            SuiteError: a param is missing, unknown, or out of its range, or the rule is about an `expect` that the file
                does not have.
        """
        space, file = self.space, self.group.file
        assert file is not None
        if cell.rule is Rule.EXPECT and all(o.sense is not Sense.EXPECT for o in self.side.program.judged.objectives):
            what = f"cell `{cell.id}` has the rule `expect`, but {file.name} has no `expect`"
            raise SuiteError(what, "write one in the scenario, or give the cell another rule")
        genome = np.zeros(len(space))
        held = {name: value for name, value in cell.params.items() if not isinstance(value, str)}
        for name in (*held, *cell.search):
            if name not in space.names:
                raise SuiteError(
                    f"cell `{cell.id}` holds `{name}`, which is not a param of {file.name}", "correct the table"
                )
        for gene, name in enumerate(space.names):
            low, high = cell.search.get(name, (held.get(name, 0.0),) * 2)
            if not space.low[gene] <= low <= high <= space.high[gene]:
                ends = f"{space.low[gene]:g} to {space.high[gene]:g} {space.units[gene]}".rstrip()
                what = "holds no value of" if name not in {*held, *cell.search} else f"has {low:g} to {high:g} for"
                raise SuiteError(f"cell `{cell.id}` {what} `{name}` of {file.name}", f"give one from {ends}")
            genome[gene] = low
        return genome

    def _free(self, cell: Cell) -> Ints:
        """Return the genes that are deviations."""
        held = {*cell.params, *cell.search}
        return np.array([gene for gene, name in enumerate(self.space.names) if name not in held], dtype=np.int64)

    def _cell(self, cell: Cell, genome: Floats) -> CellResult:
        """Return the result of a cell; a driver that fails in it fails in no other."""
        try:
            return self._searched(cell, genome) if cell.search else self._tested(cell, genome)
        except ControllerError as error:
            return cell_result(cell, Outcome.ERROR, reason=error.message)

    def _tested(self, cell: Cell, genome: Floats) -> CellResult:
        nominal = self._run(cell, genome[np.newaxis])
        if not nominal.valid[0]:
            return not_run(cell, "the nominal test has no valid scene")
        outcome = Outcome.FAIL if nominal.failed[0] else Outcome.PASS
        found = replace(self._described(cell, outcome, nominal, 0), references=self._references(cell, nominal.genomes))
        drawn = self._drawn(cell, genome)
        if drawn is not None:
            runs, failures = int(drawn.valid.sum()), int(drawn.failed.sum())
            interval = clopper_pearson(failures, runs)
            found = replace(found, runs=runs, failures=failures, low=interval.low, high=interval.high)
        before = self.runs
        least = self._least(cell, genome, nominal, drawn)
        found = replace(found, deviation=least, deviation_runs=self.runs - before)
        return self._repeated(cell, nominal, found)

    def _repeated(self, cell: Cell, judged: _Judged, found: CellResult) -> CellResult:
        """Drive the first test once more with a driver from outside; the cell fails if it fails the second time.

        A test that is driven otherwise is counted.
        """
        if self.side.driver is None:
            return found
        again = self._run(cell, judged.genomes[:1], judged.scenes.keys[:1])
        one, two = judged.scenes.actions[0], again.scenes.actions[0]
        both = min(len(one), len(two))  # the rest is beyond the end of the shorter run
        self.repeated += 1
        if not np.array_equal(one[:both], two[:both], equal_nan=True):
            self.otherwise.append(cell.id)
        if found.outcome is Outcome.FAIL or not again.failed[0]:
            return found
        worse = self._described(cell, Outcome.FAIL, again, 0)
        return replace(
            found, outcome=worse.outcome, colour=worse.colour, contact=worse.contact, impact=worse.impact,
            event=worse.event,
        )  # fmt: skip

    def _described(self, cell: Cell, outcome: Outcome, judged: _Judged, row: int) -> CellResult:
        return cell_result(
            cell,
            outcome,
            colour=COLOURS[int(judged.colour[row])],
            contact=bool(judged.contact[row]),
            impact=float(judged.impact[row]),
            event=judged.events(row),
        )

    def _drawn(self, cell: Cell, genome: Floats) -> _Judged | None:
        """Return runs with deviations that are uniform within the tolerances; None without a deviation."""
        free = self._free(cell)
        if not len(free):
            return None
        count = self._budget()
        keys = self._keys(cell, count)
        genomes = np.tile(genome, (count, 1))
        genomes[:, free] = draw_genomes(self.space, keys)[:, free]
        return self._run(cell, genomes)

    def _budget(self) -> int:
        """Return the number of runs of a cell: that of the plan, or those that fit into its share of the time left."""
        if math.isinf(self.until):
            return self.plan.budget.runs
        now = time.monotonic()
        rate = self.runs / max(now - self.started, 1e-3) if self.runs > FEWEST else USUAL_RATE
        share = max(0.0, self.until - now) / max(1, self.cells_left)
        return int(min(max(FEWEST, SHARE_OF_DRAWS * share * rate), MOST_RUNS))

    def _keys(self, cell: Cell, count: int, first: int = 0) -> Ints:
        return key_rows(self.plan.seed, Method.SAMPLE, 0, cell.number, np.arange(first, first + count))

    def _run(self, cell: Cell, genomes: Floats, keys: Ints | None = None) -> _Judged:
        """Drive and judge scenes with these genomes (n, d) and stream keys, by default the first ones of the cell.

        Raises:
            CompileError: a run met a mistake of the file.
            ControllerError: the driver fails in a run.
        """
        side, scenario = self.side, self.side.scenario
        keys = self._keys(cell, len(genomes)) if keys is None else keys
        scenes = sample(side.program, genomes, keys, scenario.config.simulation, self.plan.jobs)
        driver = None if side.driver is None else side.driver.without_history()
        done = drive(scenario, driver, scenes, self.plan.jobs)
        check_mistake(scenario, done, cell.id)
        if done.failures:
            raise done.failures[0]
        self.runs += len(genomes)
        outcomes, rows = done.outcomes, np.arange(len(genomes))
        contact = touched(outcomes)
        pair = np.maximum(outcomes.contact_actors[:, 1] - 1, 0)
        ego, other = outcomes.ego_speed[rows, pair] * KMH, outcomes.other_speed[rows, pair] * KMH
        impact = np.where(contact, ego + IMPACTS[self.group.impact] * other, np.nan)
        reduction = genomes[:, self.space.names.index("SPEED")] - ego if "SPEED" in self.space.names else -ego
        speed = float(cell.params.get("SPEED", 0.0))
        left = ~np.isnan(outcomes.left_road_time[:, 0])
        if cell.rule is Rule.EXPECT:
            colour = np.where((outcomes.broken == 1.0).any(axis=1), RED, 0)
        else:
            colour = colours(cell.rule, speed, contact, np.nan_to_num(impact), np.nan_to_num(reduction), cell.limit)
        colour = np.where(left, RED, colour)  # whoever leaves the road has not stopped for the target

        def event(row: int) -> str:
            text = end_numbers(side.program, outcomes, row)[0]
            return f"{outcomes.left_road_time[row, 0]:.2f} s: left the road; {text}" if left[row] else text

        return _Judged(done.scenes, genomes, outcomes.verdict == Verdict.VALID, contact, impact, colour, event)

    # -- the least deviation

    def _least(self, cell: Cell, genome: Floats, nominal: _Judged, drawn: _Judged | None) -> Deviation | None:
        """Return the least deviation found at which the cell fails; None if no run within the tolerances does.

        Corners of the tolerances and the drawn runs come first. From failing ones the way back to the nominal test is
        halved, and draws within the least deviation so far follow.
        """
        if nominal.failed[0]:
            return self._deviation(cell, genome, nominal, 0)
        free = self._free(cell)
        if drawn is None or not len(free):
            return None
        first = len(drawn.genomes)
        corners = np.tile(genome, (2 ** min(len(free), CORNERS), 1))
        ends = np.array([(self.space.low[gene], self.space.high[gene]) for gene in free])
        corners[:, free[:CORNERS]] = np.array(list(product(*ends[:CORNERS])))
        tried = [drawn, self._run(cell, corners, self._keys(cell, len(corners), first))]
        first += len(corners)
        found = list[_Failing]()
        for round_ in range(ROUNDS + 1):
            if failing := self._failing(tried, free):
                found.append(self._halved(cell, genome, failing, free))
            if not found or round_ == ROUNDS:
                break
            nearby = np.tile(genome, (NEARBY, 1))
            keys = self._keys(cell, NEARBY, first)
            nearby[:, free] = min(found, key=itemgetter(0))[0] * draw_genomes(self.space, keys)[:, free]
            tried = [self._run(cell, nearby, keys)]
            first += NEARBY
        if not found:
            return None
        _, judged, row = min(found, key=itemgetter(0))
        return self._deviation(cell, genome, judged, row)

    def _failing(self, tried: Sequence[_Judged], free: Ints) -> list[_Failing]:
        """Return the failing runs with the least deviations in rising order, at most `RAYS`."""
        found = list[_Failing]()
        for judged in tried:
            rows = np.flatnonzero(judged.failed)
            sizes = self._sizes(judged.genomes[rows], free)
            order = np.argsort(sizes, kind="stable")[:RAYS]
            found += [(float(sizes[each]), judged, int(rows[each])) for each in order]
        return sorted(found, key=itemgetter(0))[:RAYS]

    def _sizes(self, genomes: Floats, free: Ints) -> Floats:
        """Return (n,) the largest share of a tolerance that each genome uses."""
        values = genomes[:, free]
        low, high = (np.array([end[gene] for gene in free]) for end in (self.space.low, self.space.high))
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(values > 0.0, values / high, np.where(values < 0.0, values / low, 0.0))
        return np.asarray(shares.max(axis=1), dtype=np.float64)

    def _halved(self, cell: Cell, genome: Floats, failing: Sequence[_Failing], free: Ints) -> _Failing:
        """Return the least failing deviation on the ways from failing runs to the nominal test.

        A run on a way has the stream key of the failing run, so that only its deviations differ. With a random driver
        no run on the ways may fail; the least of the failing runs is the result then.
        """
        best = failing[0]
        far = np.array([judged.genomes[row, free] for _, judged, row in failing])
        keys = np.array([judged.scenes.keys[row] for _, judged, row in failing])
        passes, fails = np.zeros(len(failing)), np.ones(len(failing))
        for _ in range(HALVINGS):
            middle = 0.5 * (passes + fails)
            between = np.tile(genome, (len(failing), 1))
            between[:, free] = middle[:, np.newaxis] * far
            judged = self._run(cell, between, keys)
            best = min((best, *self._failing([judged], free)), key=itemgetter(0))
            passes, fails = np.where(judged.failed, passes, middle), np.where(judged.failed, middle, fails)
        return best

    def _deviation(self, cell: Cell, genome: Floats, judged: _Judged, row: int) -> Deviation:
        free = self._free(cell)
        values = judged.genomes[row]
        case = self._kept(cell, judged.scenes, row)
        words = self.side.command[1:] if self.side.driver is not None else ()
        return Deviation(
            size=float(self._sizes(values[np.newaxis], free)[0]) if len(free) else 0.0,
            params={self.space.names[gene]: float(values[gene]) for gene in free if values[gene] != genome[gene]},
            colour=COLOURS[int(judged.colour[row])],
            impact=float(judged.impact[row]),
            event=judged.events(row),
            case=case,
            replay=join(["cortexc", as_argument(self.plan.folder / case), *words]) if case and self.plan.folder else "",
        )

    def _kept(self, cell: Cell, scenes: Scenes, row: int) -> str:
        """Keep a run as a scenario of its own; return its place."""
        if self.plan.folder is None:
            return ""
        name = re.sub(r"[^\w.+-]+", "-", cell.id) + ".scn"
        texts = self.side.scenario.concrete_files(scenes, row, remark=f"{cell.id}: fails", name=name)
        self.files |= {f"cases/{each}": text.encode() for each, text in texts.items()}
        self.files |= {f"cases/{each}": content for each, content in map_copies(self.side.program).items()}
        return f"cases/{name}"

    # -- ranges

    def _searched(self, cell: Cell, genome: Floats) -> CellResult:
        """Search ranges of params for a failure."""
        names = list(cell.search)
        genes = np.array([self.space.names.index(name) for name in names])
        ends = np.array([cell.search[name] for name in names])
        shares = spread(self._budget(), len(names))
        genomes = np.tile(genome, (len(shares), 1))
        genomes[:, genes] = ends[:, 0] + shares * (ends[:, 1] - ends[:, 0])
        judged = self._run(cell, genomes)
        failing = np.flatnonzero(judged.failed)
        if not judged.valid.any():
            return not_run(cell, "no test of the range has a valid scene")
        impacts = np.nan_to_num(judged.impact[failing], nan=-1.0)
        worst = failing[np.argmax(impacts)] if len(failing) else np.argmax(judged.valid)
        row = int(worst)
        found = self._described(cell, Outcome.FAIL if len(failing) else Outcome.PASS, judged, row)
        ranges = largest_ranges(genomes[judged.valid][:, genes], judged.failed[judged.valid], ends)
        units = {name: self.space.units[gene] for name, gene in zip(names, genes, strict=True)}
        runs = int(judged.valid.sum())
        searched = SearchedRange(runs, len(failing), dict(zip(names, ranges, strict=True)), units)
        found = replace(found, references=self._references(cell, genomes))
        found = self._repeated(cell, judged, found)
        least = self._deviation(cell, genome, judged, row) if len(failing) else None
        if least is not None:
            values = {name: float(genomes[row, gene]) for name, gene in zip(names, genes, strict=True)}
            least = replace(least, size=0.0, params=values)
        return replace(found, searched=searched, deviation=least)

    # -- reference drivers

    def _references(self, cell: Cell, genomes: Floats) -> dict[str, dict[Answer, int]]:
        """Return how often each reference driver gave each answer to the collisions of tests.

        The tests have these genomes (n, d), and an ego that keeps its speed; {} if none can in the file, or without a
        collision.
        """
        if self.blind is None:
            return {}
        program, config = self.blind.program, self.blind.scenario.config
        scenes = sample(program, genomes, self._keys(cell, len(genomes)), config.simulation, self.plan.jobs)
        answers, _ = answers_and_margins(
            program, scenes, config.simulation, config.contact, self.plan.jobs, NAMES, measured=False
        )
        counts = answer_counts(NAMES, answers)
        return counts if any(counts.values()) else {}


def has_path(file: Path) -> bool:
    """Return True if a scenario gives the ego a path of its own, which is not a lane."""
    return re.search(rf"^{EGO_PATH}\s*=", file.read_text(encoding="utf-8"), re.MULTILINE) is not None


def _blind(file: Path) -> Contender | None:
    """Return an ego that keeps its speed; None if none can drive in the file."""
    try:
        return contender(Side(BLIND_TURN if has_path(file) else BLIND, SideKind.BEHAVIOUR), file)
    except (CompileError, NotComparableError):
        return None
