"""Signs, units and reserved words that are missing or in the wrong place: colons, commas, brackets, `=` for `==`.

Rules of the table of mistakes (`explain.table`): from the context of an error to its diagnostic, or None.
"""

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Span
from cortex_dsl.spelling import SYNONYMS, nearest
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.explain import phrasing
from cortex_dsl.syntax.explain.context import ErrorContext, Word
from cortex_dsl.syntax.literals import UNIT_WORDS, unit_list
from cortex_dsl.syntax.words import BLOCK_WORDS, RESERVED, SPECIFIER_WORDS

_STATEMENT_WORDS = (
    "behavior", "map", "model", "param", "simulation", "require", "terminate", "do", "take", "wait", "abort",
    "break", "continue", "return", "pass", "try", "if", "while", "interrupt", "elif", "else", "class", "monitor",
    "scenario", "setup", "compose", "precondition", "invariant", "import", "from", "record", "mutate", "override",
    "signals", "expect", "maximize", "minimize", "domain",
)  # fmt: skip
_NAMING = frozenset({"behavior", "class", "import", "map", "model", "monitor", "param", "scenario"})
"""Words that a name follows."""
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
    "expect": "a condition: `expect always not self.collided`",
    "maximize": "a value: `maximize largest(ego.speed)`",
    "minimize": "a value: `minimize least(ego.speed)`",
    "domain": 'a name and a value with its cells: `domain "speed" ego.speed in [(0, 5), (5, 10)]`',
    "override": "an object and specifiers: `override ego with speed 3`",
}


def assignment_in_condition(context: ErrorContext) -> Diagnostic | None:
    in_condition = context.first.text in ("require", "expect", "if", "elif", "while", "terminate", "interrupt", "do")
    if context.found.text != "=" or not in_condition:
        return None
    return phrasing.does_not_compare(context)


def second_assignment(context: ErrorContext) -> Diagnostic | None:
    earlier = any(word.text == "=" for word in context.words[: context.place])
    if context.found.text != "=" or not earlier or context.bracket is not None:
        return None
    return errors.WRONG_TARGET.at(
        context.found.span, "an assignment has only one `=`", cure="write one line for each name, or `==` to compare"
    )


def missing_colon(context: ErrorContext) -> Diagnostic | None:
    if "COLON" not in context.accepts or context.first.text not in BLOCK_WORDS or context.bracket is not None:
        return None
    if context.found.kind != "end" and context.found.text not in ("do", "take", "wait", "{", "then", "terminate"):
        return None
    place = context.before.span.end if context.before else context.found.span.start
    return errors.MISSING_COLON.at(
        Span(place, place),
        f"missing `:` after `{_head(context)}`",
        "expected `:`",
        reason=errors.MISSING_COLON.reason,
        cure="write `:` here",
    )


def _head(context: ErrorContext) -> str:
    text = context.source.slice(
        Span(context.line.start, context.before.span.end if context.before else context.line.end)
    )
    return text if len(text) <= 40 and "\n" not in text else context.first.text


def missing_brackets(context: ErrorContext) -> Diagnostic | None:
    kind = context.first.text
    if kind not in ("behavior", "monitor") or context.found.text != ":" or "LPAR" not in context.accepts:
        return None
    return errors.UNEXPECTED.at(
        context.found.span, f"a {kind} needs brackets after its name", "expected `()`", cure=errors.WRITE_BRACKETS
    )


def orphan(context: ErrorContext) -> Diagnostic | None:
    parents = {"else": "if", "elif": "if", "interrupt": "try"}
    word = context.first
    if context.place != 0 and not (context.place == 1 and word.text == "interrupt"):
        return None
    if word.text not in parents or "COLON" in context.accepts:
        return None
    parent = parents[word.text]
    article = "an" if parent == "if" else "a"
    return errors.INCOMPLETE.at(
        word.span,
        f"`{word.text}` without {article} `{parent}`",
        reason=f"it continues {article} `{parent}` block that is right above it, at the same indentation",
        cure=f"align it with its `{parent}`, or write the `{parent}`",
    )


def missing_comma(context: ErrorContext) -> Diagnostic | None:
    found, before = context.found, context.before
    if before is None or not context.wants_operator:
        return None
    place = Span(before.span.end, before.span.end)
    after_new = any(word.text == "new" for word in context.words[: context.place])
    if found.text in SPECIFIER_WORDS and after_new:
        return errors.MISSING_COMMA.at(
            place,
            f"missing comma before `{found.text}`",
            "expected `,`",
            secondary=[Label(found.span, "the next specifier")],
            cure="write a `,` between specifiers",
        )
    begins = found.kind in ("name", "number", "string") and found.text not in RESERVED
    if context.bracket is not None and begins:
        return errors.MISSING_COMMA.at(
            place,
            f"expected `,` or an operator before {_quoted(found)}",
            "something is missing here",
            secondary=[Label(found.span, "begins another value")],
            cure="write a `,` between the two, or an operator",
        )
    return None


def word_read_as_unit(context: ErrorContext) -> Diagnostic | None:
    """`f(x) g(y)`: the grammar took `g` for the unit of `f(x)`, so the error comes one word late."""
    before, words = context.before, context.words[: context.place - 1]
    if before is None or before.kind != "name" or not words or before.text in RESERVED or before.text in UNIT_WORDS:
        return None
    if not (words[-1].text == ")" or words[-1].kind == "number") or context.found.text not in ("(", "=", "[", ":"):
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


