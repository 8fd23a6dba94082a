"""What a stranger wrote shows in a terminal, and does nothing to it."""

import json
import unicodedata
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from rich.table import Table
from rich.text import Text

from cortex_dsl import load
from cortex_dsl.console import terminal
from cortex_dsl.plain_text import harmless
from cortex_dsl.report.documents import document
from engine.sampling import rows_at_once

Command = Callable[..., Any]
EVIL = "\x1b[31mred\x1b]0;title\x07 \x9b2J \u202egnp.exe \u2066x\u2069 \ud800"
"""An escape sequence, the title of a window, a C1 control, letters turned round, half a character."""
ACTS = ("Cc", "Cf", "Cs", "Zl", "Zp")


def acting(text: str) -> set[str]:
    """Characters of a text that are no plain sign, line or stop."""
    return {c for c in text if unicodedata.category(c) in ACTS and c not in "\n\t"}


@given(st.text())
def test_every_text_is_harmless(text: str) -> None:
    """Nothing acts, nothing is lost: one character for each."""
    shown = harmless(text)
    assert acting(shown) == set()
    assert len(shown) == len(text)
    assert all(a == b or b == "\ufffd" for a, b in zip(text, shown, strict=True))


@given(st.text())
@example("\x7f\u0600\u202e\U000e0001 \u00e4")
def test_a_document_is_harmless_and_says_the_same(text: str) -> None:
    """What JSON reads is what was written."""
    written = document("run", {"text": text})
    assert acting(written) == set()
    assert json.loads(written)["text"] == text


def test_whatever_a_console_prints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Texts, tables and their titles, on a terminal with colours: no control but those of styles."""
    stream = StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    console = terminal._console(stream, None)
    table = Table(EVIL, title=EVIL)
    table.add_row(Text(EVIL, "bold red"))
    for thing in (EVIL, Text(EVIL), table):
        console.print(thing)
    plain = Text.from_ansi(stream.getvalue()).plain
    assert "\x1b[1" in stream.getvalue()
    assert "\x1b]" not in stream.getvalue()
    assert acting(plain) == set()
    assert plain.count("red") >= 4


@pytest.mark.parametrize("columns", ["0", "1", "19"])
def test_a_terminal_without_columns(columns: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nobody said how wide it is, a terminal is a usual one."""
    monkeypatch.setenv("COLUMNS", columns)
    assert terminal._console(StringIO(), None).width == terminal.USUAL


def test_a_scenario_that_writes_to_the_terminal(cortexc: Command, tmp_path: Path) -> None:
    """Docstring, names of requirements and objectives, a message, a complaint: in words and as JSON."""
    path = tmp_path / "evil.scn"
    text = f'"""{EVIL[:-2]}"""\nego = new Car\nrequire ego.speed < 0 as "{EVIL[:-2]}"\n'
    path.write_text(text, encoding="utf-8")
    for words in ((path, "--seed", 1), (path, "--check", "--json"), (path, "--emit", "ir"), (path, "--sample", 5)):
        result = cortexc(*words)
        assert acting(result.out) | acting(result.err) == set(), words
    result = cortexc("report", f"no{EVIL[:-2]}where")
    assert result.code == 2
    assert acting(result.err) == set()


def test_links_that_lead_nowhere(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """As the folder of a search or of an export: told as that, and the link stays."""
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "no" / "where")
    small = ("--random", "--generations", 1, "--population", 2, "--jobs", 1)
    for words in ((left_turn, *small), ("export", left_turn, "--to", "csv")):
        result = cortexc(*words, "--out", link)
        assert result.code == 2
        assert f"`{link}` is a link that leads nowhere" in result.said
        assert "remove it, or name another" in result.said
    assert link.is_symlink()


def test_memory_that_is_not_there(cortexc: Command, left_turn: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What asks for more than there is ends with a message and its cure, and is no bug."""

    def too_much(*_: object) -> None:
        raise MemoryError("Unable to allocate 15.6 GiB for an array with shape (10000, 210021)")

    monkeypatch.setattr("cortex_dsl.cli.draw_modes._warm_up", too_much)
    result = cortexc(left_turn, "--sample", 5)
    assert result.code == 2
    assert "this takes more memory than there is: 15.6 GiB at once" in result.said
    assert "help: fewer actors" in result.said


def test_many_actors_are_drawn_few_at_a_time(left_turn: Path) -> None:
    """Blocks of usual programs are as they were; a scene of ten thousand actors takes as much as many of two."""
    program = load(left_turn).program
    wide = program.code._replace(output_register=np.zeros((1, 210_021), dtype=np.int32))
    assert rows_at_once(program, 20_000) == 20_000
    assert rows_at_once(replace(program, code=wide), 20_000) == 119
