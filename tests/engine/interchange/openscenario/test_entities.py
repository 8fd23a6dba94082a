"""Who takes part, as others see them."""

import math

import pytest
from hypothesis import given

from engine.interchange.kinds import KINDS
from engine.interchange.openscenario.document import UNBOUNDED_SPEED
from engine.interchange.recording import Recording
from engine.interchange.xml import Element
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.openscenario.conftest import actor, recording, recordings, scenario, small


def entity(kind: ActorKind, version: str = "1.2", speed: float = 0.0) -> Element:
    """The element of an only actor."""
    alone = recording([actor("one", kind)], [0.0], [[(0.0, 0.0, 0.0)]])
    alone.states[0, 0, State.SPEED] = speed
    return next(iter(scenario(alone, version).find("Entities/ScenarioObject")))


def properties(element: Element) -> dict[str | None, str | None]:
    return {each.get("name"): each.get("value") for each in element.iter("Property")}


@pytest.mark.parametrize("kind", ActorKind)
def test_the_box_lies_ahead_of_the_rear_axle(kind: ActorKind) -> None:
    """Rule 1: the reference point is the rear axle on the ground, so the centre is off it, not 0."""
    center, model = entity(kind).find("BoundingBox/Center"), MODELS[kind]
    assert float(center.get("x")) == model.rear_to_center
    assert float(center.get("y")) == 0.0
    assert float(center.get("z")) == float(entity(kind).find("BoundingBox/Dimensions").get("height")) / 2


@given(recordings())
def test_the_reference_point_is_the_rear_axle(of: Recording) -> None:
    """Rule 1: centres of boxes put at the written poses are the centres of the recording."""
    root, of = scenario(of), of.taking_part()
    for private in root.iter("Private"):
        name = private.get("entityRef")
        index = [each.get("name") for each in root.iter("ScenarioObject")].index(name)
        where = private.find(".//WorldPosition")
        x, y, heading = (float(where.get(each)) for each in "xyh")
        ahead = float(root.find(f".//ScenarioObject[@name='{name}']//Center").get("x"))
        center = (x + ahead * math.cos(heading), y + ahead * math.sin(heading))
        assert center == pytest.approx(tuple(of.states[0, index, :2]), abs=1e-12)


@pytest.mark.parametrize("kind", ActorKind)
def test_outlines_are_those_of_the_recording(kind: ActorKind) -> None:
    """Length and width to the digit."""
    dimensions, model = entity(kind).find("BoundingBox/Dimensions"), MODELS[kind]
    assert (float(dimensions.get("length")), float(dimensions.get("width"))) == (model.length, model.width)


@pytest.mark.parametrize("kind", [kind for kind in ActorKind if KINDS[kind].tag == "Vehicle"])
def test_axles_are_a_wheelbase_apart(kind: ActorKind) -> None:
    """The rear axle is at the origin; the front wheels alone steer."""
    front, rear = entity(kind).find("Axles/FrontAxle"), entity(kind).find("Axles/RearAxle")
    assert (float(front.get("positionX")), float(rear.get("positionX"))) == (MODELS[kind].wheelbase, 0.0)
    assert (float(front.get("maxSteering")), float(rear.get("maxSteering"))) == (MODELS[kind].max_steer, 0.0)


@pytest.mark.parametrize(("speed", "told"), [(10.0, UNBOUNDED_SPEED), (140.0, 140.0), (-120.0, 120.0)])
def test_top_speed_is_finite_and_not_below_the_runs_own(speed: float, told: float) -> None:
    """No speed bounds a car, and a reader may cut what is above the maximum."""
    assert float(entity(ActorKind.CAR, speed=speed).find("Performance").get("maxSpeed")) == told


@pytest.mark.parametrize(
    ("kind", "tag", "category"),
    [
        (ActorKind.CAR, "Vehicle", "car"),
        (ActorKind.TRUCK, "Vehicle", "truck"),
        (ActorKind.BUS, "Vehicle", "bus"),
        (ActorKind.MOTORCYCLE, "Vehicle", "motorbike"),
        (ActorKind.BICYCLE, "Vehicle", "bicycle"),
        (ActorKind.PEDESTRIAN, "Pedestrian", "pedestrian"),
        (ActorKind.OBSTACLE, "MiscObject", "obstacle"),
    ],
)
def test_kinds_are_called_as_in_the_standard(kind: ActorKind, tag: str, category: str) -> None:
    """Every kind has its element and its category, and says its own name in a property."""
    element = entity(kind)
    assert (element.tag, category) in {(element.tag, value) for value in element.attrib.values()}
    assert element.tag == tag
    assert properties(element)["cortexc.kind"] == kind.name.lower()


def test_headings_run_between_vertices() -> None:
    """Rule 5: esmini interpolates headings over a segment only where the vehicle says so."""
    for element in scenario(small()).iter("ScenarioObject"):
        assert properties(element)["plineInterpolation"] == "segment"


def test_everything_is_inline() -> None:
    """Rule 7: no catalogs, and no models of a place that the reader does not have."""
    root = scenario(small(), "1.3")
    assert not list(root.iter("CatalogReference"))
    assert len(root.find("CatalogLocations")) == 0
    assert not [element.tag for element in root.iter() if "model3d" in element.attrib or element.tag == "File"]


def test_the_ego_is_told_from_the_others() -> None:
    """ScenarioRunner wants one `ego_vehicle`; it is the first."""
    types = [properties(element)["type"] for element in scenario(small()).iter("ScenarioObject")]
    assert types == ["ego_vehicle", "simulation", "simulation", "simulation"]


def test_what_an_element_has_no_place_for_is_a_property() -> None:
    """A pedestrian has no performance, a car no infinite top speed."""
    walker, car = properties(entity(ActorKind.PEDESTRIAN)), properties(entity(ActorKind.CAR))
    assert float(walker["cortexc.max_speed"]) == MODELS[ActorKind.PEDESTRIAN].max_speed
    assert float(walker["cortexc.max_braking"]) == MODELS[ActorKind.PEDESTRIAN].max_braking
    assert float(car["cortexc.max_speed"]) == math.inf
    assert "cortexc.max_braking" not in car


def test_a_name_from_the_file_is_kept() -> None:
    """What was made plain stands unchanged in a property."""
    bus = scenario(small()).find("Entities/ScenarioObject[@name='bus_12']")
    assert properties(bus)["cortexc.name"] == "bus 12"
