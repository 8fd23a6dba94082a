"""How every view is laid out: quiet headings, columns without boxes, two spaces of margin."""

from collections.abc import Iterable
from textwrap import shorten

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text

MARGIN = 2


def heading(title: str, note: str = "") -> Text:
    """A section's title, with a remark in a quiet voice."""
    return Text.assemble((title, "title"), ("  " + note if note else "", "quiet"))


def section(title: str, body: RenderableType, note: str = "") -> Group:
    """A titled block, set apart by an empty line."""
    return Group(Text(), heading(title, note), indented(body))


def indented(body: RenderableType) -> Padding:
    return Padding(body, (0, 0, 0, MARGIN))


def shortened(text: str, room: int) -> str:
    """As many whole words as there is room for, and a sign where some are left out."""
    words = shorten(text, room, placeholder=" …") if room > 2 else "…"
    return words if words.strip() != "…" else text[: max(0, room - 1)] + "…"


def columns(*specification: Column, rows: Iterable[Iterable[RenderableType]] = (), header: bool = False) -> Table:
    """A table without lines. Columns whose header is a number's should be right-aligned."""
    table = Table(
        *specification,
        box=None,
        show_header=header,
        header_style="quiet",
        padding=(0, 2, 0, 0),
        pad_edge=False,
        collapse_padding=True,
    )
    for row in rows:
        table.add_row(*row)
    return table


def left(title: str = "", style: str = "", *, wrap: bool = False) -> Column:
    return Column(title, style=style, no_wrap=not wrap, overflow="fold" if wrap else "ellipsis")


def right(title: str = "", style: str = "") -> Column:
    return Column(title, style=style, justify="right", no_wrap=True)


def quantity(number: str, unit: str) -> Text:
    """A number and its unit in a quiet voice."""
    return Text.assemble(number, (" " + unit if unit else "", "unit"))
