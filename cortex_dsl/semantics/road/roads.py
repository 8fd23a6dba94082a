"""The road network: the `map` statement, and the names that lead into the network."""

import math
from collections.abc import Callable, Container, Mapping
from types import MappingProxyType

from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS, Kind
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_each
from cortex_dsl.semantics.evaluation.functions import known_truth, whole_number
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.quantities.numbers import adopt
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.semantics.values import (
    BuiltinValue,
    DirectionField,
    EnumValue,
    GlobalParameters,
    Quantity,
    Region,
    Value,
)
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean, nearest
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.program import RoadSpec
from engine.road.build import build_network
from engine.road.network import Network
from engine.road.specification import wrong_alone, wrong_together
from engine.tables import ROAD_REGION

_WHOLE = ("ways", "lanes", "rows", "cols")
_LENGTHS = ("lane_width", "corner_radius", "approach", "block")
MAP_ARGUMENTS = (*_WHOLE, *_LENGTHS, "left_hand")


def lay_out(ev: Evaluator, node: nodes.Map) -> None:
    """`map intersection(...)`: build the network of this variant."""
    if node.kind != "intersection":
        raise errors.UNKNOWN_MAP.mistake(node.span, kind=node.kind)
    if ev.run.network is not None:
        raise errors.MAP_TOO_LATE.mistake(node.span)
    ev.run.network = _network(ev, _spec(ev, node), node.span)


def _spec(ev: Evaluator, node: nodes.Map) -> RoadSpec:
    """The road that is asked for.

    Raises:
        Mistake: there is none; what is wrong with each argument has been told.
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
        ev.report(errors.BAD_MAP.at(spans.get(error.argument, node.span), message=error.message, cure=error.cure))
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
    """Take the arguments that can be read for the map, so that nothing below is told of another one."""
    spec = RoadSpec(**values)  # type: ignore[arg-type]
    if not list(wrong_alone(spec)) and not list(wrong_together(spec)):
        ev.run.network = _network(ev, spec, node.span)


def _map_argument(argument: Given, known: Container[str]) -> str:
    if argument.name is None:
        raise errors.NOT_SUPPORTED.mistake(
            argument.span,
            what="`map` takes its arguments by name",
            reason="",
            cure="as in `ways=4, lane_width=3.5 m`, with a point for decimals",
        )
    if argument.name not in MAP_ARGUMENTS:
        raise errors.UNKNOWN_ARGUMENT.mistake(
            argument.place,
            function="map intersection",
            name=argument.name,
            suggestion=did_you_mean(argument.name, MAP_ARGUMENTS),
        )
    if argument.name in known:
        raise errors.DUPLICATE.mistake(argument.place, what="the argument", name=argument.name)
    return argument.name


def _map_value(ev: Evaluator, argument: Given, name: str) -> float | bool:
    what = f"`{name}` of the map"
    if name in _WHOLE:
        return whole_number(ev, argument.value, argument.span, what)
    if name in _LENGTHS:
        expr = adopt(ev, argument.value, LENGTH, argument.span, what)
        value = ev.constant(Quantity(expr, LENGTH), argument.span, what)
        if not math.isfinite(value):
            raise errors.NOT_FINITE.mistake(argument.span, reason=f"{what} is {value}")
        return value
    return known_truth(ev, argument.value, argument.span, what)


def _network(ev: Evaluator, spec: RoadSpec, span: Span) -> Network:
    networks = ev.file.networks
    if networks and spec not in networks:
        raise errors.MAP_VARIES.mistake(span)
    if spec not in networks:
        networks[spec] = build_network(spec)
    return networks[spec]


def network_of(ev: Evaluator) -> Network:
    """The network of this variant; the default one where the file has no map."""
    if ev.run.network is None:
        ev.run.network = _network(ev, ev.file.default_road, ev.algebra.span)
    return ev.run.network


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
        raise errors.NO_SINGLE_INTERSECTION.mistake(span, count=len(intersections))
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
