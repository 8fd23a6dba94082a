"""Statements whose words or signs are nearly right: `wait 3 s`, `terminate if x`, `with speed = 5`, `at 1, 2`.

Rules as in `mistakes`: from the surroundings of an error to its explanation, or None if it is another one.
"""

import re

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.trouble import Trouble, Word
from cortex_dsl.syntax.words import SPECIFIER_WORDS

_CALL = re.compile(r"\w+\s*\(")
LONGEST_PLACE = 80
"""Characters in which two numbers are looked for."""


def equals_after_with(trouble: Trouble) -> Diagnostic | None:
    """`with speed = 5 m/s`."""
    words, place = trouble.words, trouble.place
    if trouble.found.text != "=" or place < 2 or words[place - 2].text != "with":
        return None
    name = words[place - 1].text
    return errors.UNEXPECTED.at(
        trouble.found.span,
        f"`with {name}` is followed by its value, without `=`",
        "leave it out",
        cure=f"write `with {name} {_next_text(trouble)}`",
    )


def _next_text(trouble: Trouble) -> str:
    """What stands after the error, up to the next comma outside brackets."""
    depth, end = 0, trouble.line.end
    for word in trouble.words[trouble.place + 1 :]:
        depth += (word.text in ("(", "[", "{")) - (word.text in (")", "]", "}"))
        if (word.text == "," and depth == 0) or depth < 0:
            end = word.span.start
            break
    return trouble.source.text[trouble.found.span.end : end].strip()


def assignment_in_lambda(trouble: Trouble) -> Diagnostic | None:
    """`filter(lambda m: m.type = x, …)`, `[m for m in ms if m.type = x]`."""
    inside = [word.text for word in trouble.words[: trouble.place] if trouble.bracket is not None]
    if trouble.found.text != "=" or not ({"lambda", "if"} & set(inside)):
        return None
    return does_not_compare(trouble)


def does_not_compare(trouble: Trouble) -> Diagnostic:
    """`=` where `==` is meant."""
    return errors.ASSIGNMENT_IN_CONDITION.at(
        trouble.found.span,
        "`=` does not compare",
        "did you mean `==`?",
        reason=errors.ASSIGNMENT_IN_CONDITION.why,
        cure="write `==`",
    )


def forgotten_do(trouble: Trouble) -> Diagnostic | None:
    """`FollowLaneBehavior(5 m/s) for 5 s`."""
    line = trouble.source.text[trouble.line.start : trouble.line.end]
    if trouble.found.text not in ("for", "until") or trouble.bracket is not None or not _CALL.match(line):
        return None
    call = trouble.source.text[trouble.line.start : trouble.found.span.start].strip()
    return errors.INCOMPLETE.at(
        Span(trouble.line.start, trouble.line.start + len(call)),
        f"`do` is missing before `{trouble.first.text}`",
        "a behavior is done with `do`",
        cure=f"write `do {call} {trouble.found.text} …`",
    )


def wait_for_a_time(trouble: Trouble) -> Diagnostic | None:
    """`wait 3 s`, `wait(3)`."""
    if trouble.first.text not in ("wait", "sleep") or trouble.place != 1 or trouble.found.kind != "number":
        return None
    time = trouble.source.text[trouble.found.span.start : trouble.line.end].strip()
    return errors.UNEXPECTED.at(
        trouble.found.span,
        "`wait` waits for one step and takes no time",
        "a time",
        reason="what goes on for a time is a behavior, and `IdleBehavior` lets the car roll",
        cure=f"write `do IdleBehavior() for {time}` (or `do BrakeBehavior() for {time}` to stand)",
    )


def name_of_a_requirement(trouble: Trouble) -> Diagnostic | None:
    """`require x, "name"`, `require x "name"`, `require x as two words`."""
    found, before, after = trouble.found, trouble.before, trouble.after
    if trouble.first.text != "require" or before is None or trouble.bracket is not None:
        return None
    text = after if found.text == "," and after is not None else found
    if text.kind == "string":
        return errors.UNEXPECTED.at(
            found.span.to(text.span), "the name of a `require` follows `as`", cure=f"write `as {text.text}`"
        )
    start = next((i for i, word in enumerate(trouble.words[: trouble.place]) if word.text == "as"), None)
    if start is None or found.kind not in ("name", "number"):
        return None
    name = Span(trouble.words[start].span.end, trouble.line.end)
    written = trouble.source.slice(name).split("#")[0].strip()
    return errors.UNEXPECTED.at(found.span, "a name of several words stands in quotes", cure=f'write `as "{written}"`')


