"""Lanes that scenes drew, beside what came of them."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.semantics import elaboration
from engine.assessment import map_arrays
from engine.outcomes import Assessment
from engine.risk import PROFILES
from engine.scenes import Scenes
from engine.search.evaluator import make_evaluator
from engine.search.insight import analysis
from engine.search.insight.analysis import lane_grids
from engine.tables import Floats
from tests.engine.search.conftest import evaluated

PAIR = """
map intersection(ways=4, lanes=2)
mine = Uniform(*intersection.incomingLanes)
ego = new Car in mine.centerline, with speed 8 m/s, with behavior FollowLaneBehavior(8 m/s)
theirs = Uniform(*intersection.incomingLanes)
new Car in theirs.centerline, with behavior FollowLaneBehavior(6 m/s)
terminate after 4 s
"""


def test_simulations_are_counted_by_the_lanes_of_their_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The counts are those of the scenes when they are drawn again one by one; lanes beyond the most are one row; a
    file whose lanes are variants has no such grid.
    """
    config = compile_text(PAIR).config
    assert lane_grids(compile_text(PAIR).program, evaluated(*_searched(PAIR)[:2]), config) == ()
    monkeypatch.setattr(elaboration, "CHOSEN_LANES_LIMIT", 1)
    scenario = compile_text(PAIR)
    genomes, runs, scenes = _searched(PAIR)
    found = replace(evaluated(genomes, runs), keys=scenes.keys[:, np.newaxis])
    mine, other = lane_grids(scenario.program, found, config)
    assert [mine.name, other.name] == ["mine x side", "theirs x side"]
    valid = np.flatnonzero(found.simulated & found.valid & (runs.side[:, 0] >= 0)).tolist()
    made = Counter(dict(made_choices(scenario.program, scenes, row))["mine"] for row in valid)
    assert dict(zip(mine.first, mine.runs.sum(axis=1).tolist(), strict=True)) == made
    assert mine.failures.sum() == sum(bool(runs.collided[row, 0]) for row in valid) > 0
    monkeypatch.setattr(analysis, "MOST_LANES", 2)
    few, _ = lane_grids(scenario.program, found, config)
    assert len(few.first) == 3
    assert few.first[-1] == f"{len(mine.first) - 2} others"
    assert few.runs.sum() == mine.runs.sum()


def _searched(text: str) -> tuple[Floats, Assessment, Scenes]:
    scenario = compile_text(text)
    scenes = scenario.sample(60, seed=5)
    evaluate = make_evaluator(scenario.program, scenario.config, PROFILES["paper"])
    runs = evaluate(scenes.genomes, scenes.keys)
    return scenes.genomes, map_arrays(runs, lambda array: array[:, np.newaxis]), scenes
