"""The complete analysis of a search's failures: kinds, regions, effects of genes, and avoidability."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from engine.avoidability import STRUCK, Avoidability, Avoidance, avoidability, refuse_missing
from engine.config import Config
from engine.driving.blocks import can_be_driven, redriven
from engine.program import ParamSpace, Program, VariantLabel, choice_names, drawn_lanes
from engine.references import answer_counts, references
from engine.risk import PROFILES
from engine.road import build_network
from engine.sampling import sample
from engine.scenes import Scenes
from engine.search.evaluations import NO_PARTNERS, Evaluations, Partners, partners
from engine.search.evaluator import make_blaming, make_evaluator
from engine.search.insight.clusters import Cluster, clusters
from engine.search.insight.diversity import Grid, Spread, counted, grids, spread, worst_valid
from engine.search.insight.gene_effects import GeneEffect, gene_effects, probe_genes
from engine.search.insight.kinds import Failures, FoundKind, blamed, failures, kinds
from engine.search.insight.sensitivity import Sensitivity, sensitivity
from engine.search.protocol import Box
from engine.search.ranking import Case, worst_cases
from engine.search.statistics import spread_evenly
from engine.tables import Bools, Floats, Ints
from engine.verdicts import JudgedCollision, answers_and_margins, judge
from engine.vocabulary import Answer, Blame, GeneKind, Side

MOST_REPLAYS = 500
"""Collisions that the reference driver drives again with every start of braking; of more, as many spread evenly."""
BUDGET = 20_000
"""Simulations of the sensitivity design."""
MOST_LANES = 20
"""Number of sampled lanes with a row of their own, those with the most collisions; all remaining lanes share one row.
"""


@dataclass(frozen=True)
class SystemShare:
    """Avoidable collisions by the value that the search chose for one param of the system under test."""

    name: str
    thirds: tuple[int, int, int]
    """Numbers of collisions in the lower, the middle and the upper third of the param's range."""


@dataclass(frozen=True)
class Avoided:
    """Counts of a search's collisions by the answers of reference drivers."""

    driven: int
    """Collisions that were driven again with every start of braking: all, or as many spread evenly."""
    by: dict[Avoidance, int]
    """Number of these collisions for each answer of the careful driver."""
    by_system: tuple["SystemShare", ...] = ()
    """Avoidable collisions within the ranges of the system's own params, as far as the search chose these."""
    by_driver: dict[str, dict[Answer, int]] = field(default_factory=dict)
    """Number of these collisions for each answer of each reference driver."""

    @property
    def avoidable(self) -> int:
        return self.by.get(Avoidance.AVOIDABLE, 0)

    @property
    def lost(self) -> int:
        """Return the number of collisions that no braking avoids, because the scene begins too late."""
        return self.by.get(Avoidance.LOST, 0)

    @property
    def struck(self) -> int:
        """Return the number of collisions in which the ego was struck from behind or while it stood."""
        return sum(self.by.get(kind, 0) for kind in STRUCK)


@dataclass(frozen=True)
class Analysis:
    """Analysis of one search. Row numbers are those of its evaluations."""

    simulations: int
    valid: int
    failures: int
    """Simulated individuals that collided."""
    came: Failures
    """Counts by distinct simulation, with the verdicts of the reference driver."""
    kinds: tuple[FoundKind, ...]
    """Kinds of collisions; those that a competent driver would have avoided come first."""
    fastest: float
    """Largest closing speed of a contact [m/s]; NaN without a contact."""
    spread: Spread
    grids: tuple[Grid, ...]
    clusters: tuple[Cluster, ...]
    grouped: int
    """Failures that the clusters group: all, or as many spread evenly."""
    genes: tuple[GeneEffect, ...]
    """Effect of each gene in the search, and its effect if it alone is changed."""
    sensitivity: Sensitivity | None
    """Sensitivity indices of the scenario, from a design of their own; None if omitted or without genes."""
    worst: tuple[Case, ...]
    avoidability: tuple[Avoidability | None, ...]
    """Avoidability of each worst case by the careful driver; None for a case without a collision."""
    judged: tuple[JudgedCollision | None, ...]
    """Answers of all reference drivers for each worst case, and its counterfactuals; None without a collision."""
    avoided: Avoided
    system: tuple[str, ...]
    """Genes that the search chose and that belong to the system under test."""
    partners: Partners = NO_PARTNERS
    """Actors with which the ego collided."""


