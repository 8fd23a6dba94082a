"""Every syntax error, declared once: its code, its title, its reason, and an example with its cure.

Messages and places are made where an error is found; its constant parts are here.
"""

from collections.abc import Sequence
from dataclasses import replace

from cortex_dsl.diagnostics import Diagnostic, Label, Page, Severity
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
    """One kind of error. `wrong` is a program that has it, `right` the same program without it."""

    id: str
    title: str
    why: str
    wrong: str
    right: str
    shown: str = ""
    """Time at which the code is raised, if not while `wrong` is compiled; see `Page`."""

    @property
    def page(self) -> Page:
        return Page(self.title, self.why, self.wrong, self.right, shown=self.shown)

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
        return Diagnostic(self.id, message, Label(span, label), secondary=tuple(secondary), reason=reason, cure=cure)


WRITE_BRACKETS = "write `():`"
"""The cure of a definition without brackets, as Scenic 2 has them."""

UNEXPECTED = Code(
    "SCN101",
    "unexpected text",
    "The text here does not fit the grammar; the message says what would.",
    "x = 3 +\n",
    "x = 3 + 1\n",
)
UNCLOSED_BRACKET = Code(
    "SCN102",
    "bracket never closed",
    "Inside brackets a statement may continue over several lines, so each bracket must be closed.",
    "x = max(1, 2\n",
    "x = max(1, 2)\n",
)
WRONG_BRACKET = Code(
    "SCN103",
    "closing bracket without its opening one",
    "Brackets are closed in the reverse order of their opening, each by its own kind.",
    "x = (1, 2]\n",
    "x = (1, 2)\n",
)
UNCLOSED_STRING = Code(
    "SCN104",
    "string never closed",
    'A string ends on the line where it begins, unless it begins with three quotes (""").',
    'require ego as "starts well\n',
    'require ego as "starts well"\n',
)
STRAY_INDENT = Code(
    "SCN105",
    "unexpected indentation",
    "Indentation opens a block, and only a line that ends in `:` has one.",
    "x = 1\n    y = 2\n",
    "x = 1\ny = 2\n",
)
MISSING_BODY = Code(
    "SCN106",
    "missing block",
    "A line that ends in `:` is followed by at least one line that is indented deeper.",
    "behavior Rest():\nwait\n",
    "behavior Rest():\n    wait\n",
)
WRONG_DEDENT = Code(
    "SCN107",
    "indentation that matches no block",
    "A line that ends a block goes back to exactly the indentation of a line before it.",
    "behavior Rest():\n    wait\n  wait\n",
    "behavior Rest():\n    wait\n    wait\n",
)
MIXED_INDENT = Code(
    "SCN108",
    "tabs and spaces mixed",
    "How wide a tab is depends on the editor, so a file indents either with spaces or with tabs.",
    "behavior Rest():\n    wait\n\twait\n",
    "behavior Rest():\n    wait\n    wait\n",
)
MISSING_COLON = Code(
    "SCN109",
    "missing colon",
    "A line that opens a block ends in `:`.",
    "behavior Rest()\n    wait\n",
    "behavior Rest():\n    wait\n",
)
ASSIGNMENT_IN_CONDITION = Code(
    "SCN110",
    "`=` where a comparison is meant",
    "`=` gives a name to a value; `==` tests whether two values are equal.",
    "require x = 3\n",
    "require x == 3\n",
)
UNKNOWN_UNIT = Code(
    "SCN111",
    "unknown unit",
    "A word directly after a number or a call is read as its unit.",
    "x = 5 kmh\n",
    "x = 5 km/h\n",
)
MISPLACED_UNIT = Code(
    "SCN112",
    "unit where none is allowed",
    "A unit follows a number or a call; everywhere else the same word is a name.",
    "y = x m\n",
    "y = x * 1 m\n",
)
RESERVED_WORD = Code(
    "SCN113",
    "reserved word used as a name",
    "The keywords of Python and of Scenic cannot be names.",
    "to = 3\n",
    "target = 3\n",
)
FOREIGN_SPELLING = Code(
    "SCN114",
    "spelling of another language",
    "Other languages write this differently; the help says how it is written here.",
    "require a && b\n",
    "require a and b\n",
)
NOT_SUPPORTED = Code(
    "SCN115",
    "not supported yet",
    "Scenic has this construct; this version of the language does not have it yet.",
    "with x:\n    y = 3\n\ntruck = new Truck above road\n",
    "y = 3\ntruck = new Truck on road\n",
)
WRONG_TARGET = Code(
    "SCN116",
    "cannot be assigned to",
    "The left side of `=` is a name, or several names with commas.",
    "f(x) = 3\n",
    "y = 3\n",
)
ATTRIBUTE_CURE = "properties are given with `with` where the object is made"


def no_target(span: Span, cure: str) -> Diagnostic:
    """Return the diagnostic for a left side of `=` that is not a name."""
    return WRONG_TARGET.at(span, "only a name can be assigned to", "not a name", reason=WRONG_TARGET.why, cure=cure)


