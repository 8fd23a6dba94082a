"""Texts with values back to text."""

from collections.abc import Callable

from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import write_string

Write = Callable[[nodes.Expression], str]


def write_formatted(node: nodes.Formatted, write: Write) -> str:
    """A literal within quotes that no value in it has."""
    values = "".join(_placeholder(part, write) for part in node.parts if isinstance(part, nodes.Placeholder))
    quotes = next((each for each in ('"', "'", "'''") if each not in values), '"""')
    parts = (_between(part, quotes) if isinstance(part, str) else _placeholder(part, write) for part in node.parts)
    return f"f{quotes}{''.join(parts)}{quotes}"


def _placeholder(node: nodes.Placeholder, write: Write) -> str:
    value = write(node.value)
    gap = " " if value.startswith("{") else ""  # two braces would be one of the text
    return f"{{{gap}{value}{f':{node.layout}' if node.layout else ''}}}"


def _between(text: str, quotes: str) -> str:
    escaped = write_string(text)[1:-1].replace("{", "{{").replace("}", "}}")
    return escaped if quotes == '"' else escaped.replace("'", "\\'")
