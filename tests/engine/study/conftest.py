"""Tiny studies of two real scenarios."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from cortex_dsl import load
from engine.study.database import Study, StudyStore, read_study
from engine.study.execution import perform_all
from engine.study.plan import Plan, Subject, with_own_seeds

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="session")
def subjects() -> tuple[Subject, ...]:
    """Two of the paper's scenarios, with four generations of twelve."""
    found = []
    for name in ("left_turn", "right_into_crossing"):
        scenario = load(EXAMPLES / f"{name}.scn")
        search = replace(scenario.config.search, generations=4, population=12, seed=5)
        found.append(Subject(name, f"{name}.scn", scenario.program, replace(scenario.config, search=search)))
    return with_own_seeds(found)


@pytest.fixture(scope="session")
def plan(subjects: tuple[Subject, ...]) -> Plan:
    return Plan(subjects, ("random", "ga"), runs=3)


@pytest.fixture(scope="session")
def carry_out() -> Callable[..., Study]:
    """Do a whole plan in a folder, and read it back."""

    def carry(plan: Plan, folder: Path, jobs: int = 1) -> Study:
        folder.mkdir(parents=True, exist_ok=True)
        store = StudyStore.create(folder, plan, {"engine": "test"})
        perform_all(plan, store.write, jobs)
        store.close()
        return read_study(folder)

    return carry


@pytest.fixture(scope="session")
def study(plan: Plan, carry_out: Callable[..., Study], tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The tiny study, complete."""
    return carry_out(plan, tmp_path_factory.mktemp("study"))
