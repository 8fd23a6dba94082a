"""Regions of all surfaces of some kinds, made when they are first used."""

from collections.abc import Collection
from weakref import WeakKeyDictionary

import numpy as np

from engine.errors import InterchangeError
from engine.maps import Street
from engine.road.network import Network, Surface, SurfaceKind
from engine.road.regions import shape_of_parts
from engine.road.specification import setback
from engine.tables import ROAD_REGION

CARRIAGEWAY = (SurfaceKind.SHOULDER, SurfaceKind.PARKING, SurfaceKind.BIKE_LANE)
"""Kinds between the lanes of motor vehicles and the kerb."""
WALKABLE = (SurfaceKind.SIDEWALK, SurfaceKind.CROSSING)

_made: WeakKeyDictionary[Network, dict[tuple[frozenset[SurfaceKind], bool], int | None]] = WeakKeyDictionary()


def region_of_kinds(network: Network, kinds: Collection[SurfaceKind], *, with_road: bool = False) -> int | None:
    """Return the id of the region of all surfaces of some kinds, and of the road; None if it is empty."""
    made = _made.setdefault(network, {})
    key = frozenset(kinds), with_road
    if key not in made:
        made[key] = _region(network, [each for each in network.surfaces if each.kind in kinds], with_road=with_road)
    return made[key]


def _region(network: Network, surfaces: list[Surface], *, with_road: bool) -> int | None:
    if not surfaces:
        return ROAD_REGION if with_road else None
    if with_road and network.between_kerbs is not None:
        return network.regions.add(network.between_kerbs)
    shapes = [each.shape for each in surfaces] + [network.regions.shape(ROAD_REGION)] * with_road
    if all(each.kind is SurfaceKind.CURB for each in surfaces):
        # Lines have no common area.
        parts = np.vstack([each.edges for each in shapes]), np.vstack([each.triangles for each in shapes])
        return network.regions.add(shape_of_parts(*parts))
    from engine.road.opendrive.surfaces import NoSurface, merged

    try:
        return surfaces[0].region if len(shapes) == 1 else network.regions.add(merged(shapes))
    except NoSurface:
        what = f"the area of the {surfaces[0].kind.value.replace('_', ' ')}s of this map cannot be computed"
        raise InterchangeError(what, "name a single element, such as one of `network.sidewalks`") from None


def surface_at(network: Network, kinds: Collection[SurfaceKind], x: float, y: float) -> Surface | None:
    """Return the first surface of some kinds at a point; None without one."""
    found = (each for each in network.surfaces if each.kind in kinds)
    return next((each for each in found if each.contains(x, y)), None)


def vehicle_region(network: Network) -> int:
    """Return the id of the region in which vehicles may start: the road, and all up to its kerbs."""
    spec = network.spec
    if not setback(spec) if isinstance(spec, Street) else network.between_kerbs is None:
        return ROAD_REGION
    region = region_of_kinds(network, CARRIAGEWAY, with_road=True)
    assert region is not None
    return region
