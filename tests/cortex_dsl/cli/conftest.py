"""The scenario that commands are tried on, and a short way to run them."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.cli import main

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"


@dataclass(frozen=True)
class Result:
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        return json.loads(self.out)

    @property
    def said(self) -> str:
        """What stderr says, in one line: where its lines break depends on how long the paths of this machine are."""
        return " ".join(self.err.split())


@pytest.fixture(scope="session")
def left_turn() -> Path:
    """The example that every command is tried on."""
    return LEFT_TURN


@pytest.fixture
def cortexc(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Run a command in this process, 100 columns wide; no exception may pass for a bug of ours."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("CORTEXC_DEBUG", "1")

    def run(*arguments: object) -> Result:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Result(code, captured.out, captured.err)

    return run


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[[str], Path]:
    """Write a scenario of one's own: the worked example with `old` replaced by `new`, pairwise."""

    def write(*replacements: str) -> Path:
        text = LEFT_TURN.read_text()
        for old, new in zip(replacements[::2], replacements[1::2], strict=True):
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "own.scn"
        path.write_text(text)
        return path

    return write
