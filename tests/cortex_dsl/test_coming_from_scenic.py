"""The page for those who come from Scenic says what is so: every block compiles, or has the error that it names."""

import re
from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source

PAGE = (Path(__file__).parents[2] / "docs" / "how-to" / "coming-from-scenic.md").read_text(encoding="utf-8")
FENCE = re.compile(r"^```(?P<kind>\S+) ?(?P<code>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = [
    (PAGE.count("\n", 0, match.start()) + 1, match["kind"], match["code"], match["text"])
    for match in FENCE.finditer(PAGE)
]


@pytest.mark.parametrize(("line", "kind", "code", "text"), BLOCKS)
def test_block(line: int, kind: str, code: str, text: str) -> None:
    """A whole program without warnings, or one with exactly the error that it is marked with."""
    source = Source(f"coming-from-scenic.md:{line}", text)
    if kind == "scn":
        assert code == "whole"
        assert not [d for d in compile_source(source).diagnostics if d.severity is Severity.WARNING]
        return
    with pytest.raises(CompileError) as caught:
        compile_source(source)
    assert [d.code for d in caught.value.diagnostics if d.severity is Severity.ERROR] == [code]


def test_the_page_has_blocks() -> None:
    """The pattern finds them."""
    assert len(BLOCKS) >= 8
