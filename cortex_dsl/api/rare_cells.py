"""Cells at the start that no independent run reached: a scene in them, by directed draws or a search, and their
probability.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cortex_dsl.api.domain_cells import DomainPrograms, StartCells, distance_to
from cortex_dsl.report.findings.coverage_report import CellResult, State
from cortex_dsl.report.findings.probability_report import withheld_text
from engine.assessment import Evaluate
from engine.config import Config
from engine.gates.directed import genomes_between
from engine.outcomes import Assessment, Outcomes
from engine.risk import PAPER
from engine.scenes import Scenes
from engine.search.evaluator import make_evaluator
from engine.search.objectives import NO_MEASURES, Objective, Runs
from engine.search.probability.estimates import Probability, Withheld
from engine.search.probability.importance import importance_sampling
from engine.search.probability.levels import Score
from engine.search.probability.subset_simulation import subset_simulation
from engine.search.statistics import clopper_pearson
from engine.tables import Bools, Floats, Ints

METHOD, POPULATION = "differential_evolution", 25
"""Method of the search, and its individuals of a generation."""
ENOUGH = 10
"""Hits from which on independent draws in a part of the space of the params give the probability."""
HALF = 0.975
"""Confidence of each of two intervals that hold together with 95 %."""

Estimate = tuple[float, float, float]
"""Probability, and the ends of its 95 % interval."""
Count = Callable[[Scenes], tuple[Bools, Ints]]
"""Function from scenes to (n,) whether their run counts, and (n, domains) cells at the start."""


@dataclass(frozen=True)
class Effort:
    """Settings of the search for one cell."""

    runs: int
    """Runs of each part: search, draws, and level of an estimate."""
    config: Config
    """Settings of the runs, with the driver."""
    count: Count
    counted: int
    """Independent runs that count."""
    made: int
    """Independent runs."""


def sought(cell: CellResult, programs: DomainPrograms, effort: Effort) -> CellResult:
    """Return an untried cell at the start as rare, with a scene and its probability, if a scene in it is found."""
    cells = tuple(zip(cell.domains, cell.cells, strict=True))
    found = programs.drawn_in(cells) or _searched(cells, programs, effort)
    if found is None:
        return replace(cell, remark=f"nor of directed draws, nor of {effort.runs:,} runs of a search")
    genome, _ = found
    known, reason = _probability(cells, programs, effort)
    space = programs.program.space
    params = tuple(zip(space.names, genome[0].tolist(), space.units, strict=True))
    return replace(
        cell, state=State.RARE, sought=effort.runs, probability=known, remark=reason, params=params, found=found
    )


def _searched(cells: StartCells, programs: DomainPrograms, effort: Effort) -> tuple[Floats, Ints] | None:
    """Return genome (1, d) and key (1, 6) of a scene that a search for the cells found; None if it found none."""

    def nearness(outcomes: Outcomes) -> Floats:
        return -_distance(programs, cells, outcomes)

    scenario = replace(programs.measuring, config=effort.config)
    campaign = scenario.search(
        METHOD,
        objective=nearness,
        generations=max(1, effort.runs // POPULATION),
        population=POPULATION,
        jobs=programs.jobs,
        probes=0,
    )
    rows = np.argsort(-np.nan_to_num(campaign.evaluations.fitness, nan=-math.inf), kind="stable")[:1]
    genomes, keys = campaign.evaluations.genomes[rows], campaign.evaluations.keys[rows, 0]
    places = programs.start_places(programs.scenes(genomes, keys))
    return (genomes, keys) if all((places[:, domain] == place).all() for domain, place in cells) else None


def _distance(programs: DomainPrograms, cells: StartCells, outcomes: Outcomes) -> Floats:
    """Return (n,) the largest distance of the values of runs from the cells."""
    values = programs.values(outcomes)
    each = [distance_to(values[:, domain], programs.domains[domain].cells[place]) for domain, place in cells]
    return np.max(each, axis=0)


# -- probability -------------------------------------------------------------------------------------------------------


def _probability(cells: StartCells, programs: DomainPrograms, effort: Effort) -> tuple[Estimate | None, str]:
    """Return the probability of cells among runs that count, or the reason why there is none.

    Independent draws from the part of the space of the params outside of which no scene lies in the cells, where they
    hit often enough; otherwise subset simulation and importance sampling, where they agree.
    """
    if not effort.counted:
        return None, "no independent run counts"
    below, above = programs.quantiles(cells)
    share = float(np.prod(above - below))
    keys = programs.keys(effort.runs)
    genomes = genomes_between(programs.program.space, keys, below, above)
    counts, places = effort.count(programs.scenes(genomes, keys))
    hits = int((counts & np.all([places[:, domain] == place for domain, place in cells], axis=0)).sum())
    drawn = _of_draws(hits, effort.runs, share, effort)
    if hits >= ENOUGH:
        return drawn, ""
    known, reason = _of_rare_events(cells, programs, effort)
    if known is not None and known[1] <= drawn[2] and drawn[1] <= known[2]:
        return known, ""
    return (drawn, "") if hits else (None, reason or "the estimates contradict each other")


def _of_draws(hits: int, draws: int, share: float, effort: Effort) -> Estimate:
    """Return the probability from hits among draws that lie in a share of the space; both intervals hold together."""
    low, high = clopper_pearson(hits, draws, HALF)
    least, most = clopper_pearson(effort.counted, effort.made, HALF) if effort.counted < effort.made else (1.0, 1.0)
    counting = effort.counted / effort.made
    return share * hits / draws / counting, share * low / most, min(1.0, share * high / least)


def _of_rare_events(cells: StartCells, programs: DomainPrograms, effort: Effort) -> tuple[Estimate | None, str]:
    """Return the estimate on which subset simulation and importance sampling agree, or the reason why there is none."""
    evaluate, score = _event(cells, programs, effort)
    space, found = programs.program.space, list[Probability]()
    for function in (subset_simulation, importance_sampling):
        each = function(space, evaluate, effort.runs, programs.seed, score=score)
        if each.lost:
            each = replace(each, withheld=Withheld.LOST)
        if each.withheld is not Withheld.NOTHING:
            return None, f"{each.method}: {withheld_text(each).partition(';')[0]}"
        found.append(each)
    one, other = found
    if one.interval.low > other.interval.high or other.interval.low > one.interval.high:
        return None, f"subset simulation gives {one.value:.3g}, importance sampling {other.value:.3g}"
    low, high = min(each.interval.low for each in found), max(each.interval.high for each in found)
    return (one.value, low, high), ""


def _event(cells: StartCells, programs: DomainPrograms, effort: Effort) -> tuple[Evaluate, Score]:
    """Return an evaluator for which a scene in the cells is the failure, and its score."""

    def nearness(runs: Runs) -> Floats:
        return -_distance(programs, cells, runs.outcomes)

    def inside(runs: Runs, _values: Floats) -> Bools:
        places = programs.places(programs.values(runs.outcomes))
        return np.all([places[:, domain] == place for domain, place in cells], axis=0)

    def failed(runs: Assessment) -> Bools:
        return np.asarray(runs.found, dtype=bool)

    aim = Objective("cell", "minus the distance from the cell", nearness, inside, reads=NO_MEASURES)
    evaluate = make_evaluator(programs.measuring.program, effort.config, PAPER, (aim,), stored=NO_MEASURES)

    def of_event(genomes: Floats, keys: Ints) -> Assessment:
        runs = evaluate(genomes, keys)
        return replace(runs, collided=runs.found)

    return of_event, Score("cell", "the distance from the cell", "", lambda runs: runs.sought[:, 0], failed)
