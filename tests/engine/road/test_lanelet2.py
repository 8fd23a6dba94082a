"""Lanelet2 maps: the lanelets, references and rules of the package, in a network. Without the package: skipped.

`CORTEXC_LANELET2_MAPS` names a folder with public maps (`*.osm`), each at the origin in `ORIGINS` or by local tags.
"""

import math
import os
import re
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from engine.errors import InterchangeError
from engine.maps import LaneletFile, digest_of, map_content, map_from
from engine.road.lanelet2.fitting import TOLERANCE
from engine.road.network import LaneRole, Network, SurfaceKind
from engine.road.opendrive.surfaces import NoSurface
from engine.vocabulary import LEVEL, ManeuverType
from tests.engine.road.lanelet_maps import ARMS, FAR, NEAR, ORIGIN, Writer, bridge, crossing
from tests.laws import examples

pytest.importorskip("lanelet2", reason="needs cortexc[lanelet2]")
ORIGINS = {"mapping_example": ORIGIN}


def network_of(path: Path, origin: tuple[float, float] | None = None) -> Network:
    from engine.road.lanelet2.making import built

    return built(LaneletFile(path.name, str(path), digest_of(path), 0, origin))


def written(folder: Path, osm: str) -> Path:
    path = folder / "map.osm"
    path.write_text(osm)
    return path


def _module(name: str) -> Any:
    return import_module(f"lanelet2.{name}")


def projector() -> Any:
    return _module("projection").UtmProjector(_module("io").Origin(*ORIGIN))


def graph_of(path: Path) -> tuple[Any, Any]:
    """Return map and routing graph of the package itself."""
    found, rules = _module("io").load(str(path), projector()), _module("traffic_rules")
    made = rules.create(rules.Locations.Germany, rules.Participants.Vehicle)
    return found, _module("routing").RoutingGraph(found, made)


def lane_of(network: Network, lanelet: int):
    return next(lane for lane in network.lanes if lane.name == f"lanelet{lanelet}")


def check_against_the_package(network: Network, path: Path) -> None:
    """Compare lanelets, successors, neighbours and centre lines with those of the package."""
    found, graph = graph_of(path)
    drivable = {each.id: each for each in found.laneletLayer if each.attributes["subtype"] in ("road", "highway")}
    assert {lane.name for lane in network.lanes} == {f"lanelet{each}" for each in drivable}
    assert network.links.beside is not None
    for number, each in drivable.items():
        lane = lane_of(network, number)
        after = {f"lanelet{other.id}" for other in graph.following(each) if other.id in drivable}
        assert {other.name for other in lane.successors} == after
        left = graph.left(each) or graph.adjacentLeft(each)
        right = graph.right(each) or graph.adjacentRight(each)
        for side, other in zip(network.links.beside[lane.id], (left, right), strict=True):
            if other is not None:
                assert side is not None
                assert network.lanes[side].name == f"lanelet{other.id}"
            elif side is not None:  # the opposite lane, which the graph does not know
                ways = [network.paths.pose(one.path, 0.5 * one.length).heading for one in (lane, network.lanes[side])]
                assert math.cos(ways[0] - ways[1]) < 0.0
        points = np.array([(point.x, point.y) for point in each.centerline])
        assert network.paths.feet(lane.path, *points.T).distance.max() <= TOLERANCE
        ends = [network.paths.pose(lane.path, s)[:2] for s in (0.0, lane.length)]
        np.testing.assert_allclose(ends, points[[0, -1]], atol=1e-6)
        primitives = network.paths.primitives(lane.path)
        for one, other in pairwise(primitives):
            end = one.pose(one.length)
            assert math.dist(end[:2], (other.x, other.y)) < 1e-6
            assert abs(math.remainder(end.heading - other.heading, math.tau)) < 1e-6


@examples(10)
@given(st.floats(2.8, 4.5), st.floats(0.0, math.tau), st.booleans(), st.integers(5, 25))
def test_a_map_is_what_the_package_says(
    tmp_path_factory: pytest.TempPathFactory, width: float, turn: float, left_hand: bool, points: int
) -> None:
    """Lanelets, successors, neighbours and centre lines, however an intersection is turned."""
    made = crossing(projector(), width=width, turn=turn, left_hand=left_hand, points=points)
    path = written(tmp_path_factory.mktemp("map"), made.osm)
    network = network_of(path, ORIGIN)
    check_against_the_package(network, path)
    assert network.left_hand == left_hand
    assert not network.remarks
    (junction,) = network.intersections
    assert junction.is_4way
    assert len(network.maneuvers) == len(made.inside)
    for (start, end), each in made.inside.items():
        (way,) = (one for one in network.maneuvers if one.connecting_lane.name == f"lanelet{each}")
        assert way.start_lane.name == f"lanelet{made.incoming[start]}"
        assert way.end_lane.name == f"lanelet{made.outgoing[end]}"
        quarter = (ARMS.index(end) - ARMS.index(start)) % 4
        turns = {1: ManeuverType.RIGHT_TURN, 2: ManeuverType.STRAIGHT, 3: ManeuverType.LEFT_TURN}
        assert way.type is turns[quarter]
    roles = {lane.role for lane in network.lanes}
    assert roles == {LaneRole.INCOMING, LaneRole.OUTGOING, LaneRole.CONNECTING}
    assert len(network.roads) == 4
    for road in network.roads:
        assert [len(group.lanes) for group in road.groups] == [1, 1]


