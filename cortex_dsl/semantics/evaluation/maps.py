"""`map KIND(...)`: the road that a file asks for. Kinds and their arguments are the types of `engine.maps`."""

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import Field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

from cortex_dsl.ir import Dimension
from cortex_dsl.semantics.errors.names import DUPLICATE, NOT_SUPPORTED, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.scene import BAD_MAP, BAD_MAP_FILE, BAD_ORIGIN, MAP_TOO_LATE, NO_MAP_FILE, UNKNOWN_MAP
from cortex_dsl.semantics.errors.values import NOT_FINITE
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_each, items_of
from cortex_dsl.semantics.evaluation.functions import known_truth, whole_number
from cortex_dsl.semantics.evaluation.numbers import adopt, quantity
from cortex_dsl.semantics.evaluation.roads import network_for
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Quantity, Truth, Value
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, SPEED, example
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean, nearest
from cortex_dsl.syntax import nodes
from engine.errors import CortexError, InterchangeError
from engine.maps import KINDS, LaneletFile, MapFile, MapSpec, Places
from engine.road.build import MAKERS, wrong_numbers

FILE, LANELETS = MapFile.kind, LaneletFile.kind


def _arguments(spec: type[MapSpec]) -> tuple[str, ...]:
    """Return the arguments of a kind of map, its own before those of every street."""
    every: Sequence[Field[Any]] = fields(spec)  # type: ignore[arg-type]
    return tuple(each.name for each in sorted(every, key=lambda each: each.kw_only is True))


MAP_ARGUMENTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **{kind: _arguments(spec) for kind, spec in KINDS.items() if not issubclass(spec, MapFile)},
        FILE: ("file",),
        LANELETS: ("file", "origin"),
    }
)
"""Kinds of built-in maps, by the word after `map`."""
WHOLE = frozenset({"ways", "lanes", "rows", "cols", "arms"})
TRUTHS = frozenset({"left_hand", "one_way", "bike_lane_behind_parking"})
DIMENSIONS = {"bend": ANGLE, "speed_limit": SPEED, "parked": PURE}
"""Dimensions of the arguments; all others are lengths."""
PLACES = "crossings"
"""Argument that is a truth or a list of places along the road."""


def lay_out(ev: Evaluator, node: nodes.Map) -> None:
    """Build the network of this variant."""
    if node.kind not in KINDS:
        raise UNKNOWN_MAP.mistake(node.span, kind=node.kind, suggestion=_kinds_like(node.kind))
    if ev.run.built.network is not None:
        raise MAP_TOO_LATE.mistake(node.span)
    spec = _file(ev, node) if node.kind in (FILE, LANELETS) else _spec(ev, node)
    ev.run.built.network = network_for(ev, spec, node.span)


# -- the roads of a file -----------------------------------------------------------------------------------------------


def _file(ev: Evaluator, node: nodes.Map) -> MapSpec:
    """The file that `map opendrive("FILE")` or `map lanelet2("FILE", origin=PLACE)` names.

    Raises:
        Mistake: it names none, or none that is there and can be read.
    """
    given, mistaken = evaluate_each(ev, node.arguments)
    if mistaken:
        raise Mistake
    places = [each for each in given if each.name == "origin" and node.kind == LANELETS]
    files = [each for each in given if each not in places]
    if len(files) != 1 or len(places) > 1 or files[0].name not in (None, "file") or not isinstance(files[0].value, str):
        example = (
            'opendrive("roads/town.xodr")' if node.kind == FILE else 'lanelet2("roads/town.osm", origin=(49, 8.4))'
        )
        raise NOT_SUPPORTED.mistake(
            given[0].span if given else node.span,
            what=f"`map {node.kind}` takes the name of one file" + (" and `origin`" if node.kind == LANELETS else ""),
            reason="",
            cure=f"as in `map {example}`, relative to this file",
        )
    name, span = files[0].value, files[0].span
    origin = _origin(ev, places[0]) if places else None
    found = ev.facts.find_map(name)
    if found is None:
        what = "an OpenDRIVE" if node.kind == FILE else "a Lanelet2"
        raise NO_MAP_FILE.mistake(span, file=name, kind=node.kind, format=what)
    return _read(ev, name, found, span, origin, node.kind)


def _origin(ev: Evaluator, given: Given) -> tuple[float, float]:
    """Return the latitude and longitude of (0, 0) [deg]."""
    items = items_of(given.value, given.span, "`origin`")
    if len(items) != 2:
        raise BAD_ORIGIN.mistake(given.span, actual=f"a list of {len(items)}")
    latitude, longitude = (_number(ev, Given(each, given.span), PURE, "`origin` of the map") for each in items)
    if not -UTM_NORTH <= latitude <= UTM_NORTH or not -180.0 <= longitude <= 180.0:
        raise BAD_ORIGIN.mistake(given.span, actual=f"({latitude:g}, {longitude:g})")
    return latitude, longitude


UTM_NORTH = 80.0
"""Latitude up to which a map has UTM coordinates, in both directions; the standard ends at 80 S and 84 N [deg]."""


def read_named(ev: Evaluator, value: Value, span: Span) -> bool:
    """Build the network of the file that Scenic's `param map` names; False where there is no such file.

    Raises:
        Mistake: it cannot be read, or the road was used before.
    """
    if not isinstance(value, str) or ev.facts.has_map:
        return False
    found = value if value in ev.file.roads.map_files else ev.facts.find_map(value)
    if found is None:
        return False
    if ev.run.built.network is not None:
        raise MAP_TOO_LATE.mistake(span)
    ev.run.built.network = network_for(ev, _read(ev, value, found, span), span)
    return True


