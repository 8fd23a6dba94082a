"""Whole dialogues as they look: `UPDATE_GOLDEN=1` writes them again from what is entered in them."""

import os
import re
from pathlib import Path

import pytest

from cortex_dsl.report.terminal.kernel_progress import COMPILED

from .conftest import LEFT_TURN, Talk

GOLDEN = Path(__file__).parent / "golden"
PROMPT, MORE = "scn> ", "...  "
PACE = re.compile(r"(?<=runs in )[^,\n]+|[\d.,]+ a second")
"""What differs from machine to machine, as whether kernels have to be compiled."""


def entered(text: str) -> list[str]:
    """The chunks of a dialogue."""
    chunks: list[str] = []
    for line in text.splitlines():
        if line.startswith(PROMPT):
            chunks.append(line.removeprefix(PROMPT))
        elif line.startswith(MORE):
            chunks[-1] += "\n" + line.removeprefix(MORE)
    return chunks


def dialogue(talk: Talk, chunks: list[str]) -> str:
    """What is entered, and below it what is said, without blanks at the ends of lines."""
    parts: list[str] = []
    for chunk in chunks:
        said = talk(chunk)
        parts += [PROMPT + chunk.replace("\n", "\n" + MORE), *(said.out + said.err).splitlines()]
    whole = "\n".join(line.rstrip() for line in parts) + "\n"
    return COMPILED.sub("", PACE.sub("…", whole))


@pytest.mark.parametrize("name", ["cockpit", "plots"])
def test_a_dialogue(talk: Talk, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every answer is the one on record."""
    path = GOLDEN / f"{name}.txt"
    (tmp_path / "left_turn.scn").write_bytes(LEFT_TURN.read_bytes())
    monkeypatch.chdir(tmp_path)
    recorded = path.read_text(encoding="utf-8")
    said = dialogue(talk, entered(recorded))
    if os.environ.get("UPDATE_GOLDEN") == "1":
        path.write_text(said, encoding="utf-8")
    assert said == path.read_text(encoding="utf-8")
