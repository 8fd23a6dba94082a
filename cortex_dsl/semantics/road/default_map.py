"""The road of a file without `map`: it suits what the file asks for, and notes say so."""

import math
from collections.abc import Iterator

from cortex_dsl.semantics.names.overrides import param_entries
from cortex_dsl.semantics.road.lanes import NEIGHBOURS
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.program import RoadSpec

NEIGHBOURLY = frozenset({"adjacentLanes", *NEIGHBOURS, *(f"_{name}" for name in NEIGHBOURS)})
"""Attributes whose use asks for more than one lane a direction, unless it is a test for None."""
LIGHTS = frozenset({"signals", "isSignalized"})
SPARE = 50.0
"""How much longer than a distance to the intersection that a `require` asks for the arms are [m]."""


def default_road(module: nodes.Module) -> RoadSpec:
    """A T-junction where only those are asked for; two lanes where neighbours are; arms as long as distances need."""
    asked = {node.name for node in everything_in(module) if isinstance(node, nodes.Attribute)}
    ways = 3 if "is3Way" in asked and "is4Way" not in asked else 4
    plain = RoadSpec()
    farthest = max(_distances_kept(module), default=0.0)
    approach = max(plain.approach, 10.0 * math.ceil((farthest + SPARE) / 10.0)) if farthest else plain.approach
    return RoadSpec(ways=ways, lanes=2 if _asks_for_neighbours(module) else 1, approach=approach)


def spelled(road: RoadSpec) -> str:
    """The `map` line that gives a default road."""
    approach = "" if road.approach == RoadSpec().approach else f", approach={road.approach:g} m"
    return f"map intersection(ways={road.ways}, lanes={road.lanes}{approach})"


def reasons(road: RoadSpec) -> str:
    """Why a default road is no plain one; nothing for a plain one."""
    found = []
    if road.lanes > 1:
        found.append(f"{road.lanes} lanes a direction, since the file asks for neighbouring lanes")
    if road.approach != RoadSpec().approach:
        found.append(f"arms of {road.approach:g} m, since it keeps that far from the intersection")
    return "it has " + " and ".join(found) if found else ""


def map_with_lights(module: nodes.Module) -> Span | None:
    """The line by which a script names a map that has traffic lights, if it asks for them; else None."""
    entry = param_entries(module).get("map")
    statements = tuple(everything_in(module))
    if entry is None or any(isinstance(node, nodes.Signals) for node in statements):
        return None
    negated = {id(node.operand) for node in statements if isinstance(node, nodes.Unary) and node.operator == "not"}
    asks = any(
        (isinstance(node, nodes.Name) and "TrafficLight" in node.id)
        or (isinstance(node, nodes.Attribute) and node.name in LIGHTS and id(node) not in negated)
        or (isinstance(node, nodes.Argument) and node.name == "obey_signals")
        for node in statements
    )
    return entry.span if asks else None


def _asks_for_neighbours(module: nodes.Module) -> bool:
    tests = {
        id(node.first)
        for node in everything_in(module)
        if isinstance(node, nodes.Compare) and [op for op, other in node.rest if _is_none(other)] in (["is"], ["=="])
    }
    return any(
        isinstance(node, nodes.Attribute) and node.name in NEIGHBOURLY and id(node) not in tests
        for node in everything_in(module)
    )


def _is_none(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Constant) and node.value is None


def _distances_kept(module: nodes.Module) -> Iterator[float]:
    """Numbers that a distance to an intersection has to exceed [m]."""
    numbers = {
        name: statement.value.value
        for statement in module.statements
        if isinstance(statement, nodes.Assign) and isinstance(statement.value, nodes.Number)
        for name in statement.targets
    }
    for statement in module.statements:
        for node in everything_in(statement) if isinstance(statement, nodes.Require) else ():
            if isinstance(node, nodes.Compare) and len(node.rest) == 1 and _is_far_off(node.first):
                operator, other = node.rest[0]
                value = numbers.get(other.id) if isinstance(other, nodes.Name) else getattr(other, "value", None)
                if operator in (">", ">=") and isinstance(value, float | int) and value > 0:
                    yield float(value)


def _is_far_off(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Distance) and isinstance(node.target, nodes.Name) and "intersec" in node.target.id
