"""Correct but unintended ways of writing.

`EGO_SPEED + 10` with a param in km/h adds 10 m/s, 36 km/h: a bare number added to, or compared with, a value that the
file itself writes in a unit other than SI. `always` on the distance of two actors that can touch: a run ends at first
contact, between two samples. An object placed at random on a lane with a `require` that selects a window of it: `before
… by` samples only the window.
"""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from types import MappingProxyType

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics.errors.names import CONTACT_UNSEEN, WINDOW
from cortex_dsl.semantics.errors.values import BARE_BESIDE_UNIT
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.semantics.quantities.units import UNITS, Unit, si_word
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.frozen import frozen

SUMS = ("+", "-")
THROUGH = ("abs", "min", "max")
"""Functions with a result in the unit of their arguments."""


def bare_numbers(module: nodes.Module, genes: Iterable[ir.GeneInfo]) -> Iterator[Diagnostic]:
    params = {gene.name: gene for gene in genes}
    for node in everything_in(module):
        for one, other in _pairs(node):
            for bare, partner in ((one, other), (other, one)):
                number = _bare(bare)
                written = next(_units(partner, params), None)
                if number and written is not None:
                    yield _in_other_unit(bare.span, number, *written)


def _pairs(node: nodes.Node) -> Iterator[tuple[nodes.Expression, nodes.Expression]]:
    """Yield the pairs of operands of a sum or comparison."""
    if isinstance(node, nodes.Binary) and node.operator in SUMS:
        yield node.left, node.right
    if isinstance(node, nodes.Compare):
        sides = [node.first, *(side for _, side in node.rest)]
        yield from pairwise(sides)


def _bare(node: nodes.Expression) -> float | None:
    """The number, where nothing but one without a unit is written; 0 is 0 in every unit."""
    if isinstance(node, nodes.Unary) and node.operator in SUMS:
        number = _bare(node.operand)
        return None if number is None else -number if node.operator == "-" else number
    return node.value if isinstance(node, nodes.Number) and node.unit is None else None


def _units(node: nodes.Expression, genes: Mapping[str, ir.GeneInfo]) -> Iterator[tuple[Unit, Span]]:
    """Yield the units other than SI in the operands of an expression, each with its place."""
    match node:
        case nodes.Number(unit=str(word)) | nodes.WithUnit(unit=word):
            unit = UNITS.get(word)
        case nodes.Name(id=name) | nodes.Attribute(name=name) if name in genes:
            unit = UNITS.get(genes[name].unit)
        case _:
            unit = None
            for part in _summands(node):
                yield from _units(part, genes)
    if unit is not None and unit.factor != 1.0:
        yield unit, node.span


def _summands(node: nodes.Expression) -> Iterator[nodes.Expression]:
    match node:
        case nodes.Binary(operator=operator, left=left, right=right) if operator in SUMS:
            yield from (left, right)
        case nodes.Unary(operand=operand):
            yield operand
        case nodes.Call(function=nodes.Name(id=name), arguments=arguments) if name in THROUGH:
            yield from (argument.value for argument in arguments)


def _in_other_unit(span: Span, value: float, unit: Unit, place: Span) -> Diagnostic:
    return BARE_BESIDE_UNIT.at(
        span,
        secondary=(Label(place, f"in {unit.word}"),),
        value=value,
        si=si_word(unit.dimension),
        unit=unit.word,
        converted=value / unit.factor,
    )


# -- distances of two that can touch -----------------------------------------------------------------------------------

FASTEST = 60.0
"""Nothing here closes faster [m/s]."""
LONGEST = 5.0
"""Centres of two cars that touch are no further apart [m]."""
_SEEN_FROM: Mapping[str, str] = MappingProxyType({">": "left", ">=": "left", "<": "right", "<=": "right"})
"""Side of each comparison sign at which a distance is kept large."""


def contacts(module: nodes.Module, time_step: float | None) -> Iterator[Diagnostic]:
    """A warning for each such distance that contact can pass by."""
    step = time_step or SimulationConfig().time_step
    things = _objects(module)
    required = (
        node for owner in everything_in(module) if isinstance(owner, nodes.Require) for node in everything_in(owner)
    )
    for node in required:
        if isinstance(node, nodes.Temporal) and node.operator == "always":
            for part in everything_in(node):
                if isinstance(part, nodes.Compare) and (found := _kept_apart(part)) is not None:
                    yield from _unseen_contact(part, *found, things, step)


def _objects(module: nodes.Module) -> frozenset[str]:
    """Return the names of objects that can be struck."""
    return frozenset(
        name
        for node in everything_in(module)
        if isinstance(node, nodes.Assign) and isinstance(node.value, nodes.New)
        if node.value.class_name not in ("Point", "OrientedPoint")
        for name in node.targets
    )


