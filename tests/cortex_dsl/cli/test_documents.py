"""Every command that has `--json` writes one strict document, with all that its text says beside the result."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.cli.command_table import MODES, SUBCOMMANDS
from cortex_dsl.console.request import Mode

Command = Callable[..., Any]
SMALL = ("--generations", 2, "--population", 8, "--jobs", 1)
LINES: dict[str, tuple[object, ...]] = {
    "run": ("FILE",),
    "search": ("FILE", "--random", *SMALL, "--out", "NEW"),
    "sample": ("FILE", "--sample", 20),
    "check": ("FILE", "--check"),
    "emit": ("FILE", "--emit", "ir"),
    "examples": ("examples",),
    "explain": ("explain", "SCN321"),
    "study": ("study", "FILE", "--runs", 1, *SMALL, "--out", "NEW"),
    "resume": ("resume", "RUN"),
    "resume of a study": ("resume", "STUDY"),
    "analyse": ("analyse", "RUN", "--budget", 50, "--jobs", 1),
    "probability": ("probability", "FILE", "--samples", 20),
    "probability of a run": ("probability", "RUN", "--samples", 20),
    "verify": ("verify", "RUN", "--sample", 2),
    "verify --model": ("verify", "RUN", "--model", "dynamic", "--worst", 1),
    "verify of a study": ("verify", "STUDY"),
    "export": ("export", "FILE", "--to", "csv", "--out", "NEW"),
    "export of a run": ("export", "RUN", "--to", "csv", "--out", "NEW"),
    "measure": ("measure", "TABLE"),
    "measure --all": ("measure", "TABLE", "--all"),
    "import": ("import", "XOSC"),
    "paper-check": ("paper-check",),
    "test": ("test", "FILE", "--budget", 20, "--allow-collisions"),
    "compare": ("compare", "FILE", "FILE", "--budget", 20),
    "coverage": ("coverage", "FILE", "--budget", 20),
    "suite": ("suite", "un-r152", "--ego", "EmergencyBrakeBehavior", "--only", "car M1/*/20", "--budget", 4),
}
ABOUT_A_FILE = ("FILE", "RUN")
KEPT = ("kept in", "to go on", "compil")
"""Beginnings of lines on standard error that are no remarks on a result."""


@pytest.fixture(scope="module")
def made(left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A scenario with a warning (SCN321), and what commands made of it; then the file is edited."""
    from cortex_dsl.cli import main

    home = tmp_path_factory.mktemp("documents")
    file = home / "fast.scn"
    file.write_text(
        left_turn.read_text()
        + 'domain "speed" ego.speed in 20 km/h steps from 0 km/h to 80 km/h\n'
        + "new Car at (45, 200), with regionContainedIn None, with speed 45\n",
        encoding="utf-8",
    )
    lines = (
        (file, "--ga", *SMALL, "--out", home / "run"),
        ("study", file, "--runs", 1, *SMALL, "--out", home / "study"),
        ("export", file, "--to", "csv,xosc", "--out", home),
    )
    for words in lines:
        assert main([*map(str, words)]) == 0
    edited = Path(shutil.copy(file, home / "copy.scn"))
    file.write_text(file.read_text() + "\n")
    table, xosc = (next(home.glob(f"*.{suffix}")) for suffix in ("csv", "xosc"))
    return {"FILE": edited, "RUN": home / "run", "STUDY": home / "study", "TABLE": table, "XOSC": xosc}


def test_every_command_is_here() -> None:
    """A new command or mode that has `--json` needs a line."""
    having = {name for name, row in SUBCOMMANDS.items() if row.load().json}
    assert having == {str(words[0]) for words in LINES.values() if words[0] in SUBCOMMANDS}
    assert {mode.value for mode in MODES} == {name for name in LINES if name in {mode.value for mode in Mode}}


def no_number(name: str) -> object:
    raise ValueError(f"{name} is no JSON")


@pytest.mark.parametrize("name", LINES)
def test_a_document_says_what_the_text_says(name: str, cortexc: Command, made: dict[str, Path], tmp_path: Path) -> None:
    """It is strict; notes and codes of diagnostics are those of standard error in text."""

    def words(new: str) -> list[object]:
        return [{**made, "NEW": tmp_path / new}.get(str(word), word) for word in LINES[name]]

    shown, result = cortexc(*words("text")), cortexc(*words("json"), "--json")
    assert shown.code == result.code == 0
    document = json.loads(result.out, parse_constant=no_number)
    assert document["schema"].startswith("cortexc/")
    codes = {each["code"] for each in document["diagnostics"]}
    assert codes == ({"SCN321"} if set(ABOUT_A_FILE) & set(LINES[name]) else set())
    assert all(code in shown.said for code in codes)
    for note in document["notes"]:
        assert note in shown.said
        assert note in result.said
    if name in ("resume of a study", "verify of a study", "resume"):
        assert any("edited" in note or "finished" in note for note in document["notes"]) == (
            name != "verify of a study"
        )
    unexplained = result.said
    for note in document["notes"]:
        unexplained = unexplained.replace(note, "")
    assert not unexplained.strip() or unexplained.strip().lower().startswith(KEPT), unexplained


@pytest.mark.parametrize("name", LINES)
def test_a_refusal_is_a_document_too(name: str, cortexc: Command, tmp_path: Path) -> None:
    """A path that does not exist: message and cure in JSON as on standard error."""
    if not any(str(word).isupper() for word in LINES[name]):
        pytest.skip("it reads no file")
    result = cortexc(*(tmp_path / "nothing" if str(word).isupper() else word for word in LINES[name]), "--json")
    document = json.loads(result.out, parse_constant=no_number)
    assert (document["schema"], document["exit_code"]) == ("cortexc/error", result.code) == ("cortexc/error", 2)
    assert " ".join(document["message"].split()) in result.said
    assert document["notes"] == document["diagnostics"] == []
