"""The road network: the `map` statement, the road of a file without one, and the names that lead into the network.

The road of a file without `map` suits what the file asks for, and notes say so.
"""

import math
from collections.abc import Callable, Container, Iterator, Mapping
from types import MappingProxyType

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics.errors.names import DUPLICATE, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.roads import BAD_MAP, MAP_TOO_LATE, MAP_VARIES, NO_SINGLE_INTERSECTION, UNKNOWN_MAP
from cortex_dsl.semantics.errors.statements import NOT_SUPPORTED
from cortex_dsl.semantics.errors.values import NOT_FINITE
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_each
from cortex_dsl.semantics.evaluation.functions import known_truth, whole_number
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    BuiltinValue,
    DirectionField,
    EnumValue,
    GlobalParameters,
    Quantity,
    Region,
    Value,
)
from cortex_dsl.semantics.names.builtins import BUILTINS, Kind
from cortex_dsl.semantics.names.tree import everything_in, param_entries
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean, nearest
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.program import RoadSpec
from engine.road.build import build_network
from engine.road.network import Lane, Network
from engine.road.sections import (
    faster,
    slower,
    to_left,
    to_right,
)
from engine.road.specification import LENGTHS, wrong_alone, wrong_together
from engine.tables import ROAD_REGION

_WHOLE = ("ways", "lanes", "rows", "cols")
_LENGTHS = ("lane_width", "corner_radius", "approach", "block", "buildings")
MAP_ARGUMENTS = (*_WHOLE, *_LENGTHS, "left_hand")


def lay_out(ev: Evaluator, node: nodes.Map) -> None:
    """`map intersection(...)`: build the network of this variant."""
    if node.kind != "intersection":
        raise UNKNOWN_MAP.mistake(node.span, kind=node.kind)
    if ev.run.built.network is not None:
        raise MAP_TOO_LATE.mistake(node.span)
    ev.run.built.network = _network(ev, _spec(ev, node), node.span)


def _spec(ev: Evaluator, node: nodes.Map) -> RoadSpec:
    """The road that is asked for.

    Raises:
        Mistake: no road fits; what is wrong with each argument has been reported.
    """
    given, mistaken = evaluate_each(ev, node.arguments)
    values: dict[str, float | bool] = {}
    spans: dict[str, Span] = {}
    for argument in given:
        try:
            name = _map_argument(argument, values)
            values[name] = _map_value(ev, argument, name)
            spans[name] = argument.span
        except Mistake as mistake:
            ev.report(mistake)
            mistaken = True
    spec = RoadSpec(**values)  # type: ignore[arg-type]
    wrong = list(wrong_alone(spec)) or ([] if mistaken else list(wrong_together(spec)))
    for error in wrong:
        ev.report(BAD_MAP.at(spans.get(error.argument, node.span), message=error.message, cure=error.cure))
    if mistaken or wrong:
        good = {name: value for name, value in values.items() if name not in [error.argument for error in wrong]}
        _go_on(ev, node, {**({} if _knows_lengths(node, good) else _ROOMY), **good})
        raise Mistake
    return spec


_ROOMY: Mapping[str, float | bool] = MappingProxyType({"approach": 500.0})
"""In the place of lengths that could not be read: nothing is too far on it."""


def _knows_lengths(node: nodes.Map, good: Container[str]) -> bool:
    """Whether the map that is gone on with is as long as the one that was meant."""
    meant = {nearest(each.name, MAP_ARGUMENTS) for each in node.arguments if each.name is not None}
    return "approach" in good or "approach" not in meant


def _go_on(ev: Evaluator, node: nodes.Map, values: Mapping[str, float | bool]) -> None:
    """Take the arguments that can be read for the map, so that nothing below is judged by another one."""
    spec = RoadSpec(**values)  # type: ignore[arg-type]
    if not list(wrong_alone(spec)) and not list(wrong_together(spec)):
        ev.run.built.network = _network(ev, spec, node.span)


def _map_argument(argument: Given, known: Container[str]) -> str:
    if argument.name is None:
        raise NOT_SUPPORTED.mistake(
            argument.span,
            what="`map` takes its arguments by name",
            reason="",
            cure="as in `ways=4, lane_width=3.5 m`, with a point for decimals",
        )
    if argument.name not in MAP_ARGUMENTS:
        raise UNKNOWN_ARGUMENT.mistake(
            argument.place,
            function="map intersection",
            name=argument.name,
            suggestion=did_you_mean(argument.name, MAP_ARGUMENTS),
        )
    if argument.name in known:
        raise DUPLICATE.mistake(argument.place, what="the argument", name=argument.name)
    return argument.name


def _map_value(ev: Evaluator, argument: Given, name: str) -> float | bool:
    what = f"`{name}` of the map"
    if name in _WHOLE:
        return whole_number(ev, argument.value, argument.span, what)
    if name in _LENGTHS:
        expr = adopt(ev, argument.value, LENGTH, argument.span, what)
        value = ev.constant(Quantity(expr, LENGTH), argument.span, what)
        if not math.isfinite(value):
            raise NOT_FINITE.mistake(argument.span, reason=f"{what} is {value}")
        return value
    return known_truth(ev, argument.value, argument.span, what)


def _network(ev: Evaluator, spec: RoadSpec, span: Span) -> Network:
    networks = ev.file.networks
    if networks and spec not in networks:
        raise MAP_VARIES.mistake(span)
    if spec not in networks:
        networks[spec] = build_network(spec)
    return networks[spec]


