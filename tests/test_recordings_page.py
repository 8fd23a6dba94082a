"""The page on recordings: its commands print what it says, and its table is that of what is read."""

import os
import re
import sys
from pathlib import Path

import pytest

import cortex_dsl as cx
from cortex_dsl.cli import main
from engine.interchange.sources import SOURCES, XOSC, Source
from engine.interchange.tables.layouts import LAYOUTS, Layout
from tests.test_tutorial import FENCE, commands, pattern

FILE = Path(__file__).parents[1] / "docs" / "how-to" / "judge-recordings.md"
PAGE = FILE.read_text(encoding="utf-8")
TRAFFIC = "time,id,x,y,heading,speed,length,width,type\n" + "".join(
    f"{k / 10},1,{-30 + k},0,0,10,4.5,1.8,car\n{k / 10},2,{28 - 0.8 * k},3,3.14159265,8,4.5,1.8,car\n"
    f"{k / 10},3,{40 - 0.1 * k},9,3.14159265,1,0.5,0.5,pedestrian\n"
    for k in range(50)
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "traffic.csv").write_text(TRAFFIC, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


def blocks(kind: str) -> list[str]:
    return [match["text"] for match in FENCE.finditer(PAGE) if match["info"] == kind]


def test_the_page_can_be_followed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every command prints what is shown below it, and its Python runs."""
    monkeypatch.setattr("sys.stderr", sys.stdout)
    steps = [step for text in blocks("console") for step in commands(text)]
    assert len(steps) == 3
    for command, shown in steps:
        assert main(command.split()[1:]) == 0
        printed = capsys.readouterr().out
        assert pattern(shown).fullmatch(printed), f"{command}\n{printed}"
    assert cx.load(folder / "traffic.scn").program.space.names[0] == "EGO_AHEAD"
    assert (folder / "pairs.csv").read_text().startswith("rank,one,other,")
    page = (folder / "pairs.html").read_text()
    assert page.count("<polygon") == 2 * len(cx.measure_all("traffic.csv", near=20.0))
    for text in blocks("python"):
        exec(text, {})
    assert "RankedWindows(3 actors, " in capsys.readouterr().out


def _row(name: str, source: Layout | Source) -> str:
    if isinstance(source, Layout):
        return f"| {name} | `{source.example}` | {source.said} |"
    return f"| {name} | {', '.join(f'`*{suffix}`' for suffix in source.suffixes)} | {source.conventions} |"


def test_the_table_is_that_of_what_is_read() -> None:
    """A row for each layout and each kind of file."""
    logs = [source for name, source in SOURCES.items() if name != "table"]
    rows = [_row(layout.name, layout) for layout in LAYOUTS]
    rows += [_row(source.what, source) for source in (*logs, XOSC)]
    table = re.compile(r"(\| recording \| files \|[^\n]*\n\|---[^\n]*\n)((?:\|[^\n]*\n|ROWS\n)+)")
    found = table.search(PAGE)
    assert found
    if os.environ.get("UPDATE_GOLDEN"):
        FILE.write_text(PAGE.replace(found[2], "\n".join(rows) + "\n"), encoding="utf-8")
        return
    assert found[2].splitlines() == rows
