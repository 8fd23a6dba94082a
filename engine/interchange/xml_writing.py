"""XML writer of all formats: one element per line, numbers that read back to the same value."""

import math
import re
from decimal import Decimal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from engine.errors import InterchangeError

NO_CHARACTER = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot contain, even escaped (W3C, "Extensible Markup Language (XML) 1.0", production 2)."""


def child(parent: Element, tag: str, /, **attributes: str | float | int) -> Element:
    """Return a new last child; numbers become text (see `number`)."""
    texts = {name: value if isinstance(value, str) else number(value) for name, value in attributes.items()}
    return SubElement(parent, tag, texts)


def number(value: float) -> str:
    """Return the shortest text that reads back to the same number; -0.0 is 0."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    return repr(float(value) + 0.0).removesuffix(".0")


def decimal(value: float) -> str:
    """Return `number` without an exponent, which neither xs:decimal nor some readers' expressions accept."""
    text = f"{Decimal(repr(float(value) + 0.0)):f}" if math.isfinite(value) else repr(value)
    return text.removesuffix(".0")


def xml_text(root: Element) -> str:
    """Return the whole document.

    Raises:
        InterchangeError: a text contains a character that XML cannot.
    """
    ElementTree.indent(root, " ")
    text = '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
    if (mark := NO_CHARACTER.search(text)) is not None:
        raise InterchangeError(f"XML cannot hold the character {mark[0]!r}", "take it out of the scenario's names")
    return text
