"""Likely mistakes, each a rule from the surroundings of an error to its explanation, or None if it is another one.

The first rule that knows the mistake answers, so the more special ones come first. A new one is a function and a row
in `MISTAKES`.
"""

from collections.abc import Callable

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Span
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import errors, newcomers, phrases, sentences, slips
from cortex_dsl.syntax.habits import foreign_spelling, missing_new, not_supported, text_prefix
from cortex_dsl.syntax.trouble import Trouble, Word
from cortex_dsl.syntax.units import UNIT_WORDS, unit_list
from cortex_dsl.syntax.words import BLOCK_WORDS, RESERVED, SPECIFIER_WORDS

Mistake = Callable[[Trouble], Diagnostic | None]

_STATEMENT_WORDS = (
    "behavior", "map", "model", "param", "simulation", "require", "terminate", "do", "take", "wait", "abort",
    "break", "continue", "return", "pass", "try", "if", "while", "interrupt", "elif", "else", "class", "monitor",
    "scenario", "setup", "compose", "precondition", "invariant", "import", "from", "record", "mutate", "override",
    "signals",
)  # fmt: skip
_NAMING = frozenset({"behavior", "class", "import", "map", "model", "monitor", "param", "scenario"})
"""Words after which a name stands."""
_NAME_OF_A_THING = {
    "param": "a name and a value: `param SPEED = Range(5, 10)`",
    "behavior": "a name and brackets: `behavior Drive(trajectory):`",
    "require": "a condition: `require x < 3`",
    "take": "an action: `take SetBrakeAction(1)`",
    "do": "a behavior: `do FollowLaneBehavior()`",
    "new": "a class such as `Car`",
    "while": "a condition",
    "if": "a condition",
    "when": "a condition",
    "model": "a name such as `scenic.simulators.carla.model`",
    "map": "a kind of map: `map intersection(ways=4)`",
    "with": "a property and its value: `with speed 5 m/s`",
    "class": "a name and a base: `class Taxi(Car):`",
    "monitor": "a name and brackets: `monitor Watch():`",
    "scenario": "a name and brackets: `scenario Main():`",
    "import": "a file: `import cars`",
    "from": "a file and names: `from cars import Taxi`",
    "record": "a value: `record ego.speed`",
    "override": "an object and specifiers: `override ego with speed 3`",
}


def assignment_in_condition(trouble: Trouble) -> Diagnostic | None:
    in_condition = trouble.first.text in ("require", "if", "elif", "while", "terminate", "interrupt", "do")
    if trouble.found.text != "=" or not in_condition:
        return None
    return phrases.does_not_compare(trouble)


def second_assignment(trouble: Trouble) -> Diagnostic | None:
    earlier = any(word.text == "=" for word in trouble.words[: trouble.place])
    if trouble.found.text != "=" or not earlier or trouble.bracket is not None:
        return None
    return errors.WRONG_TARGET.at(
        trouble.found.span, "only one `=` in an assignment", cure="write one line for each name, or `==` to compare"
    )


def missing_colon(trouble: Trouble) -> Diagnostic | None:
    if "COLON" not in trouble.accepts or trouble.first.text not in BLOCK_WORDS or trouble.bracket is not None:
        return None
    if trouble.found.kind != "end" and trouble.found.text not in ("do", "take", "wait", "{", "then", "terminate"):
        return None
    place = trouble.before.span.end if trouble.before else trouble.found.span.start
    return errors.MISSING_COLON.at(
        Span(place, place),
        f"missing `:` after `{_head(trouble)}`",
        "expected `:`",
        reason=errors.MISSING_COLON.why,
        cure="write `:` here",
    )


def _head(trouble: Trouble) -> str:
    text = trouble.source.slice(
        Span(trouble.line.start, trouble.before.span.end if trouble.before else trouble.line.end)
    )
    return text if len(text) <= 40 and "\n" not in text else trouble.first.text


def missing_brackets(trouble: Trouble) -> Diagnostic | None:
    kind = trouble.first.text
    if kind not in ("behavior", "monitor") or trouble.found.text != ":" or "LPAR" not in trouble.accepts:
        return None
    return errors.UNEXPECTED.at(
        trouble.found.span, f"a {kind} has brackets after its name", "expected `()`", cure="write `():`"
    )