def _read(
    ev: Evaluator, name: str, found: str, span: Span, origin: tuple[float, float] | None = None, kind: str = FILE
) -> MapFile:
    """The specification of a file, which all variants share."""
    key = name if kind == FILE else f"{name} at {origin}"
    if key not in ev.file.roads.map_files:
        try:
            ev.file.roads.map_files[key] = _specified(Path(found).resolve(), name, origin, kind)
        except OSError as error:
            reason = error.strerror or "it cannot be read"
            raise BAD_MAP_FILE.mistake(span, file=name, message=reason, cure="name a file that can be read") from error
        except CortexError as error:
            place = f"{error.place}: " if isinstance(error, InterchangeError) and error.place else ""
            raise BAD_MAP_FILE.mistake(span, file=name, message=f"{place}{error.message}", cure=error.cure) from error
    return ev.file.roads.map_files[key]


def _specified(path: Path, name: str, origin: tuple[float, float] | None, kind: str) -> MapFile:
    if kind == LANELETS:
        from engine.road.lanelet2.network import lanelet_file

        return lanelet_file(path, name, origin)
    from engine.road.opendrive.network import map_file

    return map_file(path, name)


# -- arguments ---------------------------------------------------------------------------------------------------------


def _kinds_like(kind: str) -> str:
    return did_you_mean(kind, KINDS) or "write `map intersection(ways=4, lanes=1)` or `map road(lanes=1, length=500 m)`"


def _spec(ev: Evaluator, node: nodes.Map) -> MapSpec:
    """Return the specification of the road.

    Raises:
        Mistake: no road fits; the error of each argument has been reported.
    """
    given, mistaken = evaluate_each(ev, node.arguments)
    values: dict[str, float | bool | Places] = {}
    spans: dict[str, Span] = {}
    for argument in given:
        try:
            name = _name(node.kind, argument, values)
            values[name] = _value(ev, argument, name)
            spans[name] = argument.span
        except Mistake as mistake:
            ev.report(mistake)
            mistaken = True
    kind = KINDS[node.kind]
    spec, maker = kind(**values), MAKERS[kind]  # type: ignore[arg-type]
    wrong = list(wrong_numbers(spec)) or ([] if mistaken else list(maker.wrong(spec)))
    for error in wrong:
        ev.report(BAD_MAP.at(spans.get(error.argument, node.span), message=error.message, cure=error.cure))
    if mistaken or wrong:
        good = {name: value for name, value in values.items() if name not in [error.argument for error in wrong]}
        _go_on(ev, node, {**({} if _knows_lengths(node, good) else _ROOMY[node.kind]), **good})
        raise Mistake
    return spec


_ROOMY: Mapping[str, Mapping[str, float | bool]] = MappingProxyType(
    {"intersection": {"approach": 500.0}, "road": {"length": 2000.0}, "roundabout": {"approach": 500.0}}
)
"""Lengths that replace unreadable arguments [m]: long enough that nothing is too far away."""


def _knows_lengths(node: nodes.Map, good: Container[str]) -> bool:
    """Return whether the lengths of the map that replaces a wrong one are those that the file gives."""
    meant = {nearest(each.name, MAP_ARGUMENTS[node.kind]) for each in node.arguments if each.name is not None}
    return all(name in good or name not in meant for name in _ROOMY[node.kind])


def _go_on(ev: Evaluator, node: nodes.Map, values: Mapping[str, float | bool | Places]) -> None:
    """Use the readable arguments for the map, so that later statements are not checked against another map."""
    kind = KINDS[node.kind]
    spec, maker = kind(**values), MAKERS[kind]  # type: ignore[arg-type]
    if not list(wrong_numbers(spec)) and not list(maker.wrong(spec)):
        ev.run.built.network = network_for(ev, spec, node.span)


def _name(kind: str, argument: Given, known: Container[str]) -> str:
    """The name of an argument.

    Raises:
        Mistake: it has none, the map has no such argument, or it was given before.
    """
    if argument.name is None:
        raise NOT_SUPPORTED.mistake(
            argument.span,
            what="`map` takes its arguments by name",
            reason="",
            cure="as in `ways=4, lane_width=3.5 m`, with a point for decimals",
        )
    if argument.name not in MAP_ARGUMENTS[kind]:
        raise UNKNOWN_ARGUMENT.mistake(
            argument.place,
            function=f"map {kind}",
            name=argument.name,
            suggestion=did_you_mean(argument.name, MAP_ARGUMENTS[kind]),
        )
    if argument.name in known:
        raise DUPLICATE.mistake(argument.place, what="the argument", name=argument.name)
    return argument.name


def _value(ev: Evaluator, argument: Given, name: str) -> float | bool | Places:
    what = f"`{name}` of the map"
    if name == PLACES:
        if isinstance(argument.value, Truth):
            return known_truth(ev, argument.value, argument.span, what, may_vary=False)
        items = items_of(argument.value, argument.span, what)
        return tuple(_number(ev, Given(each, argument.span), LENGTH, what) for each in items)
    if name in WHOLE:
        return whole_number(ev, argument.value, argument.span, what, may_vary=False)
    if name in TRUTHS:
        return known_truth(ev, argument.value, argument.span, what, may_vary=False)
    dimension = DIMENSIONS.get(name, LENGTH)
    if isinstance(argument.value, Truth):
        quantity(argument.value, argument.span, what, f"give a number, as in `{name}={example(dimension)}`")
    return _number(ev, argument, dimension, what)


def _number(ev: Evaluator, argument: Given, dimension: Dimension, what: str) -> float:
    expr = adopt(ev, argument.value, dimension, argument.span, what)
    value = ev.constant(Quantity(expr, dimension), argument.span, what, may_vary=False)
    if not math.isfinite(value):
        raise NOT_FINITE.mistake(argument.span, reason=f"{what} is {value}")
    return value