def misplaced_unit(context: ErrorContext) -> Diagnostic | None:
    found, before = context.found, context.before
    if found.text not in UNIT_WORDS or before is None or not context.wants_operator:
        return None
    start = found.span.start
    unit = max((word for word in UNIT_WORDS if context.source.text.startswith(word, start)), key=len)
    if before.kind == "name":
        cure = f"if `{before.text}` is a pure number write `{before.text} * 1 {unit}`; otherwise omit the unit"
    else:
        cure = f"multiply by it: `… * 1 {unit}`"
    return errors.MISPLACED_UNIT.at(
        Span(start, start + len(unit)),
        f"the unit `{unit}` cannot be used here",
        "a unit follows a number or a call",
        reason=errors.MISPLACED_UNIT.reason,
        cure=cure,
    )


def continued_line(context: ErrorContext) -> Diagnostic | None:
    """A comma at the end of a line, and a specifier below it at the same indentation: reported once for both lines."""
    lines = context.layout.lines
    index = context.index + (context.found.kind == "end")
    if (context.place and context.found.kind != "end") or not 0 < index < len(lines):
        return None
    previous, line = lines[index - 1], lines[index]
    if line.word not in SPECIFIER_WORDS or context.source.text[previous.end - 1] != ",":
        return None
    return errors.STRAY_INDENT.at(
        Span(line.start, line.start + len(line.word)),
        f"`{line.word}` must be indented",
        "a specifier",
        secondary=[Label(Span(previous.end - 1, previous.end), "continues below")],
        reason="a line continues after a comma only if the next one is indented deeper",
        cure="indent this line by four spaces",
    )


def reserved_word(context: ErrorContext) -> Diagnostic | None:
    found, after = context.found, context.after
    second = context.words[1] if len(context.words) > 1 else found
    if context.first.text in _NAMING and second.kind == "name" and second.text in RESERVED:
        return _reserved(second)
    if found.text == "=" and context.before is context.first and context.first.text in RESERVED:
        return _reserved(context.first)
    if found.kind != "name" or found.text not in RESERVED or "NAME" not in context.accepts:
        return None
    as_name = after is not None and (after.text in ("=", ".", ",", ")", "]") or after.kind == "end")
    if context.wants_value and not as_name:
        return None
    return _reserved(found)


def _reserved(word: Word) -> Diagnostic:
    return errors.RESERVED_WORD.at(
        word.span,
        f"`{word.text}` is a reserved word and cannot be a name",
        "choose another name",
        reason=errors.RESERVED_WORD.reason,
        cure=f"for example `{word.text}_`",
    )


def strange_character(context: ErrorContext) -> Diagnostic | None:
    found = context.found
    if found.kind != "sign" or found.text[0] in "()[]{}+-*/%=<>!.,:;@'\"":
        return None
    shown = f"`{found.text}`" if found.text.isprintable() else f"U+{ord(found.text[0]):04X}"
    return errors.STRANGE_CHARACTER.at(
        found.span,
        f"the character {shown} has no meaning here",
        reason=errors.STRANGE_CHARACTER.reason,
        cure="remove it",
    )


def misspelt_statement(context: ErrorContext) -> Diagnostic | None:
    """A line that begins with two words, of which the first is nearly a statement."""
    if context.place != 1 or context.first.kind != "name" or context.found.kind not in ("name", "number", "string"):
        return None
    if context.first.text in RESERVED or context.first.text in _STATEMENT_WORDS:
        return None
    begins = f"no statement begins with `{context.first.text}`"
    if action := next((name for name in SYNONYMS.get(context.first.text, ()) if name.endswith("Action")), None):
        return errors.UNEXPECTED.at(context.first.span, begins, cure=f"write `take {action}(…)`, in a behavior")
    meant = nearest(context.first.text, _STATEMENT_WORDS)
    return errors.UNEXPECTED.at(
        context.first.span,
        begins,
        f"did you mean `{meant}`?" if meant else "",
        cure=f"write `{meant}`" if meant else "did you forget an operator or `=` after it?",
    )


def nothing_follows(context: ErrorContext) -> Diagnostic | None:
    """Explain a keyword without its operand."""
    before = context.before
    if before is None or before.text not in _NAME_OF_A_THING:
        return None
    if context.found.kind != "end" and before is context.first:
        wanted = _NAME_OF_A_THING[before.text]
        return errors.UNEXPECTED.at(context.found.span, f"`{before.text}` is followed by {wanted}", "not by this")
    if context.found.kind != "end":
        return None
    return errors.UNEXPECTED.at(
        Span(before.span.end, before.span.end),
        f"nothing follows `{before.text}`",
        f"expected {_NAME_OF_A_THING[before.text]}",
    )


def unknown_unit(context: ErrorContext) -> Diagnostic | None:
    """Explain a word in the place of a unit that is no unit; `5 %` and `90°` have rules of their own."""
    found, before = context.found, context.before
    if before is None or before.kind != "number" or found.kind != "name" or found.text in RESERVED:
        return None
    return errors.UNKNOWN_UNIT.at(found.span, f"`{found.text}` is not a unit", reason=unit_list())
