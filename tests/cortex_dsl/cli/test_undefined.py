"""Numbers that do not exist: the message names the place in the file, and never calls it a bug of ours."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cortex_dsl import open_run
from cortex_dsl.report.findings.readable import significant
from engine.vocabulary import EndReason

Command = Callable[..., Any]

ROAD = """map intersection(ways=4, lanes=1)
param W = Range(0, 1)
lane = intersection.incomingLanes[0]
"""


def written(path: Path, text: str) -> Path:
    path.write_text(ROAD + text)
    return path


@pytest.mark.parametrize(
    ("speed", "why"),
    [
        ("sqrt(W - 1)", "it is the square root of -0."),
        ("3 / (W - W)", "it divides by 0"),
        ("log(W - 0.99)", "logarithm of -0"),
    ],
)
def test_a_scene_without_a_number(speed: str, why: str, tmp_path: Path, cortexc: Command) -> None:
    """A property without a value ends with 1, at the operation, with the params that were drawn."""
    path = written(tmp_path / "a.scn", f"ego = new Car in lane.centerline, with speed {speed}\n")
    result = cortexc(path)
    assert result.code == 1
    assert f"a.scn:4:{len('ego = new Car in lane.centerline, with speed ') + 1}: error[SCN691]" in result.said
    assert why in result.said
    assert "it happened with W = 0." in result.said


def test_a_sample_without_a_number(tmp_path: Path, cortexc: Command) -> None:
    """--sample reports the first scene that holds one, as text and as a document."""
    path = written(tmp_path / "a.scn", "ego = new Car in lane.centerline, with speed sqrt(W - 0.9)\n")
    assert "error[SCN691]" in (result := cortexc(path, "--sample", 100)).err
    assert (result.code, result.out) == (1, "")
    result = cortexc(path, "--sample", 100, "--json")
    assert result.code == 1
    assert [d["code"] for d in result.document["diagnostics"]] == ["SCN691"]


@pytest.mark.parametrize("settings", ["", "simulation(fair=True)\n"])
def test_a_sample_beyond_all_bounds(settings: str, tmp_path: Path, cortexc: Command) -> None:
    """An infinite number is none, whatever else the scene is tried for."""
    text = f"{settings}ego = new Car in lane.centerline, with width 1 m / max(floor(9 * W), 0), facing 1 / (W + 1)\n"
    path = written(tmp_path / "a.scn", text)
    result = cortexc(path, "--sample", 100, "--json")
    assert result.code == 1
    assert [d["code"] for d in result.document["diagnostics"]] == ["SCN691"]


@pytest.mark.parametrize("engine", ["batch", "world"])
def test_a_run_without_a_number(engine: str, tmp_path: Path, cortexc: Command) -> None:
    """A behavior whose arithmetic fails during the run is named, in both hosts."""
    behaviour = "behavior B():\n    while True:\n        take SetThrottleAction(sqrt(self.speed / 1 m/s - 50))\n"
    path = written(tmp_path / "a.scn", behaviour + "ego = new Car in lane.centerline, with behavior B()\n")
    result = cortexc(path, "--engine", engine)
    assert result.code == 1
    assert "a.scn:6:32: error[SCN691]" in result.said


def test_guarded_arithmetic_is_fine(tmp_path: Path, cortexc: Command) -> None:
    """What the cure advises works: a root kept legal by `max` runs."""
    path = written(tmp_path / "a.scn", "ego = new Car in lane.centerline, with speed sqrt(max(0, W - 0.9))\n")
    result = cortexc(path, "--sample", 100, "--json")
    assert result.document["verdicts"]["error"] == 0


def test_a_search_without_a_number(tmp_path: Path, cortexc: Command) -> None:
    """A search keeps what it found and ends with 1 and the place; nobody is asked to report a bug."""
    path = written(tmp_path / "a.scn", "ego = new Car in lane.centerline, with speed sqrt(W - 0.5)\n")
    result = cortexc(path, "--random", "--generations", 2, "--population", 10, "--out", tmp_path / "run")
    assert result.code == 1
    assert "a.scn:4:46: error[SCN691]" in result.said
    assert "report it" not in result.said + result.out
    assert (tmp_path / "run" / "evaluations.csv").exists()


def test_a_search_by_an_objective_without_a_number(tmp_path: Path, cortexc: Command) -> None:
    """The message gives the params of the first run in which the objective is NaN."""
    ego = "ego = new Car in lane.centerline, with speed 20 m/s * W\n"
    text = f'{ego}expect always sqrt((ego.speed - 10 m/s) / (1 m/s)) < 9 as "root"\nterminate after 1 s\n'
    path = written(tmp_path / "a.scn", text)
    small = ("--generations", 2, "--population", 10, "--out", tmp_path / "run")
    result = cortexc(path, "--random", "--objective", "root", *small)
    assert result.code == 1
    assert "a.scn:5:1: error[SCN496]" in result.said
    evaluations = open_run(tmp_path / "run").record.evaluations
    broken = (evaluations.rollouts.end_reason == EndReason.BROKEN).any(axis=1)
    assert (evaluations.genomes[broken, 0] < 0.5).all()
    assert np.count_nonzero(broken) > 1
    assert f"it happened with W = {significant(float(evaluations.genomes[broken][0, 0]))} = help" in result.said
