"""Check of an exported road: ids are unique, links are valid, and lanes are at the places of the network's lanes."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from engine.errors import InterchangeError
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.opendrive.places import road_map
from engine.interchange.read_back import Tree, read_tree
from engine.interchange.recording import RecordedCase
from engine.maps import MapFile, MapSpec
from engine.opendrive.read import read_opendrive
from engine.road import build_network

NEAR = 1e-3
"""[m]"""
BETWEEN = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Parts of a lane at which its middle is checked."""


def check_opendrive(
    case: RecordedCase, folder: Path, names: Sequence[str], _options: ExportOptions
) -> Iterator[Finding]:
    """Yield findings unless ids are unique, links are valid, and lanes are at the places of the network's lanes."""
    for name in (each for each in names if each.endswith(".xodr")):
        tree = read_tree(folder / name)
        roads = [each.get("id", "") for each in tree.root.iter("road")]
        junctions = [each.get("id", "") for each in tree.root.iter("junction")]
        for tag, ids in (("road", roads), ("junction", junctions)):
            for each in twice(ids):
                yield tree.finding(tree.root, f"two <{tag}> have the id {each}", "give each an id of its own")
        yield from _links(tree, {"road": set(roads), "junction": set(junctions)})
        if case.recording.road is not None and not isinstance(case.recording.road, MapFile):
            yield from _lanes(case.recording.road, folder / name)


def twice(ids: Iterable[str]) -> list[str]:
    """Return the ids that occur more than once."""
    return [each for each, count in Counter(ids).items() if count > 1]


def _links(tree: Tree, known: dict[str, set[str]]) -> Iterator[Finding]:
    for link in tree.root.iterfind("road/link/*"):
        kind, to = link.get("elementType", ""), link.get("elementId", "")
        if to not in known.get(kind, set()):
            yield tree.finding(link, f"it leads to the {kind} {to}, which is not there", "name one of this file")
    for connection in tree.root.iter("connection"):
        for way in ("incomingRoad", "connectingRoad"):
            if connection.get(way) not in known["road"]:
                yield tree.finding(connection, f"there is no road {connection.get(way)}", "name one of this file")


def _lanes(spec: MapSpec, path: Path) -> Iterator[Finding]:
    network, where = build_network(spec), road_map(spec)
    try:
        read = read_opendrive(path)
        for lane in network.lanes:
            for part in BETWEEN:
                ours, place = (
                    network.paths.pose(lane.path, part * lane.length),
                    where.place(lane.id, part * lane.length),
                )
                found = read.pose(place.road, place.lane, place.s)
                off = max(abs(ours.x - found.x), abs(ours.y - found.y))
                if not off <= NEAR:
                    yield Finding(
                        f"{path.name}, road {place.road}", f"lane {place.lane} lies {off:.3g} m off", "export it again"
                    )
                    break
    except InterchangeError as error:
        yield Finding(error.place or path.name, error.message, error.cure)
