"""The same findings as text, as a document and as annotations: golden files beside the programs.

`UPDATE_GOLDEN=1 pytest tests/cortex_dsl/cli/test_formats.py` writes what is said, to be read before it is kept.
"""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.console.compiling import MOST_CODES

Command = Callable[..., Any]
GOLDEN = Path(__file__).parent / "golden"
PROGRAMS = sorted(path.name for path in GOLDEN.glob("*.scn"))


@pytest.mark.parametrize("form", ["text", "json", "github"])
@pytest.mark.parametrize("name", PROGRAMS)
def test_every_form(name: str, form: str, cortexc: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """Text goes to stderr, what programs read to stdout; they say the same."""
    monkeypatch.chdir(GOLDEN)
    result = cortexc(name, "--check", "--format", form)
    found = re.sub(r'("cortexc": )".*"', r'\1"*"', (result.err if form == "text" else "") + result.out)
    expected = GOLDEN / f"{name.removesuffix('.scn')}.{form}"
    if os.environ.get("UPDATE_GOLDEN"):
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")


def on_a_terminal(cortexc: Command, monkeypatch: pytest.MonkeyPatch, *arguments: object) -> str:
    """What stderr shows where somebody watches."""
    monkeypatch.setattr("rich.console.Console.is_terminal", property(lambda _: True))
    return cortexc(*arguments, "--no-colour").err


def test_a_listing_on_a_terminal_says_where_to_read_more(cortexc: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once, with every code of an error or warning; never in a file or pipe."""
    lines = on_a_terminal(cortexc, monkeypatch, GOLDEN / "several.scn", "--check").splitlines()
    assert lines[-1] == "for more: cortexc explain SCN501 (or SCN204, SCN302)"
    assert "for more" not in on_a_terminal(cortexc, monkeypatch, GOLDEN / "several.scn", "--check", "--json")


def test_a_listing_on_a_terminal_names_a_few_codes(
    cortexc: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """After some, an ellipsis; notes and hints alone need no reading."""
    slips = ["a = b", "c = (1, 2)[9]", "d = 3 m + 1 s", "e = 1 / 0", "f = Range(3, 1)", "g, h = (1, 2, 3)", "i = 1(2)"]
    path = tmp_path / "many.scn"
    path.write_text("ego = new Car on road\n" + "\n".join(slips) + "\n")
    last = on_a_terminal(cortexc, monkeypatch, path, "--check").splitlines()[-1]
    assert last.count("SCN") == 1 + MOST_CODES
    assert last.endswith(", …)")
    path.write_text("ego = new Car on road\ngap = 3 m\n")
    assert "for more" not in on_a_terminal(cortexc, monkeypatch, path, "--check")


def test_hints_belong_to_check(cortexc: Command) -> None:
    """A run prints no hints, but still prints warnings."""
    assert "hint[SCN223]" in cortexc(GOLDEN / "advice.scn", "--check").err
    quiet = cortexc(GOLDEN / "advice.scn", "--emit", "ir").err
    assert "hint" not in quiet
    assert "warning[SCN480]" in quiet