def analyse(
    program: Program,
    evaluations: Evaluations,
    config: Config,
    profile: str = "paper",
    budget: int = BUDGET,
    count: int = 10,
    blame: Ints | None = None,
) -> Analysis:
    """Return the complete analysis; results of new runs are omitted if the driver only replays recorded decisions.

    `budget`: simulations for the sensitivity design (0: none). `count`: number of worst cases. `blame` (n, k): verdict
    of the reference driver on each rollout, if it is known already.
    """
    box = Box.of(program.space)
    can_drive_new_scenes = config.driver is None or config.driver.can_drive_new_scenes
    config = replace(config, search=replace(config.search, engine="batch"))
    evaluate = make_evaluator(program, config, PROFILES[profile])
    blame = blamed(evaluations, make_blaming(program, config)) if blame is None else blame
    worst = worst_cases(evaluations, count, blame)
    simulated, seed = evaluations.simulated, config.search.seed
    return Analysis(
        simulations=int(simulated.sum()) * evaluations.keys.shape[1],
        valid=int((simulated & evaluations.valid).sum()),
        failures=int((simulated & evaluations.collided).sum()),
        came=failures(evaluations, blame),
        kinds=kinds(evaluations, blame),
        fastest=fastest_contact(evaluations),
        spread=spread(evaluations, box),
        grids=(*grids(evaluations, variant_labels(program)), *lane_grids(program, evaluations, config)),
        clusters=(groups := clusters(evaluations, program.space, evaluate, seed) if can_drive_new_scenes else ()),
        grouped=sum(len(each.rows) for each in groups),
        genes=gene_effects(
            box,
            evaluations,
            probe_genes(box, evaluations, evaluate, config.search.probes or 32) if can_drive_new_scenes else None,
        ),
        sensitivity=sensitivity(program.space, evaluate, budget, seed)
        if budget and len(box) and can_drive_new_scenes
        else None,
        worst=worst,
        avoidability=driven_again(program, evaluations, [case.row for case in worst], config),
        judged=judged_again(program, evaluations, [case.row for case in worst], config),
        avoided=avoided(program, evaluations, blame, config),
        system=tuple(name for name in program.space.system if name in program.space.names),
        partners=partners(evaluations, len(program.actors)),
    )


def driven_again(
    program: Program, evaluations: Evaluations, rows: Sequence[int], config: Config
) -> tuple[Avoidability | None, ...]:
    """Return the careful driver's answer for the worst rollout of each row.

    None for a run without a collision, and for a run whose recorded decisions are missing.
    """
    hit, scenes = _collided_again(program, evaluations, rows, config)
    answers = avoidability(program, scenes, config.simulation, contact=config.contact)
    if config.driver is None:
        refuse_missing(np.ones(len(hit), dtype=bool), np.array([answer is not None for answer in answers], dtype=bool))
    known = dict(zip(hit.tolist(), answers, strict=True))
    return tuple(known.get(row) for row in rows)


def judged_again(
    program: Program, evaluations: Evaluations, rows: Sequence[int], config: Config
) -> tuple[JudgedCollision | None, ...]:
    """Return the answers of the reference drivers of the config to the worst rollout of each row; None as in
    `driven_again`.
    """
    hit, scenes = _collided_again(program, evaluations, rows, config)
    search = config.search
    found = judge(program, scenes, config.simulation, config.contact, search.jobs, search.references)
    known = dict(zip(hit.tolist(), found, strict=True))
    return tuple(known.get(row) for row in rows)


def _collided_again(
    program: Program, evaluations: Evaluations, rows: Sequence[int], config: Config
) -> tuple[Ints, Scenes]:
    """Return the rows whose worst rollout collided and can be driven again, and their scenes."""
    chosen, driver = np.array(rows, dtype=np.int64), config.driver
    hit = chosen[evaluations.rollouts.collided[chosen, evaluations.worst_rollout[chosen]]]
    keys = evaluations.keys[hit, evaluations.worst_rollout[hit]]
    there = can_be_driven(driver, keys, evaluations.genomes[hit])
    hit, keys = hit[there], keys[there]
    return hit, redriven(program, sample(program, evaluations.genomes[hit], keys, config.simulation), config)


def avoided(program: Program, evaluations: Evaluations, blame: Ints, config: Config) -> Avoided:
    """Return the reference drivers' answers for a search's collisions, as counts."""
    found = np.flatnonzero(evaluations.simulated & evaluations.collided)
    rows = found[spread_evenly(len(found), MOST_REPLAYS)].tolist()
    answers = driven_again(program, evaluations, rows, config)
    known = [answer for answer in answers if answer is not None]
    by = Counter(answer.avoidance for answer in known)
    avoidable = (blame == Blame.AVOIDABLE).any(axis=1)
    shares = _system_shares(program.space, evaluations.genomes[avoidable])
    return Avoided(len(known), dict(sorted(by.items())), shares, _by_driver(program, evaluations, rows, config))


