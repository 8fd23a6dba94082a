"""Lanelets are our lanes, and fit together to the last bit."""

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from hypothesis import given

from engine.interchange.commonroad.road import Ids, Lanelet, add_road, lanelets
from engine.maps import RoadSpec
from engine.road import LaneRole, build_network
from engine.road.opendrive.network import map_file
from engine.road.sections import to_left, to_right
from tests.engine.interchange.opendrive.reading_back import specs
from tests.laws import examples

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"
few = examples(25)


def made(spec: RoadSpec) -> tuple[Lanelet, ...]:
    return lanelets(build_network(spec))


@few
@given(specs())
def test_bounds_are_half_a_width_from_the_centre_line(spec: RoadSpec) -> None:
    """On their side, in the lane's direction, as many points on the one as on the other."""
    for lanelet in made(spec):
        lane, paths = lanelet.lane, lanelet.lane.network.paths
        count = len(lanelet.left)
        assert count == len(lanelet.right) >= 2
        for i, (left, right) in enumerate(zip(lanelet.left, lanelet.right, strict=True)):
            pose = paths.pose(lane.path, lane.length * i / (count - 1))
            for point, side in ((left, 1.0), (right, -1.0)):
                away = side * 0.5 * lane.width
                expected = (pose.x - away * math.sin(pose.heading), pose.y + away * math.cos(pose.heading))
                assert point == pytest.approx(expected, abs=2e-6)


@few
@given(specs())
def test_neighbours_share_a_bound(spec: RoadSpec) -> None:
    """Exactly the same points, reversed where the neighbour runs the other way; and each knows the other."""
    made_of = made(spec)
    for lanelet in made_of:
        for beside, bound, is_left in (
            (lanelet.beside_left, lanelet.left, True),
            (lanelet.beside_right, lanelet.right, False),
        ):
            if beside is None:
                continue
            other = made_of[beside.lane]
            theirs = other.right if is_left == beside.same_direction else other.left
            assert np.array_equal(bound, theirs if beside.same_direction else theirs[::-1])
            back = other.beside_right if is_left == beside.same_direction else other.beside_left
            assert back is not None
            assert back.lane == lanelet.lane.id


@few
@given(specs())
def test_successors_start_where_a_lane_ends(spec: RoadSpec) -> None:
    """With both bounds, exactly."""
    made_of = made(spec)
    for lanelet in made_of:
        for successor in lanelet.lane.successors:
            after = made_of[successor.id]
            assert np.array_equal(lanelet.left[-1], after.left[0])
            assert np.array_equal(lanelet.right[-1], after.right[0])


@examples(10)
@given(specs())
def test_neighbours_are_those_of_the_language(spec: RoadSpec) -> None:
    """The same lanes as `LaneSection` has to its left and right."""
    for lanelet in made(spec):
        for beside, expected in (
            (lanelet.beside_left, to_left(lanelet.lane)),
            (lanelet.beside_right, to_right(lanelet.lane)),
        ):
            assert (None if beside is None else beside.lane) == (None if expected is None else expected.id)


def test_left_hand_traffic_has_its_middle_on_the_right() -> None:
    """The kerb of a road lane is on the left there."""
    for left_hand in (False, True):
        for lanelet in made(RoadSpec(left_hand=left_hand)):
            if lanelet.lane.role is not LaneRole.CONNECTING:
                middle, kerb = lanelet.beside_left, lanelet.beside_right
                assert (middle is None) == left_hand
                assert (kerb is None) != left_hand


def test_lanes_of_a_file_have_its_borders() -> None:
    """On both sides of the centre line, also where they widen; ends meet, and neighbours know each other."""
    network = build_network(map_file(VILLAGE, "village.xodr"))
    made_of = lanelets(network)
    widths: set[float] = set()
    for lanelet in made_of:
        assert len(lanelet.left) == len(lanelet.right) >= 2
        for left, right in zip(lanelet.left, lanelet.right, strict=True):
            x, y = 0.5 * (left + right)
            path = lanelet.lane.path
            pose = network.paths.pose(path, network.paths.project(path, x, y))
            assert network.paths.distance(path, x, y) < 0.02
            aside = [
                (p[1] - pose.y) * math.cos(pose.heading) - (p[0] - pose.x) * math.sin(pose.heading)
                for p in (left, right)
            ]
            assert aside[0] >= 0.0 >= aside[1]
            widths.add(round(aside[0] - aside[1], 1))
        for successor in lanelet.lane.successors:
            after = made_of[successor.id]
            assert np.hypot(*(lanelet.left[-1] - after.left[0])) < 0.02
            assert np.hypot(*(lanelet.right[-1] - after.right[0])) < 0.02
        for beside, is_left in ((lanelet.beside_left, True), (lanelet.beside_right, False)):
            if beside is not None:
                other = made_of[beside.lane]
                back = other.beside_right if is_left == beside.same_direction else other.beside_left
                assert back is not None
                assert back.lane == lanelet.lane.id
    assert len(widths) > 2
    assert any(lanelet.beside_left is not None for lanelet in made_of)


def test_strips_and_crossings_are_lanelets_of_their_types() -> None:
    """Behind all others, with bounds of their width, and with a number that no actor has."""
    plain = RoadSpec(lanes=2)
    street = replace(plain, sidewalk=2.0, bike_lane=1.8, parking=2.2, crossings=True)
    network, root = build_network(street), Element("commonRoad")
    add_road(root, Ids(network), None, 0.1)
    found = Counter(each.findtext("laneletType") for each in root.iter("lanelet"))
    assert (found["sidewalk"], found["bicycleLane"], found["shoulder"], found["crosswalk"]) == (12, 8, 8, 4)
    numbers = [int(each.get("id", "")) for each in root]
    assert len(set(numbers)) == len(numbers)
    assert Ids(network).actor(0) > max(numbers)
    for each in root.iter("lanelet"):
        left, right = (
            np.array([[float(point.findtext(axis, "")) for axis in "xy"] for point in each.iterfind(f"{bound}/point")])
            for bound in ("leftBound", "rightBound")
        )
        assert len(left) == len(right) >= 2
        if each.findtext("laneletType") == "bicycleLane":
            assert np.hypot(*(left - right).T) == pytest.approx(1.8)
    bare = Element("commonRoad")
    add_road(bare, Ids(build_network(plain)), None, 0.1)
    assert not {"sidewalk", "crosswalk"} & {each.findtext("laneletType") for each in bare.iter("lanelet")}
