"""Scenes, outcomes and runs as named columns of a table, for pandas and for readers.

A name ends in its unit, if it has one: `ego.speed [m/s]`. Values are those of the arrays: SI units, for params the unit
of the file, options by their value; missing values of an invalid scene are NaN.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from engine.display import ROWS, columns_table
from engine.outcomes import PAIRS
from engine.program import Program
from engine.vocabulary import Column, EndReason, State, Verdict

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.outcomes import Outcomes
    from engine.scenes import Scenes
    from engine.world import WorldRun

    Named = Iterator[tuple[str, NDArray]]


START_UNITS: Mapping[Column, str] = {
    Column.X: "m",
    Column.Y: "m",
    Column.HEADING: "rad",
    Column.SPEED: "m/s",
    Column.LENGTH: "m",
    Column.WIDTH: "m",
    Column.WHEELBASE: "m",
    Column.REAR_TO_CENTER: "m",
    Column.MASS: "kg",
    Column.MAX_STEER: "rad",
    Column.MAX_ACCELERATION: "m/s^2",
    Column.MAX_BRAKING: "m/s^2",
    Column.FRICTION: "",
    Column.VIEW_ANGLE: "rad",
    Column.VIEW_DISTANCE: "m",
    Column.OCCLUDING: "",
    Column.FIXED: "",
    Column.TOP_SPEED: "m/s",
    Column.STEER_RATE: "rad/s",
    Column.PEDAL_TIME: "s",
    Column.DRAG: "m/s^2",
}
START_NAMES: Mapping[Column, str] = {Column.FRICTION: "grip"}
"""Names other than the column's: grip, the effect of tyres and weather, is not `ego.friction` of the tyres alone."""
STATE_UNITS: Mapping[State, str] = {
    State.X: "m",
    State.Y: "m",
    State.HEADING: "rad",
    State.SPEED: "m/s",
    State.STEER: "rad",
    State.ACCELERATION: "m/s^2",
    State.THROTTLE: "",
    State.BRAKE: "",
    State.PRESENT: "",
}


class Columns(dict[str, "NDArray"]):
    """Arrays (n,) by name, as `pandas.DataFrame` takes them; a notebook shows the first rows side by side."""

    def _repr_html_(self) -> str:
        return columns_table({name: column[:ROWS].tolist() for name, column in self.items()}, self.length)

    @property
    def length(self) -> int:
        """Rows of every column."""
        return max(map(len, self.values()), default=0)


def of_scenes(program: Program, scenes: "Scenes") -> Columns:
    """Return columns (n,): the verdict, the params, and the state of each actor at the start."""
    return Columns(_scenes(program, scenes))


def _scenes(program: Program, scenes: "Scenes") -> "Named":
    yield "verdict", _words(Verdict, scenes.verdict)
    for gene, (name, unit) in enumerate(zip(program.space.names, program.space.units, strict=True)):
        yield _named(name, unit), _values(program.space.options[gene], scenes.genomes[:, gene])
    for actor, who in enumerate(program.actors):
        for column, unit in START_UNITS.items():
            name = START_NAMES.get(column, column.name.lower())
            yield _named(f"{who}.{name}", unit), scenes.values[:, actor * len(Column) + column]


def _values(options: "Sequence[str]", genes: "NDArray") -> "NDArray":
    """Return the values of a param; for a choice, its options, as numbers if all options are numbers."""
    if not options:
        return genes
    chosen = np.array(options)[genes.astype(int)]
    with suppress(ValueError):
        return chosen.astype(float)
    return chosen


def of_outcomes(program: Program, outcomes: "Outcomes") -> Columns:
    """Return columns (n,): how each run ended, and the metrics of each pair of the ego and another actor."""
    return Columns(_outcomes(program, outcomes))


def _outcomes(program: Program, outcomes: "Outcomes") -> "Named":
    yield "verdict", _words(Verdict, outcomes.verdict)
    yield "collided", outcomes.collided
    yield "end", _words(EndReason, outcomes.end_reason)
    yield "end_time [s]", outcomes.end_time
    for pair, other in enumerate(program.actors[1:]):
        for row in (each for each in PAIRS if each.kind is float):
            yield _named(f"{other}.{row.name}", row.unit), getattr(outcomes, row.name)[:, pair]


def of_run(program: Program, run: "WorldRun") -> Columns:
    """Return columns (samples,): the time, and the state of each actor."""
    return Columns(_run(program, run))


def _run(program: Program, run: "WorldRun") -> "Named":
    yield "time [s]", run.trajectory.time
    for actor, who in enumerate(program.actors):
        for state, unit in STATE_UNITS.items():
            yield _named(f"{who}.{state.name.lower()}", unit), run.trajectory.states[:, actor, state]


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _words(names: type[Verdict] | type[EndReason], codes: "NDArray") -> "NDArray":
    """Return codes as words; -1 (no code) is the empty word."""
    return np.array([names(code).name.lower() if code >= 0 else "" for code in codes.tolist()])
