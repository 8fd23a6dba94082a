"""The page on Python can be followed: its blocks are one script, which prints what stands below them."""

import re
import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest

from tests.test_tutorial import FENCE, pattern

ROOT = Path(__file__).parents[1]
PAGE = (Path(__file__).parents[1] / "docs" / "reference" / "python.md").read_text(encoding="utf-8")


def blocks() -> Iterator[tuple[int, list[str], str, list[str]]]:
    """Line, words of the fence, text, and what is printed, of each block of Python."""
    found = list(FENCE.finditer(PAGE))
    for block, after in zip(found, [*found[1:], None], strict=True):
        if block["info"].startswith("python"):
            shown = after["text"].splitlines() if after is not None and after["info"] == "text" else []
            yield PAGE.count("\n", 0, block.start()) + 1, block["info"].split()[1:], block["text"], shown


def entry_points(group: str, **named: str) -> list[EntryPoint]:
    """As if the package of the page were installed."""
    ((name, value),) = re.findall(r"^(\w+) = \"(\S+)\"$", PAGE, re.MULTILINE)
    assert f'entry-points."{group}"' in PAGE
    return [EntryPoint(name=name, value=value, group=group)] if named.get("name", name) == name else []


def test_the_page_can_be_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From top to bottom, in a folder with the example: every block runs, and prints what is shown below it."""
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / "examples" / "left_turn.scn", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("engine.search.searchers.entry_points", entry_points)
    space: dict[str, Any] = {"__name__": "page"}
    for line, words, text, shown in blocks():
        if words:
            Path(words[0]).write_text(text, encoding="utf-8")
            continue
        exec(compile("\n" * line + text, "python.md", "exec"), space)
        printed = capsys.readouterr().out
        assert pattern(shown).fullmatch(printed), f"line {line}\n{printed}"
    sys.modules.pop("my_package", None)


def test_what_it_names_is_there() -> None:
    """Modules, classes and functions that stand in the prose."""
    named = set(re.findall(r"`((?:cortex_dsl|engine)(?:\.\w+)+)", PAGE))
    assert len(named) > 4
    for name in named:
        resolve_name(name)
