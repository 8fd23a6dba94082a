"""The README says what is so: its scenario compiles, its Python runs, its options exist."""

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from cortex_dsl.cli.command_table import FILE, SUBCOMMANDS
from cortex_dsl.console.command import Option
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "examples" / "README.md", ROOT / "docs" / "reference" / "overview.md"]


def blocks(kind: str) -> list[str]:
    """Fenced blocks of the README that are marked as `kind`."""
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGES[0].read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def test_it_is_short() -> None:
    """The first page has at most 1,200 words."""
    assert len(PAGES[0].read_text(encoding="utf-8").split()) <= 1200


def test_its_scenario_compiles() -> None:
    """The first page of the language that a newcomer sees is right, without a warning."""
    scenario = next(block for block in blocks("") if "map intersection" in block)
    assert not compile_source(Source("README.md", scenario)).diagnostics


def test_its_python_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Every line of the notebook page works as written, from the root of the repository."""
    monkeypatch.chdir(ROOT)
    (page,) = blocks("python")
    exec(page, {})
    assert "map intersection" in capsys.readouterr().out


def test_its_picture_is_what_its_command_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The caption names the search whose first case the picture shows, and the command that draws it."""
    found = re.search(r"!\[[^]]*\]\((\S+)\)\n\nThe first case of `cortexc ([^`]+)`.*?`cortexc replay RUN`",
                      PAGES[0].read_text(encoding="utf-8"), re.DOTALL)  # fmt: skip
    assert found is not None
    file, *words = found[2].split()
    assert main([str(ROOT / file), *words, "--out", str(tmp_path / "run")]) == 0
    assert main(["replay", str(tmp_path / "run"), "--to", str(tmp_path / "case.svg")]) == 0
    assert (tmp_path / "case.svg").read_bytes() == (ROOT / found[1]).read_bytes()


CALL = r"\bcortexc [^`\n|]+"
OPTION = r"(?<![\w-])--[a-z][a-z-]+"


def flags(rows: Iterable[Option]) -> set[str]:
    return {flag for row in rows for flag in row.flag.split()}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_its_options_exist(page: Path) -> None:
    """A line of a command has its options; others are those of `cortexc FILE`, or of the benchmark that is named."""
    text = page.read_text(encoding="utf-8")
    lines = re.findall(CALL, text)
    assert any(re.search(OPTION, line) for line in lines)
    for line in lines:
        word = line.split()[1]
        rows = SUBCOMMANDS[word].load().rows if word in SUBCOMMANDS else FILE.rows
        assert set(re.findall(OPTION, line)) <= flags(rows), line
    named = set(re.findall(OPTION, re.sub(CALL, "", text)))
    for benchmark in re.findall(r"python -m benchmarks\.(\w+)", text):
        source = (ROOT / "benchmarks" / f"{benchmark}.py").read_text(encoding="utf-8")
        if "campaigns" in source:  # the options that benchmarks of many runs share
            source += (ROOT / "benchmarks" / "campaigns.py").read_text(encoding="utf-8")
        named -= set(re.findall(r'add_argument\("(--[a-z-]+)"', source))
    assert named <= flags(FILE.rows)
