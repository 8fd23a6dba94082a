"""Texts of strangers, for a terminal: they show, and do nothing to it. Needs nothing else of the package."""

import unicodedata
from pathlib import Path

ASCII = {"–": "-", "…": "...", "→": "->", "°": " deg", "∞": "inf", "·": "*", "≤": "<=", "≥": ">=", "×": "x", "±": "+-"}
"""ASCII for signs of reports."""


def visible(text: str) -> str:
    """Return a text with its control and direction characters visible instead of acting on the terminal."""
    if text.isprintable():
        return text
    return "".join("\ufffd" if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Co", "Zl", "Zp") else c for c in text)


def harmless(text: str) -> str:
    """Return a text of several lines with control and direction characters made visible."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" else visible(c) for c in text)


def as_argument(path: Path) -> str:
    """Return a path as a word of a command line; a path that begins with `-` would be an option."""
    return f"./{path}" if str(path).startswith("-") else str(path)
