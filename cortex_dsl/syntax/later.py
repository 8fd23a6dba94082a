"""What Scenic has and this version of the language does not have yet, so that it gets a fitting answer."""

from collections.abc import Mapping
from types import MappingProxyType

STATEMENTS: Mapping[str, str] = MappingProxyType(
    {
        "simulator": "`simulator`",
        "def": "functions",
        "for": "`for` loops",
        "with": "`with` statements",
        "except": "`except`",
        "finally": "`finally`",
        "assert": "`assert`",
        "raise": "`raise`",
        "del": "`del`",
        "global": "`global`",
        "nonlocal": "`nonlocal`",
        "async": "`async`",
        "await": "`await`",
        "yield": "`yield`",
    }
)
"""First word of a statement, and what the message calls it."""

BLOCKS = frozenset(STATEMENTS)
"""Statements whose whole block is skipped."""

INSTEAD: Mapping[str, str] = MappingProxyType(
    {
        "for": "write a comprehension, as in `[new Car in lane.centerline for lane in lanes]`; in a behavior, `while`",
        "def": "write `NAME = lambda x: ...` for what computes a value, or a `behavior` for what an actor does",
        "assert": "write `require`",
        "except": "write `interrupt when` with a condition",
        "beyond": "write `after intersection by 10 m along trajectory`, or `ahead of x by 10 m`",
        "visible": "write `require ego can see x`",
        "contained": "write `require x in region`; that objects stand on the road is required anyway",
        "apparently": "write `facing`, which turns an object in any direction",
        "relative": "add the headings, as in `facing ego.heading + 90 deg`; for places write `offset by`",
    }
)

OPERATORS: Mapping[str, str] = MappingProxyType(
    {
        "relative": "`relative to` and `relative position of`",
        "visible": "`visible`",
        "apparent": "`apparent heading of`",
        "altitude": "`altitude`",
        "angle": "`angle from … to …`",
        "follow": "`follow … from … for …`",
        "front": "`front of`",
        "back": "`back of`",
    }
)
"""Words of operators, and what the message calls them."""

SPECIFIERS: Mapping[str, str] = MappingProxyType(
    {
        "beyond": "`beyond`",
        "visible": "`visible`",
        "contained": "`contained in`",
        "apparently": "`apparently facing`",
        "above": "`above`",
        "below": "`below`",
        "using": "`using`",
    }
)
