"""Metrics of one run by name, with units, for reports and exports; and the records of a file.

MD, MS, D_MS and TTC_MS determine the risk and come with the outcomes; those of the table are reported in addition.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from engine.metrics.bodies import Body, usual_body
from engine.metrics.encounters import Encounter, on_levels, span_of, time_step
from engine.metrics.table import OF_ACTORS, OF_PAIRS
from engine.outcomes import PAIRS, Outcomes
from engine.program import Program, Record
from engine.scenes import Trajectory
from engine.tables import A_BUILDING, Floats
from engine.vocabulary import ActorKind

if TYPE_CHECKING:
    from engine.scenes import Impact


@dataclass(frozen=True)
class Metric:
    """One number of a run."""

    name: str
    actors: tuple[int, ...]
    """Actors of the metric: a pair (ego, other), or one actor."""
    value: float
    """Infinite if the measured danger does not exist; NaN if it is not defined."""
    unit: str
    meaning: str


def measure_trajectory(
    trajectory: Trajectory, outcomes: Outcomes, bodies: Sequence[Body] = (), row: int = 0, commands: bool = True
) -> tuple[Metric, ...]:
    """Return all metrics of one run: those of each pair (ego, other) that meets, then those of each actor.

    `bodies`: the actors; without them they are cars of the size of their outlines, with centres that move along the
    heading. `commands`: True if wheel and pedals are known.
    """
    known = tuple(bodies) or tuple(usual_body(ActorKind.CAR, *size) for size in trajectory.outlines.tolist())
    actors = range(len(known))
    seen = on_levels(trajectory, outcomes, row)
    pairs = [Encounter(seen, outcomes, row, known, other) for other in actors[1:]]
    return (
        *(metric for pair in pairs if pair.span[1] > 0 for metric in _of_pair(pair)),
        *(m for actor in actors for m in (*_of_grip(outcomes, row, actor), *_of_actor(trajectory, actor, commands))),
    )


def _of_pair(pair: Encounter) -> Iterator[Metric]:
    who = (0, pair.number)
    for row in PAIRS:
        if row.symbol:
            yield Metric(row.symbol, who, pair.outcome(row.name), row.unit, row.meaning)
    for each in OF_PAIRS:
        value = each.value(pair)
        if value is not None:
            yield Metric(each.symbol, who, float(value), each.unit, each.meaning)


def _of_grip(outcomes: Outcomes, row: int, actor: int) -> Iterator[Metric]:
    """Yield the use of grip of an actor with tyres, if the friction is known."""
    lateral, combined = float(outcomes.lateral_grip[row, actor]), float(outcomes.combined_grip[row, actor])
    if not math.isnan(combined):
        yield Metric("lateral grip", (actor,), lateral, "", "largest use of grip sideways, as a share of mu g")
        yield Metric("combined grip", (actor,), combined, "", "the same, of acceleration and turning together")


def _of_actor(trajectory: Trajectory, actor: int, commands: bool) -> Iterator[Metric]:
    first, present = span_of(trajectory, actor)
    states, step = trajectory.states[first : first + present, actor], time_step(trajectory)
    for each in OF_ACTORS:
        if commands or not each.of_commands:
            value = each.value(states, step)
            yield Metric(each.symbol, (actor,), math.nan if value is None else value, each.unit, each.meaning)


def measure_impacts(impacts: "Sequence[Impact]") -> tuple[Metric, ...]:
    """Return the largest delta-V of each struck actor: the change of its velocity by the impulses of one impact."""
    struck = sorted({actor for impact in impacts for actor in impact.actors if actor != A_BUILDING})
    return tuple(
        Metric("delta-V", (actor,), max(_delta_v(impact, actor) for impact in impacts), "m/s", "of the hardest impact")
        for actor in struck
    )


def _delta_v(impact: "Impact", actor: int) -> float:
    return impact.delta_v[impact.actors.index(actor)] if actor in impact.actors else 0.0


# -- records of a file: values of each `record` over time, at the start or at the end ----------------------------------


@dataclass(frozen=True)
class Recorded:
    """Values of one `record` in one run. SI units."""

    name: str
    when: str
    """`series`, or `initial` or `final` with one value."""
    unit: str
    """SI unit word, "" for pure numbers and truths."""
    line: int
    time: Floats
    """(n,) [s]"""
    values: Floats
    """(n,) truths as 1 and 0."""


def recorded(program: Program, trajectory: Trajectory) -> tuple[Recorded, ...]:
    """Return all records of a program, in the order of the file, from the first sample to the end of the scored run.

    A record of a scenario that another one starts has only the samples during which that scenario runs.
    """
    return tuple(_recorded(record, trajectory) for record in program.records)


def _recorded(record: Record, trajectory: Trajectory) -> Recorded:
    counts = np.arange(len(trajectory.watched))
    if record.during >= 0:
        counts = np.flatnonzero(trajectory.watched[:, record.during])
    part = {"series": counts, "initial": counts[:1], "final": counts[-1:]}[record.when]
    values = trajectory.watched[part, record.rule]
    return Recorded(record.name, record.when, record.unit, record.line, trajectory.time[part], values)
