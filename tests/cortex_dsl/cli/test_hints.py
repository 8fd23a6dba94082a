"""Command lines that are guessed: each is answered with the line as it should be."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]


@pytest.mark.parametrize(
    ("line", "message", "cure"),
    [
        ("--explain SCN203", "`explain` is a command, not an option", "cortexc explain SCN203"),
        ("--repl", "`repl` is a command, not an option", "cortexc repl"),
        ("check ped.scn", "there is no command `check`", "cortexc ped.scn --check"),
        ("run ped.scn --seed 3", "there is no command `run`", "cortexc ped.scn --seed 3"),
        ("ga ped.scn", "there is no command `ga`", "cortexc ped.scn --ga"),
        ("sample ped.scn", "there is no command `sample`", "cortexc ped.scn --sample 10000"),
        ("check", "there is no command `check`", "cortexc FILE --check"),
        ("help", "`help` is an option here", "cortexc --help"),
        ("version", "`version` is an option here", "cortexc --version"),
        ("analyze runs/x", "there is no command `analyze`", "cortexc analyse runs/x"),
        ("reprot runs/x", "there is no command `reprot`", "cortexc report runs/x"),
        ("format a.scn", "there is no command `format`", "cortexc fmt a.scn"),
    ],
)
def test_a_guess_is_answered(
    line: str, message: str, cure: str, cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With exit code 2 and the command that was meant."""
    monkeypatch.chdir(tmp_path)
    result = cortexc(*line.split())
    assert result.code == 2
    assert result.err == f"cortexc: {message}\n  help: write `{cure}`\n"


def test_a_file_of_that_name_is_a_file(cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody is kept from a file called `check`, and a file that is not there is missed as before."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "check").write_text("map intersection()\nego = new Car on road, with speed 3 m/s\n", encoding="utf-8")
    assert cortexc("check", "--check").code == 0
    assert "there is no file `ped.scn`" in cortexc("ped.scn", "--check").err
