"""Words for the strips beside the lanes of a road and its crossings: the map argument that makes each of them."""

from collections.abc import Mapping
from typing import Any

from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.syntax import nodes
from engine.road.network import LANE_TYPES, SurfaceKind

_USUAL: Mapping[str, float | bool] = {
    "sidewalk": 2.0,
    "shoulder": 1.5,
    "parking": 2.0,
    "bike_lane": 1.8,
    "crossings": True,
}
"""Arguments of a `map` line that make surfaces, with usual values [m]."""
_MAKERS: Mapping[SurfaceKind, tuple[str, ...]] = {
    SurfaceKind.SIDEWALK: ("sidewalk",),
    SurfaceKind.SHOULDER: ("shoulder",),
    SurfaceKind.PARKING: ("parking",),
    SurfaceKind.BIKE_LANE: ("bike_lane",),
    SurfaceKind.CROSSING: ("sidewalk", "crossings"),
}
"""Arguments by the kind of surface that they make; every road has kerbs."""
MADE_BY: Mapping[SurfaceKind, str] = {
    kind: ", ".join(
        f"{name}={_USUAL[name]}" if _USUAL[name] is True else f"{name}={_USUAL[name]:g} m" for name in names
    )
    for kind, names in _MAKERS.items()
}
"""The same as text."""

OUTSIDE: Mapping[SurfaceKind, tuple[str, ...]] = {
    **LANE_TYPES,
    SurfaceKind.SHOULDER: (*LANE_TYPES[SurfaceKind.SHOULDER], *LANE_TYPES[SurfaceKind.PARKING]),
    SurfaceKind.CROSSING: ("crosswalk",),
}
"""Types of lanes, and of objects, from which the region of a kind is read in OpenDRIVE."""

_WORDS: Mapping[SurfaceKind, tuple[str, ...]] = {
    SurfaceKind.SIDEWALK: ("sidewalk", "_sidewalk", "sidewalks", "sidewalkRegion", "walkableRegion"),
    SurfaceKind.SHOULDER: ("shoulder", "_shoulder", "shoulders", "shoulderRegion"),
    SurfaceKind.CROSSING: ("crossing", "crossings", "crossingRegion"),
    SurfaceKind.BIKE_LANE: ("bikeLane", "_bikeLane", "bikeLanes"),
    SurfaceKind.PARKING: ("parking",),
}
"""Words by the kind of surface that they need."""


def _fields(kind: SurfaceKind) -> dict[str, Any]:
    """Return the fields of the road of a file without `map` that needs surfaces of a kind."""
    return {name: _USUAL[name] for name in _MAKERS[kind]}


def street_of(module: nodes.Module) -> Mapping[str, Any]:
    """Return the fields of the road that a file without `map` needs for the strips and crossings that it names."""
    every = tuple(everything_in(module))
    own = {target for node in every for target in getattr(node, "targets", ())}
    own |= {node.name for node in every if isinstance(node, nodes.Parameter | nodes.PropertyDefault)}
    names = {node.id for node in every if isinstance(node, nodes.Name)}
    names |= {node.name for node in every if isinstance(node, nodes.Attribute)}
    found: dict[str, Any] = {}
    for kind, words in _WORDS.items():
        if not (names - own).isdisjoint(words):
            found |= _fields(kind)
    people = (node for node in every if isinstance(node, nodes.New) and node.class_name == "Pedestrian")
    if any(isinstance(node, nodes.Model) for node in every) and not all(map(_is_placed, people)):
        found |= _fields(SurfaceKind.SIDEWALK)
    return found


def _is_placed(node: nodes.New) -> bool:
    return any(not isinstance(each, nodes.With | nodes.Facing) or _is_position(each) for each in node.specifiers)


def _is_position(specifier: nodes.Specifier) -> bool:
    return isinstance(specifier, nodes.With) and specifier.property == "position"
