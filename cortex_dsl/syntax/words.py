"""The words of the language: reserved ones, every keyword with its meaning, and Scenic's unsupported words."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

RESERVED = frozenset({
    "False", "None", "True", "and", "as", "assert", "async", "at", "await", "break", "by", "class", "continue",
    "def", "del", "do", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in",
    "is", "lambda", "new", "nonlocal", "not", "of", "on", "or", "pass", "raise", "require", "return", "to",
    "try", "until", "while", "with", "yield",
})  # fmt: skip
"""Words that are never names; the same as in the grammar's NAME (a test compares them)."""

BLOCK_WORDS = frozenset({
    "behavior", "if", "elif", "else", "while", "try", "interrupt", "for", "def", "class", "with", "except",
    "finally", "monitor", "scenario", "setup", "compose", "precondition", "invariant",
})  # fmt: skip
"""Words whose lines continue in deeper ones; a guard only by mistake."""

GUARDS = frozenset({"precondition", "invariant"})
TEMPORAL_PREFIXES = frozenset({"always", "eventually", "next"})
TEMPORAL = TEMPORAL_PREFIXES | {"until", "implies"}
SPECIFIER_WORDS = frozenset({
    "at", "in", "on", "with", "offset", "ahead", "behind", "left", "right", "following", "facing", "before",
    "after", "beyond", "meeting", "visible", "contained", "apparently",
})  # fmt: skip

# -- Keywords ----------------------------------------------------------------------------------------------------------
#
# Every keyword once: its role, the form of the construct, and one sentence about it.
#
# The grammar says the same with more precision (a test compares the words); colouring, completion and hover read this.


class Role(Enum):
    """Position of a keyword."""

    STATEMENT = "statement"
    """Begins a statement of the file, or of a scenario's `setup`."""
    ACT = "act"
    """Begins a statement of a behavior, a monitor or a `compose`."""
    CLAUSE = "clause"
    """Start of a part of a statement: a line that continues the statement above it."""
    SPECIFIER = "specifier"
    """Place or property of an object."""
    OPERATOR = "operator"
    """Makes a value."""
    LINK = "link"
    """Joins the parts of a construct."""


@dataclass(frozen=True)
class Keyword:
    """A word, or words in a row, that the language gives a meaning to."""

    phrase: str
    """Words with one blank between them."""
    role: Role
    form: str
    """Form of the whole construct; capitals are placeholders."""
    doc: str

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(self.phrase.split())


def _rows(role: Role, *rows: tuple[str, str, str]) -> tuple[Keyword, ...]:
    return tuple(Keyword(phrase, role, form, doc) for phrase, form, doc in rows)


