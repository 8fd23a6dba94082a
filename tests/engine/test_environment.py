"""Environments: episodes side by side, each the run that the batch host makes of its scene."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from engine import environment as environments
from engine.driving.observations import EGOCENTRIC
from engine.errors import ControllerError
from engine.program import Program
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.streams import StreamKey, key_rows
from engine.tables import Floats, Ints
from engine.vocabulary import EndReason, Method, Verdict
from tests.engine.driving.test_blocks import cruising, scenario_of, split


@pytest.fixture(scope="module")
def scenario() -> cx.Scenario:
    return scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")


def test_an_environment_steps_through_episodes(scenario: cx.Scenario) -> None:
    """A lane that has ended begins its next episode with the next step; rewards come at the end alone."""
    environment = scenario.environment(8)
    seen = environment.reset(seed=3)
    assert seen.shape == (8, len(environment.observations))
    ended = np.zeros(8, dtype=bool)
    episodes = 0
    for _ in range(300):
        step = environment.step(cruising(seen))
        ended = step.terminated | step.truncated
        assert (step.rewards[~ended] == 0.0).all()
        assert np.isfinite(step.observations).all()
        if ended.any():
            reasons = environment.outcomes.end_reason[ended]
            assert (step.truncated[ended] == (reasons == EndReason.TIMEOUT)).all()
            score = scenario.assess(environment.outcomes).score[ended]
            assert np.array_equal(step.rewards[ended], -np.maximum(score, 0))
        episodes += int(ended.sum())
        seen = step.observations
    assert episodes > 8


def test_an_episode_is_the_run_of_its_scene(scenario: cx.Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first episodes are the scenes of `sample`, and what becomes of them is what the batch host says."""
    split(monkeypatch)
    environment = scenario.environment(16, jobs=2)
    seen = environment.reset(seed=9)
    drawn = scenario.sample(16, seed=9)
    valid = drawn.valid
    assert np.array_equal(environment.scenes.genomes[valid], drawn.genomes[valid])
    first = None
    for _ in range(400):
        seen = environment.step(cruising(seen)).observations
        done = environment.outcomes.end_reason >= 0
        if done.any():
            first = int(np.flatnonzero(done)[0])
            break
    assert first is not None
    again = scenario.simulate(environment.scenes)
    assert again.end_reason[first] == environment.outcomes.end_reason[first]
    assert again.steps[first] == environment.outcomes.steps[first]
    assert np.array_equal(again.min_distance[first], environment.outcomes.min_distance[first])


def test_scenes_that_were_asked_for_stay_as_they_are(scenario: cx.Scenario) -> None:
    """The next episode, which begins in the lane, has its own."""
    environment = scenario.environment(1)
    step = environment.step(cruising(environment.reset(seed=9)))
    while not (step.terminated[0] or step.truncated[0]):
        step = environment.step(cruising(step.observations))
    kept, outcomes = environment.scenes, environment.outcomes
    environment.step(cruising(step.observations))
    assert not np.array_equal(kept.genomes, environment.scenes.genomes)
    assert scenario.simulate(kept).steps[0] == outcomes.steps[0]


def test_a_seed_gives_the_same_episodes(scenario: cx.Scenario) -> None:
    """Whatever other lanes there are, and after another reset."""
    few, many = scenario.environment(2), scenario.environment(5)
    one = few.reset(seed=2)
    assert np.array_equal(one, many.reset(seed=2)[:2])
    few.step(cruising(one))
    assert np.array_equal(one, few.reset(seed=2))


def test_records_are_observed_and_rewarded() -> None:
    """What the file records is what is observed; a record called reward is what each step brings."""
    text = """
ego = new Car on road, with speed 5 m/s, with behavior ExternalBehavior()
record ego.speed as "speed"
record 2 * ego.speed as "reward"
terminate after 2 s
"""
    scenario = cx.compile_text(text)
    environment = scenario.environment(3)
    assert environment.observations == (("speed", "m/s"),)
    seen = environment.reset()
    assert seen[:, 0].tolist() == [5.0] * 3
    step = environment.step(np.tile([1.0, 0.0, 0.0], (3, 1)))
    assert step.rewards == pytest.approx(2.0 * (step.observations[:, 0] - 5.0))
    assert (step.rewards > 0.0).all()