def test_areas_are_between_the_bounds(tmp_path: Path) -> None:
    """A straight lanelet has the area of its rectangle, and its width."""
    made = crossing(width=3.2)
    network = network_of(written(tmp_path, made.osm))
    for each in (*made.incoming.values(), *made.outgoing.values()):
        lane = lane_of(network, each)
        assert network.regions.area(lane.region) == pytest.approx(3.2 * (FAR - NEAR), rel=1e-9)
        assert lane.width == pytest.approx(3.2)
        assert lane.length == pytest.approx(FAR - NEAR)
        left, right = network.bounds[lane.id]
        np.testing.assert_allclose(np.hypot(*(left - right).T), 3.2)


def test_local_coordinates_are_those_of_the_tags(tmp_path: Path) -> None:
    """Without an origin the map is where the tags say, wherever that is on Earth; with one it lies there."""
    here = network_of(written(tmp_path, crossing().osm))
    there = network_of(written(tmp_path, crossing(projector()).osm), ORIGIN)
    assert [lane.name for lane in here.lanes] == [lane.name for lane in there.lanes]
    for one, other in zip(here.lanes, there.lanes, strict=True):
        np.testing.assert_allclose(
            here.paths.pose(one.path, 0.3 * one.length), there.paths.pose(other.path, 0.3 * other.length), atol=1e-6
        )


def test_rules_of_the_map(tmp_path: Path) -> None:
    """Limits and lights belong to their lanelets; traffic with priority gives way to none that yields."""
    made = crossing()
    network = network_of(written(tmp_path, made.osm))
    for each in made.incoming.values():
        assert lane_of(network, each).speed_limit == pytest.approx(30.0 / 3.6)
    assert {lane_of(network, each).speed_limit for each in made.outgoing.values()} == {None}
    (light,) = network.signs
    assert light.is_traffic_light
    assert [network.lanes[lane].name for lane in light.lanes] == [f"lanelet{made.incoming['south']}"]
    assert any(each.gives_way_to for each in network.maneuvers)
    arms = {f"lanelet{each}": arm for arm, each in made.incoming.items()}
    for way in network.maneuvers:
        mine = arms[way.start_lane.name]
        for other in way.conflicting_maneuvers:
            theirs = arms[other.start_lane.name]
            first = mine in ("east", "west") and theirs in ("north", "south")
            assert (other in way.gives_way_to) != first


def test_strips_beside_the_lanes(tmp_path: Path) -> None:
    """Each subtype is a surface of its kind; crossings know their intersection and sidewalks, others are counted."""
    made = crossing()
    network = network_of(written(tmp_path, made.osm))
    kinds = {
        "bicycle_lane": SurfaceKind.BIKE_LANE,
        "walkway": SurfaceKind.SIDEWALK,
        "road_shoulder": SurfaceKind.SHOULDER,
        "crosswalk": SurfaceKind.CROSSING,
    }
    assert sorted(each.kind.value for each in network.surfaces) == sorted(kind.value for kind in kinds.values())
    for name, kind in kinds.items():
        (surface,) = (each for each in network.surfaces if each.kind is kind)
        assert surface.name == f"{kind.value}{made.others[name]}"
    (walk,) = (each for each in network.surfaces if each.kind is SurfaceKind.CROSSING)
    assert [each and each.kind for each in walk.sidewalks] == [SurfaceKind.SIDEWALK, None]
    assert walk.road in {road.name for road in network.roads}
    assert "`rail`" in network.unread


@pytest.mark.parametrize("height", [0.0, LEVEL - 0.1, 6.0, -6.0])
def test_heights_make_levels(tmp_path: Path, height: float) -> None:
    """Lanelets that cross at a headroom are a bridge, and their lanes have heights; else there is one plane."""
    network = network_of(written(tmp_path, bridge(height)))
    assert bool(network.levels) == bool(len(network.heights)) == (abs(height) >= LEVEL)


