"""Mistakes as newcomers make them: what `cortexc FILE --check` says of each, and the file mended from that alone.

A new one is two files in `tests/cortex_dsl/mistakes`: `NN_name.scn`, whose first line says what its author wanted, and
`NN_name.fixed.scn`. `UPDATE_GOLDEN=1 pytest tests/cortex_dsl/cli/test_mistakes.py` writes `NN_name.txt`, to be read.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
FOLDER = Path(__file__).parents[1] / "mistakes"
FILES = sorted(path for path in FOLDER.glob("*.scn") if ".fixed" not in path.name)


def name(path: Path) -> str:
    return path.stem


@pytest.mark.parametrize("path", FILES, ids=name)
def test_a_mistake_is_answered(path: Path, cortexc: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """With an error or a warning that has a cure, as written beside the file."""
    monkeypatch.chdir(FOLDER)
    result = cortexc(path.name, "--check")
    found, expected = result.err + result.out, path.with_suffix(".txt")
    if os.environ.get("UPDATE_GOLDEN"):
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert result.code == 1 or "warning[" in result.said
    assert "= help: " in result.said


@pytest.mark.parametrize("path", FILES, ids=name)
def test_the_mended_file_compiles_in_silence(path: Path, cortexc: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """No noise on good files: not even a hint."""
    monkeypatch.chdir(FOLDER)
    result = cortexc(f"{path.stem}.fixed.scn", "--check")
    assert (result.code, result.err) == (0, "")


def test_there_are_forty() -> None:
    """One for each kind of mistake."""
    assert len(FILES) >= 40
