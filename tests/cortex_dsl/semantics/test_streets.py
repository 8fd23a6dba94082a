"""Words for sidewalks, kerbs, shoulders, bicycle lanes, parking rows and crossings, for the compiler and for scenes."""

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.semantics import elaboration
from engine.maps import LoneRoad, RoadSpec
from engine.road import build_network
from engine.road.areas import WALKABLE, region_of_kinds, vehicle_region
from engine.road.network import SurfaceKind
from engine.road.regions import distance
from engine.scenes import actor_columns
from engine.vocabulary import Column
from tests.cortex_dsl.semantics.conftest import findings

STREET = "map intersection(sidewalk=2 m, shoulder=0.5 m, bike_lane=1.8 m, parking=2.2 m, crossings=True)\n"
SPEC = RoadSpec(sidewalk=2.0, shoulder=0.5, bike_lane=1.8, parking=2.2, crossings=True)
EGO = "ego = new Car in network.lanes[0].centerline\n"
ALWAYS, NEVER = "SCN480", "SCN423"
"""What is said of a requirement that always or never holds."""


def holds(condition: str, head: str = STREET) -> bool:
    """Return whether the compiler can prove that a condition on the road is true."""
    codes = [each.code for each in findings(f"{head}{EGO}require {condition}\n")]
    assert len(codes) == 1
    assert codes[0] in (ALWAYS, NEVER), codes
    return codes[0] == ALWAYS


@pytest.mark.parametrize(
    "condition",
    [
        "len(network.sidewalks) == 12 and len(network.crossings) == 4",
        "len(network.shoulders) == 16 and len(network.bikeLanes) == 8",
        "len(network.roads[0].sidewalks) == 2 and len(network.roads[0].crossings) == 0",
        "network.lanes[0].group.sidewalk is network.roads[0].sidewalks[0]",
        "network.lanes[0].group._sidewalk is network.lanes[0].group.sidewalk",
        "network.lanes[0].group.opposite.sidewalk is network.roads[0].sidewalks[1]",
        "network.lanes[0].group.bikeLane.width == 1.8 m",
        "network.lanes[0].group.sidewalk.road is network.roads[0]",
        "intersection.crossings[0] is network.crossings[0]",
        "intersection.crossings[0].parent is intersection",
        "intersection.crossings[0].startSidewalk is not intersection.crossings[0].endSidewalk",
        "intersection.crossings[0] in intersection.crossings[0].startSidewalk.crossings",
        "network.crossingAt((0, 17)) is intersection.crossings[0]",
        "network.crossingAt((0, 50)) is None",
        "network.roads[0].crossingAt((0, 17)) is None",
        "network.sidewalkAt((9.5, 50)) is network.roads[0].sidewalks[1]",
        "network.shoulderAt((5.4, 50)) is not None and network.shoulderAt((0, 50)) is None",
        "network.elementAt((0, 0)) is intersection and network.elementAt((1, 50)) is network.roads[0]",
        "network.elementAt((9.5, 50)) is network.roads[0].sidewalks[1]",
    ],
)
def test_what_the_compiler_knows_of_streets(condition: str) -> None:
    """Elements of a four-way intersection with all strips."""
    assert holds(condition)
    assert not holds(f"not ({condition})")


def test_a_road_without_strips_has_kerbs_only() -> None:
    head = "map intersection()\n"
    assert holds("network.lanes[0].group._sidewalk is None and network.lanes[0].group._shoulder is None", head)
    assert holds("network.lanes[0].group.curb is not None", head)


@pytest.mark.parametrize(
    ("word", "argument"),
    [
        ("sidewalk", "sidewalk=2 m"),
        ("shoulder", "shoulder=1.5 m"),
        ("crossing", "sidewalk=2 m, crossings=True"),
        ("bikeLane", "bike_lane=1.8 m"),
        ("parking", "parking=2 m"),
        ("network.sidewalkRegion", "sidewalk=2 m"),
        ("network.walkableRegion", "sidewalk=2 m"),
        ("network.crossings[0]", "sidewalk=2 m, crossings=True"),
        ("network.lanes[0].group.sidewalk", "sidewalk=2 m"),
        ("ego.oppositeLaneGroup.shoulder", "shoulder=1.5 m"),
    ],
)
def test_the_map_argument_that_makes_an_element_is_named(word: str, argument: str) -> None:
    """With it in the `map` line the same file compiles."""
    text = "map intersection(ways=4{0})\nego = new Car on road\nnew Pedestrian on {1}\n"
    (found,) = [each for each in findings(text.format("", word)) if each.code == "SCN450"]
    assert f"`{argument}`" in (found.cure or "")
    compile_text(text.format(f", {argument}", word))


