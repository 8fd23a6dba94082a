"""One case of a search, run again from its genome and stream key: what a page, a film or a terminal shows of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cortex_dsl.api.arguments import Held, held_params
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.page.drawing import Frame, Shape, shapes, way_of
from cortex_dsl.page.replay import Approach, approach
from cortex_dsl.report.aftermath import aftermath
from cortex_dsl.report.motion import speeds
from cortex_dsl.report.speeds import SpeedUnit, speed_unit
from cortex_dsl.report.story import Moment, in_order, tell
from engine.metrics import Metric, measure_impacts, measure_trajectory, scored_samples
from engine.outcomes import Outcomes
from engine.program import Program
from engine.road import build_network, outline
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory, actor_columns
from engine.tables import Floats
from engine.vocabulary import Column, Verdict
from engine.world.impacts import Impact


@dataclass(frozen=True)
class ToldCase:
    """Row 0 of its scenes, with everything that was seen when it ran in the world host."""

    program: Program
    scenes: Scenes
    outcomes: Outcomes
    trajectory: Trajectory
    impacts: Sequence[Impact]
    road: Outline
    score: int
    parts: tuple[int, ...]
    pair: int
    """The pair (ego, pair + 1) that decides the risk; 0 where there is none."""
    files: Mapping[str, str]
    """The case as a scenario of its own: texts by name, the main one first."""
    held: Sequence[Held] = ()
    """Params that were held fixed."""

    @cached_property
    def shapes(self) -> list[Shape]:
        return shapes(self.program, self.trajectory)

    @cached_property
    def moments(self) -> list[Moment]:
        told = tell(self.program, self.outcomes, self.trajectory, 0, self.pair, self.unit)
        return in_order([*told, *aftermath(self.program, self.impacts, self.trajectory)])

    @cached_property
    def unit(self) -> SpeedUnit:
        """Of speeds, as people read them."""
        return speed_unit(self.program)

    @cached_property
    def speeds(self) -> Floats:
        """(samples, actors) [m/s], after contact those of free bodies."""
        return speeds(self.trajectory)

    @cached_property
    def metrics(self) -> tuple[Metric, ...]:
        """Of a valid run."""
        if int(self.outcomes.verdict[0]) != Verdict.VALID:
            return ()
        driven = measure_trajectory(self.trajectory, self.outcomes, rear_to_center=self._rear_to_center)
        return (*driven, *measure_impacts(self.impacts))

    @cached_property
    def approach(self) -> Approach:
        return approach(self.trajectory, self.pair + 1, self._rear_to_center)

    @cached_property
    def _rear_to_center(self) -> list[float]:
        return actor_columns(self.program, self.scenes.values[0])[:, Column.REAR_TO_CENTER].tolist()

    @cached_property
    def ways(self) -> list[Floats]:
        """Where each actor drove until the scored run was over."""
        scored = self.scored
        return [way_of(scored, actor) for actor in range(len(self.program.actors))]

    @cached_property
    def scored(self) -> Trajectory:
        """The run without what follows contact."""
        end = scored_samples(self.trajectory)
        now = self.trajectory
        return Trajectory(now.time[:end], now.states[:end], now.outlines, now.contact_sample)

    @property
    def collided(self) -> bool:
        """Whether any two touched."""
        return self.trajectory.contact_sample >= 0

    @property
    def key_time(self) -> float:
        """When it was worst: contact, or the closest approach of the deciding pair [s]."""
        if self.collided or not self.outcomes.min_distance.shape[1]:
            return float(self.outcomes.end_time[0])
        time = float(self.outcomes.min_distance_time[0, self.pair])
        return time if np.isfinite(time) else 0.0

    @property
    def key_sample(self) -> int:
        """The sample nearest to the key moment."""
        return int(np.abs(self.trajectory.time - self.key_time).argmin())

    @property
    def contact_point(self) -> tuple[float, float] | None:
        """Where bodies first met [m]."""
        return self.impacts[0].point if self.impacts else None

    @property
    def frame(self) -> Frame:
        """The part of the world in which it all happens."""
        ways = [way_of(self.trajectory, actor) for actor in range(len(self.program.actors))]
        points = [way for way in ways if len(way)]
        return Frame.around(np.concatenate(points) if points else np.zeros((1, 2)))


def tell_case(
    scenario: Scenario, scenes: Scenes, profile: str = "paper", remark: str = "", name: str = "case.scn"
) -> ToldCase:
    """Run row 0 of the scenes, which must be valid, and keep what was seen."""
    run = scenario.watch(scenes)
    risk = scenario.assess(run.outcomes, profile)
    return ToldCase(
        program=scenario.program,
        scenes=scenes,
        outcomes=run.outcomes,
        trajectory=run.trajectory,
        impacts=run.impacts,
        road=outline(build_network(scenario.program.road_spec)),
        score=int(risk.score[0]),
        parts=tuple(risk.parts[0].tolist()),
        pair=max(0, int(risk.pair[0])),
        files=scenario.concrete_files(scenes, remark=remark, name=name),
        held=held_params(scenario.compiled.module, scenario.overrides),
    )
