"""The one JSON document that each command prints under --json, and its content for `--check`.

Numbers that do not exist are null.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from cortex_dsl.version import VERSION
from engine.strict_json import json_text

if TYPE_CHECKING:
    from cortex_dsl.report.blocks import Block
    from engine.feasibility import Cut, Feasibility
    from engine.program import Program

SCHEMA_VERSION = 1
"""Rises when a field changes its meaning or goes away; new fields may come at any time."""
EFFORT = "effort.json"
"""File beside the document of a command, with versions, platform and computing time."""


def document(kind: str, content: Mapping[str, Any]) -> str:
    """One document of `kind`, such as `run` or `search`, indented for people too."""
    head = {"schema": f"cortexc/{kind}", "schema_version": SCHEMA_VERSION, "cortexc": VERSION}
    text = json_text({**head, **content}, indent=2)
    return "".join(sign if sign.isprintable() or sign == "\n" else _escaped(sign) for sign in text)


def _escaped(sign: str) -> str:
    """A character that might act on a terminal, or turn the direction of writing, as JSON can also write it."""
    return f"\\u{ord(sign):04x}" if ord(sign) <= 0xFFFF else json_text(sign, ascii_only=True)[1:-1]


# -- the report model --------------------------------------------------------------------------------------------------


def blocks_content(block: "Block") -> dict[str, Any]:
    """Return a view as a tree: the kind of each block, its fields, and the number of each value; drawings are null."""
    return {"block": type(block).__name__.lower(), **{name: _content(value) for name, value in vars(block).items()}}


def _content(value: Any) -> Any:
    from cortex_dsl.report.blocks import Block, Drawing

    if isinstance(value, Block):
        return blocks_content(value)
    if isinstance(value, Drawing):
        return None
    if hasattr(value, "__dataclass_fields__"):
        return {name: _content(each) for name, each in vars(value).items()}
    return [_content(each) for each in value] if isinstance(value, list | tuple) else value


# -- which parts of the ranges cannot hold -----------------------------------------------------------------------------


def feasibility_content(program: "Program", found: "Feasibility") -> dict[str, Any]:
    """Return the proofs of `--check` as a document; params in the file's own units."""
    names = [requirement.name for requirement in program.requirements]
    return {
        "looked_at": found.looked_at,
        "infeasible": found.infeasible,
        "conflict": [names[r] for r in found.conflict],
        "cuts": [_cut_content(program, cut) for cut in found.cuts],
        "variants": len(found.impossible),
        "impossible_variants": int((found.impossible >= 0).sum()),
    }


def _cut_content(program: "Program", cut: "Cut") -> dict[str, Any]:
    return {
        "param": program.space.names[cut.gene],
        "unit": program.space.units[cut.gene],
        "side": "above" if cut.above else "below",
        "value": cut.value,
        "requirements": [program.requirements[r].name for r in cut.requirements],
    }
