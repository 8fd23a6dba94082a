"""Content of a file that its reader does not read, by kind, with number and first place.

Nodes of road files record each access (`Node.read`), and `unread` finds the rest. Other readers name the elements that
they read (`unread_elements`), or note those that they skip (`Unread`). An unread element counts with all its content.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from engine.errors import cited, quoted
from engine.xml import Node

NOTHING = re.compile(r"\s*(false|[+-]?(0+\.?0*|\.0+)([eE][+-]?\d+)?)?\s*")
"""Values of attributes that state nothing: none, zero in any notation, false."""
MOST_KINDS = 50
"""Maximum number of notes on one file; a last note counts the remaining kinds."""


class Kind(NamedTuple):
    """Elements, attributes or lines of one name that are not read."""

    name: str
    """`roadMark`, or `pitch, roll of signal`."""
    number: int
    place: str
    """Place of the first."""

    def __str__(self) -> str:
        return f"{self.name} ({self.number:,}, {self.place})"


@dataclass
class Unread:
    """Skipped content, in the order of the file."""

    kinds: dict[str, Kind] = field(default_factory=dict[str, Kind])
    """Kinds by name."""

    def add(self, name: str, place: str) -> None:
        """Count one more element of a kind."""
        known = self.kinds.get(name)
        self.kinds[name] = Kind(name, 1, place) if known is None else known._replace(number=known.number + 1)

    def notes(self) -> tuple[str, ...]:
        """Return a note for each kind."""
        notes = [f"not read: {each._replace(name=cited(each.name))}" for each in self.kinds.values()]
        more = len(notes) - MOST_KINDS
        return (*notes[:MOST_KINDS], *([f"not read: {more:,} more kinds"] if more > 0 else []))


# -- what readers name, and what they never asked for ------------------------------------------------------------------


def unread_elements(
    root: Node, read: Mapping[str, Collection[str] | None], remarked: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return notes on elements that `read` does not name, with all their content, and on attributes whose value is not
    one of `NOTHING`.

    `read`: attributes that are read of each element; None: no note on its attributes. `remarked`: elements with another
    remark.
    """
    found, known = Unread(), {*remarked}
    stack = [root]
    while stack:
        node = stack.pop()
        if node.tag in known:
            continue
        if node.tag not in read:
            found.add(node.tag, node.place)
            continue
        attributes = read[node.tag]
        for name, value in node.attributes.items() if attributes is not None else ():
            if attributes is not None and name not in attributes and not NOTHING.fullmatch(value):
                found.add(f"{node.tag}.{name}", node.place)
        stack.extend(reversed(node.children))
    return found.notes()


def unread(root: Node, known: Collection[str] = ()) -> tuple[Kind, ...]:
    """Return every kind that was not read, in the order of the file: elements first, then attributes.

    The attributes of an element of one name are one kind. `known`: elements (`header`) and attributes (`name`,
    `connection id`) that are irrelevant to the reader.
    """
    elements: dict[str, list[int]] = {}
    attributes: dict[str, tuple[dict[str, None], list[int]]] = {}
    for node in _visited(root):
        for child in node.children:
            if child.read is None and child.tag not in known:
                elements.setdefault(child.tag, []).append(child.line)
        if names := [name for name in node.attributes if _is_unread(node, name, known)]:
            seen, lines = attributes.setdefault(node.tag, ({}, []))
            seen.update(dict.fromkeys(names))
            lines.append(node.line)
    return (
        *(Kind(_shown(tag), len(lines), f"line {min(lines)}") for tag, lines in elements.items()),
        *(
            Kind(f"{', '.join(map(_shown, names))} of {_shown(tag)}", len(lines), f"line {min(lines)}")
            for tag, (names, lines) in attributes.items()
        ),
    )


def _visited(root: Node) -> Iterator[Node]:
    """Yield the elements that a reader has accessed."""
    stack = [root]
    while stack:
        yield (node := stack.pop())
        stack += [child for child in reversed(node.children) if child.read is not None]


def _is_unread(node: Node, name: str, known: Collection[str]) -> bool:
    """Return True for an attribute that was never accessed; a name space does not count."""
    is_known = name in known or f"{node.tag} {name}" in known or name.partition(":")[0] == "xmlns"
    return not is_known and name not in (node.read or ())


def _shown(text: str) -> str:
    return quoted(text)[1:-1]


def not_read(kinds: Collection[Kind]) -> str:
    """Return the sentence about these kinds; "" for none."""
    return f"not read: {', '.join(map(str, kinds))}" if kinds else ""