def orphan(trouble: Trouble) -> Diagnostic | None:
    parents = {"else": "if", "elif": "if", "interrupt": "try"}
    word = trouble.first
    if trouble.place != 0 and not (trouble.place == 1 and word.text == "interrupt"):
        return None
    if word.text not in parents or "COLON" in trouble.accepts:
        return None
    parent = parents[word.text]
    article = "an" if parent == "if" else "a"
    return errors.INCOMPLETE.at(
        word.span,
        f"`{word.text}` without {article} `{parent}`",
        reason=f"it continues {article} `{parent}` block that is right above it, at the same indentation",
        cure=f"align it with its `{parent}`, or write the `{parent}`",
    )


def missing_comma(trouble: Trouble) -> Diagnostic | None:
    found, before = trouble.found, trouble.before
    if before is None or not trouble.wants_operator:
        return None
    place = Span(before.span.end, before.span.end)
    after_new = any(word.text == "new" for word in trouble.words[: trouble.place])
    if found.text in SPECIFIER_WORDS and after_new:
        return errors.MISSING_COMMA.at(
            place,
            f"missing comma before `{found.text}`",
            "expected `,`",
            secondary=[Label(found.span, "the next specifier")],
            cure="write a `,` between specifiers",
        )
    begins = found.kind in ("name", "number", "string") and found.text not in RESERVED
    if trouble.bracket is not None and begins:
        return errors.MISSING_COMMA.at(
            place,
            f"expected `,` or an operator before {_quoted(found)}",
            "something is missing here",
            secondary=[Label(found.span, "begins another value")],
            cure="write a `,` between the two, or an operator",
        )
    return None


def word_read_as_unit(trouble: Trouble) -> Diagnostic | None:
    """`f(x) g(y)`: the grammar took `g` for the unit of `f(x)`, so the error comes one word late."""
    before, words = trouble.before, trouble.words[: trouble.place - 1]
    if before is None or before.kind != "name" or not words or before.text in RESERVED or before.text in UNIT_WORDS:
        return None
    if not (words[-1].text == ")" or words[-1].kind == "number") or trouble.found.text not in ("(", "=", "[", ":"):
        return None
    place = Span(words[-1].span.end, words[-1].span.end)
    return errors.MISSING_COMMA.at(
        place,
        f"expected `,` or an operator before {_quoted(before)}",
        "something is missing here",
        secondary=[Label(before.span, "begins another value")],
        cure="write a `,` between the two, or an operator",
    )


def _quoted(word: Word) -> str:
    return "a string" if word.kind == "string" else f"`{word.text}`"


def misplaced_unit(trouble: Trouble) -> Diagnostic | None:
    found, before = trouble.found, trouble.before
    if found.text not in UNIT_WORDS or before is None or not trouble.wants_operator:
        return None
    start = found.span.start
    unit = max((word for word in UNIT_WORDS if trouble.source.text.startswith(word, start)), key=len)
    if before.kind == "name":
        cure = f"if `{before.text}` is a pure number write `{before.text} * 1 {unit}`; else leave the unit away"
    else:
        cure = f"multiply by it: `… * 1 {unit}`"
    return errors.MISPLACED_UNIT.at(
        Span(start, start + len(unit)),
        f"the unit `{unit}` cannot stand here",
        "a unit follows a number or a call",
        reason=errors.MISPLACED_UNIT.why,
        cure=cure,
    )


def continued_line(trouble: Trouble) -> Diagnostic | None:
    """A comma at the end of a line, and a specifier below it at the same indentation: told once for both lines."""
    lines = trouble.layout.lines
    index = trouble.index + (trouble.found.kind == "end")
    if (trouble.place and trouble.found.kind != "end") or not 0 < index < len(lines):
        return None
    previous, line = lines[index - 1], lines[index]
    if line.word not in SPECIFIER_WORDS or trouble.source.text[previous.end - 1] != ",":
        return None
    return errors.STRAY_INDENT.at(
        Span(line.start, line.start + len(line.word)),
        f"`{line.word}` must be indented",
        "a specifier",
        secondary=[Label(Span(previous.end - 1, previous.end), "goes on below")],
        reason="a line goes on after a comma only if the next one is indented deeper",
        cure="indent this line by four spaces",
    )


