"""What is gathered while a file is written: lines for its head, and what cannot be said in it."""

import re
from dataclasses import dataclass, field

from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.errors import Signal


class Unsaid(Signal):
    """Scenic has no words for an expression."""

    def __init__(self, what: str, span: Span) -> None:
        self.what = what
        """Of which a sentence can say "Scenic has no …"."""
        self.span = span
        super().__init__(what)


@dataclass
class Sheet:
    """Filled from top to bottom; its order is that of the file."""

    source: Source
    lookups: dict[str, str] = field(default_factory=dict)
    """Value by name: the parts of the road that the file names."""
    mathematics: set[str] = field(default_factory=set)
    classes: dict[str, str] = field(default_factory=dict)
    """Base by name: classes that Scenic's library has not."""
    stand_ins: dict[str, None] = field(default_factory=dict)
    """Behaviours that the file has to bring along."""
    remarks: dict[str, None] = field(default_factory=dict)

    def remark(self, text: str, span: Span | None = None) -> None:
        """Something to be told, with its line in the file of the author."""
        place = "" if span is None else f"line {self.source.position(span.start).line}: "
        self.remarks[f"{place}{text}"] = None

    def free_name(self, wanted: str) -> str:
        """A name like the wanted one that the author's file does not use."""
        name = re.sub(r"\W+", "_", wanted)
        while re.search(rf"\b{name}\b", self.source.whole):
            name += "_"
        return name


def verbatim(text: str) -> nodes.Name:
    """Text as it is to stand in the file: the printer of trees writes names as they are."""
    return nodes.Name(text, span=NOWHERE)


def comments(text: str) -> tuple[nodes.Statement, ...]:
    """Every line of a text behind a number sign; they tell and do nothing."""
    return tuple(nodes.ExpressionStatement(verbatim(f"# {each}".rstrip()), span=NOWHERE) for each in text.splitlines())


def is_comment(node: nodes.Statement) -> bool:
    value = node.value if isinstance(node, nodes.ExpressionStatement) else None
    return isinstance(value, nodes.Name) and value.id.startswith("#")


NOWHERE = Span(0, 0)