TOO_DEEP = Code(
    "SCN117",
    "nested too deeply",
    "Nesting is limited, so that no input can exhaust the compiler.",
    "x = " + "(" * 101 + "1" + ")" * 101 + "\n",
    "x = 1\n",
)
STRANGE_CHARACTER = Code(
    "SCN118",
    "character that has no meaning here",
    "Outside strings and comments only letters, digits and the language's symbols have a meaning.",
    "x = 3 $\n",
    "x = 3\n",
)
MISSING_COMMA = Code(
    "SCN119",
    "missing comma",
    "Commas separate the specifiers of an object, the arguments of a call and the items of a list.",
    "ego = new Car at p with speed 3\n",
    "ego = new Car at p, with speed 3\n",
)
MISSING_NEW = Code(
    "SCN120",
    "object made without `new`",
    "Since Scenic 3 an object is made with `new`.",
    "ego = Car at p\n",
    "ego = new Car at p\n",
)
WRONG_LITERAL = Code(
    "SCN121",
    "number or string that cannot be read",
    "Numbers reach up to 1.8e308; in a string, `\\` begins one of the known escapes.",
    "x = 1e999\n",
    "x = 1e99\n",
)
INCOMPLETE = Code(
    "SCN122",
    "incomplete statement",
    "Some statements have parts that belong together, such as `try` and `interrupt when`.",
    "behavior B():\n    try:\n        wait\n    wait\n",
    "behavior B():\n    try:\n        wait\n    interrupt when x:\n        wait\n",
)
TOO_MANY = Code(
    "SCN123",
    "too many errors",
    "After many errors further ones are mostly consequences, so reading stops.",
    "x = $\n" * MAX_ERRORS,
    "x = 1\n",
)
_READ = "while the file is read"
MISPLACED_TEMPORAL = Code(
    "SCN124",
    "temporal operator in the wrong place",
    "`always`, `eventually`, `next`, `until` and `implies` apply to a whole run, so they belong in the condition of a "
    "`require`, joined only by `and`, `or` and `not`.",
    "require f((x until y))\n",
    "require x until y\n",
)
MISPLACED_PART = Code(
    "SCN125",
    "part of a definition in the wrong place",
    "A scenario has, in this order, its docstring, its guards, `setup:` and `compose:`; a behavior its docstring, its "
    "guards and its statements.",
    "behavior B():\n    wait\n    precondition: x\n",
    "behavior B():\n    precondition: x\n    wait\n",
)
CLASS_BODY = Code(
    "SCN126",
    "class with something other than properties",
    "The lines of a class are `name: value`, the defaults of its objects' properties.",
    "class Taxi(Car):\n    speed = 3\n",
    "class Taxi(Car):\n    speed: 3\n",
)
WRONG_IMPORT = Code(
    "SCN127",
    "import that names no file",
    "A file is imported by its name without `.scn`, with dots for folders, or by its path in quotes.",
    "import my-cars\n",
    'import "my-cars.scn" as my_cars\n',
)
WRONG_FORMATTED = Code(
    "SCN128",
    "f-string that cannot be read",
    'In `f"..."` a value goes between braces, with its format after a colon; `{{` and `}}` are literal braces.',
    'x = 3\ny = f"{x cars"\n',
    'x = 3\ny = f"{x} cars"\n',
)
EMPTY_FILE = Code("SCN130", "empty file", "A scenario has at least one statement.", "# later\n", "x = 1\n", _READ)
BINARY_FILE = Code(
    "SCN131", "not a text file", "A scenario is text; this file contains NUL bytes.", "x = 1\n\0", "x = 1\n", _READ
)
WRONG_ENCODING = Code(
    "SCN132",
    "not UTF-8",
    "A scenario is read as UTF-8; editors call the older encodings Latin-1 or Windows-1252.",
    "# gr\xf6\xdfer\nx = 1\n",
    "# greater\nx = 1\n",
    _READ,
)
LARGE_FILE = Code(
    "SCN133", "file too large", "The size of a file is limited, so that none can exhaust the compiler.", "", "", _READ
)
LONE_RETURN = Code(
    "SCN134",
    "lines that end with only a carriage return",
    "A line ends with a line feed, or with a carriage return and a line feed; only very old systems end it with a "
    "carriage return alone, which is mere white space here.",
    "",
    "",
    _READ,
)

CODES: tuple[Code, ...] = tuple(value for value in list(globals().values()) if isinstance(value, Code))
"""All of them, in the order of their numbers."""


def too_many(last: Diagnostic) -> Diagnostic:
    """The note below the last error that is reported."""
    diagnostic = TOO_MANY.at(
        Span(last.label.span.end, last.label.span.end),
        f"reading stops here, after {MAX_ERRORS} errors",
        reason=TOO_MANY.why,
        cure="correct the first ones and try again",
    )
    return replace(diagnostic, severity=Severity.NOTE)
