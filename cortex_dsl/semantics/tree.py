"""Walking the syntax tree."""

from collections.abc import Iterator
from dataclasses import fields
from functools import cache

from cortex_dsl.syntax import nodes


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    return tuple(f.name for f in fields(kind))


def parts(node: nodes.Node) -> Iterator[nodes.Node]:
    """The nodes directly inside a node, in the order of the text."""
    for name in _field_names(type(node)):
        yield from _nodes_in(getattr(node, name))


def everything_in(node: nodes.Node) -> Iterator[nodes.Node]:
    """All nodes below a node."""
    for part in parts(node):
        yield part
        yield from everything_in(part)


def _nodes_in(value: object) -> Iterator[nodes.Node]:
    if isinstance(value, nodes.Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _nodes_in(item)