def _by_driver(
    program: Program, evaluations: Evaluations, rows: Sequence[int], config: Config
) -> dict[str, dict[Answer, int]]:
    """Return the number of collisions for each answer of each reference driver."""
    _, scenes = _collided_again(program, evaluations, rows, config)
    search = config.search
    answers, _ = answers_and_margins(
        program, scenes, config.simulation, config.contact, search.jobs, search.references, measured=False
    )
    return answer_counts([each.name for each in references(search.references)], answers)


def _system_shares(space: ParamSpace, genomes: Floats) -> tuple[SystemShare, ...]:
    """Return one row for each param of the system that has a range."""
    shares: list[SystemShare] = []
    for gene, name in enumerate(space.names):
        if name in space.system and space.kinds[gene] != GeneKind.INDEX:
            width = float(space.high[gene] - space.low[gene]) or 1.0
            third = np.clip(np.floor(3.0 * (genomes[:, gene] - space.low[gene]) / width), 0, 2)
            low, middle, high = (int((third == k).sum()) for k in range(3))
            shares.append(SystemShare(name, (low, middle, high)))
    return tuple(shares)


def fastest_contact(evaluations: Evaluations) -> float:
    """Return the largest closing speed of a simulated contact [m/s]; NaN without a contact."""
    runs = evaluations.rollouts
    speeds = runs.closing_speed[evaluations.simulated][runs.collided[evaluations.simulated]]
    return float(np.nanmax(speeds)) if np.isfinite(speeds).any() else math.nan


def variant_labels(program: Program) -> list[str]:
    """Return a label for each combination of the file's finite choices."""
    return [", ".join(choice.option for choice in variant.choices) or "the only one" for variant in program.variants]


# -- lanes that scenes drew, where the file leaves a lane to chance without a variant for each -------------------------


def lane_grids(program: Program, evaluations: Evaluations, config: Config) -> tuple[Grid, ...]:
    """Return, for each choice of a sampled lane, the valid simulations by lane and by the nearest side of the ego.

    Journals do not store draws. The scenes are sampled again from their keys, which costs a small part of a simulation.
    """
    names = tuple(dict.fromkeys(name for label in program.variants for name in _drawn_by(label)))
    if not names:
        return ()
    runs, chosen = evaluations.rollouts, worst_valid(evaluations)
    met = runs.side[chosen] >= 0
    rows, rollouts = (each[met] for each in chosen)
    scenes = sample(program, evaluations.genomes[rows], evaluations.keys[rows, rollouts], config.simulation)
    lanes = [lane.name for lane in build_network(program.road_spec).lanes]
    at = rows, rollouts
    found: list[Grid] = []
    for name in names:
        number = _lane_of(program, name, scenes.variant, scenes.values)
        labels, row = _rows(lanes, number, runs.collided[at])
        sides = tuple(side.name.lower() for side in Side)
        found.append(
            counted(f"{name} x side", labels, sides, row, runs.side[at], runs.continuous[at], runs.collided[at])
        )
    return tuple(found)


def _drawn_by(label: VariantLabel) -> dict[str, int]:
    """Return the number of the scene value with each drawn lane, by the name of the choice."""
    lanes = drawn_lanes(label)
    return dict(zip(choice_names(label)[len(label.choices) :], (site.values[0] for site in lanes), strict=True))


def _lane_of(program: Program, name: str, variants: Ints, values: Floats) -> Ints:
    """Return (n,) the lane of each scene; -1 if it drew none."""
    places = np.array([_drawn_by(label).get(name, -1) for label in program.variants])[variants]
    numbers = values[np.arange(len(values)), np.maximum(places, 0)]
    return np.where((places >= 0) & np.isfinite(numbers), np.nan_to_num(numbers), -1.0).astype(np.int64)


def _rows(lanes: list[str], number: Ints, collided: Bools) -> tuple[tuple[str, ...], Ints]:
    """Return the names of rows, and the row of each scene (n,)."""
    seen, row = np.unique(number, return_inverse=True)
    failures = np.bincount(row, weights=collided, minlength=len(seen))
    lanes_shown = np.sort(np.argsort(-failures, kind="stable")[:MOST_LANES])
    place = np.full(len(seen), len(lanes_shown))
    place[lanes_shown] = np.arange(len(lanes_shown))
    chosen: list[int] = seen[lanes_shown].tolist()
    names = [lanes[lane] if lane >= 0 else "none" for lane in chosen]
    others = len(seen) - len(lanes_shown)
    return (*names, *([f"{others} others"] if others else [])), place[row]
