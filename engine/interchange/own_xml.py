"""XML files of an export, as its checks read them."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from engine.interchange.contract import Finding


@dataclass(frozen=True)
class Tree:
    """An XML file of an export, with the places of its elements in words."""

    name: str
    root: Element

    def find(self, tag: str) -> Element | None:
        return next(self.root.iter(tag), None)

    def finding(self, element: Element, reason: str, cure: str = "") -> Finding:
        called = element.get("name") or element.get("id") or ""
        return Finding(f"{self.name}, {element.tag} {called}".rstrip(), reason, cure)


def read_tree(path: Path) -> Tree:
    """Return a file that was just written, so that it needs no protection against hostile content."""
    return Tree(path.name, ElementTree.parse(path).getroot())  # noqa: S314
