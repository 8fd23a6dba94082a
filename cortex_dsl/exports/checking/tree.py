"""An XML file of ours, with the places of its elements in words."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from cortex_dsl.exports.findings import Finding


@dataclass(frozen=True)
class Tree:
    name: str
    root: Element

    def find(self, tag: str) -> Element | None:
        return next(self.root.iter(tag), None)

    def version(self) -> str:
        """Of OpenSCENARIO, `1.2`."""
        header = self.find("FileHeader")
        return "" if header is None else f"{header.get('revMajor')}.{header.get('revMinor')}"

    def finding(self, element: Element, reason: str, cure: str = "") -> Finding:
        called = element.get("name") or element.get("id") or ""
        return Finding(f"{self.name}, {element.tag} {called}".rstrip(), reason, cure)


def read_tree(path: Path) -> Tree:
    """A file that was written just now, so that it may be read without suspicion."""
    return Tree(path.name, ElementTree.parse(path).getroot())  # noqa: S314
