"""An element of somebody else's XML, which remembers where it stands and says what is wrong with it."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from engine.interchange.errors import InterchangeError, did_you_mean, quoted
from engine.interchange.xml_text import INFINITE, LARGEST, NUMBER


@dataclass(eq=False, slots=True)
class Node:
    """One element; text between elements is not kept, since no format here says anything with it."""

    tag: str
    attributes: Mapping[str, str]
    file: str
    line: int
    children: list["Node"] = field(default_factory=list)

    @property
    def place(self) -> str:
        return f"{self.file}, line {self.line}"

    def error(self, message: str, cure: str) -> InterchangeError:
        """What is wrong here."""
        return InterchangeError(message, cure, self.place)

    def every(self, *tags: str) -> list["Node"]:
        """Children of these names, in the order of the file."""
        return [node for node in self.children if node.tag in tags]

    def find(self, *path: str) -> "Node | None":
        """The first element down a path of names."""
        node: Node | None = self
        for tag in path:
            node = next((child for child in node.children if child.tag == tag), None) if node else None
        return node

    def need(self, *path: str) -> "Node":
        """As `find`.

        Raises:
            InterchangeError: it is not there.
        """
        if (node := self.find(*path)) is not None:
            return node
        raise self.error(f"<{self.tag}> has no <{'/'.join(path)}>", f"write <{path[-1]}> into it")

    def only(self) -> "Node":
        """Its one child element."""
        if len(self.children) == 1:
            return self.children[0]
        said = "is empty" if not self.children else f"holds {len(self.children)} elements"
        raise self.error(f"<{self.tag}> {said}", "it must hold exactly one")

    def walk(self) -> Iterator["Node"]:
        """Itself and everything within, in the order of the file."""
        stack: list[Node] = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children))

    def text(self, name: str, default: str | None = None) -> str:
        """An attribute.

        Raises:
            InterchangeError: it is missing and there is no default.
        """
        value = self.attributes.get(name, default)
        if value is None:
            near = did_you_mean(name, self.attributes, few=0)
            raise self.error(f"<{self.tag}> lacks the attribute `{name}`", near or f'write {name}="…"')
        return value

    def number(self, name: str, default: float | None = None, low: float = -LARGEST, high: float = LARGEST) -> float:
        """An attribute as a number within bounds; with `high` infinite, INF is one, too.

        Raises:
            InterchangeError: missing without default, no number, not finite, or out of bounds.
        """
        if default is not None and name not in self.attributes:
            return default
        text = self.text(name)
        if high == math.inf and text.strip() in INFINITE:
            return math.inf
        if not NUMBER.fullmatch(text):
            raise self.error(f"{name}={quoted(text)} is not a number", "write a finite decimal number")
        value = float(text)
        if not low <= value <= high:
            bounds = f"from {low:g} to {high:g}"
            raise self.error(f"{name}={quoted(text)} cannot be: it must be {bounds}", "correct the number")
        return value

    def integer(self, name: str) -> int:
        """An attribute as a whole number of at most nine digits."""
        text = self.text(name).strip()
        if not re.fullmatch(r"[+-]?\d{1,9}", text, re.ASCII):
            raise self.error(f"{name}={quoted(text)} is not a whole number", "write one such as -1")
        return int(text)
