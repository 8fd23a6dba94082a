"""The one helper that answers a misspelt word with the nearest right one."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from types import MappingProxyType


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """The candidate that `word` was probably meant to be, or None if none is near."""
    by_folded = {candidate.lower(): candidate for candidate in candidates}
    matches = get_close_matches(word.lower(), by_folded, n=1, cutoff=0.6)
    return by_folded[matches[0]] if matches else None


ELSEWHERE: Mapping[str, str] = MappingProxyType(
    {
        "inf": "numbers are finite here: write a large one, or leave the limit out",
        "nan": "every number has a value here",
        "everywhere": "write `None`, as in `with regionContainedIn None`",
        "nowhere": "there is no empty region here",
        "simulation": "there is no clock: count steps in a variable, or write `do … for 5 s`, `terminate after 5 s`",
        "print": "`cortexc FILE --emit ir` shows what was computed",
        "Vector": "write `(x, y)`",
    }
)
"""Names of Scenic and Python that are not here, and what to write instead."""


def did_you_mean(word: str, candidates: Iterable[str]) -> str:
    """A sentence for a diagnostic's cure: the nearest name, or the list of valid ones when it is short."""
    choices = sorted(set(candidates))
    if word in ELSEWHERE and word not in choices:
        return ELSEWHERE[word]
    if (match := nearest(word, choices)) is not None:
        return f"did you mean `{match}`?"
    if 0 < len(choices) <= 12:
        return "valid here: " + ", ".join(f"`{choice}`" for choice in choices)
    return ""
