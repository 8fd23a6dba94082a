"""Words for the strips beside the lanes of a road and its crossings: the map argument that makes each of them."""

from collections.abc import Mapping
from typing import Any

from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.syntax import nodes
from engine.road.network import LANE_TYPES, SurfaceKind

MADE_BY: Mapping[SurfaceKind, str] = {
    SurfaceKind.SIDEWALK: "sidewalk=2 m",
    SurfaceKind.SHOULDER: "shoulder=1.5 m",
    SurfaceKind.PARKING: "parking=2 m",
    SurfaceKind.BIKE_LANE: "bike_lane=1.8 m",
    SurfaceKind.CROSSING: "sidewalk=2 m, crossings=True",
}
"""Arguments of a `map` line by the kind of surface that they make; every road has kerbs."""

OUTSIDE: Mapping[SurfaceKind, tuple[str, ...]] = {
    **LANE_TYPES,
    SurfaceKind.SHOULDER: (*LANE_TYPES[SurfaceKind.SHOULDER], *LANE_TYPES[SurfaceKind.PARKING]),
    SurfaceKind.CROSSING: ("crosswalk",),
}
"""Types of lanes, and of objects, from which the region of a kind is read in OpenDRIVE."""

_SIDEWALK: Mapping[str, Any] = {"sidewalk": 2.0}
_NEEDS: tuple[tuple[tuple[str, ...], Mapping[str, Any]], ...] = (
    (("sidewalk", "_sidewalk", "sidewalks", "sidewalkRegion", "walkableRegion"), _SIDEWALK),
    (("shoulder", "_shoulder", "shoulders", "shoulderRegion"), {"shoulder": 1.5}),
    (("crossing", "crossings", "crossingRegion"), {**_SIDEWALK, "crossings": True}),
    (("bikeLane", "_bikeLane", "bikeLanes"), {"bike_lane": 1.8}),
    (("parking",), {"parking": 2.0}),
)
"""Words, and the fields of the road of a file without `map` that they need."""


def street_of(module: nodes.Module) -> Mapping[str, Any]:
    """Return the fields of the road that a file without `map` needs for the strips and crossings that it names."""
    every = tuple(everything_in(module))
    own = {target for node in every for target in getattr(node, "targets", ())}
    own |= {node.name for node in every if isinstance(node, nodes.Parameter | nodes.PropertyDefault)}
    names = {node.id for node in every if isinstance(node, nodes.Name)}
    names |= {node.name for node in every if isinstance(node, nodes.Attribute)}
    found: dict[str, Any] = {}
    for words, needed in _NEEDS:
        if not (names - own).isdisjoint(words):
            found |= needed
    people = (node for node in every if isinstance(node, nodes.New) and node.class_name == "Pedestrian")
    if any(isinstance(node, nodes.Model) for node in every) and not all(map(_is_placed, people)):
        found |= _SIDEWALK
    return found


def _is_placed(node: nodes.New) -> bool:
    return any(not isinstance(each, nodes.With | nodes.Facing) or _is_position(each) for each in node.specifiers)


def _is_position(specifier: nodes.Specifier) -> bool:
    return isinstance(specifier, nodes.With) and specifier.property == "position"
