"""Mistakes of habit: text that another language, an older Scenic or a fuller one would accept.

Comments of C, ranges of OpenSCENARIO, signs of other languages, statements that Scenic has and this language lacks.
Rules of the table of mistakes (`explain.table`): from the context of an error to its diagnostic, or None.
"""

import re
from itertools import pairwise

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors, words
from cortex_dsl.syntax.explain.context import ErrorContext, Word
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import SPECIFIER_WORDS

_FOREIGN = {
    "&&": "and",
    "||": "or",
    "!": "not",
    "&": "and",
    "|": "or",
    "<>": "!=",
    "===": "==",
    "°": "deg",
    "\N{LEFT DOUBLE QUOTATION MARK}": '"',
    "\N{RIGHT DOUBLE QUOTATION MARK}": '"',
    "\N{LEFT SINGLE QUOTATION MARK}": "'",
    "\N{RIGHT SINGLE QUOTATION MARK}": "'",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{MULTIPLICATION SIGN}": "*",
    "·": "*",
    "÷": "/",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "^": "**",
    "++": "+= 1",
    "--": "-= 1",
}


def not_supported(context: ErrorContext) -> Diagnostic | None:
    first, found, before = context.first, context.found, context.before
    named = len(context.words) > 1 and context.words[1].text in ("=", ".", ",")
    if first.text in words.LATER_STATEMENTS and first.kind == "name" and not named:
        return _later(first, words.LATER_STATEMENTS[first.text], words.INSTEAD.get(first.text, ""))
    if first.text == "record" and found.text in ("every", "after", "to") and context.wants_operator:
        return _later(found, f"`record … {found.text} …`", "a plain `record` takes the value at every step")
    if found.kind == "name" and found.text in words.LATER_OPERATORS and context.wants_operator:
        return _later(found, words.LATER_OPERATORS[found.text], words.INSTEAD.get(found.text, ""))
    if before is not None and before.text in words.LATER_OPERATORS and found.kind == "name":
        return _later(before, words.LATER_OPERATORS[before.text], words.INSTEAD.get(before.text, ""))
    if found.kind == "name" and found.text in words.LATER_SPECIFIERS:
        return _later(found, words.LATER_SPECIFIERS[found.text], words.INSTEAD.get(found.text, ""))
    return None


def beyond_along(context: ErrorContext) -> Diagnostic | None:
    """Explain `beyond intersection by 10 m along way`: a place behind it on a way is `after` it."""
    if context.found.text != "along" or not any(word.text == "beyond" for word in context.words[: context.place]):
        return None
    return errors.UNEXPECTED.at(
        context.found.span,
        "`beyond` is measured on a line of sight, not on a trajectory",
        cure="write `after` instead of `beyond`, as in `after intersection by 10 m along trajectory`",
    )


def _later(word: Word, what: str, cure: str = "") -> Diagnostic:
    message = f"not supported yet: {what}"
    return errors.NOT_SUPPORTED.at(word.span, message, reason=errors.NOT_SUPPORTED.reason, cure=cure)


def foreign_spelling(context: ErrorContext) -> Diagnostic | None:
    found, before = context.found, context.before
    second = context.words[1] if len(context.words) > 1 else context.first
    if context.first.text == "else" and second.text == "if":
        return _written(Word("name", "else if", context.first.span.to(second.span)), "elif")
    if before is not None and before.text in ("++", "--") and found.kind == "end":
        return _written(before, _FOREIGN[before.text])
    if found.kind == "sign" and found.text in _FOREIGN:
        return _written(found, _FOREIGN[found.text], _further(context))
    if context.first.text in ("elseif", "elsif") and context.first.kind == "name":
        return _written(context.first, "elif")
    if context.first.text in ("function", "fn", "func", "behaviour") and context.before is context.first:
        return _written(context.first, "behavior")
    if context.first.text in ("include", "use", "using", "load") and context.before is context.first:
        return _written(context.first, "import")
    if context.first.text in ("let", "var", "const", "auto") and context.before is context.first:
        return errors.FOREIGN_SPELLING.at(
            context.first.span, f"`{context.first.text}` is not needed", cure="write `name = value`"
        )
    if found.text == "?":
        return errors.FOREIGN_SPELLING.at(
            found.span, "`?` is not an operator", cure="a choice between two values is `a if condition else b`"
        )
    if found.text == ";" or (found.text == "{" and context.wants_operator):
        return errors.FOREIGN_SPELLING.at(
            found.span, f"`{found.text}` does not belong here", cure="blocks begin with `:` and are indented"
        )
    return None


