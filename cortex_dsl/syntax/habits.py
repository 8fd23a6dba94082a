"""Mistakes of habit: what another language, an older Scenic or a fuller one would have taken.

Rules as in `mistakes`: from the surroundings of an error to its explanation, or None if it is another one.
"""

from itertools import pairwise

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.syntax import errors, later
from cortex_dsl.syntax.trouble import Trouble, Word
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


def not_supported(trouble: Trouble) -> Diagnostic | None:
    first, found, before = trouble.first, trouble.found, trouble.before
    named = len(trouble.words) > 1 and trouble.words[1].text in ("=", ".", ",")
    if first.text in later.STATEMENTS and first.kind == "name" and not named:
        return _later(first, later.STATEMENTS[first.text], later.INSTEAD.get(first.text, ""))
    if first.text == "wait" and found.text in ("for", "until"):
        return _later(found, f"`wait {found.text}`", f"write `do IdleBehavior() {found.text} …`")
    if first.text == "record" and found.text in ("every", "after", "to") and trouble.wants_operator:
        return _later(found, f"`record … {found.text} …`", "a plain `record` takes the value at every step")
    if first.text == "return" and before is first and found.kind != "end":
        return _later(found, "a value after `return`", "a behavior ends with `return` alone")
    if found.text == ":" and trouble.bracket is not None and trouble.bracket.text == "[":
        return _later(found, "a slice", "index one element, or write a comprehension")
    if found.kind == "name" and found.text in later.OPERATORS and trouble.wants_operator:
        return _later(found, later.OPERATORS[found.text], later.INSTEAD.get(found.text, ""))
    if before is not None and before.text in later.OPERATORS and found.kind == "name":
        return _later(before, later.OPERATORS[before.text], later.INSTEAD.get(before.text, ""))
    if found.kind == "name" and found.text in later.SPECIFIERS:
        return _later(found, later.SPECIFIERS[found.text], later.INSTEAD.get(found.text, ""))
    return None


def _later(word: Word, what: str, cure: str = "") -> Diagnostic:
    message = f"not supported yet: {what}"
    return errors.NOT_SUPPORTED.at(word.span, message, reason=errors.NOT_SUPPORTED.why, cure=cure)


def foreign_spelling(trouble: Trouble) -> Diagnostic | None:
    found, before = trouble.found, trouble.before
    second = trouble.words[1] if len(trouble.words) > 1 else trouble.first
    if trouble.first.text == "else" and second.text == "if":
        return _foreign(Word("name", "else if", trouble.first.span.to(second.span)), "elif")
    if before is not None and before.text in ("++", "--") and found.kind == "end":
        return _foreign(before, _FOREIGN[before.text])
    if found.kind == "sign" and found.text in _FOREIGN:
        return _foreign(found, _FOREIGN[found.text], _further(trouble))
    if trouble.first.text in ("elseif", "elsif") and trouble.first.kind == "name":
        return _foreign(trouble.first, "elif")
    if trouble.first.text in ("function", "fn", "func", "behaviour") and trouble.before is trouble.first:
        return _foreign(trouble.first, "behavior")
    if trouble.first.text in ("include", "use", "using", "load") and trouble.before is trouble.first:
        return _foreign(trouble.first, "import")
    if trouble.first.text in ("let", "var", "const", "auto") and trouble.before is trouble.first:
        return errors.FOREIGN_SPELLING.at(
            trouble.first.span, f"`{trouble.first.text}` is not needed", cure="write `name = value`"
        )
    if found.text == "?":
        return errors.FOREIGN_SPELLING.at(
            found.span, "`?` is no operator", cure="a choice between two values is `a if condition else b`"
        )
    if found.text == ";" or (found.text == "{" and trouble.wants_operator):
        return errors.FOREIGN_SPELLING.at(
            found.span, f"`{found.text}` does not belong here", cure="blocks begin with `:` and are indented"
        )
    return None


def _foreign(word: Word, ours: str, further: str = "") -> Diagnostic:
    return errors.FOREIGN_SPELLING.at(
        word.span, f"`{word.text}` is written `{ours}`", f"write `{ours}`", cure=f"write `{ours}`{further}"
    )


def _further(trouble: Trouble) -> str:
    """The other foreign signs of the line, so that it can be mended at once."""
    rest = {word.text for word in trouble.words[trouble.place + 1 :] if word.kind == "sign" and word.text in _FOREIGN}
    return "".join(f", and `{_FOREIGN[sign]}` for `{sign}`" for sign in sorted(rest - {trouble.found.text}))


def text_prefix(trouble: Trouble) -> Diagnostic | None:
    found, before = trouble.found, trouble.before
    if found.kind != "string" or before is None or before.span.end != found.span.start:
        return None
    if before.text.lower() not in ("f", "r", "b", "u", "rb", "br", "fr", "rf"):
        return None
    return errors.NOT_SUPPORTED.at(
        before.span, f"strings with the prefix `{before.text}` are not supported", cure="write a plain string"
    )


def missing_new(trouble: Trouble) -> Diagnostic | None:
    """`ego = Car at p`, and `ego = Car in lane, with speed 5`, whose `in` was read as a comparison."""
    after, goes_on = trouble.after, trouble.found.text == "," and trouble.bracket is None
    place = after.text if goes_on and after is not None else trouble.found.text
    if place not in SPECIFIER_WORDS or any(word.text == "new" for word in trouble.words[: trouble.place]):
        return None
    for name, specifier in pairwise(trouble.words[: trouble.place + 1]):
        is_class = name.kind == "name" and name.text[0].isupper() and not name.text.isupper()
        if is_class and specifier.text in SPECIFIER_WORDS:
            return errors.MISSING_NEW.at(
                name.span,
                f"missing `new` before `{name.text}`",
                reason=errors.MISSING_NEW.why,
                cure=f"write `new {name.text} {specifier.text} …`",
            )
    return None
