"""Search for scenes in which two sides differ: their robustness is as far apart as it can be.

The search is that of `failure_kinds`. Its first individuals are failures of A among the paired draws, or of the search
of A, then the draws with the largest difference. A find is a scene with a new, cured or moved failure. The searched
scenes are no sample, so nothing is estimated from them.
"""

from dataclasses import dataclass, replace

import numpy as np

from cortex_dsl.api.pairs import Collected, Pairing
from cortex_dsl.report.findings.comparison_report import Change, Searched
from engine.config import Config, SearchConfig
from engine.outcomes import Assessment
from engine.sampling import sample
from engine.search.methods.best_first import BestFirst
from engine.search.protocol import Box
from engine.search.run import Task, run_campaign
from engine.search.searchers import build_searcher
from engine.tables import Bools, Floats, Ints

METHOD = "failure_kinds"
POPULATION = 50
"""Scenes between two looks at the results."""
DIFFERENCE = ("difference",)


@dataclass(frozen=True)
class Start:
    """Beginning of a search."""

    genomes: Floats
    """(n, d) Genomes of the first individuals, the most important first."""
    scales: Floats
    """(conditions,) Unit of the difference of each condition: its standard deviation over A and B."""


def start_of(collected: Collected, failures: Floats | None = None) -> Start:
    """Return the beginning that follows from pairs; `failures` (n, d) are genomes in which A fails in addition."""
    space, names = collected.pairing.a.program.space, collected.pairing.names
    values = np.concatenate([np.zeros((0, 2, len(names))), *collected.values])
    genomes = np.concatenate([np.zeros((0, len(space))), *collected.genomes])
    failed: Bools = np.concatenate([np.zeros(0, dtype=bool), *collected.failed_a])
    scales = np.array([_spread(values[:, :, column]) for column in range(len(names))])
    order = np.lexsort((-difference(values[:, 0], values[:, 1], scales), ~failed))
    first = genomes[order]
    return Start(first if failures is None else np.concatenate([failures, first]), scales)


def _spread(values: Floats) -> float:
    """Return the standard deviation of the values that exist; 1 if they are all equal."""
    known = values[np.isfinite(values)]
    return (float(known.std()) if len(known) else 0.0) or 1.0


def difference(a: Floats, b: Floats, scales: Floats) -> Floats:
    """Return (n,) the largest difference of the values (n, conditions) of two sides, in units of `scales`."""
    apart = np.abs(a - b) / scales
    return np.where(np.isfinite(apart), apart, 0.0).max(axis=1, initial=0.0)


def search_differences(pairing: Pairing, start: Start, scenes: int, seed: int) -> Searched:
    """Search for differences in at most this number of scenes; Ctrl-C ends the search with what it has found."""
    program, found = pairing.a.program, Collected(pairing)
    generations = -(-scenes // POPULATION)
    config = SearchConfig(generations=generations, population=scenes // generations, seed=seed, probes=0)

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        numbers = np.arange(found.pairs + 1, found.pairs + len(keys) + 1)
        drawn = sample(program, genomes, keys, pairing.a.scenario.config.simulation, pairing.jobs)
        block = pairing.run(numbers, None, drawn)
        new = found.take(block)
        apart = difference(block.a.values, block.b.values, start.scales)
        verdict = np.where(block.a.valid, block.b.runs.verdict, block.a.runs.verdict).astype(np.int32)
        sought = np.where(block.valid, apart, np.nan)[:, np.newaxis]
        return replace(block.b.runs, verdict=verdict, sought=sought, found=new)

    searcher = build_searcher(METHOD, Box.of(program.space), Config(search=config))
    assert isinstance(searcher, BestFirst)
    searcher.begin_with(start.genomes)
    task = Task(program.space, evaluate, config, METHOD, objective=DIFFERENCE)
    try:
        stopped = run_campaign(task, searcher).stopped
    except KeyboardInterrupt:
        stopped = True
    changes = tuple(each for each in found.changes if each.change is not Change.KEPT)
    return Searched(found.pairs, found.valid, METHOD, changes, stopped)
