"""What is decided outside of a program: the actors that a controller drives, and the numbers that it gives for them.

Controllers are named on the command line or in Python, never by a file: a program knows the name under which one is
asked for, and nothing about who answers.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from engine.frozen import frozen


@frozen
class Action:
    """One number that a controller gives."""

    name: str
    unit: str
    """SI unit word."""
    low: float
    high: float


@frozen
class Control:
    """An actor that is driven from outside."""

    controller: str
    """Who is asked; a name of the file's own, of one actor."""
    actor: int
    actions: tuple[Action, ...]
    every: float = 0.0
    """From one question to the next, at which an action is held [s]; 0: each step."""
    delay: float = 0.0
    """From what is observed to the action that it leads to [s]."""

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(action.name for action in self.actions)


def turns(time: float, time_step: float) -> int:
    """How many steps a time is; one that ends between two counts as the later."""
    return math.ceil(time / time_step - 1e-9)


def numbers_decided(controls: Iterable[Control]) -> int:
    """How many numbers are decided in a turn."""
    return sum(len(each.actions) for each in controls)


def columns(controls: Sequence[Control]) -> tuple[slice, ...]:
    """Where the numbers of each control stand among those of all."""
    ends = [numbers_decided(controls[: number + 1]) for number in range(len(controls))]
    return tuple(slice(end - len(each.actions), end) for each, end in zip(controls, ends, strict=True))


def control_from(content: Mapping[str, Any]) -> Control:
    """Inverse of `dataclasses.asdict`."""
    actions = tuple(Action(**action) for action in content["actions"])
    values: dict[str, Any] = {**content, "actions": actions}
    return Control(**values)