@pytest.mark.parametrize("more", ['record ego.speed as "speed"', ""])
@pytest.mark.parametrize("observe", ["records", "egocentric"])
def test_a_reward_is_no_observation(more: str, observe: str) -> None:
    """Neither of an environment nor of a driver, who was perhaps trained in one; it is paid whatever is observed."""
    text = f"""
ego = new Car on road, with speed 5 m/s, with behavior ExternalBehavior()
record 2 * ego.speed as "reward"
{more}
terminate after 1 s
"""
    scenario, widths = cx.compile_text(text), set[int]()
    environment = scenario.environment(2, observe=observe)
    wide = 1 if more and observe == "records" else len(EGOCENTRIC)
    assert environment.reset(seed=1).shape == (2, wide)
    assert (environment.step(np.tile([1.0, 0.0, 0.0], (2, 1))).rewards > 0.0).all()

    def drive(seen: Floats) -> Floats:
        widths.add(seen.shape[1])
        return np.zeros((len(seen), 3))

    scenario.driven_by(drive).sample(2, seed=1)
    assert widths == {1 if more else len(EGOCENTRIC)}


def test_an_adversary_gets_what_a_search_seeks() -> None:
    """Who is not the ego is paid for what the ego is to avoid."""
    text = Path("examples/left_turn.scn").read_text(encoding="utf-8")
    external = "ExternalBehavior(trajectory=advTrajectory)"
    found = text.replace("FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=advTrajectory)", external)
    scenario = cx.compile_text(found)
    environment = scenario.environment(8)
    assert scenario.program.controls[0].controller == "adversary"
    seen = environment.reset(seed=1)
    paid = np.zeros(8)
    for _ in range(200):
        step = environment.step(cruising(seen))
        seen, paid = step.observations, paid + step.rewards
    assert (paid >= 0.0).all()
    assert paid.sum() > 0.0


def test_who_drives_a_scenario_drives_in_its_environments(scenario: cx.Scenario) -> None:
    """Beside the agent, whoever that is; an agent has no other driver."""
    duel = cx.compile_text(
        "ego = new Car on road, with behavior ExternalBehavior()\n"
        'lead = new Car ahead of ego by 20 m, with behavior ExternalBehavior("lead")\nterminate after 1 s\n'
    ).driven_by({"ego": cruising, "lead": cruising})
    for agent in ("", "ego", "lead"):
        arena = duel.environment(2, controller=agent)
        assert arena.step(cruising(arena.reset(seed=1))).observations.shape == (2, len(EGOCENTRIC))
    assert len(scenario.driven_by(cruising).environment(2)) == 2
    with pytest.raises(cx.CortexError, match="`lead` decides step by step, and has a driver in `others`"):
        duel.environment(2, controller="lead", others={"lead": cruising, "ego": cruising})


def test_what_is_asked_of_an_environment_is_checked(scenario: cx.Scenario) -> None:
    environment = scenario.environment(2)
    with pytest.raises(cx.CortexError, match="nothing has begun yet"):
        environment.step(np.zeros((2, 3)))
    environment.reset()
    with pytest.raises(ControllerError, match=r"shape \(2, 1\); expected \(2, 3\)"):
        environment.step(np.zeros((2, 1)))
    with pytest.raises(ControllerError, match="gave complex numbers"):
        environment.step(np.zeros((2, 3), dtype=complex))
    with pytest.raises(cx.CortexError, match="seed: expected a whole number, got None"):
        environment.reset(seed=None)  # type: ignore[arg-type]
    with pytest.raises(ControllerError, match="throttle = nan, in slot 1 at 0"):
        environment.step(np.ma.masked_array(np.zeros((2, 3)), [[False] * 3, [True, False, False]]))
    with pytest.raises(cx.CortexError, match="seed: expected 0 or more, got -1"):
        environment.reset(seed=-1)
    with pytest.raises(cx.CortexError, match=r"1,000,000,000,000 scenes side by side need [\d,]+ bytes"):
        scenario.environment(10**12)
    with pytest.raises(cx.CortexError, match="has no controller `eg`"):
        scenario.environment(1, controller="eg")
    with pytest.raises(cx.CortexError, match=r"nobody in .* is driven from outside"):
        cx.load("examples/left_turn.scn").environment(1)


