"""The one helper that answers a misspelt word with the nearest right one."""

from collections.abc import Iterable
from difflib import get_close_matches


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """The candidate that `word` was probably meant to be, or None if none is near."""
    by_folded = {candidate.lower(): candidate for candidate in candidates}
    matches = get_close_matches(word.lower(), by_folded, n=1, cutoff=0.6)
    return by_folded[matches[0]] if matches else None


def did_you_mean(word: str, candidates: Iterable[str]) -> str:
    """A sentence for a diagnostic's cure: the nearest name, or the list of valid ones when it is short."""
    choices = sorted(set(candidates))
    if (match := nearest(word, choices)) is not None:
        return f"did you mean `{match}`?"
    if 0 < len(choices) <= 12:
        return "valid here: " + ", ".join(f"`{choice}`" for choice in choices)
    return ""
