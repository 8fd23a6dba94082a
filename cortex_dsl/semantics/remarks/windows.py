"""An object drawn anywhere on a lane, and a `require` that keeps a window of it: `before … by` draws only what fits."""

from collections.abc import Iterator, Mapping

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics import errors
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes
from engine.frozen import frozen


@frozen
class _Window:
    """`low <= distance from NAME to REGION <= high`."""

    name: str
    region: nodes.Expression
    distance: str
    """What to write behind `by`."""


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
                yield errors.WINDOW.at(
                    statement.condition.span,
                    secondary=(Label(specifier.span, "drawn anywhere on the lane"),),
                    name=window.name,
                    kind=made[window.name].class_name,
                    place=f"before {region} by {window.distance} along [{lane}]",
                )


def _drawn_on_a_lane(name: str, made: Mapping[str, nodes.New]) -> nodes.InRegion | None:
    """The `in lane.centerline` that places an object, itself or through the point that it stands at."""
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
    """Of `abs(distance - middle) <= width`."""
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
