"""Scenarios as environments of PettingZoo, an agent for each controller of a file; needs the extra `gym`.

    from cortex_dsl.pettingzoo import ScenarioParallelEnv
    env = ScenarioParallelEnv("mine.scn")

Observations, actions and rewards of an agent are those of `Scenario.environment`.
"""

# PettingZoo declares attributes of instances as class annotations.
# pyright: reportIncompatibleVariableOverride=false, reportIncompatibleMethodOverride=false

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from cortex_dsl.api.scenario import Scenario
from cortex_dsl.gym import SEEDS, action_space, bounded, end_of, observation_space, scenario_of
from engine.environment import Episodes
from engine.extras import needed
from engine.tables import Floats

if TYPE_CHECKING:
    from gymnasium import spaces
    from pettingzoo import ParallelEnv
else:
    ParallelEnv = needed("pettingzoo", "environments of PettingZoo need", "gym").ParallelEnv


class ScenarioParallelEnv(ParallelEnv[str, Floats, Floats]):
    """An environment with one scene after another, in which all controllers act at once."""

    metadata: ClassVar[dict[str, Any]] = {"name": "cortexc_scenario_v0", "render_modes": []}

    def __init__(self, scenario: Scenario | str | Path, reward: str = "risk", observe: str = "records") -> None:
        self.scenario, self.render_mode = scenario_of(scenario), None
        program = self.scenario.program
        self.possible_agents = [control.controller for control in program.controls]
        self.agents: list[str] = []
        self.episodes = Episodes(program, 1, self.scenario.config, self.possible_agents, None, reward, observe)
        self._stream = np.random.default_rng()

    def observation_space(self, agent: str) -> "spaces.Box":
        """Return the observation space of an agent."""
        del agent
        return self._spaces[0]

    def action_space(self, agent: str) -> "spaces.Box":
        """Return the action space of an agent."""
        return self._spaces[1][agent]

    @property
    def _spaces(self) -> "tuple[spaces.Box, dict[str, spaces.Box]]":
        if not hasattr(self, "_made"):
            actions = {agent: action_space(self.episodes.control(agent).actions) for agent in self.possible_agents}
            self._made = observation_space(len(self.episodes.observations)), actions
        return self._made

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Floats], dict[str, dict[str, Any]]]:
        """Begin another scene, which the seed decides."""
        del options
        if seed is not None:
            self._stream = np.random.default_rng(seed)
        self.agents = list(self.possible_agents)
        seen = self.episodes.reset(int(self._stream.integers(SEEDS)))
        return self._each([bounded(each)[0] for each in seen]), self._each([{} for _ in seen])

    def step(
        self, actions: dict[str, Floats]
    ) -> tuple[dict[str, Floats], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Let every agent act, and run on to the next decision."""
        given = [np.asarray(actions[agent], dtype=np.float64)[np.newaxis] for agent in self.possible_agents]
        seen, rewards, terminated, truncated = self.episodes.step(given)
        ends = [bool(terminated[0])] * len(seen), [bool(truncated[0])] * len(seen)
        info = end_of(self.episodes.outcomes) if terminated[0] or truncated[0] else {}
        found = (
            self._each([bounded(each)[0] for each in seen]),
            self._each([float(each[0]) for each in rewards]),
            self._each(ends[0]),
            self._each(ends[1]),
            self._each([dict(info) for _ in seen]),
        )
        if terminated[0] or truncated[0]:
            self.agents = []
        return found

    def _each(self, values: list[Any]) -> dict[str, Any]:
        """A value for each agent."""
        return dict(zip(self.possible_agents, values, strict=True))
