"""Laws of the syntax tree: text and tree say the same, and a part lies inside its whole."""

import dataclasses
from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.unparse import unparse


def children(value: Any) -> Iterator[nodes.Node]:
    """The nodes directly below a node."""
    if isinstance(value, nodes.Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from children(item)


def spans_nest(parent: nodes.Node) -> None:
    for field in dataclasses.fields(parent):
        for child in children(getattr(parent, field.name)):
            assert parent.span.start <= child.span.start <= child.span.end <= parent.span.end, (parent, child)
            spans_nest(child)


@settings(suppress_health_check=list(HealthCheck))  # pyright: ignore[reportArgumentType]
@given(st.data())
def test_print_then_parse_gives_the_same_tree(programs: st.SearchStrategy[nodes.Module], data: st.DataObject) -> None:
    """What is written for a tree reads as that tree, and spans nest in what was read."""
    module = data.draw(programs)
    text = unparse(module)
    read = parse(Source("generated", text))
    assert read == module, text
    assert unparse(read) == text
    spans_nest(read)
