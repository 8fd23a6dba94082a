"""`read_openscenario`: a scenario of timed polylines as a recording, with its road. Versions 1.0 to 1.3.

file -> xml -> parameters put in -> entities, road -> actions in the order of time -> tracks -> one grid of samples
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from engine.interchange.errors import InterchangeError, did_you_mean, quoted
from engine.interchange.properties import FILE_PREFIX
from engine.interchange.reading.catalogs import Catalogs
from engine.interchange.reading.entities import read_entities
from engine.interchange.reading.judging import judged
from engine.interchange.reading.motion import read_tracks
from engine.interchange.reading.node import Node
from engine.interchange.reading.opendrive import OdrNetwork, read_opendrive
from engine.interchange.reading.parameters import substituted
from engine.interchange.reading.storyboard import condition_name, stop_time, timed_actions
from engine.interchange.reading.timeline import Grid, Part, grid, part_of, states
from engine.interchange.reading.xml import LIMITS, Limits, read_xml
from engine.interchange.recording import Provenance, Recording
from engine.vocabulary import State

SHORTEST_STEP = 1e-4
"""[s]"""


@dataclass(frozen=True)
class Imported:
    """What a file says, and what it says that could not be taken over."""

    recording: Recording
    """Without contact, which `measure` finds."""
    road: OdrNetwork | None
    remarks: tuple[str, ...]


def read_openscenario(
    path: str | Path, *, ego: str | None = None, step: float | None = None, limits: Limits = LIMITS
) -> Imported:
    """A scenario in which everybody who moves follows a timed polyline.

    Actor 0 is the entity `ego`, or who is called ego or hero, or the first. Without `step` [s] samples stand where
    vertices do, and every 0.05 s where these are further than 0.2 s apart.

    Raises:
        InterchangeError: the file, its road or a catalog cannot be read, or it needs a simulator to be played.
    """
    path = Path(path)
    _check_step(step)
    raw = _of_kind(read_xml(path, "OpenSCENARIO", limits))
    scenario = substituted(raw)
    road, remarks = _read_road(scenario, path.parent, limits)
    catalogs = Catalogs(scenario, path.parent, limits)
    entities = read_entities(scenario, catalogs, ego)
    storyboard = scenario.need("Storyboard")
    tracks, said = read_tracks(entities, timed_actions(storyboard), road, catalogs)
    end, on_end = _read_end(storyboard)
    parts = [part_of(entity, track) for entity, track in zip(entities, tracks, strict=True)]
    times = grid(parts, end, step, path.name)
    parts = judged(parts, times.told)
    recording = replace(_recording(path, parts, times), provenance=_provenance(raw, path))
    on_motion = (remark for part in parts for remark in part.remarks)
    return Imported(recording, road, (*remarks, *said, *on_motion, *times.remarks, *on_end))


def _check_step(step: float | None) -> None:
    if step is not None and not SHORTEST_STEP <= step < math.inf:
        raise InterchangeError(f"a step of {step:g} s", f"take one of at least {SHORTEST_STEP:g} s")


def _read_end(storyboard: Node) -> tuple[float, list[str]]:
    """When it ends at the latest [s], and remarks on ends that only a simulator would see."""
    end, passed_over = stop_time(storyboard)
    names = dict.fromkeys(map(condition_name, passed_over))
    return end, [f"the end by <{name}> is not taken over: it ends with the last vertex" for name in names]


def _of_kind(root: Node) -> Node:
    """The file itself, if it is a scenario of a version that is read here."""
    header = root.need("FileHeader")
    major, minor = header.text("revMajor"), header.text("revMinor", "0")
    if major != "1":
        raise header.error(
            f"this is OpenSCENARIO {quoted(major)[1:-1]}.{quoted(minor)[1:-1]}", "1.0 to 1.3 are read: convert it"
        )
    for tag, kind in (("Catalog", "a catalog"), ("ParameterValueDistribution", "a distribution of parameters")):
        if (node := root.find(tag)) is not None:
            raise node.error(f"this is {kind}, not a scenario", "name the .xosc that uses it")
    return root


def _read_road(scenario: Node, folder: Path, limits: Limits) -> tuple[OdrNetwork | None, list[str]]:
    """The road that the scenario names, looked for beside it."""
    network = scenario.find("RoadNetwork")
    lights = network.find("TrafficSignals") if network else None
    remarks = ["its traffic lights are not taken over"] if lights and lights.children else []
    node = network.find("LogicFile") if network else None
    name = node.text("filepath").replace("\\", "/") if node else ""
    if node is None or not name:
        return None, remarks
    if "://" in name:
        raise node.error(f"the road {quoted(name)} lies elsewhere, and nothing is fetched", "put the .xodr beside it")
    if not Path(name).suffix:
        return None, [*remarks, f"the road {quoted(name)} is the name of a map, not a file: it is not read"]
    road = read_opendrive(_beside(node, folder, name), limits)
    return road, [*remarks, *road.remarks, "whether anybody leaves the road is not judged: that needs a road of ours"]


def _beside(node: Node, folder: Path, name: str) -> Path:
    """Where the road file is: where the scenario says, or in the scenario's own folder."""
    for candidate in (folder / name, folder / Path(name).name):
        try:
            if candidate.exists():
                return candidate
        except (OSError, ValueError):
            continue
    try:
        others = [path.name for path in folder.glob("*.xodr")]
    except OSError:
        others = []
    near = did_you_mean(Path(name).name, others)
    cure = near or "put it beside the scenario, or take <LogicFile> out if all positions are world positions"
    raise node.error(f"the road file {quoted(name)} is not there", cure)


def _recording(path: Path, parts: Sequence[Part], times: Grid) -> Recording:
    return Recording(
        name=path.stem or "imported",
        actors=tuple(part.entity.actor for part in parts),
        time=times.times,
        states=np.stack([states(part, times.times) for part in parts], axis=1),
        step=times.step,
        commands=all(map(_carries_commands, parts)),
    )


def _carries_commands(part: Part) -> bool:
    return part.believed and part.carried is not None and State.STEER in part.carried.columns


def _title(description: str, facts: Mapping[str, str]) -> str:
    """Our own descriptions go on with the facts, which stand in parameters, too."""
    return description.split(f" - {next(iter(facts))}: ")[0] if facts else description


def _provenance(root: Node, path: Path) -> Provenance:
    """What the header says, and what our own files say of themselves in parameters."""
    header = root.need("FileHeader")
    declarations = root.find("ParameterDeclarations")
    declared = {
        row.text("name"): row.text("value", "")
        for row in (declarations.every("ParameterDeclaration") if declarations else [])
    }
    facts = {name.removeprefix(FILE_PREFIX): value for name, value in declared.items() if name.startswith(FILE_PREFIX)}
    genome = {name: value for name, value in declared.items() if not name.startswith(FILE_PREFIX)} if facts else {}
    version = f"OpenSCENARIO 1.{header.text('revMinor', '0')[:3]}"
    return Provenance(
        title=_title(header.text("description", ""), facts)[:500],
        author=header.text("author", "")[:100],
        date=header.text("date", "")[:40] or Provenance().date,
        facts={**facts, "read from": path.name, "format": version},
        genome=genome,
    )
