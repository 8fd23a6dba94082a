"""Texts and lists that a file makes while it is compiled: what they are, and that they end."""

from collections.abc import Callable

import pytest

from cortex_dsl.semantics.model import state

Said = Callable[..., list[str]]


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
    ],
    ids=["spread", "text", "compared", "joined", "ranges", "sums", "slices"],
)
def test_what_multiplies_ends(lines: str, code: str, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state, "EVALUATION_LIMIT", 20_000)
    assert code in said(lines)


def test_a_list_may_grow_to_its_limit(said: Said) -> None:
    assert said("x = []\nfor i in range(10000):\n    x.append(i)\nassert len(x) == 10000\n") == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [(r'f"\x7b\x7b{1}"', "{{1"), ('f"{{{1}}}"', "{1}"), (r'f"\u007d\x7d{{\n"', r"}}{\n"), ('f"{{{{"', "{{")],
)
def test_braces_of_escapes_are_two(written: str, meant: str, said: Said) -> None:
    """As in Python."""
    assert said(f'assert {written} == "{meant}"\n') == []


def test_what_has_no_text_is_told_its_name(answered: Callable[..., list[tuple[str, str]]]) -> None:
    assert "write its `.name`, or a text of your own" in [cure for _, cure in answered("x = str(lane.centerline)\n")]
