"""Mistakes in definitions and connections: classes, scenarios, guards, imports, and requirements over time.

Rules of the table of mistakes (`explain.table`): from the context of an error to its diagnostic, or None.
"""

from collections.abc import Mapping
from types import MappingProxyType

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Span
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.explain.context import ErrorContext, Word
from cortex_dsl.syntax.words import BLOCK_WORDS, GUARDS, RESERVED, SPECIFIER_WORDS, TEMPORAL_PREFIXES

_SECOND_WORDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "do": ("choose", "shuffle"),
        "require": ("always", "eventually", "next", "monitor"),
        "expect": ("always", "eventually", "next"),
        "record": ("initial", "final"),
        "terminate": ("when", "after", "simulation"),
        "interrupt": ("when",),
    }
)
"""Words that may follow the first one of a statement."""


def misspelt_second_word(context: ErrorContext) -> Diagnostic | None:
    """Explain `do chose A()`, `require allways x`: a known statement with a misspelt second word."""
    if context.place > 2 or len(context.words) < 3:
        return None
    second, known = context.words[1], _SECOND_WORDS.get(context.first.text, ())
    if second.kind != "name" or second.text in known or not _begins_value(context.words[2]):
        return None
    meant = nearest(second.text, known)
    return _misspelt(second, meant) if meant else None


def misspelt_joint(context: ErrorContext) -> Diagnostic | None:
    """`require a untill b`, `expect a untill b`."""
    found = context.found
    if context.first.text not in ("require", "expect") or found.kind != "name" or not context.wants_operator:
        return None
    meant = nearest(found.text, ("until", "implies"))
    return _misspelt(found, meant) if meant and meant != found.text else None


def _misspelt(word: Word, meant: str) -> Diagnostic:
    return errors.UNEXPECTED.at(
        word.span, f"`{word.text}` is not a word of this statement", f"did you mean `{meant}`?", cure=f"write `{meant}`"
    )


def _ends_value(word: Word) -> bool:
    return word.text not in RESERVED and (word.kind in ("name", "number", "string") or word.text in (")", "]", "}"))


def _begins_value(word: Word) -> bool:
    return word.kind in ("name", "number", "string") or word.text in ("(", "[", "{")


def temporal_elsewhere(context: ErrorContext) -> Diagnostic | None:
    """A temporal operator where the grammar has none."""
    found, before, first = context.found, context.before, context.first.text
    if before is not None and before.text in TEMPORAL_PREFIXES and found.kind in ("name", "number", "string"):
        return _misplaced(before, "write it as `require " + before.text + " …`")
    if found.text not in ("until", "implies") or first in ("do", "wait") or before is None or not _ends_value(before):
        return None
    if first in ("require", "expect") and any(
        word.text in ("until", "implies") for word in context.words[: context.place]
    ):
        return _misplaced(found, f"put brackets around one part: `(a {found.text} b) {found.text} c`")
    return _misplaced(found, f"write it as `require … {found.text} …`")


def _misplaced(word: Word, cure: str) -> Diagnostic:
    return errors.MISPLACED_TEMPORAL.at(
        word.span, f"`{word.text}` cannot be used here", reason=errors.MISPLACED_TEMPORAL.reason, cure=cure
    )


def guard(context: ErrorContext) -> Diagnostic | None:
    """A guard without its colon, or without a condition on its line."""
    first, before = context.first, context.before
    if first.text not in GUARDS or before is None or context.place > 2:
        return None
    if before.text == ":" and context.found.kind == "end":
        return errors.INCOMPLETE.at(
            Span(before.span.end, before.span.end),
            f"nothing follows `{first.text}:`",
            "expected a condition",
            reason="the condition of a guard goes on the same line",
            cure=f"write `{first.text}: CONDITION`",
        )
    return missing_guard_colon(first) if context.place == 1 and _begins_value(context.found) else None


def missing_guard_colon(word: Word) -> Diagnostic:
    return errors.MISSING_COLON.at(
        Span(word.span.end, word.span.end),
        f"missing `:` after `{word.text}`",
        "expected `:`",
        reason="a guard is its keyword, `:` and a condition",
        cure=f"write `{word.text}: CONDITION`",
    )


def class_head(context: ErrorContext) -> Diagnostic | None:
    """`class Taxi extends Car:`, `class Taxi(Car, Boat):`."""
    found = context.found
    if context.first.text != "class" or context.place < 2:
        return None
    name = context.words[1].text
    if context.place == 2 and found.kind == "name":
        base = context.after.text if context.after is not None and context.after.kind == "name" else "Car"
        cure = f"write `class {name}({base}):`"
        return errors.FOREIGN_SPELLING.at(found.span, f"`{found.text}` does not belong here", cure=cure)
    if found.text == "," and context.bracket is not None:
        return errors.NOT_SUPPORTED.at(
            found.span, "not supported: several base classes", "a class has one base", cure="keep one of them"
        )
    return None


