"""Texts and lists that a file makes while it is compiled: what they are, and that they end."""

from collections.abc import Callable

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.semantics.model import state
from cortex_dsl.source import Source

Said = Callable[..., list[str]]
Answered = Callable[..., list[tuple[str, str]]]


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("x = [1]\n" + "x = [*x, *x]\n" * 40 + "require len(x) > ego.speed\n", "SCN434"),
        ("x = [1]\n" + "x = [x, x]\n" * 40 + 'assert str(x) == "a"\n', "SCN553"),
        ("x = [1]\ny = [1]\n" + "x = [x, x]\ny = [y, y]\n" * 40 + "assert x == y\n", "SCN434"),
        ("x = range(10000)\nfor i in range(9000):\n    y = x + []\n    assert len(y) > 0\n", "SCN434"),
        ("for i in range(9000):\n    y = range(10000)\n    assert len(y) > 0\n", "SCN434"),
        ("x = range(10000)\nfor i in range(9000):\n    y = sum(x)\n    assert y > 0\n", "SCN434"),
        ("x = range(10000)\nfor i in range(9000):\n    y = x[:]\n    assert len(y) > 0\n", "SCN434"),
        ("x = range(10000)\nfor i in range(9000):\n    assert max(x) > min(x)\n", "SCN434"),
        ("x = range(10000)\nfor i in range(9000):\n    assert 3 in x\n", "SCN434"),
        ("for i in range(9000):\n    assert all(range(1, 10000))\n", "SCN434"),
    ],
    ids=["spread", "text", "compared", "joined", "ranges", "sums", "slices", "extrema", "searches", "all"],
)
def test_what_multiplies_ends(lines: str, code: str, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state, "EVALUATION_LIMIT", 20_000)
    assert code in said(lines)


@pytest.mark.parametrize("limit", ["EVALUATION_LIMIT", "REPETITION_LIMIT"])
@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("for i in range(9000):\n    for j in range(3):\n        x = i + j\n", "range(9000)"),
        ("for i in range(3):\n    for j in range(9000):\n        x = i + j\n", "range(9000)"),
        ("x = [i + j for i in range(9000) for j in range(2)]\n", "range(9000)"),
        (
            "def f(x):\n    n = 0\n    while n < x:\n        n += 1\n    return n\ny = f(3)\nz = f(99999)\n",
            "n < x",
        ),
        ("def f(x):\n    return x + 1\ny = sum(map(f, range(9000)))\n", "range(9000)"),
        ("def f(x):\n    return x + 1\nfor i in range(9000):\n    y = f(i)\n", "range(9000)"),
    ],
    ids=["outer loop", "inner loop", "list", "condition", "map", "loop of calls"],
)
def test_what_is_too_much_is_pointed_at(text: str, place: str, limit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop, list or call to be shortened, and not where in it the last of the work happened to be. All work of a
    loop counts as repetition.
    """
    monkeypatch.setattr(state, limit, 20_000)
    with pytest.raises(CompileError) as caught:
        compile_source(Source("m.scn", f"map intersection()\nego = new Car on road\n{text}"))
    (found,) = [each for each in caught.value.diagnostics if each.code == "SCN434"]
    span = found.label.span
    assert caught.value.source.text[span.start : span.end] == place


def test_a_list_may_grow_to_its_limit(said: Said) -> None:
    assert said("x = []\nfor i in range(10000):\n    x.append(i)\nassert len(x) == 10000\n") == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [(r'f"\x7b\x7b{1}"', "{{1"), ('f"{{{1}}}"', "{1}"), (r'f"\u007d\x7d{{\n"', r"}}{\n"), ('f"{{{{"', "{{")],
)
def test_braces_of_escapes_are_two(written: str, meant: str, said: Said) -> None:
    """As in Python."""
    assert said(f'assert {written} == "{meant}"\n') == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ('f"{(1,)}{(1, 2)}{[1]}{()}"', "(1,)(1, 2)[1]()"),
        ('f"{2**53} {10.0**15:d}"', "9007199254740992 1000000000000000"),
    ],
)
def test_tuples_and_whole_numbers_are_written_as_python_does(written: str, meant: str, said: Said) -> None:
    assert said(f'assert {written} == "{meant}"\n') == []


@pytest.mark.parametrize(
    ("line", "code", "cure"),
    [
        ('x = "a" + 1', "SCN304", 'use `f"{x}"`'),
        ('x = "a" - 1', "SCN304", "`int(...)` or `float(...)`"),
        ('x = f"{3=}"', "SCN128", "`x = {x}`"),
        ('require ego.speed < 99 as f"n{3}"', "SCN115", "write a plain string"),
        ("record ego.speed as r'v'", "SCN115", "write a plain string"),
    ],
)
def test_cures_for_texts_speak_of_texts(line: str, code: str, cure: str, answered: Answered) -> None:
    ((found, said),) = answered(f"{line}\n")
    assert (found, cure in said) == (code, True)


def test_a_message_is_worked_out_as_any_text() -> None:
    """What is chosen at random has the value of a choice."""
    text = 'map intersection()\nego = new Car on road\nn = Uniform(1, 2)\nassert 1 > 2, f"{n} is too many"\n'
    with pytest.raises(CompileError) as caught:
        compile_source(Source("m.scn", text))
    assert [each.reason for each in caught.value.diagnostics] == ["1 is too many"]


@pytest.mark.parametrize("written", [r"""f'''{1}{"\""}{""}'''""", r"""f"{'\''}{''}\"" """, r"""f'{"\\"}{1}'"""])
def test_escaped_quotes_end_no_text_of_a_value(written: str, said: Said) -> None:
    """As in Python from 3.12 on; before, what followed was taken for text, up to the next quotes."""
    assert said(f"assert {written} != ''\n") == []


def test_what_has_no_text_is_told_its_name(answered: Answered) -> None:
    assert "write its `.name`, or a text of your own" in [cure for _, cure in answered("x = str(lane.centerline)\n")]
