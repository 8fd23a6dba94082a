"""Scenarios of cortexc: the name of each, its docstring, and the files that it needs."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources.abc import Traversable

from cortex_dsl.installation import resource

SUFFIX = ".scn"
FOLDERS = ("examples", "examples/roads", "examples/streets", "examples/own_driver", "examples/paper")
"""Folders in the order of the list: case studies of the paper, roads that are no grid, streets with sidewalks, a
driver of one's own, and the case studies once more with validity that depends on several params."""


@dataclass(frozen=True)
class Example:
    """A scenario, and the files of its folder that it speaks of: maps, drivers."""

    scenario: Traversable
    beside: tuple[Traversable, ...]

    @property
    def name(self) -> str:
        """Return the name of the file without the suffix, such as `left_turn`."""
        return self.scenario.name.removesuffix(SUFFIX)

    @property
    def files(self) -> tuple[Traversable, ...]:
        """Return all files that it needs to run, the scenario first."""
        return (self.scenario, *self.beside)

    @cached_property
    def text(self) -> str:
        """The scenario."""
        return self.scenario.read_text(encoding="utf-8")

    @property
    def summary(self) -> str:
        """Return the first paragraph of the docstring as one line."""
        paragraph, _, _ = self.text.partition("\n\n")
        return " ".join(paragraph.strip('"').split())


@lru_cache(maxsize=1)
def examples() -> tuple[Example, ...]:
    """All of them, folder by folder; in each in the order of their summaries, as these may begin with a letter."""
    return tuple(each for folder in FOLDERS for each in _of(resource(folder)))


def _of(folder: Traversable) -> list[Example]:
    files = sorted((file for file in folder.iterdir() if file.is_file()), key=lambda file: file.name)
    others = [file for file in files if not file.name.endswith((SUFFIX, ".md"))]
    found = []
    for file in files:
        if file.name.endswith(SUFFIX):
            text = file.read_text(encoding="utf-8")
            found.append(Example(file, tuple(other for other in others if other.name in text)))
    return sorted(found, key=lambda each: each.summary)
