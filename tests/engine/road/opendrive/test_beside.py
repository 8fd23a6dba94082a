"""Lanes beside the driving lanes, and crossings, as a file has them."""

from pathlib import Path

import numpy as np
import pytest

from engine.road.network import Network, Surface, SurfaceKind
from tests.engine.road.opendrive.files import lane, network, road, section, written

KINDS = {
    "sidewalk": SurfaceKind.SIDEWALK,
    "walking": SurfaceKind.SIDEWALK,
    "curb": SurfaceKind.CURB,
    "shoulder": SurfaceKind.SHOULDER,
    "border": SurfaceKind.SHOULDER,
    "parking": SurfaceKind.PARKING,
    "biking": SurfaceKind.BIKE_LANE,
}


def of_type(number: int, kind: str, width: float = 2.0, b: float = 0.0) -> str:
    return lane(number, a=width, b=b).replace("driving", kind)


def of_kind(found: Network, kind: SurfaceKind) -> list[Surface]:
    return [each for each in found.surfaces if each.kind is kind]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("side", [-1, 1])
def test_each_type_is_the_element_of_its_name(tmp_path: Path, kind: str, side: int) -> None:
    """With its place, its area, and a centre line along the traffic beside it."""
    here = [lane(side), of_type(2 * side, kind)]
    sections = section(left=here) if side > 0 else section(right=here)
    found = network(written(tmp_path, road("1", sections)))
    (surface,) = of_kind(found, KINDS[kind])
    start, end = surface.ends_at
    assert surface.forward is (side < 0)
    assert (start.y, end.y) == pytest.approx((side * 4.5, side * 4.5))
    assert (start.x, end.x) == pytest.approx((50.0, 0.0) if side > 0 else (0.0, 50.0))
    assert surface.area == pytest.approx(100.0)
    assert surface.width == pytest.approx(2.0)
    assert found.unread == ""
    assert found.road_named["road1"] is surface.parent


def test_the_kerb_is_the_outer_border_of_the_carriageway(tmp_path: Path) -> None:
    """Of the shoulder, if there is one inside the sidewalk, else of the driving lane."""
    right = [lane(-1), of_type(-2, "shoulder", 1.0), of_type(-3, "sidewalk")]
    found = network(written(tmp_path, road("1", section(left=[lane(1)], right=right))))
    kerbs = {each.forward: each for each in of_kind(found, SurfaceKind.CURB)}
    assert kerbs[True].ends_at[0].y == pytest.approx(-4.5)
    assert kerbs[False].ends_at[0].y == pytest.approx(3.5)
    assert kerbs[True].length == kerbs[False].length == pytest.approx(50.0)


def test_a_sidewalk_goes_on_through_sections_and_ends_at_a_gap(tmp_path: Path) -> None:
    """Its number may change; where a section has none it ends."""
    walk = section(right=[lane(-1), of_type(-2, "sidewalk")], s=0.0)
    wide = section(right=[lane(-1), lane(-2), of_type(-3, "sidewalk")], s=20.0)
    bare = section(right=[lane(-1)], s=30.0)
    again = section(right=[lane(-1), of_type(-2, "sidewalk")], s=40.0)
    found = network(written(tmp_path, road("1", walk + wide + bare + again)))
    lengths = sorted(each.area / 2.0 for each in of_kind(found, SurfaceKind.SIDEWALK))
    assert lengths == pytest.approx([10.0, 30.0])
    longest = found.beside("road1", SurfaceKind.SIDEWALK, forward=True)
    assert longest is not None
    assert longest.area == pytest.approx(60.0)


def test_a_sidewalk_that_narrows_has_the_area_of_its_borders(tmp_path: Path) -> None:
    found = network(written(tmp_path, road("1", section(right=[lane(-1), of_type(-2, "sidewalk", 3.0, -0.06)]))))
    (walk,) = of_kind(found, SurfaceKind.SIDEWALK)
    assert walk.area == pytest.approx(75.0)  # a triangle
    assert walk.width == pytest.approx(1.5)


def test_a_strip_inside_a_tight_curve_has_the_area_that_it_covers(tmp_path: Path) -> None:
    """A sidewalk further in than the centre of the curve covers no place twice."""
    place = {"curvature": 1.0 / 5.0}
    right = road("1", section(left=[of_type(1, "sidewalk", 4.0)], right=[lane(-1)]), length=10.0, place=place)
    (walk,) = of_kind(network(written(tmp_path, right)), SurfaceKind.SIDEWALK)
    assert walk.area == pytest.approx(0.5 * 2.0 * (25.0 - 1.0), rel=5e-3)  # between radii of 5 m and 1 m, over 2 rad


# -- crossings ---------------------------------------------------------------------------------------------------------

