"""Train an adversary against a driver by reinforcement learning: PPO of Stable-Baselines3.

    python -m pip install stable-baselines3
    python train_adversary.py [STEPS] [SEED ...]

The car that turns left is an agent, which chooses its speed ten times a second; `planner.py` drives the ego. At the end
of an episode the agent is paid what a search looks for, the risk. It is compared with speeds drawn at random in as many
steps: by what its episodes bring while it learns, and afterwards.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
from planner import drive
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

import cortex_dsl as cx
from cortex_dsl.gym import ScenarioEnv

HERE = Path(__file__).parent
SIDE_BY_SIDE = 8
FASTEST = 20.0
"""[m/s]"""
EPISODES = 200
PATIENCE = 0.999
"""Discount of a step: what an episode brings comes at its end."""


def scenario() -> cx.Scenario:
    """The crossing, with the adversary driven from outside as well."""
    text = (HERE / "crossing.scn").read_text(encoding="utf-8")
    text = text.replace(
        "FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=turn)",
        'ExternalBehavior(trajectory=turn, actions="speed", every=0.1 s)',
    )
    return cx.compile_text(text, name="duel.scn")


class Duel(gymnasium.ActionWrapper):
    """One number from -1 to 1 is a speed from 0 to `FASTEST`; the agent keeps to its path."""

    def __init__(self, duel: cx.Scenario) -> None:
        super().__init__(ScenarioEnv(duel, controller="adversary", others={"ego": drive}))
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), dtype=np.float32)

    def action(self, action: np.ndarray) -> np.ndarray:
        return np.array([0.5 * FASTEST * (1.0 + float(np.clip(action[0], -1.0, 1.0))), 0.0])


def paid(
    env: gymnasium.Env, act: Callable[[np.ndarray], np.ndarray], seed: int, steps: int = 0, count: int = 0
) -> list:
    """What each episode brings: of `count`, or of as many as `steps` hold."""
    brought, total, taken = [], 0.0, 0
    seen, _ = env.reset(seed=seed)
    while taken < steps or len(brought) < count:
        seen, reward, terminated, truncated, _ = env.step(act(seen))
        total, taken = total + float(reward), taken + 1
        if terminated or truncated:
            brought.append(total)
            total, (seen, _) = 0.0, env.reset()
    return brought


def compared(duel: cx.Scenario, seed: int, steps: int) -> str:
    """Train one, and hold it against chance."""
    many = make_vec_env(lambda: Duel(duel), SIDE_BY_SIDE, seed=seed)
    scaled = VecNormalize(many, gamma=PATIENCE)
    model = PPO(
        "MlpPolicy", scaled, n_steps=512, batch_size=256, gamma=PATIENCE, gae_lambda=0.98, seed=seed, device="cpu"
    )
    model.learn(steps)
    learning = [each for episodes in many.get_attr("episode_returns") for each in episodes]
    scaled.training = False
    stream, one = np.random.default_rng(seed), Duel(duel)

    def trained(seen: np.ndarray) -> np.ndarray:
        return model.predict(scaled.normalize_obs(seen))[0]

    afterwards = paid(one, trained, seed, count=EPISODES)
    blind = paid(one, lambda _: stream.uniform(-1.0, 1.0, 1), seed, steps=steps)
    return (
        f"seed {seed}, {steps:,} steps: an episode brings {np.mean(learning):.2f} while learning,"
        f" {np.mean(afterwards):.2f} afterwards, {np.mean(blind):.2f} at random\n"
    )


def main(steps: int = 50_000, *seeds: int) -> None:
    """For each seed a line."""
    duel = scenario()
    check_env(Duel(duel))
    for seed in seeds or (1, 2, 3):
        sys.stdout.write(compared(duel, seed, steps))
        sys.stdout.flush()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
