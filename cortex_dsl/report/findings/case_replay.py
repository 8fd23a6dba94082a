"""One case of a search, run again from its genome and stream key: the data of a page, a film or a terminal view.

In addition to the run: the drawing of each actor, and the approach of the deciding pair over time, by the kernels that
measure it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cortex_dsl import ir
from cortex_dsl.lowering.given_out import light_colours
from cortex_dsl.report.findings.framing import Frame, heading_of_road, tracks
from cortex_dsl.report.findings.readable import SpeedUnit, speed_unit
from cortex_dsl.report.findings.run_report import PARTS, events_content, metrics_content, pairs_content, params_content
from cortex_dsl.report.findings.story import Moment, aftermath, in_order, speeds, story_of
from cortex_dsl.semantics.names.linking import FixedParam, held_params
from cortex_dsl.syntax import nodes
from engine.config import Config
from engine.kernels.conflict import Snapshot, snapshot
from engine.kernels.geometry import box_distance
from engine.maps import MapFile
from engine.metrics import (
    Body,
    Metric,
    apart_in_height,
    bodies_of,
    measure_impacts,
    measure_trajectory,
    outlines_of,
    scored_samples,
    span_together,
    time_step,
)
from engine.outcomes import Outcomes
from engine.program import Program
from engine.risk import Risk
from engine.road import build_network
from engine.road.outline import Outline, near, outline
from engine.scenes import Scenes, Trajectory, actor_columns
from engine.search.ranking import Case
from engine.tables import Floats, Ints
from engine.vocabulary import ActorKind, State, Verdict

if TYPE_CHECKING:
    from engine.scenes import Impact
    from engine.search.journal_reader import Record
    from engine.world import WorldRun

COLOURS = 6
"""Actors that have a colour of their own."""


@dataclass(frozen=True)
class Shape:
    """How an actor is drawn."""

    name: str
    kind: ActorKind
    length: float
    width: float
    """[m]"""


def shapes(program: Program, trajectory: Trajectory) -> list[Shape]:
    """One an actor."""
    rows = zip(program.actors, program.code.actor_kind.tolist(), trajectory.outlines.tolist(), strict=True)
    return [Shape(name, ActorKind(kind), length, width) for name, kind, (length, width) in rows]


def way_of(trajectory: Trajectory, actor: int) -> Floats:
    """Return the centre (n, 2) of an actor while it is present with a finite pose."""
    states = trajectory.states[:, actor]
    there = (states[:, State.PRESENT] > 0.5) & np.isfinite(states[:, : State.HEADING + 1]).all(axis=1)
    return states[there][:, [State.X, State.Y]]


def colour(actor: int) -> int:
    """Which of the colours an actor has: the ego always the first, many actors share the rest."""
    return actor if actor == 0 else 1 + (actor - 1) % (COLOURS - 1)


def outline_corners(x: float, y: float, heading: float, length: float, width: float) -> list[tuple[float, float]]:
    """Corners of an oriented rectangle, anticlockwise [m]."""
    cos, sin = math.cos(heading), math.sin(heading)
    half = ((length / 2, width / 2), (-length / 2, width / 2), (-length / 2, -width / 2), (length / 2, -width / 2))
    return [(x + u * cos - v * sin, y + u * sin + v * cos) for u, v in half]


# -- how the deciding pair came near -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Approach:
    """How the deciding pair came near, at every sample of the run; NaN where the two are not both scored."""

    distance: Floats
    """(samples,) between the outlines [m]"""
    closing_speed: Floats
    """(samples,) of the centres [m/s], positive while they approach"""


def approach(trajectory: Trajectory, other: int, outlines: Floats) -> Approach:
    """Measure the approach of the ego and another actor with the engine's kernels; `outlines` in their format."""
    samples = len(trajectory.time)
    distance, closing = np.full(samples, np.nan), np.full(samples, np.nan)
    if 0 < other < trajectory.states.shape[1]:
        first, together = span_together(trajectory, other)
        states = np.ascontiguousarray(trajectory.states[first:])
        for k in range(together):
            now = snapshot(states, together, k, 0.0, time_step(trajectory), other, outlines)
            distance[first + k], closing[first + k] = box_distance(now.ego, now.other), _closing_speed(now)
        apart = apart_in_height(trajectory, other)
        distance[apart], closing[apart] = np.nan, np.nan
    return Approach(distance, closing)


