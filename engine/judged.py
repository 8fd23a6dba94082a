"""Objectives of a program: expectations and values to maximize or minimize, computed from each finished run.

They may name results of the run (`NAMED_RESULTS`): with several actors those of the actor nearest to the ego.
`engine.kernels.judging` computes them; a new result is a row here and a case there.
"""

from collections.abc import Mapping
from dataclasses import asdict, field
from typing import Any

import numpy as np

from engine.frozen import frozen
from engine.tables import ObjectiveTables
from engine.vocabulary import Measure, Reducer, Sense

# -- results that an objective may name --------------------------------------------------------------------------------


@frozen
class NamedResult:
    """One result."""

    name: str
    unit: str
    """SI unit word, "" for pure numbers."""
    sentence: str
    of_pair: bool = True
    """True if it requires a second actor."""
    measure: int = 0
    """The `Measure` from which it comes; 0 if it is always computed."""


NAMED_RESULTS: tuple[NamedResult, ...] = (
    NamedResult("min_distance", "m", "Least distance of the outlines; 0 on contact."),
    NamedResult("max_closing_speed", "m/s", "Fastest closing speed of the centres."),
    NamedResult("distance_at_ms", "m", "Distance at the instant of the largest closing speed."),
    NamedResult("ttc_at_ms", "s", "That distance divided by that closing speed."),
    NamedResult("closing_speed", "m/s", "Closing speed of the centres at the closest approach, or at contact."),
    NamedResult("ego_speed", "m/s", "Speed of the ego at the closest approach, or at contact."),
    NamedResult("other_speed", "m/s", "Speed of the other at the closest approach, or at contact."),
    NamedResult(
        "hidden_time", "s", "How long the other was hidden inside the ego's field of view.", measure=Measure.SIGHT
    ),
    NamedResult(
        "delta_v", "m/s", "Change of the ego's velocity in a collision with the velocities at the closest approach."
    ),
    NamedResult("post_encroachment_time", "s", "Least time between both being at the same place; 0 on contact."),
    NamedResult("end_time", "s", "When the run ends.", of_pair=False),
)
"""A program stores the name of a result, never its place in this table."""


@frozen
class Objective:
    """An expectation of the file (its robustness, a pure number), or a value to maximize or minimize."""

    name: str
    sense: Sense
    unit: str
    """SI unit word."""
    line: int


@frozen
class Reading:
    """A number of a finished run: from a rule of kind WATCH, or a result by name."""

    kind: Reducer
    rule: int = -1
    result: str = ""
    """A row of `engine.judged`."""


NO_TABLES = ObjectiveTables(np.zeros(0, np.int32), np.zeros((0, 0, 3), np.int32))


@frozen
class Judged:
    """The objectives of a file."""

    objectives: tuple[Objective, ...] = ()
    readings: tuple[Reading, ...] = ()
    tables: ObjectiveTables = field(default=NO_TABLES, compare=False)

    def __len__(self) -> int:
        return len(self.objectives)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(objective.name for objective in self.objectives)

    def content(self) -> dict[str, Any]:
        """Return all fields except the tables, as JSON can represent them."""
        return {name: [asdict(each) for each in getattr(self, name)] for name in ("objectives", "readings")}

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the tables by name."""
        return {f"judged.{name}": array for name, array in self.tables._asdict().items()}

    def deciding(self) -> tuple[object, ...]:
        """Return all data that determine a result, without the tables."""
        return tuple(each.sense for each in self.objectives), tuple(asdict(each) for each in self.readings)


NOTHING_JUDGED = Judged()
"""Objectives of a file without any."""


def judged_from(content: Mapping[str, Any] | None, arrays: Mapping[str, np.ndarray]) -> Judged:
    """Return the objectives from `content` and `arrays`; None: written by a version without objectives."""
    if content is None:
        return NOTHING_JUDGED
    said: list[dict[str, Any]] = content["objectives"]
    objectives = tuple(Objective(each["name"], Sense(each["sense"]), each["unit"], each["line"]) for each in said)
    read: list[dict[str, Any]] = content["readings"]
    readings = tuple(Reading(Reducer(each["kind"]), each["rule"], each["result"]) for each in read)
    return Judged(objectives, readings, ObjectiveTables(*(arrays[f"judged.{n}"] for n in ObjectiveTables._fields)))
