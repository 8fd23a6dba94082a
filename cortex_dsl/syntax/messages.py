"""What to say where the grammar stops: first the likely mistakes, then what was found and what would have fitted."""

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.layout import Layout
from cortex_dsl.syntax.mistakes import MISTAKES
from cortex_dsl.syntax.trouble import Trouble, Word
from cortex_dsl.syntax.words import RESERVED

_VALUE_STARTS = frozenset({
    "NAME", "NUMBER", "STRING", "CONSTANT", "LPAR", "LSQB", "LBRACE", "PLUS", "MINUS", "STAR", "NOT", "_LAMBDA",
    "_NEW", "DISTANCE", "_RELATIVE_HEADING_OF", "TEMPORAL", "DO_MODE", "RECORD_WHEN",
})  # fmt: skip
_STATEMENT_STARTS = frozenset({
    "_BEHAVIOR", "_MAP", "_MODEL", "_PARAM", "_SIMULATION", "_REQUIRE", "_REQUIRE_PROBABLY", "_ABORT", "_TAKE",
    "TERMINATE", "_TERMINATE_AFTER", "TERMINATE_WHEN", "_WAIT", "_DO", "_BREAK", "_CONTINUE", "_RETURN",
    "_PASS", "_TRY", "_IF", "_WHILE", "$END", "_DEDENT", "_CLASS", "_COMPOSE", "_FROM", "_IMPORT", "_MONITOR",
    "_MUTATE", "_OVERRIDE", "_RECORD", "_REQUIRE_MONITOR", "_SCENARIO", "_SETUP", "_SIGNALS", "GUARD",
})  # fmt: skip
_OPERATORS = frozenset({
    "PLUS", "MINUS", "STAR", "SLASH", "DOUBLE_SLASH", "DOUBLE_STAR", "PERCENT", "AT_SIGN", "COMPARE", "IN",
    "NOT_IN", "IS", "IS_NOT", "_AND", "_OR", "_IF", "_CAN_SEE", "_DEG", "_INTERSECTS", "_OFFSET_ALONG",
    "_OFFSET_BY", "_IMPLIES", "UNIT", "UNKNOWN_UNIT", "LPAR", "LSQB", "DOT", "AUGMENTED_ASSIGN", "SEMICOLON",
})  # fmt: skip
_SPECIFIERS = frozenset({
    "_AT", "ON", "_AFTER", "_BEFORE", "BESIDE", "_FACING", "_FACING_AWAY", "_FACING_TOWARD", "_FOLLOWING", "_WITH",
})  # fmt: skip
_SPOKEN = {
    "NAME": "a name",
    "STRING": "a string",
    "COLON": "`:`",
    "COMMA": "`,`",
    "_COMMA_SPECIFIER": "`,` and a specifier",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "RBRACE": "`}`",
    "_EQUAL": "`=`",
    "_NEWLINE": "the end of the line",
    "_INDENT": "an indented block",
    "_INTERRUPT_WHEN": "`interrupt when`",
    "_ELSE": "`else`",
    "_ELIF": "`elif`",
    "_BY": "`by`",
    "_TO": "`to`",
    "_FROM": "`from`",
    "_FOR": "`for`",
    "_AS": "`as` and a name",
    "_UNTIL": "`until`",
    "_IMPORT": "`import`",
    "_ALONG": "`along`",
    "IN": "`in`",
    "TIME_WORD": "`seconds` or `steps`",
}


def explain(source: Source, layout: Layout, index: int, offset: int, accepts: frozenset[str]) -> Diagnostic:
    """The diagnostic for the place where the grammar of a line ends."""
    trouble = Trouble(source, layout, index, offset, accepts)
    for mistake in MISTAKES:
        if (diagnostic := mistake(trouble)) is not None:
            return diagnostic
    return _unexpected(trouble)


def _unexpected(trouble: Trouble) -> Diagnostic:
    expected = " or ".join(wanted) if (wanted := expectations(trouble)) and len(wanted) < 3 else _one_of(wanted)
    found = name_of(trouble.found)
    return errors.UNEXPECTED.at(
        trouble.found.span,
        f"expected {expected}, found {found}" if expected else f"{found} is unexpected here",
        f"expected {expected}" if expected else "unexpected",
        reason=f"`{trouble.found.text}` is a reserved word" if trouble.found.text in RESERVED else "",
    )


def _one_of(words: list[str]) -> str:
    return ", ".join(words[:-1]) + " or " + words[-1] if words else ""


def name_of(word: Word) -> str:
    """A found word in a sentence."""
    if word.kind == "end":
        return "the end of the line"
    if word.kind == "string":
        return "a string"
    if word.kind == "number":
        return f"the number `{word.text}`"
    return f"`{word.text}`"


def expectations(trouble: Trouble) -> list[str]:
    """What could stand here, in human words, the most useful first."""
    accepts = set(trouble.accepts)
    words: list[str] = []
    if {"_REQUIRE", "_PASS"} <= accepts:
        words.append("a statement")
        accepts -= _STATEMENT_STARTS | _VALUE_STARTS
    elif "NUMBER" in accepts:
        words.append("an expression")
        accepts -= _VALUE_STARTS
    elif "_WITH" in accepts:
        words.append("a specifier such as `at`, `with` or `facing`")
        accepts -= _SPECIFIERS | {"IN", "_OFFSET_BY", "_OFFSET_ALONG"}
    if "PLUS" in accepts:
        accepts -= _OPERATORS
        if trouble.bracket is not None:
            accepts -= {"_NEWLINE"}
    if "COMMA" in accepts:
        accepts -= {"_COMMA_SPECIFIER"}
    words += sorted(_SPOKEN[kind] for kind in accepts if kind in _SPOKEN)
    if "PLUS" in trouble.accepts and "an expression" not in words and "a statement" not in words:
        words.append("an operator")
    return words
