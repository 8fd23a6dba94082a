"""The ego and one other actor in one run, as metrics of a pair need them: states, bodies, instants."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from engine.kernels.conflict import Snapshot, snapshot, time_to_collision
from engine.kernels.encroachment import OccupancyInterval, stays
from engine.kernels.levels import hide_levels
from engine.kernels.swept import Span, swept
from engine.metrics.bodies import Body, outlines_of
from engine.outcomes import Outcomes
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import LEVEL, State

# -- measured parts of a trajectory ------------------------------------------------------------------------------------


def on_levels(trajectory: Trajectory, outcomes: Outcomes, row: int) -> Trajectory:
    """Return a trajectory in which other actors are absent while they are not on the ego's level; `outcomes` at `row`
    name the actor that the ego touches.
    """
    if trajectory.heights is None:
        return trajectory
    states = trajectory.states.copy()
    heights = np.hstack([trajectory.heights, np.zeros_like(trajectory.heights)])
    hide_levels(states, len(states), heights, int(outcomes.contact_actors[row, 1]), trajectory.contact_sample)
    return replace(trajectory, states=states)


def apart_in_height(trajectory: Trajectory, other: int) -> NDArray[np.bool_]:
    """Return (samples,) True while the ego and another actor are on different levels."""
    if trajectory.heights is None:
        return np.zeros(len(trajectory.time), dtype=bool)
    present = trajectory.states[:, [0, other], State.PRESENT] != 0.0
    return present.all(axis=1) & (np.abs(trajectory.heights[:, other] - trajectory.heights[:, 0]) >= LEVEL)


def never_on_one_level(trajectory: Trajectory, other: int) -> bool:
    """Return whether the ego and another actor are in the scene together, and never on one level."""
    present = trajectory.states[:, [0, other], State.PRESENT] != 0.0
    together, apart = present.all(axis=1), apart_in_height(trajectory, other)
    return bool(together.any()) and bool(apart[together].all())


def scored_samples(trajectory: Trajectory) -> int:
    """Return the number of samples up to the end of the scored run, without those of contact physics."""
    return trajectory.contact_sample + 1 if trajectory.contact_sample >= 0 else len(trajectory.time)


def span_together(trajectory: Trajectory, other: int) -> tuple[int, int]:
    """Return the first scored sample with the ego and another actor, and the number of samples with both."""
    present = trajectory.states[: scored_samples(trajectory), [0, other], State.PRESENT] != 0.0
    return _stretch(present.all(axis=1))


def span_of(trajectory: Trajectory, actor: int) -> tuple[int, int]:
    """Return the first scored sample with an actor, and the number of samples with it from then on."""
    return _stretch(trajectory.states[: scored_samples(trajectory), actor, State.PRESENT] != 0.0)


def time_step(trajectory: Trajectory) -> float:
    """Return the time between two samples [s]; 1 for a single sample."""
    return float(trajectory.time[1] - trajectory.time[0]) if len(trajectory.time) > 1 else 1.0


def _stretch(flags: np.ndarray) -> tuple[int, int]:
    """Return the first flag that is True, and the length of its run without a gap; 0, 0 if none is True."""
    if not flags.any():
        return 0, 0
    first = int(np.argmax(flags))
    rest = flags[first:]
    return first, len(rest) if rest.all() else int(np.argmin(rest))


@dataclass(frozen=True)
class Encounter:
    """One pair of one run, from their first common sample until one actor is absent, or the scored run ends."""

    trajectory: Trajectory
    outcomes: Outcomes
    row: int
    """Row of the outcomes."""
    bodies: tuple[Body, ...]
    number: int
    """Index of the other actor."""

    @property
    def ego(self) -> Body:
        return self.bodies[0]

    @property
    def other(self) -> Body:
        return self.bodies[self.number]

    @cached_property
    def step(self) -> float:
        return time_step(self.trajectory)

    @cached_property
    def span(self) -> tuple[int, int]:
        """Return the first sample of both, and the number of samples that they share."""
        return span_together(self.trajectory, self.number)

    @cached_property
    def states(self) -> Floats:
        """Return (samples, actors, len(State)) from the first sample of both."""
        return self.trajectory.states[self.span[0] :]

    @cached_property
    def outlines(self) -> Floats:
        """Return (actors, 3) the outlines."""
        return outlines_of(self.bodies)

    @cached_property
    def touched(self) -> bool:
        """Return True if the ego collided with this actor."""
        return bool(self.outcomes.collided[self.row]) and self._contact_with == self.number

    @property
    def _contact_with(self) -> int:
        return int(self.outcomes.contact_actors[self.row, 1])

    def outcome(self, name: str) -> float:
        """Return a result of the pair, by its name in the table of results."""
        return float(getattr(self.outcomes, name)[self.row, self.number - 1])

    # -- instants

    @cached_property
    def samples(self) -> tuple[Snapshot, ...]:
        """Return the pair at every sample that it shares."""
        return tuple(self._at(k, 0.0) for k in range(self.span[1]))

    @cached_property
    def nearest(self) -> Snapshot:
        """Return the pair at the instant of MD, or of contact; an instant after the last sample counts as the last
        sample.
        """
        first, together = self.span
        time = self.outcome("min_distance_time") - first * self.step
        steps = min(max(time / self.step, 0.0), together - 1.0)
        return self._at(int(steps), steps - int(steps))

    @cached_property
    def contact(self) -> Snapshot:
        """Return the pair at the instant of contact, extrapolated from the last sample."""
        now, (first, together) = self.nearest, self.span
        late = max(0.0, self.outcome("min_distance_time") - (first + together - 1.0) * self.step)
        ego = now.ego._replace(x=now.ego.x + late * now.ego_rate.x, y=now.ego.y + late * now.ego_rate.y)
        other = now.other._replace(x=now.other.x + late * now.other_rate.x, y=now.other.y + late * now.other_rate.y)
        return now._replace(ego=ego, other=other)

    def _at(self, sample: int, part: float) -> Snapshot:
        return snapshot(self.states, self.span[1], sample, part, self.step, self.number, self.outlines)

    # -- over time

    @cached_property
    def ttc(self) -> Floats:
        """Return the time to collision at every sample [s]."""
        return np.array([time_to_collision(now) for now in self.samples])

    def on_course(self, measure: Callable[[Snapshot], float], otherwise: float) -> Floats:
        """Return a measure at every sample, `otherwise` where no contact is ahead."""
        ahead = zip(self.samples, np.isfinite(self.ttc).tolist(), strict=True)
        return np.array([measure(now) if there else otherwise for now, there in ahead])

    # -- the area that both pass

    @cached_property
    def stays(self) -> tuple[OccupancyInterval, OccupancyInterval]:
        """Return the stays of the ego and of the other in the common area, in samples, while it is in the scene."""
        states = self.trajectory.states
        ego, other = self._span_of(0), self._span_of(self.number)
        mine, theirs = stays(states, ego, other, self.outlines, swept(len(states)))
        return mine, theirs

    def _span_of(self, actor: int) -> Span:
        first, count = span_of(self.trajectory, actor)
        return Span(actor, first, first + count - 1)
