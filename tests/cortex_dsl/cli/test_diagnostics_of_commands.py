"""Whatever a command says about a file in text, its document under --json contains too."""

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.laws import share

Command = Callable[..., Any]
ROOT = Path(__file__).parents[3]
CODE = re.compile(r"\bSCN\d{3}\b")
SMALL = ("--generations", 1, "--population", 6, "--jobs", 1)
COMMANDS: dict[str, tuple[object, ...]] = {
    "check": ("FILE", "--check"),
    "run": ("FILE",),
    "sample": ("FILE", "--sample", 20),
    "search": ("FILE", "--random", *SMALL, "--out", "OUT"),
    "export": ("export", "FILE", "--to", "xosc", "--out", "OUT"),
    "probability": ("probability", "FILE", "--samples", 20),
    "emit": ("FILE", "--emit", "ir"),
}


def both(cortexc: Command, words: tuple[object, ...], file: Path, out: Path) -> tuple[set[str], set[str]]:
    """Codes that a command shows in text, and those in its document."""

    def run(name: str, *more: str) -> Any:
        return cortexc(*({"FILE": file, "OUT": out / name}.get(str(word), word) for word in words), *more)

    text, document = run("text"), run("json", "--json").document
    said = re.sub(r"^.*cortexc explain.*$", "", text.said, flags=re.MULTILINE)
    return set(CODE.findall(said)), {each["code"] for each in document["diagnostics"]}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_warning_is_told_by_every_command(name: str, cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """A speed of 45 m/s that was meant as km/h: in text on stderr, and in `diagnostics`."""
    file = tmp_path / "fast.scn"
    text = left_turn.read_text()
    file.write_text(text + "new Car at (45, 200), with regionContainedIn None, with speed 45\n")
    in_text, in_document = both(cortexc, COMMANDS[name], file, tmp_path)
    assert in_text == in_document
    assert "SCN321" in in_text


@pytest.mark.parametrize("name", ["check", "run", "sample", "search"])
def test_text_and_document_have_the_same_codes(name: str, cortexc: Command, tmp_path: Path) -> None:
    """Of files with every kind of mistake, of which some compile."""
    files = sorted((ROOT / "tests" / "cortex_dsl" / "mistakes").glob("*.scn"))
    chosen = random.Random(name).sample(files, min(len(files), share(100)))
    differ = {}
    for file in chosen:
        out = tmp_path / file.stem
        out.mkdir()
        in_text, in_document = both(cortexc, COMMANDS[name], file, out)
        if in_text != in_document:
            differ[file.name] = in_text, in_document
    assert differ == {}
