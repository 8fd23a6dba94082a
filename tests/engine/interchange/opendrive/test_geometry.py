"""Roads as OpenDRIVE lie where ours do."""

import cmath
import math
from itertools import pairwise

import numpy as np
from hypothesis import given, settings

from engine.interchange.opendrive import road_map, write_opendrive
from engine.program import RoadSpec
from engine.road import LaneRole
from tests.engine.interchange.opendrive.reading_back import Document, number, only, specs

few = settings(max_examples=25, deadline=None)


def written(spec: RoadSpec) -> Document:
    return Document(write_opendrive(spec, None, "road"))


@few
@given(specs())
def test_lane_centres_are_our_paths(spec: RoadSpec) -> None:
    """Every lane, evaluated as the standard says, runs along our path, with its traffic; `place` says where."""
    document, roads = written(spec), road_map(spec)
    for lane in roads.network.lanes:
        for along in np.linspace(0.0, lane.length, 7).tolist():
            pose, place = roads.network.paths.pose(lane.path, along), roads.place(lane.id, along)
            read = document.place(*place)
            assert abs(read.point - complex(pose.x, pose.y)) < 1e-9
            assert abs(math.remainder(read.heading - pose.heading, math.tau)) < 1e-9


@few
@given(specs())
def test_every_lane_is_one_of_ours(spec: RoadSpec) -> None:
    """No lane of the document is left over, none stands for two."""
    document, roads = written(spec), road_map(spec)
    ours = [(place.road, place.lane) for place in roads.places]
    assert len(set(ours)) == len(ours)
    assert set(ours) == {(road, lane) for road in document.roads for lane in document.lane_ids(road) if lane}


@few
@given(specs())
def test_reference_lines_are_continuous(spec: RoadSpec) -> None:
    """Each piece starts at the length and pose at which the one before it ends; the last ends with the road."""
    document = written(spec)
    for name, road in document.roads.items():
        pieces = road.findall("planView/geometry")
        assert number(pieces[0], "s") == 0.0
        for piece, following in pairwise(pieces):
            end = number(piece, "s") + number(piece, "length")
            assert end == number(following, "s")
            point, heading = document.reference(name, np.nextafter(end, 0.0))
            assert abs(point - complex(number(following, "x"), number(following, "y"))) < 1e-9
            assert abs(math.remainder(heading - number(following, "hdg"), math.tau)) < 1e-9
        assert abs(number(pieces[-1], "s") + number(pieces[-1], "length") - number(road, "length")) < 1e-9
        assert {shape.tag for piece in pieces for shape in piece} <= {"line", "arc"}


@few
@given(specs())
def test_lanes_meet_where_they_are_linked(spec: RoadSpec) -> None:
    """A turn begins and ends at the middle of the lanes that it links, with their headings and widths."""
    document = written(spec)
    for name, road in document.roads.items():
        if road.attrib["junction"] == "-1":
            continue
        (lane,) = (lane for lane in document.lane_ids(name) if lane)
        for end, s in (("predecessor", 0.0), ("successor", number(road, "length"))):
            other, neighbour = (
                only(road, f"link/{end}"),
                int(number(only(document.lane(name, lane), f"link/{end}"), "id")),
            )
            at_end = other.attrib["contactPoint"] == "end"
            there = other.attrib["elementId"]
            met = document.place(there, neighbour, number(document.roads[there], "length") if at_end else 0.0)
            here = document.place(name, lane, s)
            assert abs(met.point - here.point) < 1e-9
            assert abs(cmath.exp(1j * met.heading) - cmath.exp(1j * here.heading)) < 1e-9


@few
@given(specs())
def test_bounds_hold_the_road(spec: RoadSpec) -> None:
    """The header says how far the road reaches."""
    document, roads = written(spec), road_map(spec)
    header = only(document.root, "header")
    corners = np.vstack([roads.network.paths.points(lane.path) for lane in roads.network.lanes])
    west, south, east, north = (number(header, side) for side in ("west", "south", "east", "north"))
    assert (corners >= np.array([west, south]) - 1e-9).all()
    assert (corners <= np.array([east, north]) + 1e-9).all()


def test_places_run_against_the_road_on_the_other_side() -> None:
    """Traffic that leaves an arm comes from where its road ends."""
    roads = road_map(RoadSpec(approach=50.0))
    lanes = {lane.name: lane.id for lane in roads.network.lanes}
    coming, leaving = (roads.place(lanes[f"north.{way}.1"], 10.0) for way in ("in", "out"))
    assert coming.road == leaving.road
    assert (coming.lane, coming.s) == (-1, 10.0)
    assert (leaving.lane, leaving.s) == (1, 40.0)
    assert all(roads.places[lane.id].forward for lane in roads.network.lanes if lane.role is LaneRole.CONNECTING)
