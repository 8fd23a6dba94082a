"""`always` on the distance of two that can touch: a run ends at first contact, between two samples."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.quantities.units import UNITS
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig

FASTEST = 60.0
"""Nothing here closes faster [m/s]."""
LONGEST = 5.0
"""Centres of two cars that touch are no further apart [m]."""
_SEEN_FROM: Mapping[str, str] = MappingProxyType({">": "left", ">=": "left", "<": "right", "<=": "right"})
"""On which side of a sign a distance is kept large."""


def contacts(module: nodes.Module, time_step: float | None) -> Iterator[Diagnostic]:
    """A warning for each such distance that contact can pass by."""
    step = time_step or SimulationConfig().time_step
    things = _objects(module)
    for node in everything_in(module):
        if isinstance(node, nodes.Temporal) and node.operator == "always":
            for part in everything_in(node):
                if isinstance(part, nodes.Compare) and (found := _kept_apart(part)) is not None:
                    yield from _remark(part, *found, things, step)


def _objects(module: nodes.Module) -> frozenset[str]:
    """Names of what can be struck."""
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


def _remark(
    node: nodes.Compare, distance: nodes.Distance, limit: float, things: frozenset[str], step: float
) -> Iterator[Diagnostic]:
    origin, target = distance.origin or nodes.Name("ego", span=distance.span), distance.target
    if not (isinstance(origin, nodes.Name) and isinstance(target, nodes.Name) and {origin.id, target.id} <= things):
        return
    outlines = distance.between_outlines
    if limit >= (FASTEST * step if outlines else LONGEST):
        return
    speed = f"{limit / step * 3.6:.3g} km/h"
    yield errors.CONTACT_UNSEEN.at(
        node.span,
        one=origin.id,
        other=target.id,
        reason=f"they close by {limit:g} m within one step at {speed}, and contact between two samples ends the run"
        if outlines
        else "it is the distance of centres, and outlines touch while those are further apart",
        cure=f"minimum distance from {origin.id} to {target.id}) > 0.1 m + {2 * step:.3g} s * "
        f"({origin.id}.speed + {target.id}.speed",
    )
