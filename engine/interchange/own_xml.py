"""XML files that an export of ours wrote just now, as its checks look at them."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from engine.interchange.contract import Finding


@dataclass(frozen=True)
class Tree:
    """An XML file of ours, with the places of its elements in words."""

    name: str
    root: Element

    def find(self, tag: str) -> Element | None:
        return next(self.root.iter(tag), None)

    def finding(self, element: Element, reason: str, cure: str = "") -> Finding:
        called = element.get("name") or element.get("id") or ""
        return Finding(f"{self.name}, {element.tag} {called}".rstrip(), reason, cure)


def read_tree(path: Path) -> Tree:
    """A file that was written just now, so that it may be read without suspicion."""
    return Tree(path.name, ElementTree.parse(path).getroot())  # noqa: S314
