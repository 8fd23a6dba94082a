"""What a study remembers of each run: its figures, their course over the generations, and all its evaluations."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from engine.search.campaign import Campaign
from engine.search.diversity import distinct_failures, grids
from engine.search.evaluations import Evaluations
from engine.search.figures import Figures, GenerationFigures
from engine.search.protocol import Box
from engine.study.block import pack
from engine.study.plan import Address
from engine.tables import Floats

LAST = 10
"""Generations at the end that are told apart, as in the paper."""
FIELDS = tuple(field.name for field in fields(Figures))
"""Rows of a course."""
OWN = ("distinct_collisions", "distinct_failures", "failing_cells", "first_collision")
"""Numbers of a run that are no `Figures`."""


@dataclass(frozen=True)
class RunFigures:
    """One run in numbers; a pure function of plan and address."""

    individuals: Figures
    """Over the whole run, elites counted in each generation that kept them, as the paper does."""
    simulations: Figures
    """The same, each distinct simulation once."""
    last_individuals: Figures
    """Of the last ten generations."""
    last_simulations: Figures
    distinct_collisions: int
    """Different genomes that collided: the primary outcome of a study."""
    distinct_failures: int
    """Collisions that differ enough from all counted before (see `engine.search.diversity`)."""
    failing_cells: int
    """Cells with a collision, over all descriptor grids."""
    first_collision: float
    """Distinct simulations up to and with the first that collided; NaN where none did."""


@dataclass(frozen=True)
class RunRecord:
    """One finished run."""

    address: Address
    figures: RunFigures
    course: Floats
    """(2, fields, generations): `FIELDS` of each generation, by individual and by simulation."""
    seconds: float
    """What it took; the one thing here that no second run repeats."""


@dataclass(frozen=True)
class Finished:
    """A run that has just ended, on its way into the store."""

    record: RunRecord
    block: bytes
    """All its evaluations, see `engine.study.block`."""


def finished(address: Address, campaign: Campaign) -> Finished:
    """What is kept of a campaign that ran to its end."""
    record = RunRecord(address, run_figures(campaign), course(campaign.generations), campaign.elapsed)
    return Finished(record, pack(campaign.evaluations))


def run_figures(campaign: Campaign) -> RunFigures:
    evaluations = campaign.evaluations
    return RunFigures(
        individuals=campaign.by_individual,
        simulations=campaign.by_simulation,
        last_individuals=campaign.last(LAST),
        last_simulations=campaign.last(LAST, by_simulation=True),
        distinct_collisions=campaign.distinct_collisions,
        distinct_failures=len(distinct_failures(evaluations, Box.of(campaign.space))),
        failing_cells=sum(grid.failing for grid in grids(evaluations)),
        first_collision=first_collision(evaluations),
    )


def first_collision(evaluations: Evaluations) -> float:
    """How many distinct simulations it took to collide; NaN where it never did."""
    hits = np.flatnonzero(evaluations.rollouts.collided[evaluations.simulated].ravel())
    return float(hits[0] + 1) if len(hits) else float("nan")


def course(generations: Sequence[GenerationFigures]) -> Floats:
    """(2, fields, generations)"""
    pairs = [(figures.by_individual, figures.by_simulation) for figures in generations]
    rows = [[[getattr(figures, name) for name in FIELDS] for figures in pair] for pair in pairs]
    return np.array(rows, dtype=np.float64).reshape(len(rows), 2, len(FIELDS)).transpose(1, 2, 0).copy()


def flat(figures: RunFigures) -> dict[str, float]:
    """Every number by a name of its own, such as `nc`, `simulated_nc`, `last_nc` and `last_simulated_nc`."""
    groups = {"": "individuals", "simulated_": "simulations", "last_": "last_individuals"}
    groups["last_simulated_"] = "last_simulations"
    row: dict[str, float] = {name: getattr(figures, name) for name in OWN}
    for prefix, group in groups.items():
        row |= {f"{prefix}{name}": getattr(getattr(figures, group), name) for name in FIELDS}
    return row


def unflat(row: dict[str, Any]) -> RunFigures:
    """Inverse of `flat`; None is NaN."""
    numbers: dict[str, Any] = {name: float("nan") if value is None else value for name, value in row.items()}

    def group(prefix: str) -> Figures:
        return Figures(**{name: numbers[f"{prefix}{name}"] for name in FIELDS})

    return RunFigures(
        individuals=group(""),
        simulations=group("simulated_"),
        last_individuals=group("last_"),
        last_simulations=group("last_simulated_"),
        **{name: numbers[name] for name in OWN},
    )
