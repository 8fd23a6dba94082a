"""Drivers of the controllers that are no agents of an environment."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

from engine.config import ActorDriver
from engine.driving.controllers import ControllerSlot, meant, seats_of
from engine.driving.named import driver_of
from engine.errors import ArgumentError, nearest
from engine.program import Program


def number_of(program: Program, name: str) -> int:
    """Return the number of the control with this controller.

    Raises:
        ArgumentError: no control has it; the hint names the nearest name.
    """
    names = [control.controller for control in program.controls]
    if name not in names:
        near = nearest(name, names)
        raise ArgumentError(
            f"{program.name} has no controller `{name}`",
            f"did you mean `{near}`?" if near else f"name one of {', '.join(names)}",
        )
    return names.index(name)


def others_of(program: Program, driver: ActorDriver | None, agent: str, observe: str) -> Mapping[str, object]:
    """Return the drivers of a scenario's controllers except the agent's, by controller name.

    Raises:
        ArgumentError: they observe something else than the environment.
    """
    if driver is None:
        return {}
    given: object = getattr(driver, "given", None)
    every = cast("Mapping[str, object]", given) if isinstance(given, Mapping) else {meant(program): given}
    others = {name: each for name, each in every.items() if name != (agent or meant(program)) and each is not None}
    if others and driver.observe != observe:
        raise ArgumentError(
            f"{', '.join(others)} observe {driver.observe}, and this environment {observe}",
            f'add `observe="{driver.observe}"`, or name `others` that observe {observe}',
        )
    return others


def seats_beside(
    program: Program, agents: Sequence[str], others: Mapping[str, object]
) -> list[tuple[ControllerSlot, int]]:
    """Return the slot and control number of each controller that is no agent.

    Raises:
        ArgumentError: a controller has no driver, or is both an agent and in `others`.
    """
    if both := [name for name in agents if name in others]:
        raise ArgumentError(
            f"`{both[0]}` decides step by step, and has a driver in `others`", "leave it out of `others`"
        )
    missing = [c.controller for c in program.controls if c.controller not in (*agents, *others)]
    if missing:
        raise ArgumentError(
            f"nobody drives for the controller `{missing[0]}`",
            "give it a driver: `others={" + f'"{missing[0]}": …' + "}`, or make it an agent",
        )
    rest = replace(program, controls=tuple(c for c in program.controls if c.controller not in agents))
    given = driver_of(others)
    seats = seats_of(rest, given.given) if rest.controls and given is not None else ()
    return [(seat, number_of(program, seat.control.controller)) for seat in seats]
