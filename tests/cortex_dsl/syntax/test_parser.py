"""The parser's promises beyond single programs: words, codes, cache, imports."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from cortex_dsl.codes import Entry
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.installation import resource
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import errors, parse, parse_tree
from cortex_dsl.syntax.errors import CODES, Code
from cortex_dsl.syntax.literals import SPOKEN_UNITS, UNIT_WORDS
from cortex_dsl.syntax.nodes import Assign, Module, Number
from cortex_dsl.syntax.unparse import unparse
from cortex_dsl.syntax.words import RESERVED, TEMPORAL_PREFIXES

GRAMMAR = resource("grammar/cortex.lark").read_text(encoding="utf-8")
FILE_CODES = {"SCN130", "SCN131", "SCN132", "SCN133", "SCN134"}


def codes_of(text: str) -> list[str]:
    with pytest.raises(CompileError) as caught:
        parse(Source("test.scn", text))
    return [diagnostic.code for diagnostic in caught.value.diagnostics]


def value_of(text: str) -> object:
    (statement,) = parse(Source("test.scn", text)).statements
    assert isinstance(statement, Assign)
    return statement.value


@pytest.mark.parametrize("code", [code for code in CODES if code.code not in FILE_CODES], ids=lambda code: code.code)
def test_example_of_a_code(code: Code) -> None:
    """The wrong example of a code has that error, and the right one none."""
    page = Entry(code.code, code.severity).page
    assert code.code in codes_of(page.wrong)
    parse(Source("right.scn", page.right))


def test_codes_are_declared_once_and_in_order() -> None:
    """A code stands for one kind of error."""
    codes = [code.code for code in CODES]
    assert codes == sorted(set(codes))


@pytest.mark.parametrize("word", UNIT_WORDS)
def test_every_unit_is_read(word: str) -> None:
    """A unit of the table is a unit of the grammar, with and without a space, and a name where no number is before."""
    assert value_of(f"x = 5 {word}") == value_of(f"x = 5{word}") == Number(5.0, word, span=parse_span())
    if word.isidentifier():
        parse(Source("name.scn", f"{word} = {word} + f({word})"))


def parse_span() -> Span:
    return parse(Source("empty", "")).span


def test_grammar_knows_no_other_unit() -> None:
    """The grammar's units are those of the table."""
    found = re.search(r"^UNIT\.\d: /\(\?:(.*)\)\(\?!\[", GRAMMAR, re.MULTILINE)
    assert found is not None
    assert sorted(found[1].replace(r"(?!\*\*)", "").replace("\\", "").split("|")) == sorted(UNIT_WORDS)


@pytest.mark.parametrize("word", SPOKEN_UNITS)
def test_spoken_units_are_answered_with_the_right_one(word: str) -> None:
    """What people write for a unit gives the unit that they mean."""
    with pytest.raises(CompileError) as caught:
        parse(Source("test.scn", f"x = 5 {word}\n"))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == errors.UNKNOWN_UNIT.code
    assert diagnostic.cure == f"write `{SPOKEN_UNITS[word]}`"


@pytest.mark.parametrize(("word", "action"), [("brake", "SetBrakeAction"), ("steer", "SetSteerAction")])
def test_a_pedal_is_an_action(word: str, action: str) -> None:
    """Who brakes in a behavior wants the action, and not `break`."""
    with pytest.raises(CompileError) as caught:
        parse(Source("a.scn", f"behavior B():\n    {word} at 3\n"))
    assert caught.value.diagnostics[0].cure == f"write `take {action}(…)`, in a behavior"


def test_reserved_words_are_those_of_the_grammar() -> None:
    """Grammar and messages agree on what is never a name."""
    found = re.search(r"^NAME: /\(\?!\(\?:(.*?)\)", GRAMMAR, re.MULTILINE)
    assert found is not None
    assert set(found[1].split("|")) == RESERVED


def test_a_unit_wins_over_a_name_only_after_a_number_or_call() -> None:
    """`5 min` is a duration, `min(1, 2)` a call, `m` a name."""
    assert unparse(parse(Source("t", "x = 5 min + min(m, 2 m) * m"))) == "x = 5 min + min(m, 2 m) * m\n"


def test_errors_are_reported_in_the_order_of_the_file_and_once() -> None:
    """Errors of layout, grammar and shape come as one list."""
    assert codes_of("f(x) = 3\nx = 5 kmh\nrequire x = 3\n    y = 1\nz = (1\n") == [
        "SCN116",
        "SCN111",
        "SCN110",
        "SCN105",
        "SCN102",
    ]


def test_reading_stops_after_many_errors() -> None:
    """The last diagnostic says so, and is a note."""
    with pytest.raises(CompileError) as caught:
        parse(Source("test.scn", "x = $\n" * 100))
    *rest, last = caught.value.diagnostics
    assert len(rest) == 20
    assert last.severity is Severity.NOTE