def place_without_brackets(trouble: Trouble) -> Diagnostic | None:
    """`new Car at 1.75, -30`."""
    words, place = trouble.words, trouble.place
    start = next((i for i in range(place - 1, 0, -1) if words[i].text in SPECIFIER_WORDS), 0)
    if trouble.found.text != "," and "," not in [word.text for word in words[start:place]]:
        return None
    if words[start].text != "at" or trouble.bracket is not None:
        return None
    number = re.compile(r"[^,]*?(-?[\w. ]+)\s*,\s*(-?[\w. ]*?\d[\w. ]*)").match(
        trouble.source.text, words[start].span.end, min(trouble.line.end, words[start].span.end + LONGEST_PLACE)
    )
    if number is None:
        return None
    x, y = number[1].strip(), number[2].strip()
    return errors.UNEXPECTED.at(
        Span(words[start + 1].span.start, number.end()),
        "a place of two numbers stands in brackets",
        cure=f"write `at ({x}, {y})`",
    )


def braces(trouble: Trouble) -> Diagnostic | None:
    """`behavior Stop() {`."""
    opens = trouble.found.text == "{" and "COLON" in trouble.accepts and trouble.bracket is None
    if not opens and not (trouble.place == 0 and trouble.found.text == "}"):
        return None
    cure = "write `:` here, indent the lines of the block, and leave out the `}` at its end" if opens else "remove it"
    return errors.FOREIGN_SPELLING.at(
        trouble.found.span,
        f"`{trouble.found.text}` does not belong here",
        "blocks have no braces",
        reason="a block begins with `:`, and the lines that belong to it are indented",
        cure=cure,
    )


def param_without_equals(trouble: Trouble) -> Diagnostic | None:
    """`param SPEED Range(5, 60)`, `param SPEED: Range(5, 60)`."""
    before, found = trouble.before, trouble.found
    if trouble.first.text != "param" or "_EQUAL" not in trouble.accepts or before is None or before is trouble.first:
        return None
    return errors.UNEXPECTED.at(
        found.span if found.text in (":", ":=", "==") else Span(before.span.end, before.span.end),
        f"missing `=` after `param {before.text}`",
        "expected `=`",
        cure=f"write `param {before.text} = …`",
    )


def terminate_if(trouble: Trouble) -> Diagnostic | None:
    """`terminate if x`, `interrupt if x`, `terminate until x`."""
    if trouble.first.text not in ("terminate", "interrupt") or trouble.found.text not in ("if", "until", "while"):
        return None
    if trouble.place > 2 or not _only_words(trouble.words[: trouble.place]):
        return None
    return errors.UNEXPECTED.at(
        trouble.found.span,
        f"`{trouble.first.text}` is followed by `when` and a condition",
        "did you mean `when`?",
        cure=f"write `{trouble.first.text} when …`",
    )


def _only_words(words: tuple[Word, ...]) -> bool:
    return all(word.text in ("terminate", "interrupt", "simulation") for word in words)


def distance_without_from(trouble: Trouble) -> Diagnostic | None:
    """`distance ego to intersection`, `distance between a and b`."""
    found, before = trouble.found, trouble.before
    if before is None or before.text != "distance" or found.kind != "name":
        return None
    return errors.UNEXPECTED.at(
        found.span,
        "a distance is measured `from` one thing `to` another",
        "did you mean `from`?",
        cure="write `distance from ego to other`, or `distance to other` from the ego",
    )


def percent(trouble: Trouble) -> Diagnostic | None:
    """`SetBrakeAction(50%)`: the sign was read as the remainder of a division."""
    before = trouble.before
    if before is None or before.text != "%" or not trouble.wants_value or trouble.place < 2:
        return None
    if trouble.found.text not in (")", ",", "]") and trouble.found.kind != "end":
        return None
    number = trouble.words[trouble.place - 2]
    cure = f"write `{float(number.text) / 100:g}`" if number.kind == "number" else "divide by 100"
    return errors.FOREIGN_SPELLING.at(before.span, "there are no per cent here", "`%` is a remainder", cure=cure)


def function_in_a_class(trouble: Trouble) -> Diagnostic | None:
    """`def __init__(self):` and whatever else Python has in its classes."""
    if trouble.first.text != "def" or not ({"NAME", "STRING", "_PASS"} <= trouble.accepts):
        return None
    if "NUMBER" in trouble.accepts:
        return None
    return errors.CLASS_BODY.at(
        trouble.first.span,
        "a class has no functions",
        reason=errors.CLASS_BODY.why,
        cure="write each property as a line `name: value`, such as `width: 2.2 m`",
    )
