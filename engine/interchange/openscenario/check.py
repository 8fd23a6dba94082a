"""Check of OpenSCENARIO's rules that its schema does not contain, or whose violation is known to confuse readers.

docs/how-to/cases-elsewhere.md describes them. A replay is also read back and compared with the run.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from engine.errors import InterchangeError
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.opendrive.check import check_opendrive
from engine.interchange.openscenario.read import read_openscenario
from engine.interchange.read_back import Tree, read_tree, same_run
from engine.interchange.recording import RecordedCase


def check_openscenario(
    case: RecordedCase, folder: Path, names: Sequence[str], options: ExportOptions
) -> Iterator[Finding]:
    """Yield violations of OpenSCENARIO's rules, and differences between a replay and its run above a millimetre."""
    for name in (each for each in names if each.endswith(".xosc")):
        yield from scenario_rules(folder, name)
        if options.mode != "trajectory":  # maneuvers require a simulator
            continue
        try:
            read = read_openscenario(folder / name).recording
        except InterchangeError as error:
            yield Finding(error.place or name, error.message, error.cure)
            continue
        yield from same_run(_as_written(case, options), read, name)
    yield from check_opendrive(case, folder, names, options)


def _as_written(case: RecordedCase, options: ExportOptions) -> RecordedCase:
    """Return the part of the case whose replay is motion of the run."""
    after, contact = options.after_contact or "through", case.recording.contact
    if contact is None or after == "physics":
        return case
    samples = case.recording.scored_samples()
    cut = replace(case.recording, time=case.recording.time[:samples], states=case.recording.states[:samples])
    return replace(case, recording=cut)


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
    """Yield findings unless a file of parameter values contains values."""
    for tag in ("ValueSetDistribution", "ParameterValueSet", "Stochastic"):
        for element in tree.root.iter(tag):
            if not len(element):
                yield tree.finding(element, f"<{tag}> holds no values", "write one case at least")


def _named_once(tree: Tree) -> Iterator[Finding]:
    """Yield findings for sibling elements of one kind with equal names."""
    for element in tree.root.iter():
        names = Counter((child.tag, child.get("name")) for child in element if child.get("name"))
        for (tag, name), count in names.items():
            if count > 1:
                yield tree.finding(element, f"{count} <{tag}> are called `{name}`", "give each a name of its own")


def _entities(tree: Tree) -> Iterator[Finding]:
    """Check that every entity that is referred to exists."""
    known = {each.get("name", "") for each in tree.root.iter("ScenarioObject")}
    for element in tree.root.iter():
        who = element.get("entityRef")
        if who is not None and who not in known and not who.startswith("$"):
            yield tree.finding(element, f"there is no entity `{who}`", f"known: {', '.join(sorted(known))}")


def _referenced(tree: Tree, folder: Path, tag: str) -> Iterator[Finding]:
    """Yield findings for files that are named but missing."""
    for element in tree.root.iter(tag):
        path = element.get("filepath", "")
        if not (folder / path).is_file():
            yield tree.finding(element, f"there is no file `{path}`", "put it beside this one")


def _timing(tree: Tree) -> Iterator[Finding]:
    """Yield findings for trajectories without <Timing>: esmini ignores their times (esmini 642, 121)."""
    for element in tree.root.iter("FollowTrajectoryAction"):
        if element.find("TimeReference/Timing") is None:
            yield tree.finding(element, "a trajectory without <Timing>, whose times are passed over", "give it one")


def _ends(tree: Tree) -> Iterator[Finding]:
    """Yield findings unless there is an end, and the start is not a step late."""
    stop = tree.root.find("Storyboard/StopTrigger")
    if stop is None or not len(stop):
        yield tree.finding(tree.root, "it never ends: there is no StopTrigger with a condition", "give it one")
    late = (each for each in tree.root.iter("SimulationTimeCondition") if each.get("value") in ("0", "0.0"))
    for element in late:
        if element.get("rule") == "greaterThan" and _version(tree) > "1.0":
            yield tree.finding(element, "`greaterThan` 0 starts a step late", "write `greaterOrEqual`")


def _version(tree: Tree) -> str:
    """Return the version of OpenSCENARIO: `1.2`."""
    header = tree.find("FileHeader")
    return "" if header is None else f"{header.get('revMajor')}.{header.get('revMinor')}"