KEYWORDS: tuple[Keyword, ...] = (
    *_rows(
        Role.STATEMENT,
        ("map", "map intersection(ways=4, lanes=1)", "The roads of the scenario: intersections, or a lone road."),
        ("simulation", "simulation(time_step=0.05 s)", "What the file says about how it is drawn and run."),
        ("signals", "signals(green=20 s, yellow=3 s)", "The intersections have traffic lights."),
        ("environment", "environment(friction=0.4, sight=60 m)", "The weather: less grip for all, a shorter view."),
        ("model", "model NAME", "Read for Scenic's sake; the map here is made by `map`."),
        ("param", "param NAME = Range(LOW, HIGH)", "A parameter; with a distribution, a gene of the search."),
        ("require", "require CONDITION", "Holds in every scene; a scene in which it fails is drawn again."),
        ("require monitor", "require monitor NAME()", "The monitor runs beside the scenario."),
        ("terminate when", "terminate when CONDITION", "Ends the run as soon as the condition holds."),
        ("terminate after", "terminate after 20 s", "Ends the run after a time, or after a number of steps."),
        ("terminate simulation when", "terminate simulation when CONDITION", "Ends the whole run, not one scenario."),
        ("behavior", "behavior NAME(PARAMETERS):", "What an object does, step by step, during the run."),
        ("monitor", "monitor NAME(PARAMETERS):", "A behavior without an actor: it watches, requires and terminates."),
        ("scenario", "scenario NAME(PARAMETERS):", "A scenario with a name, which others can compose."),
        ("def", "def NAME(PARAMETERS):", "A function that the compiler calls; its arguments are known before the run."),
        ("assert", "assert CONDITION", "Must hold: when compiled, in the scene, or in the run."),
        ("class", "class NAME(BASE):", "A class of objects with property defaults, each evaluated for every object."),
        ("import", "import NAME", "What another `.scn` file defines, under the name of that file."),
        ("from", "from NAME import NAMES", "Names that another `.scn` file defines."),
        ("expect", "expect CONDITION as NAME", "What the system under test owes; a run that breaks it is a finding."),
        ("maximize", "maximize VALUE as NAME", "Names a number of the run that a search may make large."),
        ("minimize", "minimize VALUE as NAME", "Names a number of the run that a search may make small."),
        ("record", "record VALUE as NAME", "Keeps a value at every sample of the run."),
        ("record initial", "record initial VALUE as NAME", "Keeps a value at the start of the run."),
        ("record final", "record final VALUE as NAME", "Keeps a value at the end of the run."),
        ("domain", "domain NAME VALUE at start in CELLS", "Cells of a value for coverage; changes no run."),
        ("mutate", "mutate OBJECTS by AMOUNT", "Noise on places and headings of objects; of all, if none is named."),
        ("override", "override OBJECT with PROPERTY VALUE", "Changes an object while this scenario runs."),
    ),
    *_rows(
        Role.ACT,
        ("do", "do BEHAVIOR", "Runs a behavior until it ends."),
        ("do choose", "do choose BEHAVIORS", "Runs one of several behaviors, drawn at random."),
        ("do shuffle", "do shuffle BEHAVIORS", "Runs all of several behaviors one after the other, in random order."),
        ("take", "take ACTIONS", "Presses pedals, steers or sets a speed, and ends the step."),
        ("wait", "wait", "Does nothing for one step."),
        ("wait until", "wait until CONDITION", "Does nothing until a condition holds."),
        ("wait for", "wait for 5 s", "Does nothing for a time, or for a number of steps."),
        ("for", "for NAME in LIST:", "Runs a block for each item of a list that is known before the run."),
        ("abort", "abort", "Leaves the `try` around it with all its handlers."),
        ("terminate", "terminate", "Ends the scenario that made this object."),
        ("terminate simulation", "terminate simulation", "Ends the whole run."),
        ("try", "try:", "Runs a block that handlers may interrupt."),
        ("if", "if CONDITION:", "Runs a block if a condition holds."),
        ("while", "while CONDITION:", "Runs a block for as long as a condition holds."),
        ("break", "break", "Leaves the loop."),
        ("continue", "continue", "Begins the next round of the loop."),
        ("return", "return", "Ends the behavior; in a function `return VALUE` gives what it is worth."),
        ("pass", "pass", "An empty block."),
    ),
    *_rows(
        Role.CLAUSE,
        ("interrupt when", "interrupt when CONDITION:", "Interrupts the `try`, which then goes on; later ones win."),
        ("elif", "elif CONDITION:", "Another condition, tested when those above it did not hold."),
        ("else", "else:", "Runs when no condition above it held."),
        ("precondition", "precondition: CONDITION", "Must hold when the behavior or scenario begins."),
        ("invariant", "invariant: CONDITION", "Must hold for as long as the behavior or scenario runs."),
        ("setup", "setup:", "What the scenario consists of: its objects and rules."),
        ("compose", "compose:", "Which scenarios run in it, and when."),
    ),
    *_rows(
        Role.SPECIFIER,
        ("at", "at PLACE", "Stands at a place, and heads as that place does."),
        ("in", "in REGION", "Stands anywhere in a region, all places equally likely."),
        ("on", "on REGION", "Stands anywhere on a region, all places equally likely."),
        ("offset by", "offset by (X, Y)", "Stands beside the ego: to its right, and ahead."),
        ("offset along", "offset along DIRECTION by (X, Y)", "Stands beside the ego, measured along a direction."),
        ("ahead of", "ahead of OBJECT by DISTANCE", "Stands in front of an object."),
        ("behind", "behind OBJECT by DISTANCE", "Stands behind an object."),
        ("left of", "left of OBJECT by DISTANCE", "Stands to the left of an object."),
        ("right of", "right of OBJECT by DISTANCE", "Stands to the right of an object."),
        ("following", "following FIELD from PLACE for DISTANCE", "Stands where a way along the field ends."),
        ("before", "before intersection by DISTANCE", "Stands on its way a distance before the intersection."),
        ("after", "after intersection by DISTANCE", "Stands on its way a distance beyond the intersection."),
        ("beyond", "beyond PLACE by DISTANCE from VIEWER", "Stands behind a place, as its viewer sees it."),
        ("meeting", "meeting OBJECT at PLACE after TIME", "Stands where it reaches a place of another at a time."),
        ("visible", "visible from VIEWER", "Stands anywhere in view."),
        ("not visible", "not visible from VIEWER", "Stands anywhere out of view."),
        ("contained in", "contained in REGION", "Stands anywhere in a region, all of its outline inside."),
        ("apparently facing", "apparently facing HEADING from VIEWER", "Heads so, counted from the line of sight."),
        ("facing", "facing HEADING", "Heads in a direction; anticlockwise from the east, or as a field says."),
        ("facing toward", "facing toward PLACE", "Heads to a place."),
        ("facing directly toward", "facing directly toward PLACE", "Heads to a place, as `facing toward` does."),
        ("facing away from", "facing away from PLACE", "Heads away from a place."),
        ("with", "with PROPERTY VALUE", "Sets a property."),
    ),
    *_rows(
        Role.OPERATOR,
        ("and", "A and B", "Both hold."),
        ("or", "A or B", "One of them holds, or both."),
        ("not", "not A", "It does not hold."),
        ("is", "A is B", "They are the same."),
        ("if", "A if CONDITION else B", "One of two values."),
        ("lambda", "lambda x: VALUE", "A function without a name."),
        ("new", "new CLASS at PLACE", "Makes an object, or a place."),
        ("distance from", "distance from A to B", "Distance between centres, or to a region."),
        ("distance to", "distance to B", "Distance from the ego."),
        ("minimum distance from", "minimum distance from A to B", "Distance between outlines."),
        ("minimum distance to", "minimum distance to B", "Distance from the outline of the ego to another."),
        ("relative heading of", "relative heading of A from B", "Angle from one heading to another."),
        ("relative to", "A relative to B", "A heading turned by another, or a place in the frame of another."),
        ("at", "(FIELD at PLACE)", "Heading of a field at a place, in brackets."),
        ("relative position of", "relative position of A from B", "Where a place is in the frame of another."),
        ("apparent heading of", "apparent heading of A from B", "Heading of an object from the line of sight."),
        ("angle from", "angle from A to B", "Heading of the way from one place to another."),
        ("angle to", "angle to B", "Heading of the way from the ego to a place."),
        ("distance past", "distance past A of B", "How far an object has come past a place, along its own heading."),
        ("follow", "follow FIELD from PLACE for DISTANCE", "Where a way along the field ends."),
        ("front of", "front of A", "The middle of an edge of an outline; also `back`, `left`, `right`."),
        ("back of", "back of A", "The middle of its rear edge; `back left of` and `back right of` are its corners."),
        ("visible", "visible REGION", "The part of a region that is in the view of the ego."),
        ("visible from", "REGION visible from VIEWER", "The part of a region that is in somebody's view."),
        ("not visible from", "REGION not visible from VIEWER", "The part that is out of it."),
        ("not visible", "not visible REGION", "The part of a region that is out of the view of the ego."),
        ("initial scenario", "initial scenario", "Whether no other scenario was set up before this one."),
        ("can see", "A can see B", "Whether one is in the view of the other."),
        ("deg", "X deg", "An angle in degrees."),
        ("intersects", "A intersects B", "Whether outlines overlap."),
        ("offset by", "A offset by (X, Y)", "A place beside another, to its right and ahead."),
        ("offset along", "A offset along DIRECTION by (X, Y)", "A place beside another, measured along a direction."),
        ("always", "always A", "Holds at every sample of the run; only in `require` and `expect`."),
        ("eventually", "eventually A", "Holds at one sample at least; only in `require` and `expect`."),
        ("next", "next A", "Holds at the next sample; only in `require` and `expect`."),
        ("until", "A until B", "Holds until the other does, which it must; only in `require` and `expect`."),
        ("implies", "A implies B", "The second holds if the first does; only in `require` and `expect`."),
    ),
    *_rows(
        Role.LINK,
        ("as", "as NAME", "Gives a name."),
        ("by", "by DISTANCE", "How far, or how much."),
        ("of", "ahead of OBJECT", "To what the words before it belong."),
        ("to", "distance from A to B", "The other end."),
        ("along", "before intersection by DISTANCE along TRAJECTORY", "The way that is meant."),
        ("for", "do BEHAVIOR for 5 s", "How long a behavior runs, how far to follow, or each item of a list."),
        ("seconds", "do BEHAVIOR for 5 seconds", "A bare number as a time."),
        ("steps", "do BEHAVIOR for 100 steps", "A bare number as steps of the simulation, or cells of a domain."),
        ("at start", "domain NAME VALUE at start in CELLS", "The value that the scene has."),
        ("at first sight", "domain NAME VALUE at first sight in CELLS", "The value when the ego first sees an object."),
        ("at contact", "domain NAME VALUE at contact in CELLS", "The value at the ego's first contact."),
        ("at end", "domain NAME VALUE at end in CELLS", "The value at the last sample."),
    ),
)  # fmt: skip

