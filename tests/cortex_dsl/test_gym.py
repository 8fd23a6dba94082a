"""Environments of Gymnasium and PettingZoo pass the checks that those packages bring for them."""

import sys
from pathlib import Path
from types import ModuleType

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test

import cortex_dsl as cx
from cortex_dsl.gym import ID, ScenarioEnv, ScenarioVectorEnv
from cortex_dsl.pettingzoo import ScenarioParallelEnv

TEXT = """
param SPEED = Range(5, 15) m/s
ego = new Car on road, with speed SPEED, with behavior ExternalBehavior(every=0.1 s)
other = new Car on road, with behavior ExternalBehavior(actions="speed", every=0.1 s)
terminate after 1 s
"""


@pytest.fixture(scope="module")
def scenario() -> cx.Scenario:
    return cx.compile_text(TEXT)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.scn"
    path.write_text(TEXT.replace("ExternalBehavior(actions", "ConstantSpeedBehavior(9) #"), encoding="utf-8")
    return path


def standing(seen: np.ndarray) -> np.ndarray:
    return np.zeros((len(seen), 2))


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasium_finds_nothing(scenario: cx.Scenario) -> None:
    """Gymnasium's own checker."""
    check_env(ScenarioEnv(scenario, others={"other": standing}))


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_pictures_show_who_moves(scenario: cx.Scenario) -> None:
    """With the ego in the middle: two moments differ, Gymnasium's checker and its recorder of frames take them."""
    env = gymnasium.wrappers.RenderCollection(
        ScenarioEnv(scenario, render_mode="rgb_array", others={"other": standing}), pop_frames=False
    )
    env.reset(seed=1)
    for _ in range(3):
        env.step(np.array([1.0, 0.0, 0.0]))
    frames = [np.asarray(frame) for frame in env.render() or ()]
    assert {(frame.shape, frame.dtype.name) for frame in frames} == {((480, 640, 3), "uint8")}
    assert frames[0][240, 320].tolist() == frames[-1][240, 320].tolist() == [31, 111, 235]
    assert (frames[0] != frames[-1]).any()
    check_env(ScenarioEnv(scenario, render_mode="rgb_array", others={"other": standing}))
    assert ScenarioEnv(scenario, others={"other": standing}).render() is None
    with pytest.raises(cx.CortexError, match="render_mode is 'human'"):
        ScenarioEnv(scenario, render_mode="human")


def test_a_video_has_a_frame_for_each_step(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`RecordVideo` of an episode by the id: a frame at the reset and after each step, as many a second as decisions;
    in the place of moviepy, which only writes the file.
    """
    written: list[tuple[int, int]] = []

    class Clip:
        def __init__(self, frames: list[np.ndarray], fps: int) -> None:
            assert {frame.shape for frame in frames} == {(480, 640, 3)}
            written.append((len(frames), fps))

        def write_videofile(self, path: str, **_: object) -> None:
            Path(path).touch()

    names = ("moviepy", "moviepy.video", "moviepy.video.io", "moviepy.video.io.ImageSequenceClip")
    for name in names:
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setattr(sys.modules[names[-1]], "ImageSequenceClip", Clip, raising=False)
    env = gymnasium.make(f"cortex_dsl.gym:{ID}", scenario=str(file), render_mode="rgb_array")
    video = gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda _: True)
    video.reset(seed=3)
    steps, ended = 0, False
    while not ended:
        _, _, terminated, truncated, _ = video.step(np.zeros(3))
        steps, ended = steps + 1, terminated or truncated
    video.close()
    assert written == [(steps + 1, 10)]
    assert [path.suffix for path in (tmp_path / "videos").iterdir()] == [".mp4"]


def test_ids_are_registered(file: Path) -> None:
    """One environment, and many on one kernel, by the id."""
    env = gymnasium.make(f"cortex_dsl.gym:{ID}", scenario=file)
    seen, _ = env.reset(seed=1)
    assert env.observation_space.contains(seen)
    env.close()
    many = gymnasium.make_vec(ID, num_envs=3, scenario=file)
    seen, _ = many.reset(seed=1)
    assert seen.shape == (3, *(many.single_observation_space.shape or ()))
    ended = 0
    for _ in range(30):
        seen, rewards, terminated, truncated, _ = many.step(np.zeros((3, 3)))
        assert rewards.shape == (3,)
        ended += int((terminated | truncated).sum())
    assert ended >= 3
    many.close()


def test_info_says_how_a_run_ended(scenario: cx.Scenario) -> None:
    """Of one, of lanes side by side, where they have ended, and of each agent."""
    one = ScenarioEnv(scenario, others={"other": standing})
    one.reset(seed=5)
    while not (step := one.step(np.zeros(3)))[3]:
        assert step[4] == {}
    assert step[4] == {"collided": False, "end": "timeout", "verdict": "valid"}
    many = ScenarioVectorEnv(4, scenario, others={"other": standing})
    many.reset(seed=5)
    while not (step := many.step(np.zeros((4, 3))))[3].any():
        assert step[4] == {}
    info = step[4]
    assert np.array_equal(info["_end"], step[2] | step[3])
    assert info["end"][info["_end"]].tolist() == ["timeout"] * int(info["_end"].sum())
    agents = ScenarioParallelEnv(scenario)
    agents.reset(seed=5)
    while agents.agents:
        *_, info = agents.step({"ego": np.zeros(3), "other": np.zeros(2)})
    assert info["ego"]["end"] == info["other"]["end"] == "timeout"


def test_lanes_are_single_environments(scenario: cx.Scenario) -> None:
    """The first lane of many does what one alone does."""
    one = ScenarioVectorEnv(1, scenario, others={"other": standing})
    many = ScenarioVectorEnv(4, scenario, others={"other": standing})
    assert np.array_equal(one.reset(seed=5)[0][0], many.reset(seed=5)[0][0])
    for _ in range(15):
        alone, among = one.step(np.full((1, 3), 0.1)), many.step(np.full((4, 3), 0.1))
        assert np.array_equal(alone[0][0], among[0][0])
        assert [each[0] for each in alone[1:4]] == [each[0] for each in among[1:4]]


def test_pettingzoo_finds_nothing(scenario: cx.Scenario) -> None:
    """PettingZoo's own checker."""
    env = ScenarioParallelEnv(scenario)
    assert env.possible_agents == ["ego", "other"]
    parallel_api_test(env, num_cycles=40)


def test_lanes_with_seeds_of_their_own(scenario: cx.Scenario) -> None:
    """Lane i is the single environment of its seed, in its first and its next episodes; a wrong number is refused."""
    seeds = [1, 2, 1, 77]
    many = ScenarioVectorEnv(len(seeds), scenario, others={"other": standing})
    ones = [ScenarioEnv(scenario, others={"other": standing}) for _ in seeds]
    seen, _ = many.reset(seed=seeds)
    alone = [env.reset(seed=seed)[0] for env, seed in zip(ones, seeds, strict=True)]
    np.testing.assert_array_equal(seen, alone)
    assert (seen[0] == seen[2]).all()
    assert (seen[0] != seen[1]).any()
    wide = len(many.environment.actions)
    for _ in range(15):
        seen, rewards, terminated, truncated, _ = many.step(np.zeros((len(seeds), wide)))
        steps = [env.step(np.zeros(wide)) for env in ones]
        for lane, (one, reward, ended, late, _) in enumerate(steps):
            np.testing.assert_array_equal(seen[lane], one)
            assert (rewards[lane], terminated[lane], truncated[lane]) == (reward, ended, late)
    with pytest.raises(cx.CortexError, match="2 seeds for 4 slots"):
        many.reset(seed=[1, 2])
