"""Scenarios as environments of Gymnasium; needs the extra `gym`.

    import gymnasium
    env = gymnasium.make("cortex_dsl.gym:cortexc/Scenario-v0", scenario="mine.scn")
    many = gymnasium.make_vec("cortex_dsl.gym:cortexc/Scenario-v0", num_envs=1024, scenario="mine.scn")

Observations, actions and rewards are those of `Scenario.environment`, and its other arguments may be given too. Lanes
begin their next episode by the step after the end of an episode (Gymnasium's NEXT_STEP). At an end `info` has the
result of the run: `collided`, `end` and `verdict`, as in `evaluations.csv`.
"""

# The classes of this extra's packages declare attributes of instances as class annotations.
# pyright: reportIncompatibleVariableOverride=false, reportIncompatibleMethodOverride=false
# pyright: reportAttributeAccessIssue=false

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from cortex_dsl.api.scenario import Scenario, load
from engine.extras import needed

if TYPE_CHECKING:
    import gymnasium
    from gymnasium import spaces, vector
else:
    gymnasium = needed("gymnasium", "environments of Gymnasium need", "gym")
    spaces, vector = gymnasium.spaces, gymnasium.vector

from numpy.typing import NDArray

from cortex_dsl.report.picture import Painter
from engine.control import Action
from engine.errors import ArgumentError
from engine.host import outlines
from engine.outcomes import Outcomes
from engine.road import build_network
from engine.road.outline import outline
from engine.tables import Bools, Floats
from engine.vocabulary import EndReason, Verdict

ID = "cortexc/Scenario-v0"
FARTHEST = 1e9
"""Largest magnitude of an observation: Gymnasium requires a bound."""
SEEDS = 2**31


def action_space(actions: tuple[Action, ...]) -> "spaces.Box":
    """The numbers that are decided, in their units."""
    return spaces.Box(np.array([a.low for a in actions]), np.array([a.high for a in actions]), dtype=np.float64)


def observation_space(count: int) -> "spaces.Box":
    """Return the space of `count` observed numbers."""
    return spaces.Box(-FARTHEST, FARTHEST, (count,), dtype=np.float64)


def bounded(observations: Floats) -> Floats:
    """Return the observations clipped to their space, with 0 for NaN."""
    return np.clip(np.nan_to_num(observations), -FARTHEST, FARTHEST)


def ends_of(outcomes: Outcomes, ended: Bools) -> dict[str, Any]:
    """Return the results of runs that have just ended, in Gymnasium's form for vector environments.

    Arrays are (n,); for each key, `_` and the key is a mask of valid entries.
    """
    words = {
        "end": [EndReason(int(reason)).name.lower() if reason >= 0 else "" for reason in outcomes.end_reason],
        "verdict": [Verdict(int(verdict)).name.lower() for verdict in outcomes.verdict],
    }
    columns = {"collided": outcomes.collided, **{name: np.array(each, dtype=object) for name, each in words.items()}}
    return columns | {f"_{name}": ended for name in columns}


def end_of(outcomes: Outcomes) -> dict[str, Any]:
    """Return the results of the only lane, whose run has ended."""
    columns = ends_of(outcomes, np.ones(1, dtype=bool))
    return {name: each.tolist()[0] for name, each in columns.items() if not name.startswith("_")}


def scenario_of(scenario: "Scenario | str | Path") -> Scenario:
    """Return a scenario that is given itself, or by its file."""
    return scenario if isinstance(scenario, Scenario) else load(scenario)


class ScenarioEnv(gymnasium.Env[Floats, Floats]):
    """An environment with one scene after another."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, scenario: Scenario | str | Path, render_mode: str | None = None, **how: Any) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ArgumentError(f"render_mode is {render_mode!r}", 'take "rgb_array", or leave it out')
        self.render_mode = render_mode
        self.environment = scenario_of(scenario).environment(1, **how)
        self._painter: Painter | None = None
        every = min(control.every for control in self.environment.episodes.program.controls)
        step = max(every, self.environment.episodes.config.simulation.time_step)
        self.metadata = self.metadata | {"render_fps": max(1, round(1.0 / step))}
        self.action_space = action_space(self.environment.actions)
        self.observation_space = observation_space(len(self.environment.observations))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin another scene, which the seed decides."""
        super().reset(seed=seed, options=options)
        return bounded(self.environment.reset(int(self.np_random.integers(SEEDS))))[0], {}

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Do the actions, and run on to the next decision."""
        step = self.environment.step(np.asarray(action, dtype=np.float64)[np.newaxis])
        seen, ended = bounded(step.observations)[0], bool(step.terminated[0] or step.truncated[0])
        info = end_of(self.environment.outcomes) if ended else {}
        return seen, float(step.rewards[0]), bool(step.terminated[0]), bool(step.truncated[0]), info

    def render(self) -> "NDArray[np.uint8] | None":
        """Return the pixels of this moment from above, (height, width, 3); None without a `render_mode`.

        Raises MissingExtraError: Pillow is not installed.
        """
        if self.render_mode is None:
            return None
        program = self.environment.episodes.program
        if self._painter is None:
            self._painter = Painter(outline(build_network(program.road_spec)))
        sizes = outlines(program, self.environment.scenes.values[0])
        return self._painter.picture(self.environment.states[0], sizes)


class ScenarioVectorEnv(vector.VectorEnv[Floats, Floats, Bools]):
    """Many scenes side by side, on one kernel."""

    metadata: ClassVar[dict[str, Any]] = {"autoreset_mode": vector.AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(self, num_envs: int = 1, scenario: Scenario | str | Path = "", **how: Any) -> None:
        self.num_envs = num_envs
        self.environment = scenario_of(scenario).environment(num_envs, **how)
        self.single_action_space = action_space(self.environment.actions)
        self.single_observation_space = observation_space(len(self.environment.observations))
        self.action_space = vector.utils.batch_space(self.single_action_space, num_envs)
        self.observation_space = vector.utils.batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin the first episodes of a seed, or of one seed per lane, which is then the environment of its seed."""
        if isinstance(seed, Sequence):
            drawn = [int(gymnasium.utils.seeding.np_random(each)[0].integers(SEEDS)) for each in seed]
            return bounded(self.environment.reset(drawn)), {}
        super().reset(seed=seed, options=options)
        return bounded(self.environment.reset(int(self.np_random.integers(SEEDS)))), {}

    def step(self, actions: Floats) -> tuple[Floats, Floats, Bools, Bools, dict[str, Any]]:
        """Do the actions in all lanes, and run on to the next decision."""
        step = self.environment.step(actions)
        ended = step.terminated | step.truncated
        info = ends_of(self.environment.outcomes, ended) if ended.any() else {}
        return bounded(step.observations), step.rewards, step.terminated, step.truncated, info


def register() -> None:
    """Make the environment known to Gymnasium by its id."""
    gymnasium.register(ID, entry_point=ScenarioEnv, vector_entry_point=ScenarioVectorEnv)


register()