def _kept_apart(node: nodes.Compare) -> tuple[nodes.Distance, float] | None:
    """The distance, and the length that it must exceed [m]."""
    if len(node.rest) != 1:
        return None
    operator, other = node.rest[0]
    distance, limit = (node.first, other) if _SEEN_FROM.get(operator) == "left" else (other, node.first)
    if operator not in _SEEN_FROM or not isinstance(distance, nodes.Distance) or not isinstance(limit, nodes.Number):
        return None
    unit = UNITS.get(limit.unit or "m")
    return None if unit is None else (distance, limit.value * unit.factor)


def _unseen_contact(
    node: nodes.Compare, distance: nodes.Distance, limit: float, things: frozenset[str], step: float
) -> Iterator[Diagnostic]:
    origin, target = distance.origin or nodes.Name("ego", span=distance.span), distance.target
    if not (isinstance(origin, nodes.Name) and isinstance(target, nodes.Name) and {origin.id, target.id} <= things):
        return
    outlines = distance.between_outlines
    if limit >= (FASTEST * step if outlines else LONGEST):
        return
    speed = f"{limit / step * 3.6:.3g} km/h"
    yield CONTACT_UNSEEN.at(
        node.span,
        one=origin.id,
        other=target.id,
        reason=f"they close by {limit:g} m within one step at {speed}, and contact between two samples ends the run"
        if outlines
        else "it is the distance of centres, and outlines touch while those are further apart",
        cure=f"minimum distance from {origin.id} to {target.id}) > 0.1 m + {2 * step:.3g} s * "
        f"({origin.id}.speed + {target.id}.speed",
    )


# -- windows that are drawn and then required --------------------------------------------------------------------------


@frozen
class _Window:
    """`low <= distance from NAME to REGION <= high`."""

    name: str
    region: nodes.Expression
    distance: str
    """Distance to write after `by`."""


def windows(module: nodes.Module, source: Source) -> Iterator[Diagnostic]:
    """A hint for each such `require`."""
    made = {
        statement.targets[0]: statement.value
        for statement in module.statements
        if isinstance(statement, nodes.Assign) and len(statement.targets) == 1
        if isinstance(statement.value, nodes.New)
    }
    for statement in module.statements:
        if isinstance(statement, nodes.Require) and (window := _window(statement.condition, source)) is not None:
            specifier = _drawn_on_a_lane(window.name, made)
            if specifier is not None and isinstance(specifier.region, nodes.Attribute):
                lane = source.slice(specifier.region.value.span)
                region = source.slice(window.region.span)
                yield WINDOW.at(
                    statement.condition.span,
                    secondary=(Label(specifier.span, "drawn anywhere on the lane"),),
                    name=window.name,
                    kind=made[window.name].class_name,
                    place=f"before {region} by {window.distance} along [{lane}]",
                )


def _drawn_on_a_lane(name: str, made: Mapping[str, nodes.New]) -> nodes.InRegion | None:
    """Return the `in lane.centerline` that places an object, itself or through the point at which it is placed."""
    for specifier in made[name].specifiers if name in made else ():
        match specifier:
            case nodes.InRegion(region=nodes.Attribute(name="centerline")):
                return specifier
            case nodes.At(position=nodes.Name(id=point)) if point != name:
                return _drawn_on_a_lane(point, made)
    return None


def _window(condition: nodes.Expression, source: Source) -> _Window | None:
    match condition:
        case nodes.Compare(
            first=nodes.Call(function=nodes.Name(id="abs"), arguments=(argument,)), rest=((sign, width),)
        ):
            return _around(argument.value, width, source) if sign in ("<", "<=") else None
        case nodes.Compare(first=low, rest=((first, nodes.Distance() as distance), (second, high))):
            if {first, second} <= {"<", "<="}:
                return _from_to(distance, f"Range({source.slice(low.span)}, {source.slice(high.span)})")
    return None


def _around(difference: nodes.Expression, width: nodes.Expression, source: Source) -> _Window | None:
    """Return the window of `abs(distance - middle) <= width`; None for another form."""
    if not isinstance(difference, nodes.Binary) or difference.operator != "-":
        return None
    sides = (difference.left, difference.right)
    for distance, middle in (sides, sides[::-1]):
        if isinstance(distance, nodes.Distance):
            centre, half = source.slice(middle.span), source.slice(width.span)
            return _from_to(distance, f"{centre} + Range(-{half}, {half})")
    return None


def _from_to(distance: nodes.Distance, drawn: str) -> _Window | None:
    if distance.between_outlines or not isinstance(distance.target, nodes.Name):
        return None
    if distance.origin is None:
        return _Window("ego", distance.target, drawn)
    return _Window(distance.origin.id, distance.target, drawn) if isinstance(distance.origin, nodes.Name) else None