WALKED = [lane(-1), of_type(-2, "sidewalk")], [lane(1), of_type(2, "sidewalk")]
CROSSING = '<object id="7" name="zebra" type="crosswalk" s="20" t="0" {0}>{1}</object>'


def crossed(folder: Path, about: str, inside: str = "") -> Network:
    text = road("1", section(left=WALKED[1], right=WALKED[0]))
    objects = f"<objects>{CROSSING.format(about, inside)}</objects></road>"
    return network(written(folder, text.replace("</road>", objects)))


def corners(kind: str, places: list[tuple[float, float]]) -> str:
    names = ("s", "t") if kind == "cornerRoad" else ("u", "v")
    rows = (f'<{kind} {names[0]}="{a}" {names[1]}="{b}"/>' for a, b in places)
    return f"<outline>{''.join(rows)}</outline>"


RING = [(18.0, -3.5), (22.0, -3.5), (22.0, 3.5), (18.0, 3.5)]
LOCAL = [(a - 20.0, b) for a, b in RING]
AROUND = [(b, 20.0 - a) for a, b in RING]
"""The same corners in the frame of an object that is turned by 90 degrees."""


@pytest.mark.parametrize(
    ("about", "inside"),
    [
        ("", corners("cornerRoad", RING)),
        ("", corners("cornerRoad", [*RING, RING[0]])),
        ("", corners("cornerLocal", LOCAL)),
        ('hdg="1.5707963267948966"', corners("cornerLocal", AROUND)),
        ("", f"<outlines>{corners('cornerLocal', LOCAL)}</outlines>"),
        ('length="4" width="7"', ""),
        ('hdg="1.5707963267948966" length="7" width="4"', ""),
        ('length="99" width="99"', corners("cornerRoad", RING)),
    ],
)
def test_a_crossing_has_its_outline_else_its_length_and_width(tmp_path: Path, about: str, inside: str) -> None:
    found = crossed(tmp_path, about, inside)
    (crossing,) = of_kind(found, SurfaceKind.CROSSING)
    ring = crossing.shape.edges[:, :2]
    np.testing.assert_allclose(sorted(ring.round(6).tolist()), sorted(RING), atol=1e-6)
    assert (crossing.length, crossing.width) == pytest.approx((7.0, 4.0))
    start, end = crossing.ends_at
    assert (start.y, end.y) == pytest.approx((-3.5, 3.5))
    walks = of_kind(found, SurfaceKind.SIDEWALK)
    assert crossing.sidewalks == tuple(sorted(walks, key=lambda each: each.ends_at[0].y))
    assert crossing.parent is found.road_named["road1"]
    assert found.unread == ""
    assert not found.remarks


@pytest.mark.parametrize(
    ("about", "inside"),
    [
        ("", corners("cornerRoad", RING[:2])),
        ("", corners("cornerRoad", [RING[0], RING[0], RING[1], RING[1]])),
        ("", corners("cornerRoad", [(18.0, float("nan")), *RING[1:]])),
        ("", corners("cornerRoad", [(900.0, 0.0), *RING[1:]])),
        ("", ""),
        ('length="nan" width="7"', ""),
        ("", corners("cornerRoad", [(18.0, 0.0), (19.0, 0.0), (22.0, 0.0)])),
    ],
)
def test_a_crossing_without_an_area_is_left_out_with_a_remark(tmp_path: Path, about: str, inside: str) -> None:
    """Which names its place or its name; the road is read all the same."""
    found = crossed(tmp_path, about, inside)
    assert not of_kind(found, SurfaceKind.CROSSING)
    assert len(of_kind(found, SurfaceKind.SIDEWALK)) == 2
    (remark,) = found.remarks
    assert "crossing" in remark
    assert "road.xodr" in remark or "zebra" in remark


def test_a_crossing_beside_no_sidewalk_has_none_at_that_end(tmp_path: Path) -> None:
    objects = f"<objects>{CROSSING.format('', corners('cornerRoad', RING))}</objects></road>"
    text = road("1", section(left=[lane(1)], right=WALKED[0])).replace("</road>", objects)
    (crossing,) = of_kind(network(written(tmp_path, text)), SurfaceKind.CROSSING)
    start, end = crossing.sidewalks
    assert start is not None
    assert end is None


def test_vehicles_may_start_on_the_shoulder_of_a_file(tmp_path: Path) -> None:
    right = [lane(-1), of_type(-2, "shoulder"), of_type(-3, "sidewalk")]
    found = network(written(tmp_path, road("1", section(right=right))))
    assert found.between_kerbs is not None
    edges = found.between_kerbs.edges[:, :2]
    assert np.ptp(edges, axis=0) == pytest.approx([50.0, 5.5], abs=1e-5)
    plain = network(written(tmp_path, road("1", section(right=[lane(-1)]))))
    assert plain.between_kerbs is None
