"""What stands at the head of a file."""

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.kinds import KINDS
from engine.interchange.openscenario.document import (
    LONGEST_DESCRIPTION,
    UNBOUNDED_SPEED,
    literal,
    plain_name,
    unique_names,
    value_kind,
)
from engine.interchange.recording import Provenance, Recording
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.openscenario.conftest import ROAD, Xml, actor, recording, recordings, scenario, small


def parameters(root: Xml) -> dict[str | None, tuple[str | None, str | None]]:
    return {
        each.get("name"): (each.get("parameterType"), each.get("value")) for each in root.iter("ParameterDeclaration")
    }


def test_provenance_stands_in_the_header() -> None:
    """Rule 10: what is to be seen, seed, risk, digest and command in one line that every reader shows."""
    header = scenario(small()).find("FileHeader")
    assert header.get("author") == "cortexc"
    assert header.get("date") == "1970-01-01T00:00:00"
    assert header.get("description") == (
        "The ego turns into a bus - seed: 7; risk: 22 of 22; digest: abc123; command: cortexc replay runs/one --case 1"
    )


def test_provenance_stands_in_parameters() -> None:
    """Rule 10: the genome under the names of its params, facts under our own; a number is a double."""
    assert parameters(scenario(small())) == {
        "EGO_SPEED": ("string", "36 km/h"),
        "EGO_BRAKE": ("double", "0.5"),
        "cortexc_seed": ("string", "7"),
        "cortexc_risk": ("string", "22 of 22"),
        "cortexc_digest": ("string", "abc123"),
        "cortexc_command": ("string", "cortexc replay runs/one --case 1"),
        "cortexc_contact_time": ("double", "0.12"),
        "cortexc_contact_actors": ("string", "0 1"),
    }


def test_params_that_become_the_same_stay_apart() -> None:
    """Two names that differ in signs only are two parameters."""
    of = replace(small(), contact=None, provenance=Provenance(genome={"a.b": "1", "a b": "2"}))
    assert parameters(scenario(of)) == {"a_b": ("double", "1"), "a_b_2": ("double", "2")}


@pytest.mark.parametrize("title", ["<&\"'>", "line\nbreak", "$HOME and ${x}", "道路"])
def test_any_title_can_be_written(title: str) -> None:
    """Marks of XML are escaped, and nothing refers to a parameter."""
    description = scenario(replace(small(), provenance=Provenance(title=title))).find("FileHeader").get("description")
    assert description == title.replace("$", "\N{FULLWIDTH DOLLAR SIGN}")


def test_a_long_description_is_cut() -> None:
    """The parameters still have all of it."""
    of = replace(small(), provenance=Provenance(facts={"story": "long " * 200}))
    assert len(scenario(of).find("FileHeader").get("description")) == LONGEST_DESCRIPTION
    assert parameters(scenario(of))["cortexc_story"] == ("string", "long " * 200)


@pytest.mark.parametrize(
    ("date", "written"), [("2026-05-01", "2026-05-01T00:00:00"), ("yesterday", "1970-01-01T00:00:00")]
)
def test_any_date_becomes_a_date_and_time(date: str, written: str) -> None:
    """The standard wants both."""
    header = scenario(replace(small(), provenance=Provenance(date=date))).find("FileHeader")
    assert header.get("date") == written


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("1.5", "double"),
        ("-2e-3", "double"),
        ("1.5 m", "string"),
        ("inf", "string"),
        ("nan", "string"),
        ("1_0", "string"),
    ],
)
def test_a_number_is_a_double(text: str, kind: str) -> None:
    """What XML calls a double, and only if finite."""
    assert value_kind(text) == kind


def test_the_road_is_named() -> None:
    """The file beside; none on an empty plane."""
    assert scenario(small()).find("RoadNetwork/LogicFile").get("filepath") == ROAD
    assert scenario(small(), road_file=None).find("RoadNetwork/LogicFile") is None


# -- Names that every reader takes -------------------------------------------------------------------------------------


@given(st.lists(st.text(max_size=6)))
def test_names_are_unique_and_plain(texts: list[str]) -> None:
    """Whatever they were, no two are the same, and each is an identifier."""
    names = unique_names(texts)
    assert len(names) == len(texts)
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in names)


def test_names_are_still_to_be_recognised() -> None:
    """Marks fall away, signs and spaces become underscores, a number sets those apart that become the same."""
    texts = ["ego", "Café 3", "a::b", "a b", "$speed", "2nd", "道"]
    assert unique_names(texts) == ("ego", "Cafe_3", "a_b", "a_b_2", "speed", "_2nd", "unnamed")


@given(st.from_regex(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", fullmatch=True))
def test_a_plain_name_stays(name: str) -> None:
    """What is an identifier already is not touched."""
    assert plain_name(name) == name


def test_a_number_that_is_taken_is_passed_over() -> None:
    """A name made unique never takes that of another."""
    assert unique_names(["car_2", "car", "car"]) == ("car_2", "car", "car_3")


def test_no_text_refers_to_a_parameter() -> None:
    """A dollar sign anywhere would be read as a reference."""
    assert "$" not in literal("cost $5 of ${all}")


# -- Who takes part, as others see them --------------------------------------------------------------------------------


def entity(kind: ActorKind, version: str = "1.2", speed: float = 0.0, **changes: float) -> Xml:
    """The element of an only actor."""
    alone = recording([replace(actor("one", kind), **changes)], [0.0], [[(0.0, 0.0, 0.0)]])
    alone.states[0, 0, State.SPEED] = speed
    return next(iter(scenario(alone, version).find("Entities/ScenarioObject")))


def properties(element: Xml) -> dict[str, Any]:
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


@pytest.mark.parametrize(("speed", "written"), [(10.0, UNBOUNDED_SPEED), (140.0, 140.0), (-120.0, 120.0)])
def test_top_speed_is_finite_and_not_below_the_runs_own(speed: float, written: float) -> None:
    """Where no speed bounds a car a reader may still cut what is above the maximum."""
    assert float(entity(ActorKind.CAR, speed=speed, max_speed=math.inf).find("Performance").get("maxSpeed")) == written


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


def test_the_ego_is_distinguished_from_the_others() -> None:
    """ScenarioRunner wants one `ego_vehicle`; it is the first."""
    types = [properties(element)["type"] for element in scenario(small()).iter("ScenarioObject")]
    assert types == ["ego_vehicle", "simulation", "simulation", "simulation"]


def test_what_an_element_has_no_place_for_is_a_property() -> None:
    """A pedestrian has no performance, a car no infinite top speed."""
    walker = properties(entity(ActorKind.PEDESTRIAN))
    car = properties(entity(ActorKind.CAR, max_speed=math.inf))
    assert float(walker["cortexc.max_speed"]) == MODELS[ActorKind.PEDESTRIAN].top_speed
    assert float(walker["cortexc.max_braking"]) == MODELS[ActorKind.PEDESTRIAN].max_braking
    assert float(car["cortexc.max_speed"]) == math.inf
    assert "cortexc.max_braking" not in car


def test_a_name_from_the_file_is_kept() -> None:
    """What was made plain stands unchanged in a property."""
    bus = scenario(small()).find("Entities/ScenarioObject[@name='bus_12']")
    assert properties(bus)["cortexc.name"] == "bus 12"
