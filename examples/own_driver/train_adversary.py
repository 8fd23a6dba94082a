"""Train an adversary against a driver by reinforcement learning: PPO of Stable-Baselines3.

    python -m pip install stable-baselines3
    python train_adversary.py [STEPS] [SEED ...]

The car from the side is an agent, which chooses its speed twice a second, in many scenes side by side; `planner.py`
drives the ego. At the end of an episode the agent is paid what a search looks for, the risk. It is compared with speeds
drawn at random in as many steps: by what its episodes bring while it learns, and afterwards.
"""

# What Stable-Baselines3 asks of environments side by side has arguments that are of no use here.
# ruff: noqa: ARG002
# pyright: reportMissingImports=false

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from planner import drive
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

import cortex_dsl as cx
from cortex_dsl.gym import ScenarioEnv

HERE = Path(__file__).parent
SIDE_BY_SIDE = 128
FASTEST = 20.0
"""[m/s]"""
HELD = 5
"""Tenths of a second for which the agent keeps its speed."""
EPISODES = 2_000
PATIENCE = 0.999
"""Discount of a step: what an episode brings comes at its end."""


def scenario() -> cx.Scenario:
    """The crossing, with the adversary driven from outside as well."""
    text = (HERE / "crossing.scn").read_text(encoding="utf-8")
    text = text.replace(
        "FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=across)",
        'ExternalBehavior(trajectory=across, actions="speed", every=0.1 s)',
    )
    return cx.compile_text(text, name="duel.scn")


class Duel(VecEnv):
    """Scenes side by side. One number from -1 to 1 is a speed from 0 to `FASTEST`; the agent keeps to its path."""

    def __init__(self, duel: cx.Scenario, seed: int) -> None:
        self._environment = duel.environment(SIDE_BY_SIDE, controller="adversary", others={"ego": drive})
        count = len(self._environment.observations)
        seen = gymnasium.spaces.Box(-np.inf, np.inf, (count,), dtype=np.float64)
        super().__init__(SIDE_BY_SIDE, seen, gymnasium.spaces.Box(-1.0, 1.0, (1,), dtype=np.float32))
        self._first, self._actions = seed, np.zeros((SIDE_BY_SIDE, 2))
        self.brought: list[float] = []
        """What each episode has brought."""

    def reset(self) -> np.ndarray:
        return self._environment.reset(self._first)

    def step_async(self, actions: np.ndarray) -> None:
        self._actions[:, 0] = 0.5 * FASTEST * (1.0 + np.clip(actions[:, 0], -1.0, 1.0))

    def step_wait(self) -> tuple:
        """A lane that ends begins anew within the step: the old speed is kept until the next."""
        seen, total, done = np.empty(0), np.zeros(SIDE_BY_SIDE), np.zeros(SIDE_BY_SIDE, dtype=bool)
        for _ in range(HELD):
            step = self._environment.step(self._actions)
            seen = step.observations
            ended = step.terminated | step.truncated
            total, done = total + step.rewards, done | ended
            self.brought.extend(step.rewards[ended].tolist())
        return seen, total, done, [{"terminal_observation": each} for each in seen]

    def close(self) -> None:
        pass

    def get_attr(self, attr_name: str, indices: Any = None) -> list:
        return [getattr(self, attr_name, None)] * SIDE_BY_SIDE

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, **kwargs: Any) -> list:
        raise NotImplementedError(method_name)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * SIDE_BY_SIDE


def paid(env: Duel, act: Callable[[np.ndarray], np.ndarray], steps: int = 0, count: int = 0) -> float:
    """What an episode brings: of `count`, or of as many as `steps` hold."""
    seen, taken = env.reset(), 0
    while taken < steps or len(env.brought) < count:
        seen, *_ = env.step(act(seen))
        taken += SIDE_BY_SIDE
    return float(np.mean(env.brought))


def compared(duel: cx.Scenario, seed: int, steps: int) -> str:
    """Train one, and hold it against chance."""
    many = Duel(duel, seed)
    scaled = VecNormalize(many, gamma=PATIENCE)
    model = PPO(
        "MlpPolicy", scaled, n_steps=64, batch_size=1024, learning_rate=1e-3, gamma=PATIENCE, gae_lambda=0.98,
        seed=seed, device="cpu",
    )  # fmt: skip
    model.learn(steps)
    learning = float(np.mean(many.brought))
    scaled.training = False
    stream = np.random.default_rng(seed)

    def trained(seen: np.ndarray) -> np.ndarray:
        return model.predict(scaled.normalize_obs(seen))[0]

    def chance(_: np.ndarray) -> np.ndarray:
        return stream.uniform(-1.0, 1.0, (SIDE_BY_SIDE, 1))

    afterwards = paid(Duel(duel, seed + 1_000), trained, count=EPISODES)
    blind = paid(Duel(duel, seed), chance, steps=steps)
    return (
        f"seed {seed}, {steps:,} steps: an episode brings {learning:.2f} while learning,"
        f" {afterwards:.2f} afterwards, {blind:.2f} at random\n"
    )


def main(steps: int = 200_000, *seeds: int) -> None:
    """For each seed a line."""
    duel = scenario()
    check_env(ScenarioEnv(duel, controller="adversary", others={"ego": drive}))
    for seed in seeds or (1, 2, 3):
        sys.stdout.write(compared(duel, seed, steps))
        sys.stdout.flush()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
