"""Impacts between two bodies for reports: those of pymunk, and those that the kernels recorded between other actors."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import pymunk

from engine.kernels.impacts.motion import PAUSE, PULSE, ImpactRecord
from engine.kernels.run_state import Run, Status
from engine.scenes import Impact
from engine.tables import A_BUILDING, Floats

LEAST_CHANGE = 0.01
"""Least change of a velocity for which a touch is reported as an impact [m/s]."""


@dataclass
class Episode:
    """Impulses on a body during its current contact with any body."""

    start: float
    """[s]"""
    last: float
    impulse: list[float] = field(default_factory=lambda: [0.0, 0.0])
    """[N s]"""


@dataclass
class Meeting:
    """An impact that may still continue."""

    time: float
    last: float
    pair: tuple[int, int]
    point: tuple[float, float]
    poses: tuple[tuple[float, float, float], tuple[float, float, float]]
    velocity: tuple[float, float]
    """Velocity of the higher body relative to the lower body, before the impact [m/s]."""
    episodes: tuple[Episode, Episode]


class Recorder:
    """Records all impacts of a space. Bodies are identified by their order, which is that of the actors.

    pymunk prints exceptions of callbacks and continues; so callbacks store the first exception, and `check` raises it
    after the step.
    """

    def __init__(self, space: pymunk.Space, bodies: list[pymunk.Body]) -> None:
        self.time = 0.0
        self.struck: set[int] = set()
        """Actors that have been touched by anything."""
        self.apart: set[tuple[int, int]] = set()
        """Pairs of bodies that pass one another, lower number first. Filters of pymunk have 32 categories, too few."""
        self._number = {body: number for number, body in enumerate(bodies)}
        self._open: dict[tuple[int, int], Meeting] = {}
        self._closed: list[Meeting] = []
        self.episodes: list[Episode] = []
        """All that bodies went through."""
        self._current: dict[int, Episode] = {}
        self._failure: Exception | None = None
        space.on_collision(begin=self._guarded(self._begin), post_solve=self._guarded(self._post_solve))

    def check(self) -> None:
        """Raise the exception of a callback in the last step."""
        if self._failure is not None:
            raise self._failure

    def impacts(self, masses: tuple[float, ...], least_change: float = LEAST_CHANGE) -> tuple[Impact, ...]:
        """Return all impacts so far, in the order of time, without touches that change velocities by less than
        `least_change`.

        Bodies beyond those in `masses` are buildings.
        """
        meetings = [*self._closed, *self._open.values()]
        reported = (_impact(meeting, masses) for meeting in sorted(meetings, key=lambda m: (m.time, m.pair)))
        return tuple(impact for impact in reported if max(impact.delta_v) >= least_change)

    def _guarded(self, callback: Callable[[pymunk.Arbiter], None]) -> Callable[..., None]:
        def call(arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
            try:
                callback(arbiter)
            except Exception as failure:
                self._failure = self._failure or failure

        return call

    def _pair(self, arbiter: pymunk.Arbiter) -> tuple[int, int, bool]:
        """Return lower actor, higher actor, and True if pymunk has them in reverse order."""
        one, other = (self._number[body] for body in arbiter.bodies)
        return (one, other, False) if one < other else (other, one, True)

    def _begin(self, arbiter: pymunk.Arbiter) -> None:
        low, high, swapped = self._pair(arbiter)
        if (low, high) in self.apart:
            arbiter.process_collision = False
            return
        self.struck |= {low, high}
        earlier = self._open.get((low, high))
        if earlier is not None:
            if self.time - earlier.time <= PULSE or self.time - earlier.last <= PAUSE:
                return
            self._closed.append(earlier)
        bodies = arbiter.bodies[::-1] if swapped else arbiter.bodies
        points = [point.point_a for point in arbiter.contact_point_set.points]
        velocity = bodies[1].velocity - bodies[0].velocity
        self._open[low, high] = Meeting(
            time=self.time,
            last=self.time,
            pair=(low, high),
            point=(sum(p.x for p in points) / len(points), sum(p.y for p in points) / len(points)),
            poses=(_pose(bodies[0]), _pose(bodies[1])),
            velocity=(velocity.x, velocity.y),
            episodes=(self._episode(low), self._episode(high)),
        )

    def _episode(self, body: int) -> Episode:
        """Return the current episode of a body: a new episode after a while without contact."""
        known = self._current.get(body)
        if known is None or (self.time - known.start > PULSE and self.time - known.last > PAUSE):
            known = self._current[body] = Episode(self.time, self.time)
            self.episodes.append(known)
        return known

    def _post_solve(self, arbiter: pymunk.Arbiter) -> None:
        low, high, swapped = self._pair(arbiter)
        meeting = self._open[low, high]
        x, y = arbiter.total_impulse  # on the first of `arbiter.bodies`
        sign = 1.0 if swapped else -1.0
        meeting.last = self.time
        for body, side in ((low, -sign), (high, sign)):
            episode = self._episode(body)
            episode.last = self.time
            if self.time - episode.start <= PULSE:
                episode.impulse[0] += side * x
                episode.impulse[1] += side * y


def _pose(body: pymunk.Body) -> tuple[float, float, float]:
    return body.position.x, body.position.y, body.angle


def _impact(meeting: Meeting, masses: tuple[float, ...]) -> Impact:
    low, high = meeting.pair
    headings = meeting.poses[0][2], meeting.poses[1][2]
    impulses = [episode.impulse for episode in meeting.episodes]
    sizes = [math.hypot(x, y) for x, y in impulses]
    received = [math.atan2(y, x) for x, y in impulses]
    building = high >= len(masses)
    return Impact(
        time=meeting.time,
        actors=(low, A_BUILDING if building else high),
        point=meeting.point,
        delta_v=(sizes[0] / masses[low], 0.0 if building else sizes[1] / masses[high]),
        direction=(_wrap(received[0] - headings[0]), _wrap(received[1] - headings[1])),
        closing_speed=math.hypot(*meeting.velocity),
        impact_angle=_wrap(headings[1] - headings[0]),
        clock=(clock_position(meeting.point, meeting.poses[0]), clock_position(meeting.point, meeting.poses[1])),
    )


def impacts_among_others(run: Run) -> tuple[Impact, ...]:
    """Return the impacts before the ego's contact, as the kernels recorded them."""
    return tuple(_from_record(record, len(run.actors)) for record in run.impacts[: run.status[Status.IMPACTS]])