def same(*conditions: str) -> bool:
    """Whether these are one condition, differently written."""
    trees = [parse(Source("t", f"require {condition}")).statements for condition in conditions]
    return all(tree == trees[0] for tree in trees)


@pytest.mark.parametrize(
    ("plain", "bracketed"),
    [
        ("always a and b", "always (a and b)"),
        ("always a implies b", "always (a implies b)"),
        ("always a until b", "(always a) until b"),
        ("not always a or b", "not (always (a or b))"),
        ("a or b implies c and d", "(a or b) implies (c and d)"),
        ("a implies b until c implies d", "(a implies b) until (c implies d)"),
        ("a and eventually b or c", "a and (eventually (b or c))"),
        ("next next a", "next (next a)"),
        ("always(a) and b", "always (a and b)"),
    ],
)
def test_how_temporal_operators_bind(plain: str, bracketed: str) -> None:
    """As in Scenic's grammar: `until` is loosest, and a prefix holds all that follows it."""
    assert same(plain, bracketed)


@pytest.mark.parametrize("word", sorted(TEMPORAL_PREFIXES))
def test_temporal_prefixes_are_names_elsewhere(word: str) -> None:
    """Outside a `require`, and in it where no value follows, the words are anybody's."""
    module = parse(Source("t", f"{word} = {word}(3) + x.{word} (4)\nrequire {word} < 3 and {word} in xs\n"))
    assert "Temporal" not in str(module)
    assert "Temporal" in str(parse(Source("t", f"x = 3; require {word} (x)")))


@pytest.mark.parametrize("gap", ["", " ", "\\\n"], ids=["bracket", "blank", "line break"])
def test_an_angle_has_its_end_whatever_stands_behind_the_word(gap: str) -> None:
    """`from` says where it starts and `to` where it ends."""
    assert value_of(f"x = angle from{gap}(ego)") == value_of("x = angle from ego")
    assert value_of(f"x = angle to{gap}(ego)") == value_of("x = angle to ego")
    assert value_of("x = angle from ego") != value_of("x = angle to ego")


@pytest.mark.parametrize("word", ["shuffle", "choose", "follow", "visible"])
def test_what_stands_between_two_values_follows_a_name(word: str) -> None:
    """`relative to` needs a value before it, which is no word that a value stands behind."""
    text = f"behavior B():\n    do {word} relative to x\n"
    assert unparse(parse(Source("test.scn", text))).split() == text.split()


def test_line_endings_and_a_missing_last_one_change_nothing() -> None:
    """A file means the same with any line breaks, and with or without one at its end."""
    text = '"""A\nB"""\nx = (1,\n  2)\nbehavior B():\n    wait\n\n    wait\n'
    module = parse(Source("t", text))
    assert parse(Source("t", text.replace("\n", "\r\n"))) == module
    assert parse(Source("t", text.rstrip())) == module
    assert parse(Source("t", "\ufeff" + text)) == module
    assert parse(Source("t", text.replace("    ", "\t"))) == module


def test_nothing_is_a_module_without_statements() -> None:
    """Comments and blank lines alone are grammatical; a file of them is refused when it is read."""
    assert parse(Source("t", "\n# nothing\n")) == Module((), span=parse(Source("t", "")).span)


def test_the_tree_of_a_text_can_be_asked_for() -> None:
    """`--emit tree` prints what the grammar made of it."""
    assert parse_tree(Source("t", "x = 3")).pretty().split() == ["start", "assign", "name", "x", "number", "3", "None"]
    with pytest.raises(CompileError):
        parse_tree(Source("t", "x ="))


def run(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ | environment
    )
    return done.stdout


def test_import_is_light() -> None:
    """Importing the syntax loads neither Lark nor rich nor numbers."""
    code = "import cortex_dsl.syntax, sys; print({'lark', 'rich', 'numpy', 'numba'} & set(sys.modules))"
    assert run(code).strip() == "set()"


def test_tables_are_cached_where_that_is_possible(tmp_path: Path) -> None:
    """A second process finds the tables of the first; a cache that cannot be made or is broken costs only time."""
    code = (
        "from cortex_dsl.source import Source; from cortex_dsl.syntax import parse; print(parse(Source('t', 'x = 3')))"
    )
    assert "Assign" in run(code, CORTEXC_CACHE=str(tmp_path / "new"))
    (cached,) = (tmp_path / "new").iterdir()
    assert cached.name.startswith("grammar-")
    cached.write_bytes(b"broken")
    assert "Assign" in run(code, CORTEXC_CACHE=str(tmp_path / "new"))
    assert cached.read_bytes() != b"broken"
    (tmp_path / "file").write_text("")
    assert "Assign" in run(code, CORTEXC_CACHE=str(tmp_path / "file" / "below"), XDG_CACHE_HOME=str(tmp_path / "other"))
