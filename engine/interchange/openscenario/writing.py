"""Trajectory mode: a case as an `.xosc` that replays it exactly."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from engine.interchange.errors import InterchangeError
from engine.interchange.export import Export, ExportOptions
from engine.interchange.openscenario.document import new_document
from engine.interchange.openscenario.entities import add_entities
from engine.interchange.openscenario.names import entity_names
from engine.interchange.openscenario.signals import add_signals
from engine.interchange.openscenario.storyboard import add_storyboard
from engine.interchange.openscenario.trajectory import carried_samples, stretches
from engine.interchange.openscenario.versions import Version, version_of
from engine.interchange.recording import Recording
from engine.interchange.xml_text import xml_text
from engine.vocabulary import State

MERGED = 0.1
"""Below this distance esmini 3.6 takes vertices for one [m]: its default of `--traj_filter`."""


def write_trajectories(recording: Recording, stem: str, options: ExportOptions, road_file: str | None) -> Export:
    """`<stem>.xosc`, in which every actor replays what it did; `road_file` is the name of the `.xodr` beside it.

    Raises:
        InterchangeError: the recording is empty, or a position in it is no number.
    """
    _refuse_unwritable(recording)
    version, names, shown = version_of(options), entity_names(recording), from_zero(recording)
    root = new_document(shown, version, road_file)
    if road_file is not None:
        add_signals(root[-1], shown)
    carried = [carried_samples(shown, actor) for actor in range(len(names))]
    add_entities(root, shown, names, version, carried)
    add_storyboard(root, shown, names, version)
    remarks = tuple(_remarks(recording, names, version, road_file))
    return Export({f"{stem}.xosc": xml_text(root)}, remarks)


def from_zero(recording: Recording) -> Recording:
    """The same with times that begin at 0, as those of a scenario do."""
    begin = float(recording.time[0])
    if begin == 0.0:
        return recording
    contact = recording.contact and replace(recording.contact, time=recording.contact.time - begin)
    return replace(recording, time=recording.time - begin, contact=contact)


def _refuse_unwritable(recording: Recording) -> None:
    if not len(recording) or not recording.actors:
        raise InterchangeError("a recording without samples or actors is no scenario", "record a run first")
    there = recording.states[:, :, State.PRESENT] != 0.0
    broken = there & ~np.isfinite(recording.states).all(axis=2)
    if broken.any():
        sample, actor = np.argwhere(broken)[0]
        who, when = recording.actors[actor].name, recording.time[sample]
        raise InterchangeError(f"the state of {who} at {when:g} s is no number", "export a run that did not break")


def _remarks(recording: Recording, names: tuple[str, ...], version: Version, road_file: str | None) -> Iterator[str]:
    """What OpenSCENARIO cannot carry, or carries otherwise."""
    yield (
        "OpenSCENARIO has no place for speeds, steering, accelerations and pedals over time: "
        "they stand as properties `cortexc.*` of each actor, which other tools pass over."
    )
    for actor, name in zip(recording.actors, names, strict=True):
        if actor.name != name:
            yield f"`{actor.name}` is called `{name}`: readers take letters, digits and underscores only."
    yield from _remarks_on_times(recording, version)
    yield from _remarks_on_road(recording, road_file)


def _remarks_on_times(recording: Recording, version: Version) -> Iterator[str]:
    actors = range(len(recording.actors))
    if recording.time[0] != 0.0:
        yield f"Times are {recording.time[0]:g} s less than in the recording, as a scenario begins at 0."
    if recording.contact is not None and recording.contact.time < recording.time[-1]:
        yield f"What follows first contact at {recording.contact.time:.3f} s is contact physics, replayed as it was."
    if any(part.moves and part.shortest_way() < MERGED for actor in actors for part in stretches(recording, actor)):
        yield f"esmini merges vertices nearer than {MERGED:g} m, unless it is run with `--traj_filter 0`."
    late = [recording.actors[actor].name for actor in actors if not recording.states[0, actor, State.PRESENT]]
    if late and version.minor == 0:
        yield f"Not there from the beginning: {', '.join(late)}. ScenarioRunner first puts them at the origin."


def _remarks_on_road(recording: Recording, road_file: str | None) -> Iterator[str]:
    if road_file is None:
        yield "No road is named: the scenario plays on an empty plane."
    if recording.signals is None:
        return
    if road_file is None or recording.road is None:
        yield "The traffic lights are left out, as there is no road for them to stand at."
    elif recording.signals.controlled:
        yield "The scenario may change its traffic lights by itself; what is written is their fixed plan alone."
