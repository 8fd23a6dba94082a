"""What is said as in a sentence: `15 to 50 km/h`, `40 m before intersection`, `when ego collides with truck`.

Rules as in `mistakes`: from the surroundings of an error to its explanation, or None if it is another one.
"""

import re

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.trouble import Trouble
from cortex_dsl.syntax.units import UNIT_WORDS

_UNIT = "|".join(sorted(map(re.escape, UNIT_WORDS), key=len, reverse=True))
_NUMBER = r"-?\d+(?:\.\d+)?"
_QUANTITY = rf"(?P<{{0}}>{_NUMBER})\s*(?P<{{0}}_unit>(?:{_UNIT})(?!\w))?"
_RANGE = re.compile(
    rf"(?P<begun>(?:from|between)\s+)?{_QUANTITY.format('low')}\s*(?:\.\.\.?|…|\bto\b|\band\b)\s*{_QUANTITY.format('high')}"
)
_PLACE = re.compile(
    rf"(?P<distance>{_NUMBER}\s*(?:(?:{_UNIT})(?!\w))?|[^\W\d]\w*)\s+"
    r"(?P<word>before|after|beyond|past|behind|in\s+front\s+of|ahead\s+of|left\s+of|right\s+of|from)\s+"
    r"(?P<thing>[\w.]+)(?P<way>\s+along\s+[^,\n]+)?"
)
_PLACED: dict[str, str] = {"beyond": "after", "past": "after", "from": "before", "in front of": "ahead of"}
"""Words for places that have another one here."""
_CONTACT = frozenset({"collide", "collides", "crash", "crashes", "hit", "hits", "touch", "touches", "strikes"})
LONGEST = 120
"""Characters in which a sentence is looked for."""


def range_in_words(trouble: Trouble) -> Diagnostic | None:
    """`15..50 km/h`, `15 to 50 km/h`, `between 15 and 50 km/h`."""
    match = _around(trouble, _RANGE)
    if match is None or (" and " in match.group() and match["begun"] is None):
        return None
    low, high, units = match["low"], match["high"], {match["low_unit"], match["high_unit"]} - {None}
    if len(units) > 1:
        low, high = f"{low} {match['low_unit']}", f"{high} {match['high_unit']}"
    unit = f" {units.pop()}" if len(units) == 1 else ""
    inside = trouble.source.text[: match.start()].endswith("Range(")
    cure = f"write `{low}, {high}`" if inside else f"write `Range({low}, {high}){unit}`"
    return errors.FOREIGN_SPELLING.at(Span(*match.span()), "a range is written with its name", cure=cure)


def distance_first(trouble: Trouble) -> Diagnostic | None:
    """`new Car 40 m before intersection along way`."""
    new = next((i for i, word in enumerate(trouble.words[: trouble.place]) if word.text == "new"), None)
    match = _around(trouble, _PLACE)
    if new is None or match is None or trouble.bracket is not None:
        return None
    if trouble.words[new + 1].span.end > match.start() or match["distance"] in ("by", "new"):
        return None
    said = " ".join(match["word"].split())
    word, way = _PLACED.get(said, said), match["way"] or ""
    if word in ("before", "after") and not way:
        way = " along trajectory"
    cure = f"write `{word} {match['thing']} by {match['distance'].strip()}{way.rstrip()}`"
    return errors.UNEXPECTED.at(
        Span(*match.span()), "the distance stands at the end, after `by`", "in another order", cure=cure
    )


def contact(trouble: Trouble) -> Diagnostic | None:
    """`terminate when ego collides with truck`."""
    found, before = trouble.found, trouble.before
    if found.text not in _CONTACT or not trouble.wants_operator or before is None:
        return None
    other = next((w.text for w in trouble.words[trouble.place + 1 :] if w.kind == "name" and w.text != "with"), "other")
    near = f"`(minimum distance from {before.text} to {other}) < 1 m`"
    cure = f"leave the line out; to end the run earlier write {near}" if trouble.first.text == "terminate" else ""
    return errors.UNEXPECTED.at(
        found.span,
        f"`{found.text}` is no comparison",
        "no condition is needed for that",
        reason="contact is always looked for, and a run ends with it by itself",
        cure=cure or f"write {near} for what is about to happen",
    )


def _around(trouble: Trouble, pattern: re.Pattern[str]) -> re.Match[str] | None:
    """The match that holds the place of the error."""
    place, text = trouble.found.span.start, trouble.source.text
    start, end = max(trouble.line.start, place - LONGEST), min(trouble.line.end, place + LONGEST)
    found = (match for match in pattern.finditer(text, start, end) if match.start() <= place <= match.end())
    return next(found, None)


RULES = (range_in_words, distance_first, contact)
