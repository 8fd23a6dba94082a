"""One small search, and its worst case with everything that is exported of it."""

from pathlib import Path

import pytest

from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.cli import main
from cortex_dsl.interchange.cases import ExportCase, case_of_run

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"


@pytest.fixture(scope="session")
def left_turn_run(tmp_path_factory: pytest.TempPathFactory) -> OpenedRun:
    """A finished search of 5 generations of 30."""
    folder = tmp_path_factory.mktemp("exports") / "run"
    words = ["--ga", "--generations", "5", "--population", "30", "--seed", "1", "--out", str(folder), "--json"]
    assert main([str(LEFT_TURN), *words]) == 0
    return open_run(folder)


@pytest.fixture(scope="session")
def worst(left_turn_run: OpenedRun) -> ExportCase:
    """Its worst case, a collision."""
    case = case_of_run(left_turn_run, left_turn_run.every_case()[0])
    assert case.outcomes.collided[0]
    return case
