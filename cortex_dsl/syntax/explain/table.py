"""The table of likely mistakes at a syntax error, and the answer if none of them fits.

Each mistake is a rule, from the context of an error to its diagnostic, or to None if it is another mistake. The first
rule that knows the mistake answers, so special rules come before general ones. The other files of this folder contain
the rules: `habits` of other languages, `phrasing` of sentences, `joints` of definitions and connections, and
`punctuation`.
"""

from collections.abc import Callable

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.explain import habits, joints, phrasing, punctuation
from cortex_dsl.syntax.explain.context import ErrorContext, Word
from cortex_dsl.syntax.layout import Layout
from cortex_dsl.syntax.words import RESERVED
from engine.frozen import frozen


@frozen
class Mistake:
    """One row: the wrong text, the code of its answer, and its rule (a test compiles each)."""

    written: str
    code: str
    rule: Callable[[ErrorContext], Diagnostic | None]


MISTAKES = (
    Mistake("ego = new Car at 1 @ 2,\nwith speed 5", "SCN105", punctuation.continued_line),
    Mistake("param\N{NO-BREAK SPACE}A = 1", "SCN114", habits.odd_blank),
    Mistake("x = 1 // a note", "SCN114", habits.comment_of_c),
    Mistake("require x => 3", "SCN114", habits.swapped_comparison),
    Mistake("require x between 1 and 3", "SCN114", habits.between),
    Mistake("ego = Car new on road", "SCN114", habits.new_behind),
    Mistake("ego = new Car on road, speed with 8 m/s", "SCN114", habits.with_behind),
    Mistake("ego: Car", "SCN114", habits.typed_name),
    Mistake("param V = [20..50] km/h", "SCN114", habits.range_in_brackets),
    Mistake("param V = 15 to 50 km/h", "SCN114", phrasing.range_in_words),
    Mistake("other = new Car meeting ego after 4 s", "SCN101", phrasing.meeting_incomplete),
    Mistake("ego = new Car 40 m before intersection along way", "SCN101", phrasing.distance_first),
    Mistake("terminate when ego collides with truck", "SCN101", phrasing.contact),
    Mistake("b = new Car ahead ego", "SCN101", joints.side_without_of),
    Mistake("class Taxi(Car):\n    def drive():\n        pass", "SCN126", phrasing.function_in_a_class),
    Mistake("a = new Car beyond b by 3 m along way", "SCN101", habits.beyond_along),
    Mistake("x = altitude of y", "SCN115", habits.not_supported),
    Mistake("require allways x > 3", "SCN101", joints.misspelt_second_word),
    Mistake("require a untill b", "SCN101", joints.misspelt_joint),
    Mistake("x = always y", "SCN124", joints.temporal_elsewhere),
    Mistake("scenario Main():\n    precondition x > 3", "SCN109", joints.guard),
    Mistake("class Taxi extends Car:\n    pass", "SCN114", joints.class_head),
    Mistake("class Taxi(Car):\n    speed = 3", "SCN126", joints.class_line),
    Mistake("import cars/taxi", "SCN127", joints.wrong_import),
    Mistake('x = r"{y}"', "SCN115", habits.text_prefix),
    Mistake("behavior Stop() {}", "SCN114", phrasing.braces),
    Mistake("x = 50 %", "SCN114", phrasing.percent),
    Mistake("require a && b", "SCN114", habits.foreign_spelling),
    Mistake("b = [m for m in ms if m.type = x]", "SCN110", phrasing.assignment_in_lambda),
    Mistake("require x = 3", "SCN110", punctuation.assignment_in_condition),
    Mistake("ego = new Car with speed = 5", "SCN101", phrasing.equals_after_with),
    Mistake("a = b = 3", "SCN116", punctuation.second_assignment),
    Mistake("behavior Drive()\n    wait", "SCN109", punctuation.missing_colon),
    Mistake("behavior Drive:\n    wait", "SCN101", punctuation.missing_brackets),
    Mistake("else:\n    x = 1", "SCN122", punctuation.orphan),
    Mistake("ego = Car at 1 @ 2", "SCN120", habits.missing_new),
    Mistake("behavior Drive():\n    FollowLaneBehavior() for 3 s", "SCN122", phrasing.forgotten_do),
    Mistake("behavior Drive():\n    wait 3 s", "SCN101", phrasing.wait_for_a_time),
    Mistake('require x > 3, "near"', "SCN101", phrasing.name_of_a_requirement),
    Mistake("ego = new Car, with speed 5", "SCN101", phrasing.comma_before_specifiers),
    Mistake("ego = new Car at 1.75, -30, facing 3", "SCN101", phrasing.place_without_brackets),
    Mistake("param SPEED 5 m/s", "SCN101", phrasing.param_without_equals),
    Mistake("terminate if x > 3", "SCN101", phrasing.terminate_if),
    Mistake("require distance ego to b < 3", "SCN101", phrasing.distance_without_from),
    Mistake("x = a m", "SCN112", punctuation.misplaced_unit),
    Mistake("ego = new Car at 1 @ 2 with speed 5", "SCN119", punctuation.missing_comma),
    Mistake("x = f(g(3) y(4))", "SCN119", punctuation.word_read_as_unit),
    Mistake("x = 3 steps", "SCN111", punctuation.unknown_unit),
    Mistake("requires x", "SCN101", punctuation.misspelt_statement),
    Mistake("ego = new Car att (3, 4)", "SCN101", joints.misspelt_specifier),
    Mistake("for = 3", "SCN113", punctuation.reserved_word),
    Mistake("require", "SCN101", punctuation.nothing_follows),
    Mistake("x = $", "SCN118", punctuation.strange_character),
)