@pytest.mark.parametrize(
    ("place", "kinds"),
    [
        ("sidewalk", (SurfaceKind.SIDEWALK,)),
        ("crossing", (SurfaceKind.CROSSING,)),
        ("bikeLane", (SurfaceKind.BIKE_LANE,)),
        ("parking", (SurfaceKind.PARKING,)),
        ("shoulder", (SurfaceKind.SHOULDER, SurfaceKind.PARKING)),
        ("curb", (SurfaceKind.CURB,)),
        ("network.walkableRegion", WALKABLE),
        ("Uniform(*network.sidewalks)", (SurfaceKind.SIDEWALK,)),
        ("Uniform(*network.crossings).centerline", (SurfaceKind.CROSSING,)),
        ("network.laneGroups[2].curb", (SurfaceKind.CURB,)),
        ("ego.laneGroup.sidewalk", (SurfaceKind.SIDEWALK,)),
        ("visible ego.oppositeLaneGroup.sidewalk", (SurfaceKind.SIDEWALK,)),
        ("ego.laneGroup.curb", (SurfaceKind.CURB,)),
    ],
)
def test_places_drawn_on_a_word_lie_there(place: str, kinds: tuple[SurfaceKind, ...]) -> None:
    points = placed(f"{STREET}ego = new Car on road\nthing = new Pedestrian on {place}\n", "thing")
    network = build_network(SPEC)
    found = [each for each in network.surfaces if each.kind in kinds]
    assert all(min(distance(each.shape, x, y) for each in found) < 0.01 for x, y, _ in points.tolist())
    assert len({tuple(row) for row in points[:, :2].tolist()}) == len(points)


def placed(text: str, name: str, count: int = 60) -> np.ndarray:
    """Places and headings (n, 3) of an actor in valid scenes."""
    scenario = compile_text(text)
    scenes = scenario.sample(count, seed=5)
    index = scenario.program.actors.index(name)
    assert scenes.valid.sum() > count / 2
    rows = [actor_columns(scenario.program, values)[index] for values in scenes.values[scenes.valid]]
    return np.array(rows)[:, [Column.X, Column.Y, Column.HEADING]]


def test_the_group_of_a_drawn_lane_has_its_own_kerb() -> None:
    """On the side of the car, and heading as it does; the opposite group's lies across the road."""
    text = STREET + "ego = new Car on road\nthing = new Pedestrian on ego.{}.curb\n"
    for word, turn in (("laneGroup", 1.0), ("oppositeLaneGroup", -1.0)):
        cars, things = (placed(text.format(word), each) for each in ("ego", "thing"))
        assert (np.cos(cars[:, 2] - things[:, 2]) * turn > 0.99).mean() > 0.9  # cars in the intersection turn


def test_vehicles_start_between_the_kerbs_and_nowhere_else() -> None:
    network = build_network(SPEC)
    parked = placed(STREET + "ego = new Car on road\nthing = new Car on parking, facing roadDirection\n", "thing")
    region = vehicle_region(network)
    assert all(network.regions.contains(region, x, y) for x, y, _ in parked.tolist())
    scenario = compile_text(STREET + "ego = new Car on road\nnew Car on sidewalk\n")
    assert not scenario.sample(20, seed=1).valid.any()


def test_people_without_a_place_are_on_foot_in_scripts_of_scenic() -> None:
    """Anywhere on sidewalks and crossings, with any heading."""
    text = STREET + "model scenic.domains.driving.model\nego = new Car\nthing = new Pedestrian\n"
    points, network = placed(text, "thing", 200), build_network(SPEC)
    region = region_of_kinds(network, WALKABLE)
    assert region is not None
    assert all(network.regions.distance(region, x, y) < 1e-6 for x, y, _ in points.tolist())
    assert np.abs(np.exp(1j * points[:, 2]).mean()) < 0.2
    assert "SCN407" in [each.code for each in findings(STREET + "ego = new Car on road\nnew Pedestrian\n")]


@pytest.mark.parametrize(
    ("line", "fields"),
    [
        ("new Pedestrian on sidewalk", {"sidewalk": 2.0}),
        ("new Pedestrian on Uniform(*intersection.crossings)", {"sidewalk": 2.0, "crossings": True}),
        ("new Bicycle on bikeLane", {"bike_lane": 1.8}),
        ("new Car on parking", {"parking": 2.0}),
        ("new Car on shoulder", {"shoulder": 1.5}),
        ("new Pedestrian on ego.laneGroup.curb", {}),
        ("crossing = intersection.incomingLanes[0]\nnew Pedestrian on crossing", {}),
    ],
)
def test_a_file_without_a_map_gets_the_road_that_it_names(line: str, fields: dict[str, object]) -> None:
    """A name of the file's own asks for nothing."""
    scenario = compile_text(f"ego = new Car on road\n{line}\n")
    assert scenario.program.road_spec == RoadSpec(**fields)  # type: ignore[arg-type]


