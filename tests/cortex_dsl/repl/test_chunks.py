"""When a chunk is whole."""

import io

import pytest

from cortex_dsl.repl.chunks import ChunkReader, Open, is_whole, openness


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = 1", Open.NO),
        ("x = [1,", Open.LINE),
        ("x = f(a)  # (", Open.NO),
        ("x = 'a(b'", Open.NO),
        ("ego = new Car at p,", Open.LINE),
        ("ego = new Car at p,  # here", Open.LINE),
        ('"""doc', Open.LINE),
        ('"""doc"""', Open.NO),
        ("x = 1 + \\", Open.LINE),
        ("behavior B():", Open.BLOCK),
        ("behavior B():  # what", Open.BLOCK),
        ("behavior B():\n    wait", Open.BLOCK),
        ("x = {a: 1,\n b: 2}", Open.NO),
        ("f = lambda x: x", Open.NO),
    ],
)
def test_openness(text: str, expected: Open) -> None:
    """Brackets, texts, commas, backslashes and colons leave a chunk open; what is quoted or commented does not."""
    assert openness(text) is expected


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("behavior B():\n    wait", False),
        ("behavior B():\n    wait\n", True),
        ("behavior B():\n    try:\n        wait\n    interrupt when x:", False),
        ("behavior B():\n    wait\nx = 3", True),
        ("if a:\n    b = 1\nelse:", False),
        (":list", True),
        ("quit", True),
    ],
)
def test_a_block_ends_with_a_blank_or_dedented_line(text: str, whole: bool) -> None:
    """As people type at a terminal."""
    assert is_whole(text) is whole


def chunks(text: str, *, blank_ends: bool) -> list[str]:
    reader = ChunkReader(io.StringIO(text).readline, lambda _more: None, blank_ends)
    return list(iter(reader.read, None))


SCRIPT = """\
# about x
x = 1

behavior B():
    wait

    wait
y = 2
:list
if y > 1:
    z = 1
else:
    z = 2
"""


def test_a_script_has_blank_lines_in_blocks() -> None:
    """From a pipe a block lasts until a line that is not indented; comments go with what stands below."""
    assert chunks(SCRIPT, blank_ends=False) == [
        "# about x\nx = 1",
        "behavior B():\n    wait\n\n    wait",
        "y = 2",
        ":list",
        "if y > 1:\n    z = 1\nelse:\n    z = 2",
    ]


def test_a_blank_line_ends_a_typed_block() -> None:
    """At a terminal without editing."""
    assert chunks("behavior B():\n    wait\n\nx = 1\n", blank_ends=True) == ["behavior B():\n    wait", "x = 1"]
