"""Slips of people who come from elsewhere: comments of C, ranges of OpenSCENARIO, words in the order of a sentence.

Rules as in `mistakes`: from the surroundings of an error to its explanation, or None if it is another one.
"""

import re
from itertools import pairwise

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.trouble import Trouble, Word
from cortex_dsl.syntax.units import UNIT_WORDS

_ODD_BLANK = re.compile(r"[^\S \t\r\n\f]")
_DOTS = re.compile(r"\[\s*(?P<low>-?\d+(?:\.\d+)?)\s*\.\.\.?\s*(?P<high>-?\d+(?:\.\d+)?)\s*\]")
_PAIR = re.compile(r"[(\[]\s*(?P<low>-?[\d.]+)\s*,\s*(?P<high>-?[\d.]+)\s*[)\]]\s*\Z")


def _next_to(one: Word | None, other: Word | None) -> bool:
    return one is not None and other is not None and one.span.end == other.span.start


def _foreign(span: Span, message: str, cure: str) -> Diagnostic:
    return errors.FOREIGN_SPELLING.at(span, message, cure=cure)


def odd_blank(trouble: Trouble) -> Diagnostic | None:
    """A blank from a web page or a word processor, which looks like any other and parts no words."""
    start = trouble.before.span.end if trouble.before is not None else trouble.line.start
    found = _ODD_BLANK.search(trouble.source.text, start, max(start, trouble.found.span.start))
    if found is None:
        return None
    return errors.FOREIGN_SPELLING.at(
        Span(*found.span()),
        f"this blank is the character U+{ord(found.group()):04X}",
        "no ordinary blank",
        reason="text that was copied from a web page or a word processor has such blanks",
        cure="delete it and type a blank",
    )


def comment_of_c(trouble: Trouble) -> Diagnostic | None:
    """`// so`, and `/* so */`."""
    words, place, found = trouble.words, trouble.place, trouble.found
    near = (trouble.before, found, trouble.after)
    for slash, star in pairwise(words):
        if slash.text == "/" and star.text == "*" and _next_to(slash, star) and star in near:
            cure = "write `#` in front of each line of a comment"
            return _foreign(slash.span.to(star.span), "a comment does not begin with `/*`", cure)
    double = next((word for word in words[: place + 1] if word.text == "//"), None)
    if double is not None and (found is double or (found.kind == "name" and trouble.wants_operator)):
        return _foreign(double.span, "a comment does not begin with `//`", "write `#`")
    return None


def swapped_comparison(trouble: Trouble) -> Diagnostic | None:
    """`a => b`, `a =< b`."""
    found, after = trouble.found, trouble.after
    if found.text != "=" or after is None or after.text not in ("<", ">") or not _next_to(found, after):
        return None
    meant = f"{after.text}="
    return errors.FOREIGN_SPELLING.at(
        found.span.to(after.span), f"`={after.text}` is written `{meant}`", f"write `{meant}`", cure=f"write `{meant}`"
    )


def between(trouble: Trouble) -> Diagnostic | None:
    """`require x between a and b`."""
    before, found = trouble.before, trouble.found
    if found.text != "between" or not trouble.wants_operator or before is None:
        return None
    name = before.text if before.kind == "name" else "x"
    return _foreign(found.span, "`between` is no comparison", f"write `low <= {name} <= high`")


def new_behind(trouble: Trouble) -> Diagnostic | None:
    """`ego = Car new on road`."""
    before, found = trouble.before, trouble.found
    if found.text != "new" or before is None or before.kind != "name" or not trouble.wants_operator:
        return None
    message = f"`new` stands in front of `{before.text}`"
    return _foreign(before.span.to(found.span), message, f"write `new {before.text}`")


def with_behind(trouble: Trouble) -> Diagnostic | None:
    """`new Car on road, speed with 8 m/s`."""
    found, place = trouble.found, trouble.place
    if found.text != "with" or place < 2 or trouble.words[place - 1].kind != "name":
        return None
    if trouble.words[place - 2].text != ",":
        return None
    name = trouble.words[place - 1]
    return _foreign(name.span.to(found.span), f"`with` stands in front of `{name.text}`", f"write `with {name.text} …`")


def typed_name(trouble: Trouble) -> Diagnostic | None:
    """`ego: Car`."""
    first, found, after = trouble.first, trouble.found, trouble.after
    if trouble.place != 1 or found.text != ":" or first.kind != "name" or "_EQUAL" not in trouble.accepts:
        return None
    if after is None or after.kind != "name" or not after.text[0].isupper():
        return None
    return _foreign(found.span, "a name is given a value with `=`", f"write `{first.text} = new {after.text} on road`")


def range_in_brackets(trouble: Trouble) -> Diagnostic | None:
    """`[20..50] km/h`, `(20, 50) km/h`."""
    text, found, bracket = trouble.source.text, trouble.found, trouble.bracket
    dots = _DOTS.match(text, bracket.span.start, trouble.line.end) if bracket is not None else None
    if dots is not None:
        return _as_range(dots, Span(*dots.span()))
    if found.text not in UNIT_WORDS or trouble.before is None or trouble.before.text not in (")", "]"):
        return None
    opening = max(text.rfind(sign, trouble.line.start, found.span.start) for sign in "([")
    pair = _PAIR.match(text, opening, found.span.start) if opening >= 0 else None
    called = opening > 0 and (text[opening - 1].isalnum() or text[opening - 1] == "_")
    return None if pair is None or called else _as_range(pair, Span(pair.start(), trouble.before.span.end))


def _as_range(match: re.Match[str], span: Span) -> Diagnostic:
    cure = f"write `Range({match['low']}, {match['high']})`"
    return _foreign(span, "a range is written with its name", cure)


RULES = (
    odd_blank,
    comment_of_c,
    swapped_comparison,
    between,
    new_behind,
    with_behind,
    typed_name,
    range_in_brackets,
)