def explain(source: Source, layout: Layout, index: int, offset: int, accepts: frozenset[str]) -> Diagnostic:
    """The diagnostic for the place where the grammar of a line ends."""
    context = ErrorContext(source, layout, index, offset, accepts)
    for row in MISTAKES:
        if (diagnostic := row.rule(context)) is not None:
            return diagnostic
    return _unexpected(context)


def _unexpected(context: ErrorContext) -> Diagnostic:
    found = name_of(context.found)
    wanted = [each for each in expectations(context) if each != found]  # a sign that only further signs make right
    expected = " or ".join(wanted) if len(wanted) < 3 else _one_of(wanted)
    return errors.UNEXPECTED.at(
        context.found.span,
        f"expected {expected}, found {found}" if expected else f"{found} is unexpected here",
        reason=_reason(context.found),
        cure=f"write {expected} here" if expected else "remove it, or begin a new line with it",
    )


def _reason(found: Word) -> str:
    if found.text in RESERVED:
        return f"`{found.text}` is a reserved word"
    return "a statement ends with its line, outside of brackets" if found.kind == "end" else "the line fits up to here"


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


_VALUE_STARTS = frozenset({
    "NAME", "NUMBER", "STRING", "CONSTANT", "LPAR", "LSQB", "LBRACE", "PLUS", "MINUS", "STAR", "NOT", "_LAMBDA",
    "_NEW", "DISTANCE", "_RELATIVE_HEADING_OF", "TEMPORAL", "DO_MODE", "RECORD_WHEN", "APPARENT_OR_POSITION",
    "DISTANCE_PAST", "ANGLE", "_FOLLOW", "SIDE_OF", "VISIBLE",
})  # fmt: skip
_STATEMENT_STARTS = frozenset({
    "_BEHAVIOR", "_MAP", "_MODEL", "_PARAM", "_SIMULATION", "_REQUIRE", "_REQUIRE_PROBABLY", "_ABORT", "_TAKE",
    "TERMINATE", "_TERMINATE_AFTER", "TERMINATE_WHEN", "_WAIT", "_DO", "_BREAK", "_CONTINUE", "_RETURN",
    "_PASS", "_TRY", "_IF", "_WHILE", "$END", "_DEDENT", "_CLASS", "_COMPOSE", "_FROM", "_IMPORT", "_MONITOR",
    "_MUTATE", "_OVERRIDE", "_RECORD", "_REQUIRE_MONITOR", "_SCENARIO", "_SETUP", "_SIGNALS", "GUARD",
    "_EXPECT", "OPTIMIZE", "_FOR", "_DEF", "_ASSERT",
})  # fmt: skip
_OPERATORS = frozenset({
    "PLUS", "MINUS", "STAR", "SLASH", "DOUBLE_SLASH", "DOUBLE_STAR", "PERCENT", "AT_SIGN", "COMPARE", "IN",
    "NOT_IN", "IS", "IS_NOT", "_AND", "_OR", "_IF", "_CAN_SEE", "_DEG", "_INTERSECTS", "_OFFSET_ALONG",
    "_OFFSET_BY", "_IMPLIES",
    "_RELATIVE_TO", "UNIT", "UNKNOWN_UNIT", "LPAR", "LSQB", "DOT", "AUGMENTED_ASSIGN", "SEMICOLON",
})  # fmt: skip
_SPECIFIERS = frozenset({
    "_AT", "ON", "_AFTER", "_BEFORE", "BESIDE", "_FACING", "_FACING_AWAY", "_FACING_TOWARD", "_FOLLOWING", "_WITH",
    "_BEYOND", "IN_SIGHT", "_CONTAINED_IN", "_APPARENTLY_FACING",
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


def expectations(context: ErrorContext) -> list[str]:
    """Return the expected input at this place in plain words, the most useful first."""
    accepts = set(context.accepts)
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
        if context.bracket is not None:
            accepts -= {"_NEWLINE"}
    if "COMMA" in accepts:
        accepts -= {"_COMMA_SPECIFIER"}
    words += sorted(_SPOKEN[kind] for kind in accepts if kind in _SPOKEN)
    if "PLUS" in context.accepts and "an expression" not in words and "a statement" not in words:
        words.append("an operator")
    return words
