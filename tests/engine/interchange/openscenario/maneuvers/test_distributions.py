"""Files of parameter values."""

from xml.etree import ElementTree

import pytest

from engine.interchange.openscenario.maneuvers import champions_file, is_listed, ranges_file
from engine.interchange.openscenario.maneuvers.maneuver_plan import Parameter
from engine.interchange.openscenario.versions import VERSIONS
from engine.interchange.recording import Provenance
from tests.schemas import findings

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
    root = ElementTree.fromstring(champions_file("case.xosc", sets, Provenance(), VERSIONS["1.2"]))
    read = [
        {each.get("parameterRef"): float(each.get("value")) for each in one.iter("ParameterAssignment")}
        for one in root.iter("ParameterValueSet")
    ]
    assert read == sets
    assert root.find(".//ScenarioFile").get("filepath") == "case.xosc"


def test_ranges_follow_the_laws_of_the_params() -> None:
    root = ElementTree.fromstring(ranges_file("case.xosc", PARAMETERS, Provenance(), VERSIONS["1.2"], 7.0))
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
    assert ElementTree.fromstring(text).find(".//NormalDistribution").attrib == {"expectedValue": "8", "variance": "4"}
    assert "Range" not in text


def test_what_is_listed_draws_whole_numbers_alone() -> None:
    assert [each.name for each in PARAMETERS if is_listed(each)] == ["COUNT"]
