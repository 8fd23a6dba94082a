"""Blocks of buildings between the arms: beside the road, as far back from it as is asked, in every city block once."""

import math
from dataclasses import replace

import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from engine.maps import RoadSpec
from engine.road import RoadError, build_network
from engine.road.grid import Grid
from engine.tables import ROAD_REGION
from tests.engine.interchange.opendrive.reading_back import specs
from tests.laws import examples

few = examples(25)


def blocks(spec: RoadSpec) -> list[shapely.Polygon]:
    return [
        shapely.box(x - length / 2, y - width / 2, x + length / 2, y + width / 2)
        for x, y, _, length, width in build_network(spec).buildings.tolist()
    ]


@few
@given(spec=specs(), setback=st.floats(0.0, 12.0))
def test_blocks_stand_beside_the_road(spec: RoadSpec, setback: float) -> None:
    """None touches the road or another one, and each is as far from the straight kerbs as is asked."""
    spec = replace(spec, buildings=setback)
    try:
        found = blocks(spec)
    except RoadError:
        assume(False)
    triangles = build_network(spec).regions.shape(ROAD_REGION).triangles
    road = shapely.union_all([shapely.Polygon(corners.reshape(3, 2)) for corners in triangles])
    bands = shapely.union_all([shapely.box(*band) for band in Grid(spec).bands()])
    sites = spec.rows * spec.cols
    corners = spec.rows * (spec.cols + 1) if spec.ways == 3 else (spec.rows + 1) * (spec.cols + 1)
    assert len(found) == (corners if sites > 1 else 2 if spec.ways == 3 else 4)
    for number, block in enumerate(found):
        assert block.intersection(road).area < 1e-6
        assert block.distance(bands) == pytest.approx(setback, abs=1e-9)
        assert all(block.intersection(other).area == 0.0 for other in found[:number])


@pytest.mark.parametrize("radius", [1.0, 6.0, 15.0])
def test_the_least_setback_touches_the_corner(radius: float) -> None:
    """A block may come to the arc at its corner, and no farther."""
    least = radius * (1.0 - math.sqrt(0.5))
    build_network(RoadSpec(corner_radius=radius, buildings=least + 1e-9))
    with pytest.raises(RoadError, match="stand on the road"):
        build_network(RoadSpec(corner_radius=radius, buildings=least - 1e-6))


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1.0, 1e4])
def test_lengths_that_no_block_has(wrong: float) -> None:
    with pytest.raises(RoadError, match="buildings"):
        build_network(RoadSpec(buildings=wrong))


def test_without_there_are_none() -> None:
    assert build_network(RoadSpec()).buildings.shape == (0, 5)
