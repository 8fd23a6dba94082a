"""The road network: names that refer to it, and the road of a file without `map`.

The road of a file without `map` suits the contents of the file; notes say so.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics.errors.scene import (
    BAD_MAP,
    MAP_LEVELS,
    MAP_REMARK,
    MAP_SIGNS,
    MAP_UNREAD,
    MAP_WITHOUT_INTERSECTION,
    NO_SINGLE_INTERSECTION,
    RUNS_DIFFER,
)
from cortex_dsl.semantics.model.areas import all_or_nothing
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
from cortex_dsl.semantics.names.street_words import street_of
from cortex_dsl.semantics.names.tree import everything_in, param_entries
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.maps import MapFile, MapSpec, RoadSpec, Street
from engine.road.build import build_network
from engine.road.lights import lights_for_nobody
from engine.road.network import Lane, Network
from engine.road.sections import (
    all_intersections,
    faster,
    slower,
    to_left,
    to_right,
)
from engine.road.specification import LENGTHS
from engine.tables import ROAD_REGION
from engine.vocabulary import LEVEL


def network_for(ev: Evaluator, spec: MapSpec, span: Span) -> Network:
    """The network of a specification, the same in all variants.

    Raises:
        Mistake: another variant has another road.
    """
    networks = ev.file.roads.networks
    if networks and spec not in networks:
        raise RUNS_DIFFER.mistake(span, what="the map")
    if spec not in networks:
        networks[spec] = build_network(spec)
        if isinstance(spec, MapFile):
            for diagnostic in _on_file(ev, spec, networks[spec], span):
                ev.report(diagnostic)
    return networks[spec]


def _on_file(ev: Evaluator, spec: MapFile, network: Network, span: Span) -> Iterator[Diagnostic]:
    """Yield the diagnostics of a map file: one for each code, since a place shows each code once."""
    if remarks := (*network.remarks, *_on_lights(network)):
        yield MAP_REMARK.at(span, file=spec.file, message="; ".join(remarks))
    if network.levels:
        yield MAP_LEVELS.at(span, file=spec.file, message="; ".join(network.levels), level=LEVEL)
    if network.unread:
        yield MAP_UNREAD.at(span, file=spec.file, message=network.unread)
    if unheeded := _unheeded(ev, network):
        yield MAP_SIGNS.at(span, file=spec.file, what=unheeded[0], cure=unheeded[1])


def _on_lights(network: Network) -> Iterator[str]:
    if lost := lights_for_nobody(network):
        lights = "1 traffic light stands" if lost == 1 else f"{lost} traffic lights stand"
        yield f"{lights} over no lane into an intersection: nobody waits there"


def _unheeded(ev: Evaluator, network: Network) -> tuple[str, str] | None:
    """Return a message on traffic lights and signs of a map that no driver obeys, and the cure; None without any."""
    lights = len({sign.id for sign in network.signs if sign.is_traffic_light})
    signs = len({sign.id for sign in network.signs if not sign.is_traffic_light})
    if ev.facts.default_signals is not None or ev.facts.has_plan:
        lights = 0
    found = [
        f"{count} {noun}{'s'[: count != 1]}" for count, noun in ((lights, "traffic light"), (signs, "sign")) if count
    ]
    if not found:
        return None
    cure = (
        "write `signals()`, and drive with `obey_signals=True`"
        if lights
        else "give behaviors a stop or a target speed of their own there"
    )
    return f"no driver heeds its {' and '.join(found)}", cure


def network_of(ev: Evaluator) -> Network:
    """The network of this variant; the default one where the file has no map."""
    if ev.run.built.network is None:
        ev.run.built.network = network_for(ev, ev.facts.default_road, ev.algebra.span)
    return ev.run.built.network


@frozen
class Named:
    value: Value


def named_constant(ev: Evaluator, name: str, span: Span) -> Named | None:
    """Return the value of a built-in name; None for a name that is not built in."""
    if name in _CONSTANTS:
        return Named(_CONSTANTS[name](ev, span))
    if name in BUILTINS and BUILTINS[name].kind is not Kind.CONSTANT:
        return Named(BuiltinValue(name))
    return None


def _single_intersection(ev: Evaluator, span: Span) -> Value:
    intersections = network_of(ev).intersections
    if len(intersections) == 1:
        return intersections[0]
    if intersections and ev.facts.from_scenic:
        return region_of_intersections(ev, span)
    if intersections:
        raise NO_SINGLE_INTERSECTION.mistake(span, count=len(intersections))
    raise MAP_WITHOUT_INTERSECTION.mistake(span)


ROAD = Region(ROAD_REGION, "the road")

_CONSTANTS: dict[str, Callable[[Evaluator, Span], Value]] = {
    "network": lambda ev, _: network_of(ev),
    "intersection": _single_intersection,
    "road": lambda ev, _: _region_of_road(ev),
    "roadDirection": lambda _ev, _: DirectionField(),
    "ManeuverType": lambda _ev, _: EnumValue(),
    "globalParameters": lambda _ev, _: GlobalParameters(),
    "everywhere": lambda ev, _: all_or_nothing("`everywhere`", ev.algebra.truth(True)),
    "nowhere": lambda ev, _: all_or_nothing("`nowhere`", ev.algebra.truth(False)),
    "none": lambda _ev, _: None,
    "pi": lambda ev, _: Quantity(ev.algebra.literal(math.pi), None),
}


def region_of_intersections(ev: Evaluator, span: Span) -> Region:
    """Return the region of all intersections, which is Scenic's `intersection`."""
    network = network_of(ev)
    if not network.intersections:
        raise MAP_WITHOUT_INTERSECTION.mistake(span)
    return Region(all_intersections(network), "the intersections")


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
"""Attributes that need more than one lane a direction, unless they are tested for None."""
LIGHTS = frozenset({"signals", "isSignalized"})
SPARE = 50.0
"""How much longer than a distance to the intersection that a `require` asks for the arms are [m]."""
ROOM = 25.0
"""How much of an arm is left to choose from, where objects `following` the road stand far ahead of others [m]."""
LONGEST_ARM = LENGTHS["approach"][1]


