"""Folders of runs that many tests read: made once a session, whoever of its workers comes first."""

import os
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from filelock import FileLock

from cortex_dsl.cli import main

LEFT_TURN = Path(__file__).parents[1] / "examples" / "left_turn.scn"
GENERATIONS, POPULATION = 4, 30
SEARCH = ("--ga", "--generations", GENERATIONS, "--population", POPULATION, "--seed", 1, "--jobs", 1, "--json")


def shared(factory: pytest.TempPathFactory, name: str, *words: object) -> Path:
    """Return the folder that a command wrote to `--out`; no test may change it."""
    home = factory.getbasetemp()
    home = (home.parent if "PYTEST_XDIST_WORKER" in os.environ else home) / "shared"
    home.mkdir(exist_ok=True)
    folder, made = home / name, home / f"{name}.made"
    with FileLock(home / f"{name}.lock"):
        if not made.exists():
            with redirect_stdout(StringIO()):
                assert main([*map(str, words), "--out", str(folder)]) == 0
            made.touch()
    return folder
