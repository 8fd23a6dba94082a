"""Check of an exported CommonRoad scenario: ids, references, and actors. Motion is not read back."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from engine.interchange.commonroad.steps import timeline
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.opendrive.check import twice
from engine.interchange.read_back import read_tree
from engine.interchange.recording import RecordedCase

OTHERS, BUILDINGS = ("dynamicObstacle", "staticObstacle"), ("environmentObstacle",)


def check_commonroad(
    case: RecordedCase, folder: Path, names: Sequence[str], _options: ExportOptions
) -> Iterator[Finding]:
    """Yield findings unless ids are unique, references are valid, and the ego has a planning problem."""
    for name in (each for each in names if each.endswith(".cr.xml")):
        tree = read_tree(folder / name)
        ids = [element.get("id", "") for element in tree.root.iter() if element.get("id")]
        for each in twice(ids):
            yield tree.finding(tree.root, f"the id {each} is there twice", "give each element an id of its own")
        for element in tree.root.iter():
            to = element.get("ref")
            if to is not None and to not in ids:
                yield tree.finding(element, f"it refers to {to}, which is not there", "name an id of this file")
        if tree.find("planningProblem") is None:
            yield tree.finding(tree.root, "the ego has no planningProblem", "give it one")
        line = timeline(case.replay)
        there = (("obstacles", OTHERS, len(line.others)), ("buildings", BUILDINGS, len(line.buildings)))
        for what, tags, wanted in there:
            if (found := sum(1 for tag in tags for _ in tree.root.iter(tag))) != wanted:
                yield tree.finding(tree.root, f"{found} {what} of {wanted} are there", "export it again")
