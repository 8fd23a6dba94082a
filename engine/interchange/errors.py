"""What is wrong with a file from elsewhere, or with the wish to write one, and how a stranger's words are told."""

from collections.abc import Iterable
from difflib import get_close_matches
from itertools import islice

from engine.errors import CortexError

MOST_CHOICES = 12
MOST_COMPARED = 2000
"""Names that one is held against."""
MOST_LETTERS = 60
"""Of a stranger's text that a message quotes."""


class InterchangeError(CortexError):
    """A file that cannot be read, or a case that a format cannot carry: what is wrong, where, and what to do."""

    def __init__(self, message: str, cure: str, place: str = "") -> None:
        super().__init__(message, cure)
        self.place = place
        """File, and line or element where one is known: `case.xosc, line 12`."""

    def __str__(self) -> str:
        return f"{self.place}: {super().__str__()}" if self.place else super().__str__()


def quoted(text: str) -> str:
    """A stranger's text in quotes, cut to what a message can bear, without control characters."""
    cut = text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "…"
    return '"' + "".join(letter if letter.isprintable() else "?" for letter in cut) + '"'


def did_you_mean(word: str, names: Iterable[str], few: int = MOST_CHOICES) -> str:
    """A cure for an unknown name: the nearest one, or those that exist, at most `few` of them."""
    choices = list(islice(dict.fromkeys(names), MOST_COMPARED))
    folded = {name.casefold(): name for name in choices}
    if near := get_close_matches(word.casefold()[:MOST_LETTERS], folded, n=1):
        return f"did you mean `{folded[near[0]]}`?"
    if not choices or not few:
        return ""
    rest = " and others" if len(choices) > few else ""
    return "there is " + ", ".join(f"`{name}`" for name in choices[:few]) + rest