def _closing_speed(now: Snapshot) -> float:
    """Return the closing speed as `engine.kernels.pair` defines it [m/s]."""
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    vx, vy = now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y
    apart = math.hypot(x, y)
    return -(x * vx + y * vy) / apart if apart else math.nan


# -- the case ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class CaseReplay:
    """Row 0 of its scenes, with everything that was seen when it ran in the world host."""

    program: Program
    scenes: Scenes
    outcomes: Outcomes
    trajectory: Trajectory
    impacts: "Sequence[Impact]"
    road: Outline
    score: int
    parts: tuple[int, ...]
    pair: int
    """The pair (ego, pair + 1) that decides the risk; 0 where there is none."""
    files: Mapping[str, str]
    """The case as a scenario of its own: texts by name, the main one first."""
    held: Sequence[FixedParam] = ()
    """Params that were held fixed."""
    town: Outline | None = None
    """All that `road` is a part of, where that is not everything."""

    @cached_property
    def shapes(self) -> list[Shape]:
        return shapes(self.program, self.trajectory)

    @cached_property
    def moments(self) -> list[Moment]:
        driven = story_of(self.program, self.outcomes, self.trajectory, 0, self.pair, self.unit)
        return in_order([*driven, *aftermath(self.program, self.impacts, self.trajectory)])

    @cached_property
    def unit(self) -> SpeedUnit:
        """Return the unit in which speeds are shown."""
        return speed_unit(self.program)

    @cached_property
    def speeds(self) -> Floats:
        """(samples, actors) [m/s], after contact those of free bodies."""
        return speeds(self.trajectory)

    @cached_property
    def metrics(self) -> tuple[Metric, ...]:
        """Return the metrics of a valid run; () for an invalid run."""
        if int(self.outcomes.verdict[0]) != Verdict.VALID:
            return ()
        driven = measure_trajectory(self.trajectory, self.outcomes, self._bodies)
        return (*driven, *measure_impacts(self.impacts))

    @cached_property
    def approach(self) -> Approach:
        return approach(self.trajectory, self.pair + 1, outlines_of(self._bodies))

    @cached_property
    def _bodies(self) -> tuple[Body, ...]:
        return bodies_of(self.program, self.scenes.values[0])

    @cached_property
    def columns(self) -> Floats:
        """Return the properties of the actors in the scene (actors, len(Column))."""
        return actor_columns(self.program, self.scenes.values[0])

    @cached_property
    def ways(self) -> list[Floats]:
        """Return the way of each actor until the end of the scored run."""
        scored = self.scored
        return [way_of(scored, actor) for actor in range(len(self.program.actors))]

    @cached_property
    def scored(self) -> Trajectory:
        """Return the run up to contact."""
        end = scored_samples(self.trajectory)
        now = self.trajectory
        heights = None if now.heights is None else now.heights[:end]
        return replace(now, time=now.time[:end], states=now.states[:end], heights=heights)

    @property
    def collided(self) -> bool:
        """Return whether any two actors touched."""
        return self.trajectory.contact_sample >= 0

    @property
    def key_time(self) -> float:
        """Return the time of contact, or of the closest approach of the deciding pair [s]."""
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
        """Return the first contact point of the ego [m]; None without contact."""
        return next((impact.point for impact in self.impacts if 0 in impact.actors), None)

    @cached_property
    def heading(self) -> float:
        """Direction of the ego's road, which lies along every picture [rad]."""
        return heading_of_road(self.road, self.road.reach, self.trajectory.states[:, 0])

    @cached_property
    def frame(self) -> Frame:
        """The part of the world in which it all happens."""
        return self.framed()

    def framed(self, shape: float | None = None) -> Frame:
        """Return the replay in a picture of a given shape."""
        points = tracks(self.trajectory)
        return Frame.around(points if len(points) else np.zeros((1, 2)), self.heading, shape)