def network_of(ev: Evaluator) -> Network:
    """The network of this variant; the default one where the file has no map."""
    if ev.run.built.network is None:
        ev.run.built.network = _network(ev, ev.file.default_road, ev.algebra.span)
    return ev.run.built.network


@frozen
class Named:
    value: Value


def named_constant(ev: Evaluator, name: str, span: Span) -> Named | None:
    """What a builtin name stands for; None for a name that is not built in."""
    if name in _CONSTANTS:
        return Named(_CONSTANTS[name](ev, span))
    if name in BUILTINS and BUILTINS[name].kind is not Kind.CONSTANT:
        return Named(BuiltinValue(name))
    return None


def _single_intersection(ev: Evaluator, span: Span) -> Value:
    intersections = network_of(ev).intersections
    if len(intersections) != 1:
        raise NO_SINGLE_INTERSECTION.mistake(span, count=len(intersections))
    return intersections[0]


ROAD = Region(ROAD_REGION, "the road")

_CONSTANTS: dict[str, Callable[[Evaluator, Span], Value]] = {
    "network": lambda ev, _: network_of(ev),
    "intersection": _single_intersection,
    "road": lambda ev, _: _region_of_road(ev),
    "roadDirection": lambda _ev, _: DirectionField(),
    "ManeuverType": lambda _ev, _: EnumValue(),
    "globalParameters": lambda _ev, _: GlobalParameters(),
    "none": lambda _ev, _: None,
    "pi": lambda ev, _: Quantity(ev.algebra.literal(math.pi), None),
}


def _region_of_road(ev: Evaluator) -> Region:
    network_of(ev)
    return ROAD


NEIGHBOURS: Mapping[str, Callable[[Lane], Lane | None]] = {
    "laneToLeft": to_left,
    "laneToRight": to_right,
    "fasterLane": faster,
    "slowerLane": slower,
}

# -- the road of a file without `map` ----------------------------------------------------------------------------------

NEIGHBOURLY = frozenset({"adjacentLanes", *NEIGHBOURS, *(f"_{name}" for name in NEIGHBOURS)})
"""Attributes whose use asks for more than one lane a direction, unless it is a test for None."""
LIGHTS = frozenset({"signals", "isSignalized"})
SPARE = 50.0
"""How much longer than a distance to the intersection that a `require` asks for the arms are [m]."""
LONGEST_ARM = LENGTHS["approach"][1]


def default_road(module: nodes.Module) -> RoadSpec:
    """A T-junction where only those are asked for; two lanes where neighbours are; arms as long as distances need."""
    asked = {node.name for node in everything_in(module) if isinstance(node, nodes.Attribute)}
    ways = 3 if "is3Way" in asked and "is4Way" not in asked else 4
    plain = RoadSpec()
    reachable = [distance for distance, _ in _distances_kept(module) if distance + SPARE <= LONGEST_ARM]
    farthest = max(reachable, default=0.0)
    approach = max(plain.approach, 10.0 * math.ceil((farthest + SPARE) / 10.0)) if farthest else plain.approach
    return RoadSpec(ways=ways, lanes=2 if _asks_for_neighbours(module) else 1, approach=approach)


def beyond_any_road(module: nodes.Module) -> Iterator[Diagnostic]:
    """What is said of distances to the intersection that no road is long enough for."""
    for distance, span in _distances_kept(module):
        if distance + SPARE > LONGEST_ARM:
            message = f"its arms would be longer than {LONGEST_ARM:g} m, to be {distance:g} m from the intersection"
            yield BAD_MAP.at(span, message=message, cure=f"ask for {LONGEST_ARM - SPARE:g} m or less")


def map_line(road: RoadSpec) -> str:
    """The `map` line that gives a default road."""
    approach = "" if road.approach == RoadSpec().approach else f", approach={road.approach:g} m"
    return f"map intersection(ways={road.ways}, lanes={road.lanes}{approach})"


def reasons_for_road(road: RoadSpec) -> str:
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
    negated = {node.operand.span for node in statements if isinstance(node, nodes.Unary) and node.operator == "not"}
    asks = any(
        (isinstance(node, nodes.Name) and "TrafficLight" in node.id)
        or (isinstance(node, nodes.Attribute) and node.name in LIGHTS and node.span not in negated)
        or (isinstance(node, nodes.Argument) and node.name == "obey_signals")
        for node in statements
    )
    return entry.span if asks else None


def _asks_for_neighbours(module: nodes.Module) -> bool:
    tests = {
        node.first.span
        for node in everything_in(module)
        if isinstance(node, nodes.Compare) and [op for op, other in node.rest if _is_none(other)] in (["is"], ["=="])
    }
    return any(
        isinstance(node, nodes.Attribute) and node.name in NEIGHBOURLY and node.span not in tests
        for node in everything_in(module)
    )


def _is_none(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Constant) and node.value is None


def _distances_kept(module: nodes.Module) -> Iterator[tuple[float, Span]]:
    """Numbers that a distance to an intersection has to exceed [m], and where they are written."""
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
                if operator in (">", ">=") and isinstance(value, float | int) and 0 < value < math.inf:
                    yield float(value), other.span


def _is_far_off(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Distance) and isinstance(node.target, nodes.Name) and "intersec" in node.target.id