def _written(word: Word, ours: str, further: str = "") -> Diagnostic:
    return errors.FOREIGN_SPELLING.at(
        word.span, f"`{word.text}` is written `{ours}`", f"write `{ours}`", cure=f"write `{ours}`{further}"
    )


def _further(context: ErrorContext) -> str:
    """The other foreign signs of the line, so that all of it can be corrected at once."""
    rest = {word.text for word in context.words[context.place + 1 :] if word.kind == "sign" and word.text in _FOREIGN}
    return "".join(f", and `{_FOREIGN[sign]}` for `{sign}`" for sign in sorted(rest - {context.found.text}))


def text_prefix(context: ErrorContext) -> Diagnostic | None:
    found, before = context.found, context.before
    if found.kind != "string" or before is None or before.span.end != found.span.start:
        return None
    if before.text.lower() not in ("f", "r", "b", "u", "rb", "br", "fr", "rf"):
        return None
    if before.text.lower() == "f":
        return errors.NOT_SUPPORTED.at(
            before.span,
            "a name cannot contain values",
            reason="it is the same in all scenes",
            cure="write a plain string",
        )
    return errors.NOT_SUPPORTED.at(
        before.span, f"strings with the prefix `{before.text}` are not supported", cure="write a plain string"
    )


def missing_new(context: ErrorContext) -> Diagnostic | None:
    """Explain `ego = Car at p`, and `ego = Car in lane, with speed 5`, whose `in` is read as a comparison."""
    after, goes_on = context.after, context.found.text == "," and context.bracket is None
    place = after.text if goes_on and after is not None else context.found.text
    if place not in SPECIFIER_WORDS or any(word.text == "new" for word in context.words[: context.place]):
        return None
    for name, specifier in pairwise(context.words[: context.place + 1]):
        is_class = name.kind == "name" and name.text[0].isupper() and not name.text.isupper()
        if is_class and specifier.text in SPECIFIER_WORDS:
            return errors.MISSING_NEW.at(
                name.span,
                f"missing `new` before `{name.text}`",
                reason=errors.MISSING_NEW.reason,
                cure=f"write `new {name.text} {specifier.text} …`",
            )
    return None


# -- From elsewhere: comments of C, ranges of OpenSCENARIO, words in the order of a sentence --------------------------

_ODD_BLANK = re.compile(r"[^\S \t\r\n\f]")
_DOTS = re.compile(r"\[\s*(?P<low>-?\d+(?:\.\d+)?)\s*\.\.\.?\s*(?P<high>-?\d+(?:\.\d+)?)\s*\]")
_PAIR = re.compile(r"[(\[]\s*(?P<low>-?[\d.]+)\s*,\s*(?P<high>-?[\d.]+)\s*[)\]]\s*\Z")


def _next_to(one: Word | None, other: Word | None) -> bool:
    return one is not None and other is not None and one.span.end == other.span.start


def _foreign(span: Span, message: str, cure: str) -> Diagnostic:
    return errors.FOREIGN_SPELLING.at(span, message, cure=cure)


def odd_blank(context: ErrorContext) -> Diagnostic | None:
    """Explain a space from a web page or a word processor, which looks like any other and separates no words."""
    start = context.before.span.end if context.before is not None else context.line.start
    found = _ODD_BLANK.search(context.source.text, start, max(start, context.found.span.start))
    if found is None:
        return None
    return errors.FOREIGN_SPELLING.at(
        Span(*found.span()),
        f"this space is the character U+{ord(found.group()):04X}",
        "not an ordinary space",
        reason="text that was copied from a web page or a word processor may contain such spaces",
        cure="delete it and type a space",
    )


