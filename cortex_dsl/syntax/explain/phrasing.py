"""Statements with almost correct words or signs (`wait 3 s`, `terminate if x`, `with speed = 5`), and phrases of prose.

Phrases are, e.g., `15 to 50 km/h`, `40 m before intersection`, `when ego collides with truck`. Rules of the table of
mistakes (`explain.table`): from the context of an error to its diagnostic, or None.
"""

import re

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.explain.context import ErrorContext, Word
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import SPECIFIER_WORDS

_CALL = re.compile(r"\w+\s*\(")
LONGEST_PLACE = 80
"""Characters in which two numbers are looked for."""


def equals_after_with(context: ErrorContext) -> Diagnostic | None:
    """`with speed = 5 m/s`."""
    words, place = context.words, context.place
    if context.found.text != "=" or place < 2 or words[place - 2].text != "with":
        return None
    name = words[place - 1].text
    return errors.UNEXPECTED.at(
        context.found.span,
        f"`with {name}` is followed by its value, without `=`",
        "leave it out",
        cure=f"write `with {name} {_next_text(context)}`",
    )


def _next_text(context: ErrorContext) -> str:
    """The text after the error, up to the next comma outside brackets."""
    depth, end = 0, context.line.end
    for word in context.words[context.place + 1 :]:
        depth += (word.text in ("(", "[", "{")) - (word.text in (")", "]", "}"))
        if (word.text == "," and depth == 0) or depth < 0:
            end = word.span.start
            break
    return context.source.text[context.found.span.end : end].strip()


def assignment_in_lambda(context: ErrorContext) -> Diagnostic | None:
    """`filter(lambda m: m.type = x, …)`, `[m for m in ms if m.type = x]`."""
    inside = [word.text for word in context.words[: context.place] if context.bracket is not None]
    if context.found.text != "=" or not ({"lambda", "if"} & set(inside)):
        return None
    return does_not_compare(context)


def does_not_compare(context: ErrorContext) -> Diagnostic:
    """`=` where `==` is meant."""
    return errors.ASSIGNMENT_IN_CONDITION.at(
        context.found.span,
        "`=` does not compare",
        "did you mean `==`?",
        reason=errors.ASSIGNMENT_IN_CONDITION.reason,
        cure="write `==`",
    )


def forgotten_do(context: ErrorContext) -> Diagnostic | None:
    """`FollowLaneBehavior(5 m/s) for 5 s`."""
    line = context.source.text[context.line.start : context.line.end]
    if context.found.text not in ("for", "until") or context.bracket is not None or not _CALL.match(line):
        return None
    call = context.source.text[context.line.start : context.found.span.start].strip()
    return errors.INCOMPLETE.at(
        Span(context.line.start, context.line.start + len(call)),
        f"`do` is missing before `{context.first.text}`",
        "a behavior is run with `do`",
        cure=f"write `do {call} {context.found.text} …`",
    )


def wait_for_a_time(context: ErrorContext) -> Diagnostic | None:
    """`wait 3 s`, `wait(3)`."""
    if context.first.text not in ("wait", "sleep") or context.place != 1 or context.found.kind != "number":
        return None
    time = context.source.text[context.found.span.start : context.line.end].strip()
    return errors.UNEXPECTED.at(
        context.found.span,
        "`wait` waits for one step and takes no duration",
        "a duration",
        reason="only a behavior can run for a time; `IdleBehavior` lets the car coast",
        cure=f"write `do IdleBehavior() for {time}` (or `do BrakeBehavior() for {time}` to stop)",
    )


def name_of_a_requirement(context: ErrorContext) -> Diagnostic | None:
    """`require x, "name"`, `require x "name"`, `require x as two words`."""
    found, before, after = context.found, context.before, context.after
    if context.first.text != "require" or before is None or context.bracket is not None:
        return None
    text = after if found.text == "," and after is not None else found
    if text.kind == "string":
        return errors.UNEXPECTED.at(
            found.span.to(text.span), "the name of a `require` follows `as`", cure=f"write `as {text.text}`"
        )
    start = next((i for i, word in enumerate(context.words[: context.place]) if word.text == "as"), None)
    if start is None or found.kind not in ("name", "number"):
        return None
    name = Span(context.words[start].span.end, context.line.end)
    written = context.source.slice(name).split("#")[0].strip()
    return errors.UNEXPECTED.at(found.span, "a name of several words needs quotes", cure=f'write `as "{written}"`')


