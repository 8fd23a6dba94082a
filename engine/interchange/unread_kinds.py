"""What a file states and its reader does not read: one note for each kind, with its count and its first place."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from engine.interchange.contract import cited
from engine.interchange.xml import Node

MOST_KINDS = 50
"""Notes on one file; a last one counts the kinds that are left."""


@dataclass
class Unread:
    """Kinds of what was passed over, in the order of the file."""

    kinds: dict[str, tuple[int, str]] = field(default_factory=dict[str, tuple[int, str]])
    """How many there are of each, and where the first is."""

    def add(self, name: str, place: str) -> None:
        """Count one more."""
        count, first = self.kinds.get(name, (0, place))
        self.kinds[name] = count + 1, first

    def notes(self) -> tuple[str, ...]:
        """Return a note for each kind."""
        notes = [f"not read: {cited(name)} ({count:,}, {first})" for name, (count, first) in self.kinds.items()]
        more = len(notes) - MOST_KINDS
        return (*notes[:MOST_KINDS], *([f"not read: {more:,} more kinds"] if more > 0 else []))


def unread_elements(
    root: Node, read: Mapping[str, Collection[str] | None], remarked: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return notes on elements of other names than those of `read`, with all that is in them, and on attributes.

    `read`: the attributes that are read of each element; None where all are, or none is looked at. `remarked`: elements
    on which another remark is made.
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
        for name in node.attributes if attributes is not None else ():
            if attributes is not None and name not in attributes:
                found.add(f"{node.tag}.{name}", node.place)
        stack.extend(reversed(node.children))
    return found.notes()
