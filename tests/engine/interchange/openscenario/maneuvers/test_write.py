"""Files in maneuver mode: one of each version as a person read it, and what readers rely on.

`UPDATE_GOLDEN=1 pytest` on this file writes `small.1.0.xosc` and `small.1.2.xosc`, to be read before they are kept.
"""

import os
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from engine.errors import InterchangeError
from engine.interchange.contract import OSC_VERSIONS, Export, ExportOptions
from engine.interchange.opendrive import road_map
from engine.interchange.openscenario.maneuvers import (
    ManeuverPlan,
    champions_file,
    formula,
    is_listed,
    ranges_file,
    write_maneuvers,
)
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ActorPlan,
    Bend,
    Change,
    Condition,
    End,
    Measure,
    Parameter,
    Reaction,
    Start,
    Way,
    phases_of,
)
from engine.interchange.openscenario.versions import VERSIONS
from engine.interchange.recording import Provenance
from engine.maps import RoadSpec
from tests.engine.interchange.openscenario.conftest import ROAD, Xml, actor, recording
from tests.schemas import findings

SPEED, GAP = formula.scaled(formula.parameter("SPEED"), 1 / 3.6), formula.parameter("GAP")
ROADS = road_map(RoadSpec())
BACKWARD = next(i for i, place in enumerate(ROADS.places) if not place.forward)


def plan() -> ManeuverPlan:
    """An ego that turns left and brakes for a parked van, which a third car passes on its recorded way."""
    near = ((Condition(Measure.RELATIVE_DISTANCE, GAP, True, "ego", "van"),),)
    brakes = Reaction("brakes_1", near, Change(formula.ZERO, formula.number(4.0)))
    way = Way((Bend(50.0, 60.0, 0.1),), formula.number(20.0), 50.0, 3.0)
    start = Start((0.0, 0.0, 0.0), 0, formula.number(20.0))
    phases = phases_of(way, SPEED, Change(SPEED, formula.number(3.0)))
    ego = ActorPlan("ego", start, SPEED, (0, 10, 7), phases, (brakes,), formula.number(90.0))
    still = phases_of(Way(), formula.ZERO, Change(formula.ZERO, formula.number(1.0)))
    van = ActorPlan("van", Start((9.0, 9.0, 1.0), BACKWARD, formula.number(12.0)), formula.ZERO, phases=still)
    passing = ActorPlan("passing", Start((3.0, 4.0, 0.0)), formula.number(5.0), exact=True)
    over = End("over", ((Condition(Measure.TIME, formula.number(9.0), below=False),),))
    away = End("away", ((Condition(Measure.DISTANCE_TO_START, formula.number(40.0), False, "ego"),),))
    parameters = (
        Parameter("SPEED", 36.0, 10.0, 80.0, unit="km/h"),
        Parameter("GAP", 7.5, 0.0, 20.0, normal=(8.0, 2.0), unit="m"),
    )
    return ManeuverPlan((ego, van, passing), parameters, (away, over), ("a remark",))


def written(version: str = "1.2", of: ManeuverPlan | None = None) -> Export:
    ways = [[(0, 0, 0)] * 3, [(9, 9, 1)] * 3, [(3, 4, 0), (3.2, 4, 0), (3.4, 4, 0)]]
    made = recording([actor("ego"), actor("van"), actor("passing")], [0.0, 0.05, 0.1], ways)
    return write_maneuvers(made, of or plan(), "small", ExportOptions(osc=version), ROAD, ROADS)


def document(version: str = "1.2", of: ManeuverPlan | None = None) -> Xml:
    return ElementTree.fromstring(written(version, of).files["small.xosc"])


def parsed(text: str) -> Xml:
    return ElementTree.fromstring(text)


def events(root: Xml, name: str) -> dict[str, Xml]:
    return {each.get("name"): each for each in root.iterfind(f".//Maneuver[@name='{name}_maneuver']/Event")}


