"""The story of a run as a table of moments, and the course of speeds and distance as small curves."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.sparkline import sparkline
from cortex_dsl.report.speeds import KM_H, SpeedUnit
from cortex_dsl.report.story import Moment
from cortex_dsl.report.theme import actor_style
from engine.scenes import Trajectory
from engine.vocabulary import State

APART = "apart"
KIND_STYLES = {"contact": "bad", "impact": "bad", "closest": "warn", "left_road": "warn", "end": "title"}


def timeline(moments: Sequence[Moment], actors: Sequence[str]) -> RenderableType:
    """One line a moment: time, who, what."""
    rows = []
    for moment in moments:
        who = Text(actors[moment.actor], actor_style(moment.actor)) if moment.actor >= 0 else Text("")
        rows.append((Text(f"{moment.time:.2f} s", "quiet"), who, Text(moment.text, KIND_STYLES.get(moment.kind, ""))))
    return columns(right(), left(), left(wrap=True), rows=rows)


def curves(
    trajectory: Trajectory, actors: Sequence[str], end: float, pair: int, width: int, unit: SpeedUnit = KM_H
) -> RenderableType:
    """Speed of each actor, and how far the centres of the deciding pair are apart, up to the end of the scored run."""
    scored = trajectory.time <= end + 1e-9
    room = max(10, min(48, width - max(map(len, (*actors, APART))) - 26))
    rows = [
        _curve(
            Text(actor, actor_style(index)),
            _present(trajectory, index, unit.per_si * trajectory.states[:, index, State.SPEED])[scored],
            unit.name,
            actor_style(index),
            room,
        )
        for index, actor in enumerate(actors)
        if index < len(trajectory.outlines)
    ]
    if len(actors) > 1:
        apart = _present(trajectory, pair + 1, _centre_distance(trajectory, pair + 1))[scored]
        rows.append(_curve(Text(APART), apart, "m", "warn", room))
    axis = Text(f"{0:.1f} s" + f"{end:.1f} s".rjust(max(0, room - 5)), "quiet")
    return Group(columns(left(), left(), right(), rows=[*rows, (Text(""), axis, Text(""))]))


def _curve(
    name: Text, values: NDArray[np.float64], unit: str, style: str, width: int
) -> tuple[RenderableType, RenderableType, RenderableType]:
    finite = values[np.isfinite(values)]
    extent = f"{fixed(float(finite.min()), 1)} .. {fixed(float(finite.max()), 1)} {unit}" if len(finite) else ""
    stretched = np.interp(np.linspace(0, len(values) - 1, width), np.arange(len(values)), values)
    return name, Text(sparkline(stretched.tolist(), width, low=0.0), style), Text(extent, "quiet")


def _present(trajectory: Trajectory, actor: int, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """NaN where the actor has left the scene."""
    return np.where(trajectory.states[:, actor, State.PRESENT] > 0.5, values, np.nan)


def _centre_distance(trajectory: Trajectory, other: int) -> NDArray[np.float64]:
    between = trajectory.states[:, other, : State.HEADING] - trajectory.states[:, 0, : State.HEADING]
    return np.hypot(between[:, 0], between[:, 1])