def test_an_environment_tells_its_memory(scenario: cx.Scenario) -> None:
    """Which grows with the lanes, and with the longest run; with what a formula asks it does not."""
    few, some, many = (scenario.environment(lanes).nbytes for lanes in (4, 8, 256))
    assert many - few == 63 * (some - few) > 0
    assert "MB" in repr(scenario.environment(4))
    environment = scenario.environment(256)
    seen = environment.reset(seed=1)
    for _ in range(200):
        seen = environment.step(cruising(seen)).observations
    assert many < environment.nbytes < 256 * 8000


HALF = """
param SPEED = Range(5, 15) m/s
require SPEED > 8 m/s
ego = new Car on road, with speed SPEED, with behavior ExternalBehavior()
terminate after 0.3 s
"""


def test_scenes_drawn_ahead_are_those_of_their_lane_and_episode() -> None:
    """Whenever they are drawn: as each drawn alone, of which a third has no valid scene and is passed over."""
    scenario = cx.compile_text(HALF)
    environment = scenario.environment(5)
    for seed in (1, 2):
        environment.reset(seed=seed)
        begun = [[speed] for speed in environment.scenes.genomes[:, 0].tolist()]
        for _ in range(60):
            environment.step(np.zeros((5, 3)))
            for lane, speed in enumerate(environment.scenes.genomes[:, 0].tolist()):
                if speed != begun[lane][-1]:
                    begun[lane].append(speed)
        for lane in range(5):
            keys = key_rows(seed, Method.SAMPLE, 0, 0, np.full(40, lane))
            keys[:, StreamKey._fields.index("generation")] = np.arange(40)
            drawn = sample(scenario.program, draw_genomes(scenario.program.space, keys), keys)
            known = drawn.genomes[drawn.valid, 0]
            assert len(begun[lane]) > 5
            assert begun[lane] == known[: len(begun[lane])].tolist()


def test_a_lane_without_a_scene_stops_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is told when that lane has to begin; until then the others have the scenes that they would have had."""
    scenario = cx.compile_text(HALF)
    environment = scenario.environment(3)
    whole = environments.sample

    def without(program: Program, genomes: Floats, keys: Ints, *rest: Any) -> Scenes:
        drawn = whole(program, genomes, keys, *rest)
        lost = (keys[:, StreamKey._fields.index("index")] == 2) & (keys[:, StreamKey._fields.index("generation")] > 3)
        return replace(drawn, verdict=np.where(lost, int(Verdict.EXHAUSTED), drawn.verdict).astype(np.int32))

    undisturbed = scenario.environment(3)
    undisturbed.reset(seed=1)
    for lanes in ([0], [0, 1]):
        undisturbed.episodes._begin(np.array(lanes))
    monkeypatch.setattr(environments, "sample", without)
    environment.reset(seed=1)
    environment.episodes._episode[2] = 3
    environment.episodes._begin(np.array([0]))
    with pytest.raises(cx.CortexError, match="slot 2 has no valid scene in 100 episodes"):
        environment.episodes._begin(np.array([0, 2]))
    environment.episodes._begin(np.array([0, 1]))
    assert np.array_equal(environment.scenes.keys[:2], undisturbed.scenes.keys[:2])
