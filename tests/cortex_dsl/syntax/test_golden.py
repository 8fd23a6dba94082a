"""Golden programs: each `golden/*.scn` beside a `.txt` with what the parser makes of it, tree or diagnostics.

Add a case by adding a `.scn`; `UPDATE_GOLDEN=1 pytest tests/cortex_dsl/syntax/test_golden.py` writes what it gives,
to be read before it is kept.
"""

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.snippet import render_text
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.nodes import Node
from cortex_dsl.syntax.unparse import unparse
from tests.golden import matches

GOLDEN = Path(__file__).parent / "golden"
CASES = sorted(path.stem for path in GOLDEN.glob("*.scn"))


def outline(value: Any, label: str = "", depth: int = 0) -> Iterator[str]:
    """A tree as indented lines: simple fields beside the kind of a node, others below it."""
    indent = "  " * depth + (f"{label}: " if label else "")
    if not isinstance(value, Node):
        yield f"{indent}{value!r}"
        return
    fields = [(field.name, getattr(value, field.name)) for field in dataclasses.fields(value)]
    fields = [(name, each) for name, each in fields if not isinstance(each, Span)]
    inner = [(name, each) for name, each in fields if list(nodes_in(each))]
    plain = [f" {name}={each!r}" for name, each in fields if (name, each) not in inner and each not in (None, ())]
    yield f"{indent}{type(value).__name__}{''.join(plain)}"
    for name, each in inner:
        for item in nodes_in(each):
            yield from outline(item, name, depth + 1)


def nodes_in(value: Any) -> Iterator[Any]:
    """The nodes of a field; of a pair with a word (`<`, x) the word too."""
    if isinstance(value, Node):
        yield value
    elif isinstance(value, tuple) and any(isinstance(item, (Node, tuple)) for item in value):
        for item in value:
            yield from nodes_in(item) if isinstance(item, (Node, tuple)) else (item,)


def transcript(name: str, text: str) -> str:
    source = Source(f"{name}.scn", text)
    try:
        module = parse(source)
    except CompileError as error:
        return render_text(source, error.diagnostics)
    assert parse(Source("again", unparse(module))) == module
    return "\n".join(outline(module)) + "\n"


@pytest.mark.parametrize("name", CASES)
def test_golden_program(name: str) -> None:
    """The transcript of a program is the one that was agreed on."""
    found = transcript(name, (GOLDEN / f"{name}.scn").read_bytes().decode())
    matches(found, GOLDEN / f"{name}.txt")


def test_every_transcript_has_its_program() -> None:
    """No transcript is left behind when a program goes."""
    assert sorted(path.stem for path in GOLDEN.glob("*.txt")) == CASES