def comma_before_specifiers(context: ErrorContext) -> Diagnostic | None:
    """`new Car, with speed 5`."""
    words, place, after = context.words, context.place, context.after
    if context.found.text != "," or place < 2 or words[place - 2].text != "new":
        return None
    if after is None or after.text not in SPECIFIER_WORDS:
        return None
    return errors.UNEXPECTED.at(
        context.found.span,
        "no comma stands before the first specifier",
        cure=f"write `new {words[place - 1].text} {after.text} …`; commas separate further specifiers",
    )


def place_without_brackets(context: ErrorContext) -> Diagnostic | None:
    """`new Car at 1.75, -30`."""
    words, place = context.words, context.place
    start = next((i for i in range(place - 1, 0, -1) if words[i].text in SPECIFIER_WORDS), 0)
    if context.found.text != "," and "," not in [word.text for word in words[start:place]]:
        return None
    if words[start].text != "at" or context.bracket is not None:
        return None
    number = re.compile(r"[^,]*?(-?[\w. ]+)\s*,\s*(-?[\w. ]*?\d[\w. ]*)").match(
        context.source.text, words[start].span.end, min(context.line.end, words[start].span.end + LONGEST_PLACE)
    )
    if number is None:
        return None
    x, y = number[1].strip(), number[2].strip()
    return errors.UNEXPECTED.at(
        Span(words[start + 1].span.start, number.end()),
        "a place of two numbers needs brackets",
        cure=f"write `at ({x}, {y})`",
    )


def braces(context: ErrorContext) -> Diagnostic | None:
    """`behavior Stop() {`."""
    opens = context.found.text == "{" and "COLON" in context.accepts and context.bracket is None
    if not opens and not (context.place == 0 and context.found.text == "}"):
        return None
    cure = "write `:` here, indent the lines of the block, and leave out the `}` at its end" if opens else "remove it"
    return errors.FOREIGN_SPELLING.at(
        context.found.span,
        f"`{context.found.text}` does not belong here",
        "blocks have no braces",
        reason="a block begins with `:`, and the lines that belong to it are indented",
        cure=cure,
    )


def param_without_equals(context: ErrorContext) -> Diagnostic | None:
    """`param SPEED Range(5, 60)`, `param SPEED: Range(5, 60)`."""
    before, found = context.before, context.found
    if context.first.text != "param" or "_EQUAL" not in context.accepts or before is None or before is context.first:
        return None
    return errors.UNEXPECTED.at(
        found.span if found.text in (":", ":=", "==") else Span(before.span.end, before.span.end),
        f"missing `=` after `param {before.text}`",
        "expected `=`",
        cure=f"write `param {before.text} = …`",
    )


def terminate_if(context: ErrorContext) -> Diagnostic | None:
    """`terminate if x`, `interrupt if x`, `terminate until x`."""
    if context.first.text not in ("terminate", "interrupt") or context.found.text not in ("if", "until", "while"):
        return None
    if context.place > 2 or not _only_words(context.words[: context.place]):
        return None
    return errors.UNEXPECTED.at(
        context.found.span,
        f"`{context.first.text}` is followed by `when` and a condition",
        "did you mean `when`?",
        cure=f"write `{context.first.text} when …`",
    )


def _only_words(words: tuple[Word, ...]) -> bool:
    return all(word.text in ("terminate", "interrupt", "simulation") for word in words)


def distance_without_from(context: ErrorContext) -> Diagnostic | None:
    """`distance ego to intersection`, `distance between a and b`."""
    found, before = context.found, context.before
    if before is None or before.text != "distance" or found.kind != "name":
        return None
    return errors.UNEXPECTED.at(
        found.span,
        "a distance is measured `from` one thing `to` another",
        "did you mean `from`?",
        cure="write `distance from ego to other`, or `distance to other` from the ego",
    )


def percent(context: ErrorContext) -> Diagnostic | None:
    """`SetBrakeAction(50%)`: the sign was read as the remainder of a division."""
    before = context.before
    if before is None or before.text != "%" or not context.wants_value or context.place < 2:
        return None
    if context.found.text not in (")", ",", "]") and context.found.kind != "end":
        return None
    number = context.words[context.place - 2]
    cure = f"write `{float(number.text) / 100:g}`" if number.kind == "number" else "divide by 100"
    return errors.FOREIGN_SPELLING.at(before.span, "there are no percentages", "`%` is the remainder", cure=cure)