def _from_record(record: Floats, actors: int) -> Impact:
    one, other, point = (
        int(record[ImpactRecord.ONE]),
        int(record[ImpactRecord.OTHER]),
        (float(record[ImpactRecord.X]), float(record[ImpactRecord.Y])),
    )
    headings = float(record[ImpactRecord.HEADING_ONE]), float(record[ImpactRecord.HEADING_OTHER])
    changes = record[ImpactRecord.CHANGE_X_ONE : ImpactRecord.CHANGE_Y_OTHER + 1].reshape(2, 2)
    velocities = record[ImpactRecord.VX_ONE : ImpactRecord.VY_OTHER + 1].reshape(2, 2)
    centers = record[ImpactRecord.X_ONE : ImpactRecord.Y_OTHER + 1].reshape(2, 2)
    sides = [(float(x), float(y), heading) for (x, y), heading in zip(centers, headings, strict=True)]
    turned = [_wrap(math.atan2(y, x) - heading) for (x, y), heading in zip(changes, headings, strict=True)]
    return Impact(
        time=float(record[ImpactRecord.TIME]),
        actors=(one, other if other < actors else A_BUILDING),
        point=point,
        delta_v=(math.hypot(*changes[0]), math.hypot(*changes[1])),
        direction=(turned[0], turned[1]),
        closing_speed=math.hypot(*(velocities[1] - velocities[0])),
        impact_angle=_wrap(headings[1] - headings[0]),
        clock=(clock_position(point, sides[0]), clock_position(point, sides[1])),
    )


def clock_position(point: tuple[float, float], pose: tuple[float, float, float]) -> int:
    """Return the direction of a point from a body's centre as an hour, 12 straight ahead and 3 to the right."""
    angle = math.atan2(point[1] - pose[1], point[0] - pose[0]) - pose[2]
    return (round(-angle / (math.pi / 6.0)) - 1) % 12 + 1


def _wrap(angle: float) -> float:
    """Return the angle wrapped to [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
