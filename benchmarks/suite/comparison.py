"""What searchers find: runs of one budget and one objective, kept line by line."""

import json
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.suite.outside import OUTSIDE
from benchmarks.suite.scenarios import HERE, Runs, digest_of, planted_in, scenario
from engine.config import Config
from engine.program import Program
from engine.risk import PROFILES
from engine.search.campaign import Campaign, Progress
from engine.search.evaluator import make_evaluator
from engine.search.objectives import objectives
from engine.search.protocol import Box, Searcher
from engine.search.run import Task, run_campaign
from engine.search.searchers import Watched, build_searcher, seek
from engine.streams import method_number, operator_generator

KEPT = HERE / "runs.jsonl"
POPULATION = 100


@dataclass(frozen=True)
class Found:
    """What one run found."""

    scenario: str
    digest: str
    method: str
    objective: str
    budget: int
    run: int
    valid: int
    """Distinct valid simulations."""
    seconds: float
    """On the clock, whatever else the machine did."""
    failures: int
    cells: int
    """Of mechanism and both speeds, in which something failed."""
    first: dict[str, int]
    """By mechanism: how many valid simulations the first of it took."""
    processor: float | None = None
    """Processor time of the run [s], searcher and simulations; None of runs before it was kept …"""
    reached: dict[str, float] = field(default_factory=dict)
    """… and by mechanism: until the end of the generation with the first of it."""

    @property
    def key(self) -> tuple[str, str, str, str, int, int]:
        return self.scenario, self.digest, self.method, self.objective, self.budget, self.run


def kept(path: Path = KEPT) -> list[Found]:
    """Of runs that were made twice, the later."""
    lines = path.read_text().splitlines() if path.exists() else []
    return list({found.key: found for found in (Found(**json.loads(line)) for line in lines)}.values())


def compare(
    names: Sequence[str],
    methods: Sequence[str],
    objective: str,
    runs: int,
    budget: int,
    jobs: int,
    seconds: float,
    path: Path = KEPT,
) -> None:
    """Make the runs that are not kept yet, or without their time, seeds 0, 1, … and keep each at once; for so many
    seconds at most.
    """
    digests = {name: digest_of(name, scenario(name).program) for name in names}
    there = {found.key for found in kept(path) if found.processor is not None}
    end = time.perf_counter() + seconds
    asked = [
        (name, method, objective, budget, run)
        for run in range(runs)
        for name in names
        for method in methods
        if (name, digests[name], method, objective, budget, run) not in there
    ]
    with path.open("a") as file, ProcessPoolExecutor(jobs) as pool:
        for first in range(0, len(asked), jobs):
            if time.perf_counter() > end:
                return
            of_each = pool.map if jobs > 1 else map
            for found in of_each(searched, *zip(*asked[first : first + jobs], strict=True)):
                print(json.dumps(asdict(found)), file=file, flush=True)


def searched(name: str, method: str, objective: str, budget: int, run: int) -> Found:
    """One run; generations of a hundred, the last one may be smaller than asked for."""
    made = scenario(name)
    budgeted = replace(
        made.config.search, generations=budget // POPULATION, population=POPULATION, seed=run, run=run, probes=0
    )
    config, space = replace(made.config, search=budgeted), made.program.space
    aims = objectives(made.program, (objective,))
    start, begun, clock = time.perf_counter(), time.process_time(), []
    searcher = _searcher(method, Box.of(space), config)
    seek(searcher, method, len(aims))
    evaluate = make_evaluator(made.program, config, PROFILES["paper"], aims)

    def note(_progress: Progress) -> None:
        clock.append(time.process_time() - begun)

    task = Task(space, evaluate, budgeted, method, objective=(objective,))
    campaign = run_campaign(task, searcher, note)
    return found_in(campaign, name, made.program, run, time.perf_counter() - start, clock)


def _searcher(method: str, box: Box, config: Config) -> Searcher:
    """By its name here or in cortexc; of other packages one that is watched, as plug-ins are."""
    if method not in OUTSIDE:
        return build_searcher(method, box, config)
    search = config.search
    streams = partial(operator_generator, search.seed, method_number(method), search.run)
    return Watched(method, OUTSIDE[method](box, config, streams), box, search.population)


def found_in(
    campaign: Campaign, name: str, program: Program, run: int, seconds: float, clock: Sequence[float]
) -> Found:
    """The figures of a campaign, in the order in which its simulations ran; `clock`: processor time at the end of each
    generation [s].
    """
    evaluations, defects = campaign.evaluations, planted_in(name)
    told = evaluations.rollouts
    new = evaluations.simulated & (told.verdict[:, 0] == 0)
    columns = ("collided", "fault", "pair", "side", "ego_speed", "other_speed")
    of_pairs = {column: getattr(told, column)[new, 0] for column in columns}
    runs = Runs(**of_pairs, genomes=evaluations.genomes[new])
    mechanisms, rows = runs.mechanisms(program, defects), np.flatnonzero(runs.failed).tolist()
    first: dict[str, int] = {}
    for mechanism, row in zip(mechanisms, rows, strict=True):
        first.setdefault(mechanism, row + 1)
    generation = evaluations.places[new, 0]
    reached = {mechanism: clock[generation[valid - 1]] for mechanism, valid in first.items()}
    budget = campaign.config.generations * campaign.config.population
    cells = len(set(runs.cells(program, defects)))
    objective = campaign.objective[0]
    return Found(
        scenario=name,
        digest=digest_of(name, program),
        method=campaign.method,
        objective=objective,
        budget=budget,
        run=run,
        valid=int(new.sum()),
        seconds=seconds,
        failures=len(rows),
        cells=cells,
        first=first,
        processor=clock[-1],
        reached=reached,
    )
