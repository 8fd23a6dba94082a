"""Names as every reader takes them: letters, digits and `_`, unique, and still to be recognised."""

import re
import unicodedata
from collections.abc import Iterable
from itertools import count

from engine.interchange.recording import Recording


def plain_name(text: str) -> str:
    """A name without marks, spaces and signs; `$` and `::` would mean something to readers."""
    letters = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_") or "unnamed"
    return f"_{name}" if name[0].isdigit() else name


def unique_names(texts: Iterable[str]) -> tuple[str, ...]:
    """Plain names in the same order; one that is taken already gets the first free number from 2 on."""
    taken: dict[str, None] = {}
    for text in texts:
        name = plain_name(text)
        numbered = (f"{name}_{number}" for number in count(2))
        taken[name if name not in taken else next(free for free in numbered if free not in taken)] = None
    return tuple(taken)


def entity_names(recording: Recording) -> tuple[str, ...]:
    """What each actor of a recording is called in its files."""
    return unique_names(actor.name for actor in recording.actors)


def literal(text: str) -> str:
    """A text that refers to no parameter: readers take a `$` anywhere for a reference, so it becomes its wide form."""
    return text.replace("$", "\N{FULLWIDTH DOLLAR SIGN}")
