"""Results in words and in notebooks: counts with their nouns, and small HTML tables of names and values or columns."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

ROWS = 10
"""Maximum number of rows that are shown of a longer table."""


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return a count with its noun: `1 scene`, `2 scenes`, `1,000 scenes`."""
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"


def facts_table(facts: Iterable[tuple[str, str]]) -> str:
    """Return a table of names and values, one per row."""
    rows = (f'<tr><th style="text-align:left">{escape(name)}</th><td>{escape(text)}</td></tr>' for name, text in facts)
    return f"<table><tbody>{''.join(rows)}</tbody></table>"


def columns_table(columns: Mapping[str, Sequence[Any]], length: int) -> str:
    """Return the first rows of columns under their names, and the number of rows `length` if there are more."""
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    rows = (
        "".join(f"<td>{_cell(column[row])}</td>" for column in columns.values()) for row in range(min(length, ROWS))
    )
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    more = f"<p>{length:,} rows</p>" if length > ROWS else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else escape(str(value))
