"""MCAP files read back, in order, with everything that is seen and counted in them."""

import json
import math
import sys
from collections import Counter
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from engine.interchange import Export, InterchangeError, Recording
from engine.interchange.mcap.write import write_mcap
from engine.road import build_network
from engine.road.outline import outline
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.commonroad.recordings import LIGHTS, ROAD, SPEED, absent, crash, recording


def contents(made: Recording) -> bytes:
    export = write_mcap(made, "case")
    (data,) = export.files.values()
    assert isinstance(data, bytes)
    return data


def messages(made: Recording) -> list[tuple[str, int, dict[str, Any]]]:
    """Topic, time [ns] and message, as they stand in the file; each of its schema."""
    reader = make_reader(BytesIO(contents(made)), validate_crcs=True)
    found = []
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert schema.name == ("cortexc.Numbers" if channel.topic == "/numbers" else "foxglove.SceneUpdate")
        data = json.loads(message.data)
        assert not misfits(data, json.loads(schema.data))
        found.append((channel.topic, message.log_time, data))
    return found


def topic(made: Recording, name: str) -> list[dict[str, Any]]:
    return [data for each, _, data in messages(made) if each == name]


TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": int | float}


def misfits(value: Any, schema: dict[str, Any], place: str = "") -> list[str]:
    """Where a message is not what its schema says, by the few words of JSON Schema that ours are written in."""
    if not isinstance(value, TYPES[schema["type"]]):
        return [place]
    inner = [(f"{place}[]", each, schema["items"]) for each in value] if schema["type"] == "array" else []
    if schema["type"] == "object":
        named, rest = schema.get("properties", {}), schema.get("additionalProperties")
        inner = [(f"{place}.{key}", value.get(key), each) for key, each in named.items()]
        inner += [(f"{place}.{key}", each, rest) for key, each in value.items() if rest is not None]
    return [misfit for where, each, its in inner for misfit in misfits(each, its, where)]


def test_every_sample_is_there() -> None:
    """The road once, actors and numbers at each sample and at the instant of contact, in the order of time."""
    made = crash()
    found = messages(made)
    assert Counter(name for name, _, _ in found) == {"/road": 1, "/actors": 7, "/numbers": 7}
    times = [time for _, time, _ in found]
    assert times == sorted(times)
    assert 230_000_000 in times
    assert [time for name, time, _ in found if name == "/actors"] == np.round(made.time * 1e9).astype(int).tolist()


def test_actors_are_boxes_at_their_centres() -> None:
    """True to length and width, turned by their heading, on the ground; the ego has a colour of its own."""
    made = recording(*list(ActorKind))
    made.states[:, 1, State.HEADING] = 1.25
    for sample, scene in enumerate(topic(made, "/actors")):
        entities = scene["entities"]
        assert [entity["id"] for entity in entities] == [actor.name for actor in made.actors]
        assert {entity["frame_id"] for entity in entities} == {"map"}
        for index, entity in enumerate(entities):
            (cube,) = entity["cubes"]
            state, pose = made.states[sample, index], cube["pose"]
            assert [pose["position"]["x"], pose["position"]["y"]] == state[[State.X, State.Y]].tolist()
            assert pose["position"]["z"] == cube["size"]["z"] / 2.0
            turned = 2.0 * math.atan2(pose["orientation"]["z"], pose["orientation"]["w"])
            assert math.remainder(turned - state[State.HEADING], math.tau) == pytest.approx(0.0, abs=1e-12)
            actor = made.actors[index]
            assert (cube["size"]["x"], cube["size"]["y"]) == (actor.length, actor.width)
        colours = [tuple(entity["cubes"][0]["color"].values()) for entity in entities]
        assert colours[0] not in colours[1:]


def test_who_comes_and_leaves() -> None:
    """Nobody is shown while not there, and who leaves is deleted once."""
    scenes = topic(absent(recording(ActorKind.CAR, samples=6), 1, 0, 3, 4), "/actors")
    assert [len(scene["entities"]) for scene in scenes] == [1, 2, 2, 1, 1, 2]
    assert [[each["id"] for each in scene["deletions"]] for scene in scenes] == [[], [], [], ["car_1"], [], []]


def test_the_road_is_the_outline() -> None:
    """Every kerb, marking and stop line, point by point."""
    (scene,) = topic(recording(), "/road")
    (entity,) = scene["entities"]
    drawn = outline(build_network(ROAD))
    wanted = [line for lines in (drawn.kerbs, drawn.middle_lines, drawn.lane_lines, drawn.stop_lines) for line in lines]
    found = [[(point["x"], point["y"]) for point in line["points"]] for line in entity["lines"]]
    assert [np.asarray(line).tolist() for line in found] == [line.tolist() for line in wanted]
    assert not topic(replace(recording(), road=None), "/road")


def test_numbers_of_a_head_on_course() -> None:
    """Two at 5 m/s each close in at 10 m/s, and their outlines meet at contact."""
    numbers = topic(crash(), "/numbers")
    assert numbers[0]["ego"]["speed"] == SPEED
    assert numbers[1]["car_1"]["closing_speed"] == pytest.approx(2.0 * SPEED)
    assert [each["car_1"]["distance"] for each in numbers[:4]] == pytest.approx([2.3, 1.3, 0.3, 0.0], abs=1e-9)
    assert "distance" not in numbers[0]["ego"]


def test_numbers_of_who_is_not_there() -> None:
    """None; and none between the ego and somebody where one of them is missing."""
    numbers = topic(absent(absent(recording(ActorKind.CAR), 1, 0), 0, 3), "/numbers")
    assert [sorted(each) for each in numbers] == [["ego"], ["car_1", "ego"], ["car_1", "ego"], ["car_1"]]
    assert "distance" in numbers[1]["car_1"]
    assert "distance" not in numbers[3]["car_1"]


def test_the_origin_stands_in_the_file() -> None:
    """As metadata, with contact."""
    record, actors = make_reader(BytesIO(contents(crash()))).iter_metadata()
    assert record.metadata["seed"] == "7"
    assert record.metadata["SPEED"] == "18 km/h"
    assert record.metadata["contact"] == "0.23"
    assert json.loads(actors.metadata["ego"])["kind"] == "car"


def test_the_same_case_is_the_same_file() -> None:
    """To the byte."""
    assert contents(crash()) == contents(crash())


def test_one_actor_and_one_sample() -> None:
    """Are enough."""
    assert [len(scene["entities"]) for scene in topic(recording(samples=1), "/actors")] == [1]
    assert "closing_speed" not in topic(recording(ActorKind.CAR, samples=1), "/numbers")[0]["car_1"]


def test_what_is_not_shown_is_reported() -> None:
    """Heights are made up, lights are left out."""

    def remarks(export: Export) -> str:
        return " ".join(export.remarks)

    assert "heights" in remarks(write_mcap(recording(), "case"))
    assert "lights" not in remarks(write_mcap(recording(), "case"))
    assert "lights" in remarks(write_mcap(recording(signals=LIGHTS), "case"))


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says what to install."""
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(InterchangeError, match="pip install") as caught:
        write_mcap(recording(), "case")
    assert "[export]" in caught.value.cure


def test_broken_recordings() -> None:
    """Empty, or with a state that is no number."""
    empty = recording()
    with pytest.raises(InterchangeError, match="no actor"):
        write_mcap(replace(empty, time=empty.time[:0], states=empty.states[:0]), "case")
    broken = recording()
    broken.states[1, 0, State.X] = np.inf
    with pytest.raises(InterchangeError, match="no finite state"):
        write_mcap(broken, "case")