CONSTANT_WORDS = ("True", "False", "None")


def with_role(*roles: Role) -> tuple[Keyword, ...]:
    """Return the keywords of some roles, longest first, so that the first match is the right one."""
    return tuple(sorted((k for k in KEYWORDS if k.role in roles), key=lambda k: -len(k.phrase)))


# -- Constructs of Scenic that this version of the language lacks, so that they get a fitting answer -------------------

LATER_STATEMENTS: Mapping[str, str] = MappingProxyType(
    {
        "simulator": "`simulator`",
        "with": "`with` statements",
        "except": "`except`",
        "finally": "`finally`",
        "raise": "`raise`",
        "del": "`del`",
        "global": "`global`",
        "nonlocal": "`nonlocal`",
        "async": "`async`",
        "await": "`await`",
        "yield": "`yield`",
    }
)
"""First word of a statement, and its name in the message."""

LATER_BLOCKS = frozenset(LATER_STATEMENTS)
"""Statements with a block that is skipped as a whole."""

INSTEAD: Mapping[str, str] = MappingProxyType(
    {
        "except": "write `interrupt when` with a condition",
        **dict.fromkeys(
            ("global", "nonlocal"),
            "a function changes no names outside: return the value; a behavior stores it in its object: "
            "`with count 0`, and `self.count = self.count + 1`",
        ),
    }
)

LATER_OPERATORS: Mapping[str, str] = MappingProxyType(
    {
        "altitude": "`altitude`",
        "top": "`top of`",
        "bottom": "`bottom of`",
    }
)
"""Words of operators, and their names in the message."""

LATER_SPECIFIERS: Mapping[str, str] = MappingProxyType(
    {
        "above": "`above`",
        "below": "`below`",
        "using": "`using`",
    }
)
