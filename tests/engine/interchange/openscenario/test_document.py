"""What stands at the head of a file."""

from dataclasses import replace

import pytest

from engine.interchange.openscenario.document import LONGEST_DESCRIPTION, value_kind
from engine.interchange.recording import Provenance
from engine.interchange.xml import Element
from tests.engine.interchange.openscenario.conftest import ROAD, scenario, small


def parameters(root: Element) -> dict[str | None, tuple[str | None, str | None]]:
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
    ("date", "told"), [("2026-05-01", "2026-05-01T00:00:00"), ("yesterday", "1970-01-01T00:00:00")]
)
def test_any_date_becomes_a_date_and_time(date: str, told: str) -> None:
    """The standard wants both."""
    header = scenario(replace(small(), provenance=Provenance(date=date))).find("FileHeader")
    assert header.get("date") == told


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
