"""Instructions that the interpreter executes as one give what they give one by one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cortex_dsl as cx
from benchmarks.agreement import CONSTRUCTS
from engine import batch, host
from engine.driving.blocks import Driver
from engine.host import fuse
from engine.opcodes import FUSIONS, Fused
from engine.outcomes import OUTCOMES
from engine.scenes import Scenes
from engine.vocabulary import EndReason
from tests.laws import share

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = sorted([*EXAMPLES.rglob("*.scn"), *CONSTRUCTS])
HANDLERS = """
param NEAR = Range(5, 30) m
behavior Careful():
    try:
        do FollowLaneBehavior(10 m/s)
    interrupt when withinDistanceToAnyObjs(self, NEAR):
        take SetBrakeAction(0.5)
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 10 m, with behavior Careful()
other = new Car ahead of ego by Range(10, 30) m
terminate when (distance from ego to other) > 60 m
terminate when (distance from other to (0, 0)) > 200 m
"""


def scenes_of(scenario: cx.Scenario) -> Scenes:
    """Valid and invalid scenes, driven if the file has a controller."""
    scenes = scenario.sample(share(40), seed=5)
    if not scenario.program.controls:
        return scenes
    return Driver(lambda seen: 0.1 * np.cos(seen[:, :3]) ** 2).drive(scenario.program, scenes).scenes


def results(scenario: cx.Scenario, scenes: Scenes) -> list[np.ndarray]:
    """All outcomes, and the states of the first valid scenes."""
    outcomes = batch.simulate(scenario.program, scenes, scenario.config.simulation)
    ways = [
        batch.trajectory(scenario.program, scenes, int(row), scenario.config.simulation)
        for row in np.flatnonzero(scenes.valid)[:3]
    ]
    numbers = [np.asarray(getattr(outcomes, row.name)) for row in OUTCOMES]
    return [*numbers, *(way.states for way in ways), *(way.watched for way in ways)]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_results_are_those_of_single_instructions(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = cx.load(file)
    scenes = scenes_of(scenario)
    fused = results(scenario, scenes)
    monkeypatch.setattr(host, "fuse", np.copy)
    for one, other in zip(fused, results(scenario, scenes), strict=True):
        np.testing.assert_array_equal(one, other)


def test_each_sequence_occurs() -> None:
    """The law above is about all of them."""
    programs = [*(cx.load(file).program for file in FILES), cx.compile_text(HANDLERS).program]
    found = {op for program in programs for op in fuse(program.code.step_code)[:, 0].tolist()}
    assert found >= set(Fused)


def test_a_row_keeps_its_operands_and_its_place() -> None:
    """Only the number of the first instruction differs, and only at the beginnings of sequences."""
    code = cx.compile_text(HANDLERS).program.code.step_code
    fused = fuse(code)
    np.testing.assert_array_equal(fused[:, 1:], code[:, 1:])
    for row in np.flatnonzero(fused[:, 0] != code[:, 0]):
        sequence = FUSIONS[Fused(fused[row, 0])]
        assert code[row : row + len(sequence), 0].tolist() == list(sequence)


def test_a_sequence_at_the_end_is_not_cut() -> None:
    """Code shorter than a sequence, or with a part of it at its end, stays as it is."""
    sequence = FUSIONS[Fused.IS_FAR]
    for rows in range(len(sequence)):
        code = np.zeros((rows, 6), dtype=np.int32)
        code[:, 0] = sequence[:rows]
        np.testing.assert_array_equal(fuse(code), code)


@pytest.mark.parametrize("budget", range(1, 30))
def test_the_budget_counts_single_instructions(budget: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A turn ends at the same row, fused or not; below the longest turn every run is stuck."""
    scenario = cx.compile_text(HANDLERS)
    config = replace(scenario.config.simulation, instruction_budget=budget)
    scenes = scenario.sample(5, seed=3)
    fused = batch.simulate(scenario.program, scenes, config)
    monkeypatch.setattr(host, "fuse", np.copy)
    single = batch.simulate(scenario.program, scenes, config)
    np.testing.assert_array_equal(fused.end_reason, single.end_reason)
    np.testing.assert_array_equal(fused.end_rule, single.end_rule)
    first = int(scenario.program.code.rule_segment[0, 0, 0])
    rows = int(scenario.program.code.rule_segment[0, 0, 1]) - first
    if budget < rows:
        assert set(fused.end_reason[scenes.valid].tolist()) == {EndReason.STUCK}
        assert set(fused.end_rule[scenes.valid].tolist()) == {first + budget}


def test_the_table_is_read_when_a_plan_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without sequences, code stays as it is."""
    monkeypatch.setattr(host, "FUSIONS", {})
    code = cx.compile_text(HANDLERS).program.code.step_code
    np.testing.assert_array_equal(fuse(code), code)