def test_the_sentence_about_levels_names_roads_that_level_knows(tmp_path: Path) -> None:
    """Each name between backquotes puts an object on its level."""
    network = network_of(written(tmp_path, bridge(6.0)))
    (sentence,) = network.levels
    above, below = re.findall("`(.+?)`", sentence)
    for name, end in ((above, "(0 m, -40 m), facing 90 deg"), (below, "(-40 m, 0 m), facing 0 deg")):
        text = f'map lanelet2("map.osm")\nego = new Car at {end}, with level "{name}"\nterminate after 1 s\n'
        (tmp_path / "scene.scn").write_text(text)
        assert cx.load(tmp_path / "scene.scn").sample(1).valid.all()


def test_lanelets_of_one_road_have_one_sentence(tmp_path: Path) -> None:
    """A road of two lanelets above another one: the pair of roads counts once."""
    file = Writer()
    file.lanelet([(-60.0, 2.0), (60.0, 2.0)], [(-60.0, -2.0), (60.0, -2.0)], "road", height=0.0)
    file.lanelet([(-4.0, -60.0), (-4.0, 60.0)], [(0.0, -60.0), (0.0, 60.0)], "road", height=6.0)
    file.lanelet([(4.0, 60.0), (4.0, -60.0)], [(0.0, 60.0), (0.0, -60.0)], "road", height=6.0)
    network = network_of(written(tmp_path, file.osm))
    assert len(network.roads) == 2
    assert len(network.levels) == 1


def test_a_surface_that_cannot_be_computed_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The place of the error is the map as the scenario names it."""
    from engine.road.lanelet2 import making

    def fails(_: object) -> None:
        raise NoSurface

    monkeypatch.setattr(making, "union", fails)
    with pytest.raises(InterchangeError) as caught:
        network_of(written(tmp_path, crossing().osm))
    assert caught.value.place == "map.osm"


SCENE = """
map lanelet2("map.osm"{origin})
ego = new Car on road, with speed 5 m/s, with behavior {driver}(8 m/s)
other = new Car on road, with speed 5 m/s, with behavior {driver}(8 m/s)
terminate after 8 s
"""


@pytest.mark.parametrize("driver", ["FollowLaneBehavior", "GivingWayBehavior", "CarFollowingBehavior"])
def test_both_hosts_drive_on_it(tmp_path: Path, driver: str) -> None:
    """Cars keep to their lanes, and both hosts agree; a copy of the case and its export are complete."""
    written(tmp_path, crossing().osm)
    (tmp_path / "scene.scn").write_text(SCENE.format(origin="", driver=driver))
    scenario = cx.load(tmp_path / "scene.scn")
    scenes = scenario.sample(20, seed=2)
    batch, world = scenario.simulate(scenes), scenario.simulate(scenes, engine="world")
    assert scenes.valid.all()
    np.testing.assert_array_equal(batch.collided, world.collided)
    np.testing.assert_allclose(batch.min_distance, world.min_distance, atol=1e-9)
    cx.export(scenario, ["csv", "commonroad", "scn"], tmp_path / "out")
    copy = cx.load(next((tmp_path / "out").glob("*.scn")))
    assert copy.sample(1).valid.all()
    with pytest.raises(cx.CortexError, match="Lanelet2"):
        cx.export(scenario, ["xodr"], tmp_path / "road")


def test_a_specification_is_stored_whole(tmp_path: Path) -> None:
    """With its origin, also as JSON."""
    path = written(tmp_path, crossing(projector()).osm)
    spec = LaneletFile("map.osm", str(path), digest_of(path), 1, ORIGIN)
    assert map_from(map_content(spec)) == spec


def test_points_without_coordinates_are_named(tmp_path: Path) -> None:
    """Without an origin, each point has its tags; else the message names the line of one that has none."""
    text = crossing().osm.replace('k="local_y"', 'k="local_z"', 1)
    with pytest.raises(InterchangeError, match=r"map.osm, line \d+.*origin="):
        network_of(written(tmp_path, text))


def test_broken_references_are_notes(tmp_path: Path) -> None:
    """What is left of the map is read."""
    made = crossing()
    text = made.osm.replace("</osm>", '<relation id="999999"><member type="way" ref="888888" role="left"/>'
                            '<tag k="type" v="lanelet"/><tag k="subtype" v="road"/></relation></osm>')  # fmt: skip
    network = network_of(written(tmp_path, text))
    assert network.remarks
    assert len(network.lanes) == 8 + len(made.inside)


FOLDER = os.environ.get("CORTEXC_LANELET2_MAPS", "")
PUBLIC = sorted(Path(FOLDER).glob("*.osm")) if FOLDER else []


@pytest.mark.parametrize("path", PUBLIC, ids=[path.stem for path in PUBLIC])
def test_public_maps(path: Path) -> None:
    """They load, and those at a known origin are what the package says."""
    origin = ORIGINS.get(path.stem)
    network = network_of(path, origin)
    assert len(network.lanes)
    assert network.regions.area(0) > 0.0
    if origin is not None:
        check_against_the_package(network, path)
