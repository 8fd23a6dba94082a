"""One table says what every standard calls our kinds, and how high they are."""

import csv
import json
from io import BytesIO, StringIO

import pytest
from mcap.reader import make_reader

from engine.interchange.contract import ExportOptions
from engine.interchange.kinds import KINDS, VEHICLE, WHEELCHAIR, Code, kind_of
from engine.interchange.mcap.write import write_mcap
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.read.entities import CATEGORIES
from engine.interchange.tables import write_csv
from engine.interchange.xml_writing import number
from engine.vocabulary import ActorKind
from tests.engine.interchange.commonroad.recordings import recording


def test_every_kind_has_a_row() -> None:
    """And no two have the same words."""
    assert set(KINDS) == set(ActorKind)
    for words in ("category", "commonroad", "code"):
        assert len({getattr(row, words) for row in KINDS.values()}) == len(KINDS)


@pytest.mark.parametrize("kind", ActorKind)
def test_it_is_read_back_as_the_same_kind(kind: ActorKind) -> None:
    """By what OpenSCENARIO and the Open Simulation Interface call it."""
    assert kind_of(KINDS[kind].code) is kind
    assert KINDS[kind].tag != "Vehicle" or CATEGORIES[KINDS[kind].category] is kind


def test_a_wheelchair_is_a_pedestrian() -> None:
    """As in OpenSCENARIO, where it is a category of pedestrians."""
    assert kind_of(Code(VEHICLE, subtype=WHEELCHAIR)) is ActorKind.PEDESTRIAN


@pytest.mark.parametrize("kind", ActorKind)
def test_one_height_in_every_format(kind: ActorKind) -> None:
    """A bus in a viewer is as high as in a simulator, and in a table."""
    made, height = recording(kind), KINDS[kind].height
    (text,) = write_trajectories(made, "case", ExportOptions(), None).files.values()
    assert f'length="{number(made.actors[1].length)}" height="{number(height)}"' in str(text)
    (table,) = write_csv(made, "case").files.values()
    assert {float(row["height"]) for row in csv.DictReader(StringIO(str(table))) if row["idx"] == "1"} == {height}
    (data,) = write_mcap(made, "case").files.values()
    assert isinstance(data, bytes)
    for _, _, message in make_reader(BytesIO(data)).iter_messages(topics=["/actors"]):
        assert json.loads(message.data)["entities"][1]["cubes"][0]["size"]["z"] == height
