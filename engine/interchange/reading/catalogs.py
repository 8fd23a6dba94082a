"""Entries of catalogs that stand beside a scenario, with their parameters put in."""

from collections.abc import Iterator
from pathlib import Path

from engine.interchange.errors import InterchangeError, did_you_mean, quoted
from engine.interchange.reading.node import Node
from engine.interchange.reading.parameters import substituted
from engine.interchange.reading.xml import Limits, read_xml

MOST_FILES = 100
"""Of one catalog folder."""


class Catalogs:
    """The catalog files that a scenario's `CatalogLocations` name, read when somebody asks."""

    def __init__(self, scenario: Node, folder: Path, limits: Limits) -> None:
        self._folders = [
            folder / node.text("path").replace("\\", "/")
            for node in (scenario.find("CatalogLocations") or scenario).walk()
            if node.tag == "Directory"
        ]
        self._limits = limits
        self._read: dict[str, Node] | None = None

    def entry(self, reference: Node) -> Node:
        """The element that a `CatalogReference` names, its parameters assigned.

        Raises:
            InterchangeError: no such catalog or entry, said by name.
        """
        catalog, entry = reference.text("catalogName"), reference.text("entryName")
        if self._read is None:
            self._read = dict(self._files())
        if catalog not in self._read:
            cure = did_you_mean(catalog, self._read) or "put the catalog there, or write the element in its place"
            raise reference.error(f"the catalog {quoted(catalog)} is not beside the scenario", cure)
        rows = {node.attributes.get("name", ""): node for node in self._read[catalog].children}
        if entry not in rows:
            raise reference.error(
                f"{quoted(catalog)} has no entry {quoted(entry)}", did_you_mean(entry, rows) or "fill it"
            )
        assignments = reference.find("ParameterAssignments")
        rows_assigned = assignments.every("ParameterAssignment") if assignments else []
        assigned = {row.text("parameterRef").lstrip("$"): row.text("value") for row in rows_assigned}
        return substituted(rows[entry], assigned=assigned)

    def _files(self) -> Iterator[tuple[str, Node]]:
        """Catalogs by name, and by the name of their file, which some writers refer to."""
        for folder in self._folders:
            for path in self._paths(folder):
                root = read_xml(path, "OpenSCENARIO", self._limits)
                if (catalog := root.find("Catalog")) is not None:
                    yield path.stem, catalog
                    yield catalog.text("name"), catalog

    def _paths(self, folder: Path) -> list[Path]:
        try:
            paths = sorted(folder.glob("*.xosc"))
        except (OSError, ValueError):
            return []
        if len(paths) > MOST_FILES:
            raise InterchangeError(
                f"there are {len(paths)} catalogs", f"keep at most {MOST_FILES} in one folder", folder.name
            )
        return paths