class IsCompiled(Protocol):
    """A scenario's syntax tree and its compilation."""

    @property
    def module(self) -> nodes.Module: ...
    @property
    def scenario(self) -> ir.Scenario: ...


class Runnable(Protocol):
    """A compiled scenario that can be run and written: the interface of a `Scenario` that a replay uses."""

    @property
    def program(self) -> Program: ...
    @property
    def compiled(self) -> IsCompiled: ...
    @property
    def config(self) -> Config: ...
    @property
    def overrides(self) -> Mapping[str, str]: ...
    def watch(self, scenes: Scenes, row: int = 0) -> "WorldRun": ...
    def assess(self, outcomes: Outcomes, profile: str = "paper") -> Risk: ...
    def scene(self, case: Case) -> Scenes: ...
    def concrete_files(
        self, scenes: Scenes, row: int = 0, remark: str = "", name: str = "copy.scn"
    ) -> Mapping[str, str]: ...


def replay_case(
    scenario: Runnable, scenes: Scenes, profile: str = "paper", remark: str = "", name: str = "case.scn"
) -> CaseReplay:
    """Run row 0 of the scenes, which must be valid, and return the recorded run."""
    run = scenario.watch(scenes)
    risk = scenario.assess(run.outcomes, profile)
    shown = light_colours(scenario.compiled.scenario, scenes, 0, scenario.config.simulation)
    whole = outline(build_network(scenario.program.road_spec), shown)
    part = _part(whole, scenario.program, run.trajectory)
    return CaseReplay(
        program=scenario.program,
        scenes=scenes,
        outcomes=run.outcomes,
        trajectory=run.trajectory,
        impacts=run.impacts,
        road=whole if part is None else part,
        town=None if part is None else whole,
        score=int(risk.score[0]),
        parts=tuple(risk.parts[0].tolist()),
        pair=max(0, int(risk.pair[0])),
        files=scenario.concrete_files(scenes, remark=remark, name=name),
        held=held_params(scenario.compiled.module, scenario.overrides),
    )


class StoredRun(Protocol):
    """A run on disk with its scenario: the interface of an `OpenedRun` that a page uses."""

    @property
    def folder(self) -> Path: ...
    @property
    def record(self) -> "Record": ...
    @property
    def scenario(self) -> Runnable: ...
    @property
    def edited(self) -> Sequence[str]: ...
    @cached_property
    def blame(self) -> Ints: ...
    @cached_property
    def opinions(self) -> dict[str, str]: ...
    def first_cases(self, count: int) -> tuple[Case, ...]: ...
    def scene(self, case: Case) -> Scenes: ...


def replay_of_case(run: StoredRun, case: Case) -> CaseReplay:
    """Run one case of a run again, and return the recorded run."""
    manifest = run.record.manifest
    remark = f"case {case.rank} of a search in {manifest.file}: risk {case.score}"
    scenes = run.scene(case)
    return replay_case(run.scenario, scenes, manifest.profile, remark, f"{case.rank:02d}.scn")


REACH = 100.0
"""Margin around the run in a drawing of a map [m]; the extent of the run is added."""


def _part(road: Outline, program: Program, trajectory: Trajectory) -> Outline | None:
    """Return the roads around a run if the roads come from a map file, which may hold a whole town; else None."""
    places = tracks(trajectory)
    if not isinstance(program.road_spec, MapFile) or not len(places):
        return None
    return near(road, places, REACH + float(np.ptp(places, axis=0).max()))


def case_content(replay: CaseReplay, case: Case) -> dict[str, Any]:
    """Return a case of a search and its repeated run as a document."""
    program = replay.program
    return {
        **asdict(case),
        "key": list(case.key),
        "end_time": replay.outcomes.end_time[0],
        "parts": dict(zip((name for name, _, _ in PARTS), replay.parts, strict=True)),
        "params": params_content(program.space, replay.scenes.genomes[0]),
        "held": {one.name: {"value": one.value, "unit": one.unit} for one in replay.held},
        "pairs": pairs_content(program.actors, replay.outcomes),
        "events": events_content(program.actors, replay.moments),
        "metrics": metrics_content(program.actors, replay.metrics),
    }
