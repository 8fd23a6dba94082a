"""Interface to external controllers: the actors that a controller drives, and the numbers that it supplies for them.

Controllers are named on the command line or in Python, never by a file: a program only contains the name under which a
controller is queried.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from engine.frozen import frozen


@frozen
class Action:
    """One number that a controller supplies."""

    name: str
    unit: str
    """SI unit word."""
    low: float
    high: float


@frozen
class Control:
    """An actor that is driven externally."""

    controller: str
    """Name of the controller within the file, for one actor."""
    actor: int
    actions: tuple[Action, ...]
    every: float = 0.0
    """Time between two queries, during which an action is constant [s]; 0: each step."""
    delay: float = 0.0
    """Delay between an observation and its action [s]."""

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(action.name for action in self.actions)


WARNING = "warning"
"""Action by which a driver warns: above a half it does. A driver may leave it out, and never warns then."""
NO_WARNINGS = -1.0
"""Its value of a driver that leaves it out."""


def may_warn(control: Control) -> bool:
    """Return True if the warnings of the driver are read."""
    return control.actions[-1].name == WARNING


def turns(time: float, time_step: float) -> int:
    """Return a time as a number of steps; a time between two counts is rounded up."""
    return math.ceil(time / time_step - 1e-9)


def numbers_decided(controls: Iterable[Control]) -> int:
    """Return the number of values per turn."""
    return sum(len(each.actions) for each in controls)


def columns(controls: Sequence[Control]) -> tuple[slice, ...]:
    """Return the slice of each control among the values of all controls."""
    ends = [numbers_decided(controls[: number + 1]) for number in range(len(controls))]
    return tuple(slice(end - len(each.actions), end) for each, end in zip(controls, ends, strict=True))


def control_from(content: Mapping[str, Any]) -> Control:
    """Return the control of a dictionary made by `dataclasses.asdict`."""
    actions = tuple(Action(**action) for action in content["actions"])
    values: dict[str, Any] = {**content, "actions": actions}
    return Control(**values)
