"""Check MCAP files: a message at every sample, with the place and speed of each actor that takes part then."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from engine.extras import needed
from engine.interchange.contract import OURS, ExportOptions, Finding
from engine.interchange.mcap.write import NUMBERS
from engine.interchange.read_back import NEAR
from engine.interchange.recording import RecordedActor, RecordedCase, Recording
from engine.tables import Floats
from engine.vocabulary import State

Messages = Mapping[str, Sequence[tuple[int, Any]]]
"""Times [ns] and contents by topic."""


def check_mcap(case: RecordedCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """Yield findings unless boxes and numbers equal the run, to a millimetre."""
    broken = needed("mcap.exceptions", "MCAP needs", "export").McapError
    recording = case.replay.from_zero()
    for name in (each for each in names if each.endswith(".mcap")):
        try:
            messages = _messages(folder / name)
        except (broken, ValueError) as error:
            yield Finding(name, f"it cannot be read: {error or type(error).__name__}", OURS)
            continue
        yield from _every_sample(recording, messages, name)


def _messages(path: Path) -> Messages:
    found: dict[str, list[tuple[int, Any]]] = {}
    with path.open("rb") as file:
        reader = needed("mcap.reader", "MCAP needs", "export").make_reader(file, validate_crcs=True)
        for _, channel, message in reader.iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
    return found


def _every_sample(recording: Recording, messages: Messages, name: str) -> Iterator[Finding]:
    wanted = [round(time * 1e9) for time in recording.time.tolist()]
    for topic, look in (("/actors", _boxes), ("/numbers", _numbers)):
        found = messages.get(topic, ())
        if [time for time, _ in found] != wanted:
            problem = f"{len(found):,} messages for {len(wanted):,} samples, or at other times"
            yield Finding(f"{name}, {topic}", problem, OURS)
            continue
        for sample, (_, message) in enumerate(found):
            yield from look(recording, sample, message, f"{name}, {topic} at {recording.time[sample]:.3f} s")
    if recording.road is not None and len(messages.get("/road", ())) != 1:
        yield Finding(f"{name}, /road", f"{len(messages.get('/road', ()))} messages, and not one", OURS)


def _boxes(recording: Recording, sample: int, message: Any, place: str) -> Iterator[Finding]:
    boxes = {entity["id"]: entity["cubes"][0] for entity in message["entities"]}
    yield from _same_people(recording, sample, boxes, place)
    for index, actor in enumerate(recording.actors):
        if recording.there[sample, index] and actor.name in boxes:
            off = _off(boxes[actor.name], actor, recording.states[sample, index])
            if not off <= NEAR:
                yield Finding(place, f"the box of {actor.name} is {off:.3g} off", OURS)


def _off(cube: Any, actor: RecordedActor, state: Floats) -> float:
    """Return the largest difference of place, heading and size between a box and its actor."""
    at, turned, size = cube["pose"]["position"], cube["pose"]["orientation"], cube["size"]
    heading = 2.0 * math.atan2(turned["z"], turned["w"])
    differences = (
        at["x"] - state[State.X],
        at["y"] - state[State.Y],
        at["z"] - size["z"] / 2.0,
        math.remainder(heading - state[State.HEADING], math.tau),
        size["x"] - actor.length,
        size["y"] - actor.width,
    )
    return max(map(abs, differences))


def _numbers(recording: Recording, sample: int, message: Any, place: str) -> Iterator[Finding]:
    yield from _same_people(recording, sample, message, place)
    for index, actor in enumerate(recording.actors):
        written = message.get(actor.name)
        if written is None or not recording.there[sample, index]:
            continue
        for number, column in NUMBERS.items():
            off = abs(written.get(number, math.nan) - recording.states[sample, index, column])
            if not off <= NEAR:
                yield Finding(place, f"the {number} of {actor.name} is {off:.3g} off", OURS)


def _same_people(recording: Recording, sample: int, written: Mapping[str, Any], place: str) -> Iterator[Finding]:
    there = {actor.name for actor, is_there in zip(recording.actors, recording.there[sample], strict=True) if is_there}
    if there != set(written):
        yield Finding(place, f"{len(there)} are there, {len(written)} are in the message, or others", OURS)
