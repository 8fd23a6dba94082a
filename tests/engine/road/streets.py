"""Roads of every kind with strips beside their lanes, for the laws of streets."""

from collections.abc import Callable

import numpy as np
import shapely
from hypothesis import assume
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from engine.maps import LoneRoad, RoadSpec, Roundabout
from engine.road.build import MAKERS, wrong_numbers
from engine.road.regions import Shape

DrawnSpec = RoadSpec | LoneRoad | Roundabout
Widths = st.none() | st.floats(0.5, 2.5)


@st.composite
def streets(draw: Callable, kinds: tuple[str, ...] = ("intersection", "road", "roundabout")) -> DrawnSpec:
    """Specifications that fit, with any strips and crossings."""
    sidewalk = draw(st.none() | st.floats(0.5, 5.0))
    bike, parking = draw(st.none() | st.floats(0.8, 3.0)), draw(st.none() | st.floats(1.8, 5.5))
    strips = {
        "sidewalk": sidewalk,
        "shoulder": draw(st.none() | st.floats(0.2, 3.0)),
        "bike_lane": bike,
        "bike_lane_behind_parking": draw(st.booleans()) and bike is not None and parking is not None,
        "parking": parking,
        "parked": 0.0 if parking is None else draw(st.floats(0.0, 1.0)),
        "crossing_width": draw(st.floats(1.0, 10.0)),
        "left_hand": draw(st.booleans()),
        "lanes": draw(st.integers(1, 3)),
    }
    kind, is_crossed = draw(st.sampled_from(kinds)), sidewalk is not None and draw(st.booleans())
    if kind == "intersection":
        ways, cols = draw(st.sampled_from([3, 4])), draw(st.integers(1, 2))
        spec: DrawnSpec = RoadSpec(**strips, ways=ways, cols=cols, block=150.0, crossings=is_crossed)
    elif kind == "roundabout":
        arms, radius = draw(st.integers(3, 5)), draw(st.floats(20.0, 60.0))
        spec = Roundabout(**strips, arms=arms, radius=radius, crossings=is_crossed)
    else:
        curve = draw(st.none() | st.floats(30.0, 500.0) | st.floats(-500.0, -30.0))
        places = (20.0, draw(st.floats(32.0, 80.0))) if is_crossed else ()
        one_way = draw(st.booleans())
        spec = LoneRoad(**strips, length=100.0, curve=curve, crossings=places, one_way=one_way)
    assume(not list(wrong_numbers(spec)) and not list(MAKERS[type(spec)].wrong(spec)))
    return spec


def polygon(shape: Shape) -> BaseGeometry:
    """The area of a region by its triangles, which its boundary does not influence."""
    tiles = np.asarray(shapely.polygons(shape.triangles.reshape(-1, 3, 2)))
    return shapely.union_all(tiles[shapely.area(tiles) > 1e-9])