def default_road(module: nodes.Module) -> RoadSpec:
    """Return the road of a file without `map`.

    It is a T-junction if only those are needed; it has two lanes a direction if neighbours are, and the sidewalks,
    crossings and strips that the file names; its arms are long enough for the distances of the file.
    """
    attribute_names = {node.name for node in everything_in(module) if isinstance(node, nodes.Attribute)}
    ways = 3 if "is3Way" in attribute_names and "is4Way" not in attribute_names else 4
    plain = RoadSpec()
    reachable = [distance for distance, _ in _distances_kept(module) if distance + SPARE <= LONGEST_ARM]
    farthest = max(reachable, default=0.0)
    spare = max(SPARE, min(LONGEST_ARM, _farthest_ahead(module)) + ROOM)
    longest = min(LONGEST_ARM, 10.0 * math.ceil((farthest + spare) / 10.0))
    approach = max(plain.approach, longest) if farthest else plain.approach
    lanes = 2 if _asks_for_neighbours(module) else 1
    return RoadSpec(ways=ways, lanes=lanes, approach=approach, **street_of(module))


def beyond_any_road(module: nodes.Module) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each distance to the intersection that exceeds the longest arm."""
    for distance, span in _distances_kept(module):
        if distance + SPARE > LONGEST_ARM:
            message = f"its arms would be longer than {LONGEST_ARM:g} m, to be {distance:g} m from the intersection"
            yield BAD_MAP.at(span, message=message, cure=f"ask for {LONGEST_ARM - SPARE:g} m or less")


def map_line(road: RoadSpec) -> str:
    """The `map` line that gives a default road."""
    approach = "" if road.approach == RoadSpec().approach else f", approach={road.approach:g} m"
    street = "".join(f", {name}={_argument(getattr(road, name))}" for name in _street_fields(road))
    return f"map intersection(ways={road.ways}, lanes={road.lanes}{approach}{street})"


def _street_fields(road: RoadSpec) -> list[str]:
    """Return the arguments of strips and crossings that differ from their defaults."""
    return [each.name for each in fields(Street) if getattr(road, each.name) != each.default]


def _argument(value: float | bool) -> str:
    return str(value) if isinstance(value, bool) else f"{value:g} m"


def reasons_for_road(road: RoadSpec) -> str:
    """Return why a default road differs from the plain one; "" if it does not."""
    found = []
    if road.lanes > 1:
        found.append(f"{road.lanes} lanes per direction, since the file asks for neighbouring lanes")
    if road.approach != RoadSpec().approach:
        found.append(f"arms of {road.approach:g} m, since it keeps that far from the intersection")
    if names := _street_fields(road):
        found.append(f"{' and '.join(STREET_WORDS[name] for name in names)}, since the file names them")
    return "it has " + " and ".join(found) if found else ""


STREET_WORDS: Mapping[str, str] = {
    "sidewalk": "sidewalks",
    "shoulder": "shoulders",
    "bike_lane": "bicycle lanes",
    "parking": "parking rows",
    "crossings": "crossings",
}
"""Words for the strips and crossings of the road of a file without `map`, by argument."""


def has_plan(module: nodes.Module) -> bool:
    """Return whether a file has a plan of traffic lights."""
    return any(isinstance(node, nodes.Signals) for node in everything_in(module))


def map_with_lights(module: nodes.Module) -> Span | None:
    """The line by which a script names a map that has traffic lights, if it asks for them; else None."""
    entry = param_entries(module).get("map")
    statements = tuple(everything_in(module))
    if entry is None or has_plan(module):
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


def _farthest_ahead(module: nodes.Module) -> float:
    """Return the distance by which `following` places an object ahead of the first in its row, by known numbers [m]."""
    largest: dict[str, float] = {}
    ahead: dict[str, float] = {}
    for statement in module.statements:
        if isinstance(statement, nodes.Param):
            largest |= {entry.name: _largest(entry.value, largest) for entry in statement.entries}
        if isinstance(statement, nodes.Assign):
            own = _largest(statement.value, largest)
            places = (each for each in everything_in(statement) if isinstance(each, nodes.Following))
            reach = max((_reach(each, largest, ahead) for each in places), default=0.0)
            largest |= dict.fromkeys(statement.targets, own)
            ahead |= dict.fromkeys(statement.targets, reach)
    return max(ahead.values(), default=0.0)


def _reach(place: nodes.Following, largest: Mapping[str, float], ahead: Mapping[str, float]) -> float:
    origin = place.origin.id if isinstance(place.origin, nodes.Name) else ""
    return ahead.get(origin, 0.0) + _largest(place.distance, largest)


def _largest(node: nodes.Expression, known: Mapping[str, float]) -> float:
    """Return the largest value of a sum of numbers, ranges and names; any other operand counts as 0."""
    total, rest = 0.0, [node]
    while rest:
        match rest.pop():
            case nodes.Number(value=value, unit=None | "m"):
                total += value
            case nodes.Name(id=name) | nodes.Attribute(value=nodes.Name(id="globalParameters"), name=name):
                total += known.get(name, 0.0)
            case nodes.WithUnit(value=value, unit="m"):
                rest.append(value)
            case nodes.Call(function=nodes.Name(id="Range" | "VerifaiRange"), arguments=(_, high)):
                rest.append(high.value)
            case nodes.Binary(operator="+", left=left, right=right):
                rest += (left, right)
            case _:
                pass
    return total