def reserved_word(trouble: Trouble) -> Diagnostic | None:
    found, after = trouble.found, trouble.after
    second = trouble.words[1] if len(trouble.words) > 1 else found
    if trouble.first.text in _NAMING and second.kind == "name" and second.text in RESERVED:
        return _reserved(second)
    if found.text == "=" and trouble.before is trouble.first and trouble.first.text in RESERVED:
        return _reserved(trouble.first)
    if found.kind != "name" or found.text not in RESERVED or "NAME" not in trouble.accepts:
        return None
    as_name = after is not None and (after.text in ("=", ".", ",", ")", "]") or after.kind == "end")
    if trouble.wants_value and not as_name:
        return None
    return _reserved(found)


def _reserved(word: Word) -> Diagnostic:
    return errors.RESERVED_WORD.at(
        word.span,
        f"`{word.text}` is a reserved word and cannot be a name",
        "choose another name",
        reason=errors.RESERVED_WORD.why,
        cure=f"for example `{word.text}_`",
    )


def strange_character(trouble: Trouble) -> Diagnostic | None:
    found = trouble.found
    if found.kind != "sign" or found.text[0] in "()[]{}+-*/%=<>!.,:;@'\"":
        return None
    shown = f"`{found.text}`" if found.text.isprintable() else f"U+{ord(found.text[0]):04X}"
    return errors.STRANGE_CHARACTER.at(
        found.span, f"the character {shown} means nothing here", reason=errors.STRANGE_CHARACTER.why, cure="remove it"
    )


def misspelt_statement(trouble: Trouble) -> Diagnostic | None:
    """A line that begins with two words, of which the first is nearly a statement."""
    if trouble.place != 1 or trouble.first.kind != "name" or trouble.found.kind not in ("name", "number", "string"):
        return None
    if trouble.first.text in RESERVED or trouble.first.text in _STATEMENT_WORDS:
        return None
    meant = nearest(trouble.first.text, _STATEMENT_WORDS)
    return errors.UNEXPECTED.at(
        trouble.first.span,
        f"`{trouble.first.text}` begins no statement",
        f"did you mean `{meant}`?" if meant else "",
        cure=f"write `{meant}`" if meant else "did you forget an operator or `=` after it?",
    )


def nothing_follows(trouble: Trouble) -> Diagnostic | None:
    """A keyword without what belongs to it."""
    before = trouble.before
    if before is None or before.text not in _NAME_OF_A_THING:
        return None
    if trouble.found.kind != "end" and before is trouble.first:
        wanted = _NAME_OF_A_THING[before.text]
        return errors.UNEXPECTED.at(trouble.found.span, f"`{before.text}` is followed by {wanted}", "not by this")
    if trouble.found.kind != "end":
        return None
    return errors.UNEXPECTED.at(
        Span(before.span.end, before.span.end),
        f"nothing follows `{before.text}`",
        f"expected {_NAME_OF_A_THING[before.text]}",
    )


def unknown_unit(trouble: Trouble) -> Diagnostic | None:
    """What looks like a unit and is none even by its letters: `5 %`, `90°` are told elsewhere."""
    found, before = trouble.found, trouble.before
    if before is None or before.kind != "number" or found.kind != "name" or found.text in RESERVED:
        return None
    return errors.UNKNOWN_UNIT.at(found.span, f"`{found.text}` is no unit", reason=unit_list())


MISTAKES: tuple[Mistake, ...] = (
    continued_line,
    *newcomers.RULES,
    *sentences.RULES,
    slips.side_without_of,
    phrases.function_in_a_class,
    not_supported,
    slips.misspelt_second_word,
    slips.misspelt_joint,
    slips.temporal_elsewhere,
    slips.guard,
    slips.class_head,
    slips.class_line,
    slips.wrong_import,
    text_prefix,
    phrases.braces,
    phrases.percent,
    foreign_spelling,
    phrases.assignment_in_lambda,
    assignment_in_condition,
    phrases.equals_after_with,
    second_assignment,
    missing_colon,
    missing_brackets,
    orphan,
    missing_new,
    phrases.forgotten_do,
    phrases.wait_for_a_time,
    phrases.name_of_a_requirement,
    phrases.place_without_brackets,
    phrases.param_without_equals,
    phrases.terminate_if,
    phrases.distance_without_from,
    misplaced_unit,
    missing_comma,
    word_read_as_unit,
    unknown_unit,
    misspelt_statement,
    reserved_word,
    nothing_follows,
    strange_character,
)
