"""The tutorial can be followed: its files compile, its commands run, and they print what the page says."""

import io
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.pipeline import compile_source
from cortex_dsl.report.terminal.kernel_progress import COMPILED
from cortex_dsl.source import Source
from cortex_dsl.syntax.formatting import format_source

PAGE = (Path(__file__).parents[1] / "docs" / "tutorial" / "first-collision.md").read_text(encoding="utf-8")
FENCE = re.compile(r"^```(?P<info>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
PROMPT = "scn> "
SHORTENED = "…"
"""Alone on a line: any number of lines; at the end of one or within it: any characters."""


def blocks() -> Iterator[tuple[int, list[str], str]]:
    """Line, words of the fence and text of each block."""
    for match in FENCE.finditer(PAGE):
        yield PAGE.count("\n", 0, match.start()) + 1, match["info"].split(), match["text"]


def steps() -> Iterator[tuple[int, list[str], str]]:
    """Line, words of the fence and *whole* text of each scenario: a block with `+` is added to what stood there."""
    whole: dict[str, str] = {}
    for line, (kind, *words), text in blocks():
        if kind == "scn":
            name, *marks = words
            whole[name] = whole.get(name, "") + text if "+" in marks else text
            yield line, words, whole[name]


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """Each command of a console block, with what the page says that it prints."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, *shown = part.splitlines()
        yield command, shown


def pattern(shown: list[str]) -> re.Pattern[str]:
    """What the page shows, as an expression for the whole output."""
    parts = []
    for line in shown:
        words = re.escape(line.rstrip()).replace(SHORTENED, "[^\\n]*")
        parts.append(r"(?:[^\n]*\n)*?" if line.strip() == SHORTENED else words + r" *\n")
    return re.compile("".join(parts))


@pytest.mark.parametrize(("line", "words", "text"), list(steps()))
def test_scenario(line: int, words: list[str], text: str) -> None:
    """A step compiles without warnings and is laid out as by `cortexc fmt`, or has the error that it is marked with."""
    expected = [mark for mark in words[1:] if mark != "+"]
    source = Source(f"first-collision.md:{line}", text)
    if not expected:
        assert not [d for d in compile_source(source).diagnostics if d.severity is Severity.WARNING]
        assert format_source(source) == text
        return
    with pytest.raises(CompileError) as caught:
        compile_source(source)
    assert [d.code for d in caught.value.diagnostics if d.severity is Severity.ERROR] == expected


def test_the_page_can_be_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From top to bottom in an empty folder, 80 columns wide: every command prints what is shown below it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("CORTEXC_DEBUG", "1")
    files = {line: (words[0], text) for line, words, text in steps()}
    ran = 0
    for line, words, text in blocks():
        if words[0] == "scn":
            name, whole = files[line]
            (tmp_path / name).write_text(whole, encoding="utf-8")
        elif words[0] == "console":
            for command, shown in commands(text):
                check(command, shown, line, capsys, monkeypatch)
                ran += 1
    assert ran >= 12


def check(
    command: str, shown: list[str], line: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run one command in this process; what stands behind the prompt of the REPL is what it is given."""
    name, *arguments = [quoted or word for quoted, word in re.findall(r'"([^"]*)"|(\S+)', command)]
    assert name == "cortexc"
    entries = [line.removeprefix(PROMPT) + "\n" for line in shown if line.startswith(PROMPT)]
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(entries)))
    shown = [line for line in shown if not line.startswith(PROMPT)]
    monkeypatch.setattr("sys.stderr", sys.stdout)
    main(arguments)
    printed = COMPILED.sub("", capsys.readouterr().out)
    assert pattern(shown).fullmatch(printed), f"line {line}: {command}\n{printed}"
