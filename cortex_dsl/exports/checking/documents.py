"""The rules of each format that a schema does not hold, or that readers are known to trip over.

docs/how-to/cases-elsewhere.md tells of them.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from cortex_dsl.exports.cases import ExportCase
from cortex_dsl.exports.checking.tree import Tree, read_tree
from cortex_dsl.exports.findings import Finding
from engine.interchange.commonroad.timeline import timeline
from engine.interchange.errors import InterchangeError
from engine.interchange.export import ExportOptions
from engine.road import build_network
from engine.vocabulary import State

NEAR = 1e-3
"""[m]"""
BETWEEN = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Parts of a lane at which its middle is looked at."""


# -- OpenSCENARIO -----------------------------------------------------------------------------------------------------


def scenario_rules(folder: Path, name: str) -> Iterator[Finding]:
    tree = read_tree(folder / name)
    if tree.find("Storyboard") is None:  # a distribution of parameters
        yield from _referenced(tree, folder, "ScenarioFile")
        yield from _values(tree)
        return
    yield from _named_once(tree)
    yield from _entities(tree)
    yield from _referenced(tree, folder, "LogicFile")
    yield from _timing(tree)
    yield from _ends(tree)


def _values(tree: Tree) -> Iterator[Finding]:
    """Something is drawn or set by a file of parameter values."""
    for tag in ("ValueSetDistribution", "ParameterValueSet", "Stochastic"):
        for element in tree.root.iter(tag):
            if not len(element):
                yield tree.finding(element, f"<{tag}> holds no values", "write one case at least")


def _named_once(tree: Tree) -> Iterator[Finding]:
    """No two elements of one kind beside each other have the same name."""
    for element in tree.root.iter():
        names = Counter((child.tag, child.get("name")) for child in element if child.get("name"))
        for (tag, name), count in names.items():
            if count > 1:
                yield tree.finding(element, f"{count} <{tag}> are called `{name}`", "give each a name of its own")


def _entities(tree: Tree) -> Iterator[Finding]:
    """Whoever is spoken of takes part."""
    known = {each.get("name", "") for each in tree.root.iter("ScenarioObject")}
    for element in tree.root.iter():
        who = element.get("entityRef")
        if who is not None and who not in known and not who.startswith("$"):
            yield tree.finding(element, f"there is no entity `{who}`", f"known: {', '.join(sorted(known))}")


def _referenced(tree: Tree, folder: Path, tag: str) -> Iterator[Finding]:
    """A file that is named is there."""
    for element in tree.root.iter(tag):
        path = element.get("filepath", "")
        if not (folder / path).is_file():
            yield tree.finding(element, f"there is no file `{path}`", "put it beside this one")


def _timing(tree: Tree) -> Iterator[Finding]:
    """A replay keeps its times: esmini passes over those of a trajectory without <Timing> (esmini 642, 121)."""
    for element in tree.root.iter("FollowTrajectoryAction"):
        if element.find("TimeReference/Timing") is None:
            yield tree.finding(element, "a trajectory without <Timing>, whose times are passed over", "give it one")


def _ends(tree: Tree) -> Iterator[Finding]:
    """There is an end, and the start does not come a step late."""
    stop = tree.root.find("Storyboard/StopTrigger")
    if stop is None or not len(stop):
        yield tree.finding(tree.root, "it never ends: there is no StopTrigger with a condition", "give it one")
    late = (each for each in tree.root.iter("SimulationTimeCondition") if each.get("value") in ("0", "0.0"))
    for element in late:
        if element.get("rule") == "greaterThan" and tree.version() > "1.0":
            yield tree.finding(element, "`greaterThan` 0 starts a step late", "write `greaterOrEqual`")


# -- OpenDRIVE --------------------------------------------------------------------------------------------------------


def opendrive(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """Ids are unique, links lead somewhere, and lanes lie where ours lie."""
    for name in (each for each in names if each.endswith(".xodr")):
        tree = read_tree(folder / name)
        roads = [each.get("id", "") for each in tree.root.iter("road")]
        junctions = [each.get("id", "") for each in tree.root.iter("junction")]
        for tag, ids in (("road", roads), ("junction", junctions)):
            for twice in _twice(ids):
                yield tree.finding(tree.root, f"two <{tag}> have the id {twice}", "give each an id of its own")
        yield from _links(tree, {"road": set(roads), "junction": set(junctions)})
        yield from _lanes(case, folder / name)


def _twice(ids: Iterable[str]) -> list[str]:
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


def _lanes(case: ExportCase, path: Path) -> Iterator[Finding]:
    from engine.interchange.opendrive import road_map
    from engine.interchange.reading import read_opendrive

    spec = case.scenario.program.road_spec
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


# -- the others -------------------------------------------------------------------------------------------------------


def commonroad(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """Ids are unique, references lead somewhere, and the ego has a problem to solve."""
    for name in (each for each in names if each.endswith(".cr.xml")):
        tree = read_tree(folder / name)
        ids = [element.get("id", "") for element in tree.root.iter() if element.get("id")]
        for twice in _twice(ids):
            yield tree.finding(tree.root, f"the id {twice} is there twice", "give each element an id of its own")
        for element in tree.root.iter():
            to = element.get("ref")
            if to is not None and to not in ids:
                yield tree.finding(element, f"it refers to {to}, which is not there", "name an id of this file")
        if tree.find("planningProblem") is None:
            yield tree.finding(tree.root, "the ego has no planningProblem", "give it one")
        others = sum(1 for tag in ("dynamicObstacle", "staticObstacle") for _ in tree.root.iter(tag))
        wanted = len(timeline(case.replay).others)
        if others != wanted:
            yield tree.finding(tree.root, f"{others} obstacles of {wanted} are there", "export it again")


def scenic(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """The road is there, and everybody stands where the run began."""
    for name in (each for each in names if each.endswith(".scenic")):
        text = (folder / name).read_text(encoding="utf-8")
        road = next((each for each in names if each.endswith(".xodr")), "")
        if f"localPath({road!r})" not in text or not (folder / road).is_file():
            yield Finding(name, "its road is not beside it", "export it again")
        for actor, state in zip(case.recording.actors, case.recording.states[0].tolist(), strict=True):
            place = re.escape(f"at ({state[State.X]!r}, {state[State.Y]!r})")
            if state[State.PRESENT] and not re.search(rf"new (?!Point|OrientedPoint)\w+ {place}", text):
                yield Finding(f"{name}, {actor.name}", "it does not stand where the run began", "export it again")