def class_line(context: ErrorContext) -> Diagnostic | None:
    """A line of a class that is not `name: value`."""
    first, found = context.first, context.found
    if context.place == 1 and context.accepts <= {"COLON"} and first.kind == "name" and first.text not in BLOCK_WORDS:
        if found.text == "[":
            return errors.NOT_SUPPORTED.at(
                found.span, "not supported yet: attributes of a property", cure=f"write `{first.text}: value`"
            )
        return errors.CLASS_BODY.at(
            found.span if found.text == "=" else Span(first.span.end, first.span.end),
            f"a property is given a default with `:`{', not `=`' if found.text == '=' else ''}",
            "expected `:`",
            reason=errors.CLASS_BODY.reason,
            cure=f"write `{first.text}: value`",
        )
    if context.place == 0 and {"NAME", "STRING", "_PASS"} <= context.accepts and "NUMBER" not in context.accepts:
        return errors.CLASS_BODY.at(
            found.span,
            f"`{found.text}` cannot be used in a class",
            reason=errors.CLASS_BODY.reason,
            cure="write `name: value`; what an object does belongs in its `behavior`",
        )
    return None


def wrong_import(context: ErrorContext) -> Diagnostic | None:
    first, found = context.first, context.found
    if first.text not in ("import", "from") or first.kind != "name":
        return None
    if found.text in ("-", "/", "\\"):
        return _wrong_import(found, f"`{found.text}` cannot be part of a name", _quoted_path(context))
    if found.text in (".", "..", "...") and context.place == 1:
        return _wrong_import(found, "a path does not begin with a dot", _quoted_path(context))
    if first.text == "from" and found.kind == "end" and context.before is not None and context.before.text == "import":
        return _wrong_import(found, "nothing follows `import`", "name what to import, or write `*` for everything")
    if first.text == "import" and found.text == ",":
        return _wrong_import(found, "only one import per line", "write one line for each file")
    if first.text == "import" and found.text == "from":
        name, path = context.words[1].text, context.after.text if context.after is not None else "cars"
        return _wrong_import(found, "`from` comes first", f"write `from {path or 'cars'} import {name}`")
    return None


def _quoted_path(context: ErrorContext) -> str:
    """The cure: the path that was written, in quotes."""
    after = next((word for word in context.words if word.text in ("as", "import") and word is not context.first), None)
    end = after.span.start if after is not None else context.line.end
    path = context.source.text[context.first.span.end : end].strip().replace("\\", "/").strip("\"'")
    if path.startswith("."):
        dots = len(path) - len(path.lstrip("."))
        path = "../" * (dots - 1) + path[dots:].replace(".", "/")
    path = path if path.endswith(".scn") else path + ".scn"
    return f'write the path in quotes: `{context.first.text} "{path}" …`'


def _wrong_import(word: Word, message: str, cure: str) -> Diagnostic:
    return errors.WRONG_IMPORT.at(word.span, message, reason=errors.WRONG_IMPORT.reason, cure=cure)


_SIDES: Mapping[str, str] = MappingProxyType(
    {"ahead": "ahead of", "front": "ahead of", "left": "left of", "right": "right of"}
)
"""Words for places next to an object, without `of` or in plain English."""


def side_without_of(context: ErrorContext) -> Diagnostic | None:
    """`new Car ahead ego`, `new Car left ego by 3`, `new Car in front of ego`."""
    found, before = context.found, context.before
    word = before if found.text == "of" and before is not None and before.text == "front" else found
    if word.text not in _SIDES or "new" not in [each.text for each in context.words[: context.place]]:
        return None
    meant = _SIDES[word.text]
    cure = f"write `{meant}`, as in `{meant} ego by 5 m`"
    return errors.UNEXPECTED.at(word.span, f"`{word.text}` is not a specifier", f"did you mean `{meant}`?", cure=cure)


def misspelt_specifier(context: ErrorContext) -> Diagnostic | None:
    """`new Car att (3, 4)`, `new Car on road, wiht speed 3`."""
    found = context.found
    if found.kind != "name" or "_WITH" not in context.accepts:
        return None
    if (meant := nearest(found.text, SPECIFIER_WORDS)) is None:
        return None
    return errors.UNEXPECTED.at(
        found.span, f"`{found.text}` is not a specifier", f"did you mean `{meant}`?", cure=f"write `{meant}`"
    )
