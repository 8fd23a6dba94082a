"""Laws of indentation: a line indented unlike the others is answered once, whatever depth it seems to have."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.layout import lay_out
from tests.laws import examples

_FOLDERS = ("tests/cortex_dsl/semantics/golden/good", "examples")
_TEXTS = [
    text
    for folder in _FOLDERS
    for path in sorted((Path(__file__).parents[3] / folder).rglob("*.scn"))
    if "\t" not in (text := path.read_text())
]
_BLOCKS = [text for text in _TEXTS if sum(bool(line.indent) for line in lay_out(text).lines) > 2]


def _with_tabs(text: str) -> str:
    """The text with a tab for each four spaces at the beginning of a line."""
    return re.sub(r"^(?: {4})+", lambda found: "\t" * (len(found[0]) // 4), text, flags=re.MULTILINE)


@given(st.data())
@examples(150)
def test_one_line_of_the_other_kind_is_one_diagnostic(data: st.DataObject) -> None:
    """In a file of spaces or of tabs, one line of the other kind is said alone, and at its place."""
    text, width = data.draw(st.sampled_from(_BLOCKS)), data.draw(st.sampled_from((1, 2, 4, 8)))
    tabbed = data.draw(st.booleans())
    text = _with_tabs(text) if tabbed else text
    line = data.draw(st.sampled_from([line for line in lay_out(text).lines if line.indent]))
    depth = len(line.indent) if tabbed else len(line.indent) // 4
    other = " " * (width * depth) if tabbed else "\t" * depth
    start = line.start - len(line.indent)
    with pytest.raises(CompileError) as refused:
        parse(Source("mixed.scn", text[:start] + other + text[line.start :]))
    (found,) = refused.value.diagnostics
    assert found.code == "SCN108"
    assert found.label.span.start == start
    assert ("tabs" if tabbed else "spaces") in found.cure