@pytest.mark.parametrize("version", ["1.0", "1.2"])
def test_a_small_plan_is_written_as_it_was_read(version: str) -> None:
    golden = Path(__file__).with_name(f"small.{version}.xosc")
    (text,) = written(version).files.values()
    assert isinstance(text, str)
    if os.environ.get("UPDATE_GOLDEN"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("version", OSC_VERSIONS)
def test_every_version_is_valid(version: str) -> None:
    assert findings("openscenario", version, written(version).files["small.xosc"]) == []


def test_the_first_version_names_what_it_cannot_vary() -> None:
    """It knows bare parameters, no expressions."""
    root, said = document("1.0"), "\n".join(written("1.0").remarks)
    declared = [each.get("name") for each in root.iterfind("ParameterDeclarations/ParameterDeclaration")]
    assert "GAP" in declared
    assert "SPEED" not in declared
    assert "SPEED stand as numbers of this case" in said
    assert "${" not in str(written("1.0").files["small.xosc"])
    assert not list(root.iter("ConstraintGroup"))


def test_parameters_have_their_ranges_and_units() -> None:
    root = document()
    speed = root.find("ParameterDeclarations/ParameterDeclaration[@name='SPEED']")
    limits = [(each.get("rule"), each.get("value")) for each in speed.iter("ValueConstraint")]
    assert (speed.get("value"), limits) == ("36", [("greaterOrEqual", "10"), ("lessOrEqual", "80")])
    unit = root.find("ParameterDeclarations/ParameterDeclaration[@name='cortexc_unit_of_SPEED']")
    assert unit.get("value") == "km/h"


@pytest.mark.parametrize(("version", "kind"), [("1.0", "integer"), ("1.1", "integer"), ("1.2", "int"), ("1.3", "int")])
def test_whole_numbers_are_declared_as_such(version: str, kind: str) -> None:
    """1.2 renamed their type."""
    whole = plan()
    whole = replace(whole, parameters=(whole.parameters[0], replace(whole.parameters[1], value=7.0, whole=True)))
    gap = document(version, whole).find("ParameterDeclarations/ParameterDeclaration[@name='GAP']")
    assert (gap.get("parameterType"), gap.get("value")) == (kind, "7")


@pytest.mark.parametrize(("measure", "below"), [(Measure.COLLISION, False), (Measure.TRAVELLED, True)])
def test_a_condition_without_words_is_refused(measure: Measure, below: bool) -> None:
    """That two do not touch, or that somebody has not gone so far: a trigger that says the opposite would be a lie."""
    end = End("odd", ((Condition(measure, formula.number(1.0), below, "ego", "van"),),))
    with pytest.raises(InterchangeError, match="no condition for the opposite"):
        written(of=replace(plan(), ends=(end,)))


def test_phases_and_reactions_take_turns() -> None:
    """Phases wait while the ego brakes, and each phase that has begun is resumed, the last one last."""
    found = events(document(), "ego")
    assert list(found) == [
        "ego_drives_again",
        "ego_brakes_hard",
        "ego_slows_1",
        "ego_slows_1_again",
        "ego_goes_on_1",
        "ego_goes_on_1_again",
        "ego_brakes_1",
        "ego_leaves",
    ]
    for name in ("ego_slows_1", "ego_goes_on_1"):
        far = found[name].find(".//RelativeDistanceCondition")
        assert (far.get("rule"), far.get("value")) == ("greaterOrEqual", "$GAP")
    again = found["ego_slows_1_again"].find(".//Condition[@conditionEdge='rising']")
    assert again.find(".//RelativeDistanceCondition") is not None
    near = found["ego_brakes_1"].find(".//RelativeDistanceCondition")
    assert near.get("rule") == "lessThan"
    assert {each.get("conditionEdge") for each in found["ego_brakes_1"].iter("Condition")} == {"none"}


def test_who_has_no_maneuver_goes_along_its_trajectory() -> None:
    (event,) = events(document(), "passing").values()
    assert len(list(event.iter("Vertex"))) == 3


def test_a_lane_against_the_road_is_counted_from_its_other_end() -> None:
    """Arc length from the far end, and a heading that no reader can misunderstand."""
    private = document().find(".//Private[@entityRef='van']")
    position, place = private.find(".//LanePosition"), ROADS.places[BACKWARD]
    assert float(position.get("s")) == pytest.approx(place.length - 12.0)
    assert (position.get("roadId"), position.get("laneId")) == (place.road, str(place.lane))
    orientation = position.find("Orientation")
    assert (orientation.get("type"), orientation.get("h")) == ("absolute", "1")


def test_a_route_names_every_lane_once() -> None:
    places = document().iterfind(".//Route/Waypoint/Position/LanePosition")
    lanes = [(each.get("roadId"), int(each.get("laneId") or 0)) for each in places]
    assert lanes == [(ROADS.places[lane].road, ROADS.places[lane].lane) for lane in (0, 10, 7)]


def test_who_is_not_there_at_first_is_not_placed() -> None:
    ways = [[(0, 0, 0)] * 3, [(9, 9, 1)] * 3, [None, (3.2, 4, 0), (3.4, 4, 0)]]
    made = recording([actor("ego"), actor("van"), actor("passing")], [0.0, 0.05, 0.1], ways)
    (text,) = write_maneuvers(made, plan(), "small", ExportOptions(), ROAD, ROADS).files.values()
    root = ElementTree.fromstring(text)
    assert root.find(".//Private[@entityRef='passing']") is None
    assert root.find(".//AddEntityAction") is not None


def test_a_scene_in_which_all_stand_is_a_scenario() -> None:
    """An act needs a group, even with nothing to do."""
    whole = plan()
    still = replace(whole, actors=tuple(replace(each, exact=True) for each in whole.actors))
    made = recording([actor("ego"), actor("van"), actor("passing")], [0.0, 0.05], [[(0, 0, 0)] * 2] * 3)
    (text,) = write_maneuvers(made, still, "small", ExportOptions(), ROAD, ROADS).files.values()
    assert findings("openscenario", "1.2", text) == []


# -- Files of parameter values -----------------------------------------------------------------------------------------

PARAMETERS = (
    Parameter("SPEED", 36.0, 10.0, 80.0),
    Parameter("GAP", 7.5, 0.0, 20.0, normal=(8.0, 2.0)),
    Parameter("COUNT", 2.0, 1.0, 3.0, whole=True),
    Parameter("MANY", 2.0, 1.0, 1e6, whole=True),
)


@pytest.mark.parametrize("version", ["1.1", "1.2", "1.3"])
def test_both_files_are_valid(version: str) -> None:
    sets = [{"SPEED": 1e-9, "GAP": -2.5}, {"SPEED": 20.0, "GAP": 3.0}]
    for text in (
        champions_file("case.xosc", sets, Provenance(), VERSIONS[version]),
        ranges_file("case.xosc", PARAMETERS, Provenance(), VERSIONS[version], 7.0),
    ):
        assert findings("openscenario", version, text) == []


def test_champions_stand_in_their_order_with_all_digits() -> None:
    sets = [{"SPEED": 0.1 + 0.2, "GAP": 1e-9}, {"SPEED": 20.0, "GAP": 3.0}]
    root = parsed(champions_file("case.xosc", sets, Provenance(), VERSIONS["1.2"]))
    read = [
        {each.get("parameterRef"): float(each.get("value")) for each in one.iter("ParameterAssignment")}
        for one in root.iter("ParameterValueSet")
    ]
    assert read == sets
    assert root.find(".//ScenarioFile").get("filepath") == "case.xosc"


def test_ranges_follow_the_laws_of_the_params() -> None:
    root = parsed(ranges_file("case.xosc", PARAMETERS, Provenance(), VERSIONS["1.2"], 7.0))
    laws = {each.get("parameterName"): each[0] for each in root.iter("StochasticDistribution")}
    assert {name: law.tag for name, law in laws.items()} == {
        "SPEED": "UniformDistribution",
        "GAP": "NormalDistribution",
        "COUNT": "ProbabilityDistributionSet",
        "MANY": "UniformDistribution",
    }
    assert laws["SPEED"].find("Range").attrib == {"lowerLimit": "10", "upperLimit": "80"}
    assert (laws["GAP"].get("expectedValue"), laws["GAP"].get("variance")) == ("8", "4")
    assert [each.get("value") for each in laws["COUNT"]] == ["1", "2", "3"]
    assert root.find(".//Stochastic").get("randomSeed") == "7"


def test_a_law_without_bounds_has_no_range() -> None:
    """`inf` is no number of XML Schema, and no bound."""
    endless = (Parameter("GAP", 7.5, normal=(8.0, 2.0)),)
    text = ranges_file("case.xosc", endless, Provenance(), VERSIONS["1.2"], 7.0)
    assert findings("openscenario", "1.2", text) == []
    assert parsed(text).find(".//NormalDistribution").attrib == {"expectedValue": "8", "variance": "4"}
    assert "Range" not in text


def test_what_is_listed_draws_whole_numbers_alone() -> None:
    assert [each.name for each in PARAMETERS if is_listed(each)] == ["COUNT"]
