"""`format_source`: what it keeps, what it decides, and that it decides once."""

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.formatting import format_source
from cortex_dsl.syntax.parser import read_tokens
from cortex_dsl.syntax.pieces import tidy
from cortex_dsl.syntax.scanning import pieces
from cortex_dsl.syntax.unparse import unparse

GOLDEN = Path(__file__).parent / "golden"
FORMATTED = Path(__file__).parent / "formatted"
EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.scn"))
PROGRAMS = [*EXAMPLES, *sorted(GOLDEN.glob("good_*.scn"))]
GAPS = ("\n        ", "\n", "  ", " # one\n  ", "\n# two\n    ", "  #three\n\n  #  four  \n  ", "\\\n   ")


def formatted(text: str) -> str:
    return format_source(Source("test.scn", text))


def comments(text: str) -> list[str]:
    """The comments of a text, as the formatter writes them."""
    plain = text.replace("\r\n", "\n")
    starts = [start for kind, start in pieces(plain, 0, len(plain)) if kind == "comment"]
    return [tidy(plain[start:].partition("\n")[0]) for start in starts]


def assert_law(text: str) -> None:
    """The same tree, the same comments, and nothing to do the second time."""
    found = formatted(text)
    assert parse(Source("found", found)) == parse(Source("text", text)), found
    assert comments(found) == comments(text), found
    assert formatted(found) == found


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_programs(path: Path) -> None:
    """The law on written programs."""
    assert_law(path.read_bytes().decode())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_stand_as_they_are(path: Path) -> None:
    """The examples are what files are made to look like: only a line that is too wide changes."""
    text = path.read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if len(line) <= 120]
    assert [line for line in formatted(text).splitlines() if line in kept] == kept


def disturbed(text: str, dice: random.Random) -> str:
    """The text with comments, line breaks and spaces where they may stand, and at times where they may not."""
    tokens = [token for token in read_tokens(Source("plain", text)) if token.end_pos != token.start_pos]
    parts, last, depth, calm = [], 0, 0, dice.choice([0.7, 0.9, 0.97])
    for token in tokens:
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(str(token), 0)
        found = text[last : token.start_pos]
        parts += [found if dice.random() < calm else gap(found, depth, text[last - 1 : last] == ",", dice), str(token)]
        last = token.end_pos or 0
    return "".join([*parts, text[last:].rstrip("\n"), dice.choice(["", "\n", "  # end\n\n", "\n    # end"])])


def gap(found: str, depth: int, comma: bool, dice: random.Random) -> str:
    """What may stand between two tokens instead of `found`; `depth` counts the open brackets before it."""
    if "\n" in found:
        indent = dice.choice(["", "  ", "    ", "        "])
        return dice.choice(["  # why", ""]) + dice.choice(["\n\n\n\n", f"\n{indent}# alone", "\n"]) + found
    if comma and not depth:
        return dice.choice(["\n                ", "  # why\n                ", "\n# alone\n                "])
    return dice.choice(GAPS[:-1] if depth else (" ", "  ", GAPS[-1])) if found or depth else found


@settings(suppress_health_check=list(HealthCheck))  # pyright: ignore[reportArgumentType]
@given(st.data(), st.integers(0, 2**32), st.sampled_from(["\n", "\r\n"]), st.sampled_from(["", "\ufeff"]))
def test_generated_programs(
    programs: st.SearchStrategy[nodes.Module], data: st.DataObject, seed: int, end: str, mark: str
) -> None:
    """The law on generated programs, printed and then disturbed."""
    text = unparse(data.draw(programs))
    assert_law(text)
    wild = mark + disturbed(text, random.Random(seed)).replace("\n", end)
    try:
        parse(Source("wild", wild))
    except CompileError:
        return
    assert_law(wild)


@pytest.mark.parametrize("path", sorted(FORMATTED.glob("*.scn")), ids=lambda path: path.stem)
def test_golden_layout(path: Path) -> None:
    """A file before the line `# ----`, and the same file as it is written after it."""
    before, after = path.read_text(encoding="utf-8").split("# ----\n")
    assert formatted(before) == after


def test_a_broken_file_is_left_alone() -> None:
    """What does not parse is reported, not formatted."""
    with pytest.raises(CompileError):
        formatted("x = (1\n")


def test_nothing_stays_nothing() -> None:
    """Empty files and files of comments alone."""
    assert formatted("") == ""
    assert formatted("\n\n") == ""
    assert formatted("#a\n\n\n\n\n  # b") == "# a\n\n\n# b\n"


def test_line_breaks_and_byte_order_mark_stay() -> None:
    """Kind of line breaks and the mark are the editor's business; the last line always ends."""
    assert formatted("x=1\r\n\r\ny = 2") == "x = 1\r\n\r\ny = 2\r\n"
    assert formatted("\ufeffx=1") == "\ufeffx = 1\n"


def test_spelling_stays() -> None:
    """Numbers, units and strings are not respelt."""
    text = "x = 1e3 + 1_000 + .5 + 5. + 'a' + \"b\" + 3 m/s^2\n"
    assert formatted(text) == text
