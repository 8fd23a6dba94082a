"""The schemas of the standards, out of the checkers' packages as `make dev` unpacks them; the tests need no network."""

import sys
from functools import cache
from pathlib import Path

import pytest
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  # compiled, without stubs

FOLDER = Path(sys.prefix) / "schemas"
PLACES = {
    ("opendrive", "1.7"): "qc_opendrive/schema/1.7.0/opendrive_17_core.xsd",
    ("openscenario", "1.0"): "qc_openscenario/schema/1.0.0/OpenSCENARIO.xsd",
    ("openscenario", "1.1"): "qc_openscenario/schema/1.1.0/OpenSCENARIO.xsd",
    ("openscenario", "1.2"): "qc_openscenario/schema/1.2.0/OpenSCENARIO.xsd",
    ("openscenario", "1.3"): "qc_openscenario/schema/1.3.0/OpenSCENARIO.xsd",
    ("commonroad", ""): "commonroad/common/xml_definition_files/XML_commonRoad_XSD.xsd",
    ("commonroad solution", ""): "commonroad/common/xml_definition_files/CommonRoadSolution_schema.xsd",
}
"""By standard and version. Of OpenSCENARIO 1.1 there are two; 1.1.0, by which ASAM's checker goes, is the stricter one.

OpenDRIVE 1.8 needs XML Schema 1.1, which lxml does not know; nothing here writes it.
"""


@cache
def schema(standard: str, version: str = "") -> etree.XMLSchema:
    """The schema of one version; a test that asks for a missing one fails and says what to do."""
    file = FOLDER / PLACES[standard, version]
    if not file.exists():
        pytest.fail(f"the schema of {standard} {version} is not in {FOLDER}: run `make dev`", pytrace=False)
    return etree.XMLSchema(etree.parse(file, etree.XMLParser(no_network=True, resolve_entities=False)))


def findings(standard: str, version: str, text: str | bytes) -> list[str]:
    """What a document breaks in a standard's schema, each with its line; none where it is valid."""
    judge = schema(standard, version)
    document = etree.fromstring(text.encode() if isinstance(text, str) else text)
    judge.validate(document)
    return [f"line {error.line}: {error.message}" for error in judge.error_log]
