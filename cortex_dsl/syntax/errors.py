"""Every syntax error, declared once: its code and, where a message gives it, its reason.

The code that finds an error makes its message, place and cure.
"""

from collections.abc import Sequence

from cortex_dsl.diagnostics import Diagnostic, Label, Severity
from cortex_dsl.source import Span
from engine.frozen import frozen

# -- How large a file may be and how deep it may nest: hostile or generated input gets a message, never a hang ---------

MAX_BYTES = 1 << 18
"""Size of a file [bytes]."""

MAX_DEPTH = 100
"""Brackets inside brackets, blocks inside blocks, and operators inside operators."""

MAX_ERRORS = 20
"""Errors reported in one run."""

# -- The codes ---------------------------------------------------------------------------------------------------------


@frozen
class Code:
    """One kind of error; the folder of its code in `cortex_dsl/codes` holds its page and examples."""

    code: str
    reason: str = ""
    severity: Severity = Severity.ERROR

    def at(
        self,
        span: Span,
        message: str,
        label: str = "",
        *,
        secondary: Sequence[Label] = (),
        reason: str = "",
        cure: str = "",
    ) -> Diagnostic:
        """The diagnostic for one place that has this error."""
        return Diagnostic(self.code, message, Label(span, label), self.severity, tuple(secondary), reason, cure)


WRITE_BRACKETS = "write `():`"
"""The cure of a definition without brackets, as Scenic 2 has them."""

UNEXPECTED = Code("SCN101")
UNCLOSED_BRACKET = Code("SCN102")
WRONG_BRACKET = Code("SCN103")
UNCLOSED_STRING = Code("SCN104")
STRAY_INDENT = Code("SCN105")
MISSING_BODY = Code("SCN106", "A line that ends in `:` is followed by at least one line that is indented deeper.")
WRONG_DEDENT = Code("SCN107")
MIXED_INDENT = Code(
    "SCN108", "How wide a tab is depends on the editor, so a file indents either with spaces or with tabs."
)
MISSING_COLON = Code("SCN109", "A line that opens a block ends in `:`.")
ASSIGNMENT_IN_CONDITION = Code("SCN110", "`=` gives a name to a value; `==` tests whether two values are equal.")
UNKNOWN_UNIT = Code("SCN111")
MISPLACED_UNIT = Code("SCN112", "A unit follows a number or a call; everywhere else the same word is a name.")
RESERVED_WORD = Code("SCN113", "The keywords of Python and of Scenic cannot be names.")
FOREIGN_SPELLING = Code("SCN114")
NOT_SUPPORTED = Code("SCN115", "Scenic has this construct; this version of the language does not have it yet.")
WRONG_TARGET = Code("SCN116", "The left side of `=` is a name, or several names with commas.")
ATTRIBUTE_CURE = "properties are given with `with` where the object is made"


def no_target(span: Span, cure: str) -> Diagnostic:
    """Return the diagnostic for a left side of `=` that is not a name."""
    return WRONG_TARGET.at(span, "only a name can be assigned to", "not a name", reason=WRONG_TARGET.reason, cure=cure)


TOO_DEEP = Code("SCN117", "Nesting is limited, so that no input can exhaust the compiler.")
STRANGE_CHARACTER = Code(
    "SCN118", "Outside strings and comments only letters, digits and the language's symbols have a meaning."
)
MISSING_COMMA = Code("SCN119")
MISSING_NEW = Code("SCN120", "Since Scenic 3 an object is made with `new`.")
WRONG_LITERAL = Code("SCN121", "Numbers reach up to 1.8e308; in a string, `\\` begins one of the known escapes.")
INCOMPLETE = Code("SCN122", "Some statements have parts that belong together, such as `try` and `interrupt when`.")
TOO_MANY = Code(
    "SCN123", "After many errors further ones are mostly consequences, so reading stops.", severity=Severity.NOTE
)
MISPLACED_TEMPORAL = Code(
    "SCN124",
    "`always`, `eventually`, `next`, `until` and `implies` apply to a whole run, so they belong in the condition of a "
    "`require`, joined only by `and`, `or` and `not`.",
)
MISPLACED_PART = Code(
    "SCN125",
    "A scenario has, in this order, its docstring, its guards, `setup:` and `compose:`; a behavior its docstring, its "
    "guards and its statements.",
)
CLASS_BODY = Code("SCN126", "The lines of a class are `name: value`, the defaults of its objects' properties.")
WRONG_IMPORT = Code(
    "SCN127", "A file is imported by its name without `.scn`, with dots for folders, or by its path in quotes."
)
WRONG_FORMATTED = Code(
    "SCN128",
    'In `f"..."` a value goes between braces, with its format after a colon; `{{` and `}}` are literal braces.',
)
EMPTY_FILE = Code("SCN130", "A scenario has at least one statement.")
BINARY_FILE = Code("SCN131")
WRONG_ENCODING = Code(
    "SCN132", "A scenario is read as UTF-8; editors call the older encodings Latin-1 or Windows-1252."
)
LARGE_FILE = Code("SCN133", "The size of a file is limited, so that none can exhaust the compiler.")
LONE_RETURN = Code("SCN134")

CODES: tuple[Code, ...] = tuple(value for value in list(globals().values()) if isinstance(value, Code))
"""All of them, in the order of their numbers."""


def too_many(last: Diagnostic) -> Diagnostic:
    """Return the note below the last error that is reported."""
    return TOO_MANY.at(
        Span(last.label.span.end, last.label.span.end),
        f"reading stops here, after {MAX_ERRORS} errors",
        reason=TOO_MANY.reason,
        cure="correct the first ones and try again",
    )
