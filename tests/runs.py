"""Folders of runs that many tests read: made once a session, whoever of its workers comes first."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from filelock import FileLock

from cortex_dsl.cli import main

LEFT_TURN = Path(__file__).parents[1] / "examples" / "left_turn.scn"
GENERATIONS, POPULATION = 4, 30
STUDY = ("--runs", 2, "--generations", 3, "--population", 12, "--jobs", 1)
SEARCH = ("--ga", "--generations", GENERATIONS, "--population", POPULATION, "--seed", 1, "--jobs", 1)


@contextmanager
def small_designs() -> Iterator[None]:
    """Pages find out which params matter by a design of at most 500 simulations, where users get one of 20,000, and
    conditions of failures are judged by 400 draws, where users get 2,000.
    """
    from cortex_dsl.report.page import run_page
    from engine.search.insight import clusters

    analyse = run_page.analyse

    def small(program: Any, found: Any, config: Any, profile: str, budget: int, *others: Any) -> Any:
        return analyse(program, found, config, profile, min(budget, 500), *others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_page, "analyse", small)
        patch.setattr(clusters, "BACKGROUND", 400)
        patch.setattr(clusters, "JUDGES", 400)
        yield


def shared(factory: pytest.TempPathFactory, name: str, *words: object, code: int = 0) -> Path:
    """Return the folder that a command wrote to `--out`, ending with `code`; no test may change it."""
    home = factory.getbasetemp()
    home = (home.parent if "PYTEST_XDIST_WORKER" in os.environ else home) / "shared"
    home.mkdir(exist_ok=True)
    folder, made = home / name, home / f"{name}.made"
    with FileLock(home / f"{name}.lock"):
        if not made.exists():
            with redirect_stdout(StringIO()) as said, pytest.MonkeyPatch.context() as patch:
                patch.setenv("COLUMNS", "100")
                assert main([*map(str, words), "--out", str(folder)]) == code
            made.write_text(said.getvalue(), encoding="utf-8")
    return folder


def said_of(folder: Path) -> str:
    """Return what the command printed that made a shared folder."""
    return folder.with_name(f"{folder.name}.made").read_text(encoding="utf-8")
