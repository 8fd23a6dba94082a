"""What a file states and its reader never asked for, so that nothing is left out without a note.

Nodes record what is asked of them (`Node.read`). The rest is named kind by kind: an element that no reader asked for
counts with all that is in it; the attributes of an element of one name are one kind.
"""

from collections.abc import Collection, Iterator
from typing import NamedTuple

from engine.interchange.contract import quoted
from engine.interchange.xml import Node


class Unread(NamedTuple):
    """One kind of element, or the attributes of one, that are not read."""

    name: str
    """`roadMark`, or `pitch, roll of signal`."""
    elements: int
    """Their number."""
    line: int
    """Where the first one stands in the file."""

    def __str__(self) -> str:
        return f"{self.name} ({self.elements}, line {self.line})"


def unread(root: Node, known: Collection[str] = ()) -> tuple[Unread, ...]:
    """Return every kind that was not read, in the order of the file: elements first, then attributes.

    `known`: elements (`header`) and attributes (`name`, `connection id`) that say nothing of what the reader is after.
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
        *(Unread(_shown(tag), len(lines), min(lines)) for tag, lines in elements.items()),
        *(
            Unread(f"{', '.join(map(_shown, names))} of {_shown(tag)}", len(lines), min(lines))
            for tag, (names, lines) in attributes.items()
        ),
    )


def _visited(root: Node) -> Iterator[Node]:
    """Yield the elements that a reader asked for."""
    stack = [root]
    while stack:
        yield (node := stack.pop())
        stack += [child for child in reversed(node.children) if child.read is not None]


def _is_unread(node: Node, name: str, known: Collection[str]) -> bool:
    """Return True for an attribute that nobody asked for; a name space is no statement."""
    is_known = name in known or f"{node.tag} {name}" in known or name.partition(":")[0] == "xmlns"
    return not is_known and name not in (node.read or ())


def _shown(text: str) -> str:
    return quoted(text)[1:-1]


def not_read(kinds: Collection[Unread]) -> str:
    """Return the sentence about these kinds; "" for none."""
    return f"not read: {', '.join(map(str, kinds))}" if kinds else ""
