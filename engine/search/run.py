"""A search: one call for a compiled scenario (`search`), and the campaign loop behind it (`run_campaign`).

The loop asks a searcher for proposals, evaluates them, passes the results back, and stores everything. It does not
depend on sampler or simulator: `evaluate` is an argument (`engine.search.evaluator` makes the real one). Scenes draw
from streams keyed by birth and rollout, so a result does not depend on other individuals or on the number of threads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import NamedTuple

import numpy as np

from engine.assessment import Evaluate, Rows, concatenate, map_arrays, take
from engine.config import Config, SearchConfig
from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.program import ParamSpace, Program
from engine.search.campaign import FINISHED, INTERRUPTED, STOPPED, Campaign, OnGeneration, Progress
from engine.search.evaluations import (
    Evaluations,
    GenerationFigures,
    distinct_collisions,
    figures,
    generation_figures,
    judge,
    parent_rows,
    quantile_level,
    results,
)
from engine.search.insight.gene_effects import gene_effects, probe_genes
from engine.search.insight.kinds import Blaming, blamed
from engine.search.past import checked
from engine.search.protocol import DEFAULT_OBJECTIVES, Box, ObjectiveSpec, Proposal, Searcher
from engine.search.ranking import Case, severity, worst_cases
from engine.search.searchers import build_searcher, canonical, find_searcher, seek
from engine.search.workers import Workers, open_workers, spread
from engine.streams import key_rows, method_number
from engine.tables import Floats, Ints


@dataclass(frozen=True)
class Task:
    """The space that a campaign searches, the evaluation of genomes, and the settings."""

    space: ParamSpace
    evaluate: Evaluate
    config: SearchConfig
    method: str
    preset: str = ""
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES
    blaming: Blaming | None = None
    """Assessment of a collision; it is called once for every collision, at the end."""
    probing: Evaluate | None = None
    """Evaluation of probes of genes, whose risk is shown and no objective; None: `evaluate`."""


@dataclass(frozen=True)
class Past:
    """The first generations of a campaign, from its journal."""

    generations: Sequence[Evaluations] = ()
    spent: float = 0.0
    """Duration of these generations [s]."""
    number: int | None = None
    """Number of the method in the stream keys; None: the number of its name."""
    whole: Evaluations | None = None
    """The generations as one table, if it is there."""


NO_PAST = Past()


class Done(NamedTuple):
    """A generation that is evaluated, and its rows."""

    figures: GenerationFigures
    first: int
    end: int


def run_campaign(
    task: Task,
    searcher: Searcher,
    on_generation: OnGeneration | None = None,
    past: Past = NO_PAST,
) -> Campaign:
    """Run all generations, or those until an interrupt.

    The searcher receives the stored results of `past` and continues there. `on_generation` is called for new
    generations.

    Ctrl-C ends the campaign with the finished generations. Ctrl-C before the end of the first generation is passed on,
    and so are exceptions of `on_generation`.

    Raises:
        ForeignPastError: the searcher's proposals differ from those of `past`.
    """
    config = task.config
    quantile_level(config.aggregate)
    number = method_number(task.method) if past.number is None else past.number
    start = perf_counter() - past.spent
    done: list[Done] = []
    rows = Rows(past.whole)
    best: Case | None = None
    least = (math.inf, math.inf)
    simulations = 0
    try:
        for generation in range(config.generations):
            proposals = searcher.ask()
            if generation < len(past.generations):
                evaluations = checked(proposals, past.generations[generation], generation)
            else:
                evaluations = _evaluate(proposals, rows, done, task, number)
            searcher.tell(results(evaluations))
            found, first = generation_figures(evaluations, generation), _rows_of(done)
            rows.put(evaluations, first)
            done.append(Done(found, first, first + len(evaluations)))
            for case in worst_cases(evaluations, 1):
                first, then = (float(key[case.row]) for key in severity(evaluations))
                if (first, then) < least:
                    best, least = replace(case, row=case.row + done[-1].first), (first, then)
            simulations += found.by_simulation.runs
            if on_generation is not None and generation >= len(past.generations):
                elapsed = perf_counter() - start
                said = (evaluations, found, best, simulations, elapsed, task.objective)
                on_generation(Progress(generation, config.generations, *said))
        status = FINISHED
    except KeyboardInterrupt:
        if not done:
            raise
        status = STOPPED
    campaign = summarize(task, rows.table(_rows_of(done)), [each.figures for each in done], status)
    return replace(campaign, elapsed=perf_counter() - start)


def _rows_of(done: Sequence[Done]) -> int:
    return done[-1].end if done else 0


def _evaluate(
    proposals: Sequence[Proposal], rows: Rows[Evaluations], done: Sequence[Done], task: Task, number: int
) -> Evaluations:
    """Return one generation: new individuals are simulated, reused ones are looked up at their birth."""
    generation, count = len(done), len(proposals)
    genomes = np.array([proposal.genome for proposal in proposals], dtype=np.float64).reshape(count, -1)
    births = np.array([proposal.birth for proposal in proposals], dtype=np.int32)
    reused = np.array([proposal.reused is not None for proposal in proposals])
    fresh = np.flatnonzero(~reused)
    tables: list[tuple[Ints, Assessment]] = []
    if len(fresh):
        tables.append(_simulate(genomes[fresh], births[fresh], generation, task, number))
    if reused.any():
        at = np.array([done[int(born)].first for born in births[reused, 0]]) + births[reused, 1]
        earlier = take(rows.table(_rows_of(done)), at)
        tables.append((earlier.keys, earlier.rollouts))
    order = np.argsort(np.concatenate([fresh, np.flatnonzero(reused)]))
    rollouts = take(concatenate([runs for _, runs in tables]), order)
    verdict, fitness = judge(rollouts, task.config.aggregate)
    return Evaluations(
        genomes=genomes,
        places=np.stack([np.full(count, generation), np.arange(count)], axis=1).astype(np.int32),
        births=births,
        operator=np.array([proposal.operator for proposal in proposals], dtype=np.int32),
        parents=parent_rows(proposals),
        reused=reused,
        verdict=verdict,
        fitness=fitness,
        keys=np.concatenate([keys for keys, _ in tables])[order],
        rollouts=rollouts,
    )


def _simulate(genomes: Floats, births: Ints, generation: int, task: Task, number: int) -> tuple[Ints, Assessment]:
    """Return keys (m, k, 6) and results (m, k, …) of m new genomes."""
    if (births[:, 0] != generation).any():
        raise ValueError(f"a proposal without a stored result must be born in generation {generation}")
    config = task.config
    keys = np.stack(
        [
            key_rows(config.seed, number, config.run, generation, births[:, 1], rollout)
            for rollout in range(config.rollouts)
        ],
        axis=1,
    )
    shape = keys.shape[:2]
    rows = task.evaluate(np.repeat(genomes, config.rollouts, axis=0), keys.reshape(-1, keys.shape[2]))
    return keys, map_arrays(rows, lambda array: array.reshape(*shape, *array.shape[1:]))


def summarize(task: Task, evaluations: Evaluations, generations: Sequence[GenerationFigures], status: str) -> Campaign:
    """Return the campaign of a search that ended with this status.

    Genes are probed if it is finished, and collisions are assessed unless it was interrupted. Ctrl-C makes it
    interrupted. The caller fills in the time.
    """
    box = Box.of(task.space)
    blame = probes = None
    try:
        if status != INTERRUPTED:
            blame = blamed(evaluations, task.blaming)
        if status == FINISHED and task.config.probes > 0:
            probes = probe_genes(box, evaluations, task.probing or task.evaluate, task.config.probes)
    except KeyboardInterrupt:
        status, blame, probes = INTERRUPTED, None, None
    blame = blamed(evaluations, None) if blame is None else blame
    return Campaign(
        method=task.method,
        preset=task.preset,
        space=task.space,
        config=task.config,
        evaluations=evaluations,
        generations=tuple(generations),
        by_individual=figures(evaluations, np.ones(len(evaluations), dtype=bool)),
        by_simulation=figures(evaluations, evaluations.simulated),
        distinct_collisions=distinct_collisions(evaluations),
        worst=worst_cases(evaluations, blame=blame),
        genes=gene_effects(box, evaluations, probes),
        elapsed=float("nan"),
        status=status,
        objective=task.objective,
        blame=blame,
    )


# -- one call for a whole search ---------------------------------------------------------------------------------------

DEFAULTS = Config()


def search(
    program: Program,
    method: str = "ga",
    config: Config = DEFAULTS,
    profile: str = "paper",
    on_generation: OnGeneration | None = None,
    past: Past = NO_PAST,
    workers: Workers | None = None,
    objective: Sequence[ObjectiveSpec] = DEFAULT_OBJECTIVES,
) -> Campaign:
    """Search a program's box by a method of `searchers.known_searchers`, under a risk profile; see `run_campaign`.

    `objective` names the objectives: rows of `engine.search.objectives`, objectives of the file, or functions of
    outcomes, which run only in threads of this process.

    Without `workers`, threads of this process run the simulations, as many as the config says. The choice does not
    affect results.

    Raises:
        ValueError: an unknown method, engine, profile or aggregate, or settings out of range.
        MissingExtraError, PluginError: the method cannot be used.
        WorkersLostError: no worker process is left to run simulations.
    """
    method = canonical(method)
    searcher = build_searcher(method, Box.of(program.space), config, past.number)
    from engine.risk import PROFILES
    from engine.search.evaluator import make_blaming, make_evaluator
    from engine.search.objectives import Objective, names_of, objectives
    from engine.verdicts import KnownVerdicts

    if profile not in PROFILES:
        raise ArgumentError(f"profile: `{profile}` is none of {', '.join(PROFILES)}", "name one of these")
    aims = objectives(program, objective)
    seek(searcher, method, len(aims))
    entry = find_searcher(method)
    workers = workers or Workers("threads", config.search.jobs)
    if config.driver is not None and workers.kind != "dask":
        workers = Workers("threads", workers.jobs)  # a controller is queried in this process only
    with open_workers(workers) as executor:
        if executor and config.driver is not None:
            raise ArgumentError("a controller drives in this process, and not on a cluster", "leave `--dask` out")
        if executor and not all(isinstance(each, str) for each in objective):
            raise ArgumentError("a function as objective runs in threads of this process", "leave `workers` out")
        if config.driver is not None:
            config = replace(config, driver=config.driver.without_history())

        known = KnownVerdicts()

        def evaluator(aims: Sequence[Objective], names: Sequence[str]) -> Evaluate:
            if executor:
                return spread(executor, workers, program, config, profile, names)
            return make_evaluator(program, config, PROFILES[profile], aims, known)

        names = names_of(objective)
        task = Task(
            program.space,
            evaluator(aims, names),
            config.search,
            method,
            entry.preset(config),
            names,
            make_blaming(program, config, known),
            None if names == DEFAULT_OBJECTIVES else evaluator((), DEFAULT_OBJECTIVES),
        )
        return run_campaign(task, searcher, on_generation, past)