def comment_of_c(context: ErrorContext) -> Diagnostic | None:
    """`// so`, and `/* so */`."""
    words, place, found = context.words, context.place, context.found
    near = (context.before, found, context.after)
    for slash, star in pairwise(words):
        if slash.text == "/" and star.text == "*" and _next_to(slash, star) and star in near:
            cure = "write `#` in front of each line of a comment"
            return _foreign(slash.span.to(star.span), "a comment does not begin with `/*`", cure)
    double = next((word for word in words[: place + 1] if word.text == "//"), None)
    if double is not None and (found is double or (found.kind == "name" and context.wants_operator)):
        return _foreign(double.span, "a comment does not begin with `//`", "write `#`")
    return None


def swapped_comparison(context: ErrorContext) -> Diagnostic | None:
    """`a => b`, `a =< b`."""
    found, after = context.found, context.after
    if found.text != "=" or after is None or after.text not in ("<", ">") or not _next_to(found, after):
        return None
    meant = f"{after.text}="
    return errors.FOREIGN_SPELLING.at(
        found.span.to(after.span), f"`={after.text}` is written `{meant}`", f"write `{meant}`", cure=f"write `{meant}`"
    )


def between(context: ErrorContext) -> Diagnostic | None:
    """`require x between a and b`."""
    before, found = context.before, context.found
    if found.text != "between" or not context.wants_operator or before is None:
        return None
    name = before.text if before.kind == "name" else "x"
    return _foreign(found.span, "`between` is not an operator", f"write `low <= {name} <= high`")


def new_behind(context: ErrorContext) -> Diagnostic | None:
    """`ego = Car new on road`."""
    before, found = context.before, context.found
    if found.text != "new" or before is None or before.kind != "name" or not context.wants_operator:
        return None
    message = f"`new` goes before `{before.text}`"
    return _foreign(before.span.to(found.span), message, f"write `new {before.text}`")


def with_behind(context: ErrorContext) -> Diagnostic | None:
    """`new Car on road, speed with 8 m/s`."""
    found, place = context.found, context.place
    if found.text != "with" or place < 2 or context.words[place - 1].kind != "name":
        return None
    if context.words[place - 2].text != ",":
        return None
    name = context.words[place - 1]
    return _foreign(name.span.to(found.span), f"`with` goes before `{name.text}`", f"write `with {name.text} …`")


def typed_name(context: ErrorContext) -> Diagnostic | None:
    """`ego: Car`."""
    first, found, after = context.first, context.found, context.after
    if context.place != 1 or found.text != ":" or first.kind != "name" or "_EQUAL" not in context.accepts:
        return None
    if after is None or after.kind != "name" or not after.text[0].isupper():
        return None
    return _foreign(found.span, "a name gets its value with `=`", f"write `{first.text} = new {after.text} on road`")


def range_in_brackets(context: ErrorContext) -> Diagnostic | None:
    """`[20..50] km/h`, `(20, 50) km/h`."""
    text, found, bracket = context.source.text, context.found, context.bracket
    dots = _DOTS.match(text, bracket.span.start, context.line.end) if bracket is not None else None
    if dots is not None:
        return _as_range(dots, Span(*dots.span()))
    if found.text not in UNIT_WORDS or context.before is None or context.before.text not in (")", "]"):
        return None
    opening = max(text.rfind(sign, context.line.start, found.span.start) for sign in "([")
    pair = _PAIR.match(text, opening, found.span.start) if opening >= 0 else None
    called = opening > 0 and (text[opening - 1].isalnum() or text[opening - 1] == "_")
    return None if pair is None or called else _as_range(pair, Span(pair.start(), context.before.span.end))


def _as_range(match: re.Match[str], span: Span) -> Diagnostic:
    cure = f"write `Range({match['low']}, {match['high']})`"
    return _foreign(span, "a range is written `Range(low, high)`", cure)
