"""The page on exports can be followed: its commands run, they print what it says, and what it names is there."""

import re
import sys
from pathlib import Path

import pytest

from benchmarks.validation.environments import REQUIREMENTS
from benchmarks.validation.table import BEGIN, END
from cortex_dsl.cli import main
from cortex_dsl.interchange.formats import FORMATS
from engine.interchange.kinds import KINDS, VEHICLE, Code, kind_of
from engine.vocabulary import ActorKind
from tests.test_tutorial import FENCE, commands, pattern

ROOT = Path(__file__).parents[1]
PAGE = (Path(__file__).parents[1] / "docs" / "how-to" / "cases-elsewhere.md").read_text(encoding="utf-8")


def consoles() -> list[tuple[int, str]]:
    """Line and text of each block of commands of ours."""
    blocks = [match for match in FENCE.finditer(PAGE) if match["info"] == "console"]
    return [(PAGE.count("\n", 0, match.start()) + 1, match["text"]) for match in blocks]


def test_the_page_can_be_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From top to bottom in a folder with the example, 80 columns wide: every command prints what is shown below it."""
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "left_turn.scn").write_bytes((ROOT / "examples" / "left_turn.scn").read_bytes())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("CORTEXC_DEBUG", "1")
    monkeypatch.setattr("sys.stderr", sys.stdout)
    steps = [(line, *step) for line, text in consoles() for step in commands(text)]
    assert len(steps) >= 7
    for line, command, shown in steps:
        name, *arguments = command.split()
        assert name == "cortexc"
        assert main(arguments) == 0, f"line {line}: {command}"
        printed = capsys.readouterr().out
        assert pattern(shown).fullmatch(printed), f"line {line}: {command}\n{printed}"
    assert {file.suffix for file in tmp_path.rglob("*.x*")} == {".xosc", ".xodr", ".xml"}


def test_every_format_has_its_row() -> None:
    """A format that is added is described on the page."""
    rows = [row for row in PAGE.splitlines() if row.startswith("| `")]
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row.split("|")[1])} >= set(FORMATS)
    for name, entry in FORMATS.items():
        assert name in PAGE, name
        assert all(suffix in PAGE for suffix in entry.suffixes), name


def test_the_codes_of_types_are_those_that_are_written() -> None:
    """Every kind has its row, as `engine.interchange.kinds` has it; subtypes are read as the page says."""
    rows = [[cell.strip() for cell in row.strip("|").split("|")] for row in PAGE.splitlines() if row.startswith("| ")]
    listed = {row[0]: tuple(int(cell.split()[0]) for cell in row[1:]) for row in rows if re.match(r"-?\d", row[1])}
    assert {kind.name.lower(): tuple(entry.code) for kind, entry in KINDS.items()}.items() <= listed.items()
    read = {"CAR": range(2, 7), "TRUCK": (7, 8, 9, 16), "BUS": (12, 13, 14), "BICYCLE": (11, 17), "PEDESTRIAN": (15,)}
    for name, codes in read.items():
        assert {kind_of(Code(VEHICLE, 2, code)) for code in codes} == {ActorKind[name]}
    assert [kind_of(Code(VEHICLE, 2, code)) for code in (0, 1, 18)] == [None, None, None]


def test_the_versions_are_those_that_are_tried() -> None:
    """`Plays in` names the version of a checker that `make validate` sets up."""
    for file in REQUIREMENTS.glob("*.txt"):
        for package, version in re.findall(r"^([\w-]+)==([\d.]+)$", file.read_text(encoding="utf-8"), re.MULTILINE):
            if package.removeprefix("eclipse-") in ("sumo", "scenic", "omega-prime", "commonroad-io"):
                assert version in PAGE, package


def test_the_result_of_the_checkers_stands_there() -> None:
    """Between its markers, every row without a finding."""
    table = PAGE.partition(BEGIN)[2].partition(END)[0].strip().splitlines()
    assert len(table) > 10
    assert all(row.endswith("| 0 |") for row in table[2:]), "`make validate ARGS=--write` has found something"
