"""The schemas can distinguish a valid document from another."""

from pathlib import Path

import pytest

from tests import schemas
from tests.schemas import PLACES, findings, schema

ROAD = """<?xml version="1.0" encoding="UTF-8"?>
<OpenDRIVE><header revMajor="1" revMinor="7"/>{}</OpenDRIVE>"""
LINE = """<road id="1" length="1" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="{}"><line/>
</geometry></planView><lanes><laneSection s="0"><center><lane id="0" level="false" type="none"/></center></laneSection>
</lanes></road>"""


@pytest.mark.parametrize(("standard", "version"), list(PLACES))
def test_every_schema_loads(standard: str, version: str) -> None:
    """From the folder that `make dev` fills, and refuses what is nothing of the kind."""
    assert schema(standard, version)
    assert findings(standard, version, "<nonsense/>")


def test_a_valid_document_has_no_findings() -> None:
    """The types of a split schema are all there: a length of zero is against one of them."""
    assert not findings("opendrive", "1.7", ROAD.format(LINE.format("1")))
    (finding,) = findings("opendrive", "1.7", ROAD.format(LINE.format("0")))
    assert finding.startswith("line 2: ")
    assert "length" in finding


def test_a_missing_schema_fails_with_a_cure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test is passed over in silence because a machine was not set up."""
    monkeypatch.setattr(schemas, "FOLDER", tmp_path)
    schema.cache_clear()
    with pytest.raises(pytest.fail.Exception, match="run `make dev`"):
        schema("openscenario", "1.2")