def function_in_a_class(context: ErrorContext) -> Diagnostic | None:
    """`def __init__(self):` and other functions that Python has in its classes."""
    if context.first.text != "def" or not ({"NAME", "STRING", "_PASS"} <= context.accepts):
        return None
    if "NUMBER" in context.accepts:
        return None
    return errors.CLASS_BODY.at(
        context.first.span,
        "a class has no functions",
        reason=errors.CLASS_BODY.reason,
        cure="write each property as a line `name: value`, such as `width: 2.2 m`",
    )


# -- As in a sentence -------------------------------------------------------------------------------------------------

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


def range_in_words(context: ErrorContext) -> Diagnostic | None:
    """`15..50 km/h`, `15 to 50 km/h`, `between 15 and 50 km/h`."""
    match = _around(context, _RANGE)
    if match is None or (" and " in match.group() and match["begun"] is None):
        return None
    low, high, units = match["low"], match["high"], {match["low_unit"], match["high_unit"]} - {None}
    if len(units) > 1:
        low, high = f"{low} {match['low_unit']}", f"{high} {match['high_unit']}"
    unit = f" {units.pop()}" if len(units) == 1 else ""
    inside = context.source.text[: match.start()].endswith("Range(")
    cure = f"write `{low}, {high}`" if inside else f"write `Range({low}, {high}){unit}`"
    return errors.FOREIGN_SPELLING.at(Span(*match.span()), "a range is written `Range(low, high)`", cure=cure)


_AFTER_PART = {"an object": ("at", "after"), "`at P`": (",", "after", "by", ""), "`after T`": (",", "by", "")}
"""Words before which a part of a meeting is missing."""


def meeting_incomplete(context: ErrorContext) -> Diagnostic | None:
    """`new Car meeting ego after 4 s`."""
    words, place = context.words, context.place
    start = next((i for i in range(place - 1, 0, -1) if words[i].text == "meeting"), 0)
    said = [word.text for word in words[start + 1 : place]]
    if not start or "," in said or "after" in said or context.bracket is not None:
        return None
    lacks = "`after T`" if "at" in said else "`at P`" if said else "an object"
    if context.found.text not in _AFTER_PART[lacks] and not (said and context.found.kind == "end"):
        return None
    other = "ego"
    if said:
        other = context.source.text[words[start + 1].span.start : words[place - 1].span.end].split(" at ")[0]
    return errors.UNEXPECTED.at(
        context.found.span,
        f"a meeting lacks {lacks}: it names an object, a place of it and a time",
        cure=f"write `meeting {other} at 0.5 after 4 s`",
    )


def distance_first(context: ErrorContext) -> Diagnostic | None:
    """`new Car 40 m before intersection along way`."""
    new = next((i for i, word in enumerate(context.words[: context.place]) if word.text == "new"), None)
    match = _around(context, _PLACE)
    if new is None or match is None or context.bracket is not None:
        return None
    if context.words[new + 1].span.end > match.start() or match["distance"] in ("by", "new", "visible"):
        return None
    said = " ".join(match["word"].split())
    word, way = _PLACED.get(said, said), match["way"] or ""
    if word in ("before", "after") and not way:
        way = " along trajectory"
    cure = f"write `{word} {match['thing']} by {match['distance'].strip()}{way.rstrip()}`"
    return errors.UNEXPECTED.at(
        Span(*match.span()), "the distance goes at the end, after `by`", "in the wrong order", cure=cure
    )


def contact(context: ErrorContext) -> Diagnostic | None:
    """`terminate when ego collides with truck`."""
    found, before = context.found, context.before
    if found.text not in _CONTACT or not context.wants_operator or before is None:
        return None
    other = next((w.text for w in context.words[context.place + 1 :] if w.kind == "name" and w.text != "with"), "other")
    near = f"`(minimum distance from {before.text} to {other}) < 1 m`"
    cure = f"leave the line out; to end the run earlier write {near}" if context.first.text == "terminate" else ""
    return errors.UNEXPECTED.at(
        found.span,
        f"`{found.text}` is not an operator",
        "no condition is needed for that",
        reason="contact is always detected, and it ends the run by itself",
        cure=cure or f"write {near} for the moment before contact",
    )


def _around(context: ErrorContext, pattern: re.Pattern[str]) -> re.Match[str] | None:
    """The match that contains the place of the error."""
    place, text = context.found.span.start, context.source.text
    start, end = max(context.line.start, place - LONGEST), min(context.line.end, place + LONGEST)
    found = (match for match in pattern.finditer(text, start, end) if match.start() <= place <= match.end())
    return next(found, None)