def test_sidewalks_of_many_people_are_drawn_with_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where choosing them would make too many variants; a copy of a case names those that were drawn."""
    monkeypatch.setattr(elaboration, "CHOSEN_LANES_LIMIT", 1)
    text = STREET + "ego = new Car on road\nwalks = [Uniform(*network.sidewalks) for i in range(4)]\n"
    text += "people = [new Pedestrian on walk for walk in walks]\nrequire ego.position.x > 0\nterminate after 1 s\n"
    scenario = compile_text(text)
    assert len(scenario.program.variants) == 1
    scenes = scenario.sample(20, seed=3)
    row = int(np.flatnonzero(scenes.valid)[0])
    concrete = scenario.concrete(scenes, row)
    assert concrete.count("network.sidewalks[") == 4
    again = compile_text(concrete).sample(1)
    count = 5 * len(Column)
    np.testing.assert_array_equal(again.values[0, :count], scenes.values[row, :count])


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("map intersection(sidewalk=8 m)", "SCN411"),
        ("map road(sidewalk=2 m, crossings=[400 m], length=300 m)", "SCN411"),
        ("map road(sidewalk=2 m, crossings=True)", "SCN411"),
        ("map road(curve=3 m, parking=2 m)", "SCN411"),
        ("map intersection(parked=0.5)", "SCN411"),
        ("map intersection(sidewalk=2 m, crossings=[20 m])", "SCN411"),
        ("map road(sidewalk=2 m, crossings=[3 s])", "SCN301"),
        ("map road(sidewalk=2 m, crossings=3)", "SCN303"),
        ("map intersection(sidewalks=2 m)", "SCN205"),
    ],
)
def test_mistakes_in_the_map_are_named(line: str, code: str) -> None:
    found = findings(f"{line}\nego = new Car on road\n")
    assert code in [each.code for each in found], found


def test_a_truth_for_a_width_is_answered_with_an_example() -> None:
    (found,) = findings("map road(sidewalk=True)\nego = new Car on road\n")
    assert found.code == "SCN303"
    assert "sidewalk=" in (found.cure or "")


@pytest.mark.parametrize("name", ["_shoulder", "_sidewalk", "_bikeLane"])
def test_a_strip_that_no_road_has_is_none(name: str) -> None:
    """Also of an object whose lane only the scene knows; without the underscore the map argument is named."""
    text = "map road(length=300 m)\nego = new Car on road\nassert ego.laneGroup.{} is None\n"
    compile_text(text.format(name))
    assert [each.code for each in findings(text.format(name[1:]))] == ["SCN450"]


ANYWHERE = """map road(length=300 m, sidewalk=2 m, crossings=[100 m, 200 m])
ego = new Car on road
walker = new Pedestrian on network.walkableRegion
"""


def test_the_crossing_under_an_object_is_known_to_the_scene() -> None:
    """`x.crossing` rejects scenes without one, `x._crossing` is None there, and a place on it lies on the same one."""
    places = placed(f"{ANYWHERE}other = new Pedestrian on walker.crossing\n", "walker")
    others = placed(f"{ANYWHERE}other = new Pedestrian on walker.crossing\n", "other")
    network = build_network(LoneRoad(length=300.0, sidewalk=2.0, crossings=(100.0, 200.0)))
    crossings = [each for each in network.surfaces if each.kind is SurfaceKind.CROSSING]
    on = [[each.contains(x, y) for each in crossings] for x, y, _ in places.tolist()]
    assert all(map(any, on))
    assert on == [[distance(each.shape, x, y) < 0.01 for each in crossings] for x, y, _ in others.tolist()]
    off = placed(f"{ANYWHERE}require walker._crossing is None\n", "walker")
    assert not any(each.contains(x, y) for each in crossings for x, y, _ in off.tolist())
    first = placed(f"{ANYWHERE}require walker._crossing is network.crossings[1]\n", "walker")
    assert all(crossings[1].contains(x, y) for x, y, _ in first.tolist())


def test_an_object_whose_lane_the_scene_draws_may_have_no_sidewalk() -> None:
    """`is None` asks for each scene, not once for all."""
    head = "map road(length=300 m, sidewalk=2 m)\nego = new Car on road\n"
    assert len(placed(f"{head}require ego.laneGroup._sidewalk is not None\n", "ego")) == 60
    assert [each.code for each in findings("map road()\nego = new Car on road\nrequire ego._crossing is None\n")] != []
