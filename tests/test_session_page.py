"""The page on the session can be followed: what is entered prints what is shown below it."""

from pathlib import Path

import pytest

from cortex_dsl.repl.commands import COMMANDS
from tests.test_tutorial import FENCE, check, commands

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "how-to" / "session.md").read_text(encoding="utf-8")


def test_the_session_can_be_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder with the examples, 80 columns wide; what it writes is there, and nothing else."""
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "left_against_crossing.scn").write_bytes(
        (ROOT / "examples" / "left_against_crossing.scn").read_bytes()
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("CORTEXC_DEBUG", "1")
    consoles = [match["text"] for match in FENCE.finditer(PAGE) if match["info"] == "console"]
    for command, shown in (step for text in consoles for step in commands(text)):
        check(command, shown, 0, capsys, monkeypatch)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elsewhere", "examples", "mine.scn"]


def test_the_page_names_commands_that_exist() -> None:
    """Those of the cockpit above all."""
    for name in ("plot", "ga", "random", "worst", "watch", "export", "help"):
        assert f":{name}" in PAGE
        assert name in COMMANDS
