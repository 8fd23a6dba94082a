"""Trajectory mode: a case as an `.xosc` that replays it exactly."""

from collections.abc import Iterator

from engine.interchange.export import Export, ExportOptions
from engine.interchange.openscenario.document import new_document
from engine.interchange.openscenario.entities import add_entities
from engine.interchange.openscenario.names import entity_names
from engine.interchange.openscenario.signals import add_signals
from engine.interchange.openscenario.storyboard import add_storyboard
from engine.interchange.openscenario.trajectory import stretches
from engine.interchange.openscenario.versions import Version, version_of
from engine.interchange.properties import of_samples
from engine.interchange.reading.xml import LIMITS, MEGABYTE
from engine.interchange.recording import MOST_ACTORS, Recording
from engine.interchange.xml_text import xml_text

MERGED = 0.1
"""Below this distance esmini 3.6 takes vertices for one [m]: its default of `--traj_filter`."""


def write_trajectories(recording: Recording, stem: str, options: ExportOptions, road_file: str | None) -> Export:
    """`<stem>.xosc`, in which every actor replays what it did; `road_file` is the name of the `.xodr` beside it.

    Raises:
        InterchangeError: the recording is empty or broken, or the ego takes no part.
    """
    recording.refuse_broken()
    recording = recording.taking_part()
    version, shown = version_of(options), recording.from_zero()
    names = entity_names(shown)
    document = new_document(shown, version, road_file)
    if road_file is not None:
        add_signals(document.network, shown)
    carried = [of_samples(shown, actor) for actor in range(len(names))]
    add_entities(document.root, shown, names, version, carried)
    add_storyboard(document.root, shown, names, version)
    text = xml_text(document.root)
    remarks = (*_remarks(recording, names, version, road_file), *_remarks_on_size(recording, text))
    return Export({f"{stem}.xosc": text}, remarks)


def _remarks(recording: Recording, names: tuple[str, ...], version: Version, road_file: str | None) -> Iterator[str]:
    """What OpenSCENARIO cannot carry, or carries otherwise."""
    what = "speeds, steering, accelerations and pedals" if recording.commands else "speeds and accelerations"
    yield (
        f"OpenSCENARIO has no place for {what} over time: "
        "they stand as properties `cortexc.*` of each actor, which other tools pass over"
    )
    for actor, name in zip(recording.actors, names, strict=True):
        if actor.name != name:
            yield f"`{actor.name}` is called `{name}`: readers take letters, digits and underscores only"
    yield from _remarks_on_times(recording, version)
    yield from _remarks_on_road(recording, road_file)


def _remarks_on_size(recording: Recording, text: str) -> Iterator[str]:
    """What is larger than `cortexc import` takes from anybody."""
    actors, elements, megabytes = len(recording.actors), text.count("<") - text.count("</"), len(text) / MEGABYTE
    if actors > MOST_ACTORS or elements > LIMITS.elements or megabytes > LIMITS.megabytes:
        has = f"{actors:,} actors, {elements:,} elements, {megabytes:.0f} MB"
        most = f"{MOST_ACTORS:,}, {LIMITS.elements:,} and {LIMITS.megabytes:g} MB"
        yield f"`cortexc import` refuses a file of {has}: it reads at most {most}"


def _remarks_on_times(recording: Recording, version: Version) -> Iterator[str]:
    actors = range(len(recording.actors))
    if recording.time[0] != 0.0:
        yield f"times are {recording.time[0]:g} s less than in the recording, as a scenario begins at 0"
    if recording.contact is not None and recording.contact.time < recording.time[-1]:
        yield f"what follows first contact at {recording.contact.time:.3f} s is contact physics, replayed as it was"
    if any(part.moves and part.shortest_way() < MERGED for actor in actors for part in stretches(recording, actor)):
        yield f"esmini merges vertices nearer than {MERGED:g} m, unless it is run with `--traj_filter 0`"
    late = [recording.actors[actor].name for actor in actors if not recording.there[0, actor]]
    if late and not version.late_entities:
        yield f"not there from the beginning: {', '.join(late)}; ScenarioRunner first puts them at the origin"


def _remarks_on_road(recording: Recording, road_file: str | None) -> Iterator[str]:
    if road_file is None:
        yield "no road is named: the scenario plays on an empty plane"
    if recording.signals is None:
        return
    if road_file is None or recording.road is None:
        yield "the traffic lights are left out, as there is no road for them to stand at"
    elif recording.signals.controlled:
        yield "the scenario may change its traffic lights by itself; what is written is their fixed plan alone"
