"""Which part of the world a picture shows, and how it is turned: the ego's road along it, cropped to the tracks.

A picture of a road that runs north would be a thin line in a wide stage. So every picture has a heading, that of the
ego's road where the ego starts, which points to its right. A north arrow and a bar tell of it (`north_degrees`, `bar`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.road.outline import Outline
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

MARGIN = 9.0
"""Margin of the world around the events [m]."""
LEAST_HEIGHT = 24.0
"""[m]"""
CARD = 1.5
"""Width of a picture over its height if it is next to other pictures or plots."""
BAND = 3.0
"""Width over height of a picture with the whole width of a page: a long road."""
STAGES = {CARD: 725.0, BAND: 1138.0}
"""How wide a page shows each shape, where it has room [px]."""
BARS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000)
"""Lengths of the scale bar [m]."""
BAR = 140.0
"""The most that it takes of `STAGES` [px]."""
REACH = 3.0
"""Distance from the lanes within which a place still counts as at the road [m]."""


@dataclass(frozen=True)
class Frame:
    """A rectangle of the world as it lies in the picture [m]: x to the right, along `heading`, and y up."""

    left: float
    bottom: float
    width: float
    height: float
    heading: float = 0.0
    """Direction of the world that points to the right of the picture [rad]."""

    @staticmethod
    def around(points: Floats, heading: float = 0.0, shape: float | None = None) -> "Frame":
        """The frame that shows all points (n, 2) of the world and a margin; of the shape in which they are largest."""
        turned = _turned(points, heading)
        low, high = turned.min(axis=0) - MARGIN, turned.max(axis=0) + MARGIN
        (x, y), size = (low + high) / 2.0, high - low
        shape = shape or _largest(*size)
        height = max(LEAST_HEIGHT, float(size[1]), float(size[0]) / shape)
        return Frame(float(x) - shape * height / 2.0, float(y) - height / 2.0, shape * height, height, heading)

    def turned(self, points: Floats | Sequence[tuple[float, float]]) -> Floats:
        """Points (n, 2) of the world, in the picture's own axes."""
        return _turned(points, self.heading)

    @property
    def shape(self) -> float:
        """Width over height."""
        return self.width / self.height

    @property
    def is_band(self) -> bool:
        """Return whether it has the wide shape."""
        return self.shape > (CARD + BAND) / 2.0

    @property
    def turn_degrees(self) -> float:
        """Return the rotation of the world, anticlockwise [deg]."""
        return -math.degrees(self.heading)

    @property
    def north_degrees(self) -> float:
        """Return the rotation, clockwise [deg], of an arrow that points up so that it points north."""
        return math.degrees(self.heading)

    @property
    def pixel(self) -> float:
        """Return the width of a pixel in the world, if the page has room for the whole picture [m]."""
        return self.width / STAGES[BAND if self.is_band else CARD]

    @property
    def bar(self) -> int:
        """Return the longest round length whose bar fits [m]."""
        return max((length for length in BARS if length <= BAR * self.pixel), default=BARS[0])


def alike(frames: Sequence[Frame]) -> list[Frame]:
    """The frames in one size, that of the largest in the shape that suits it, each about its own middle."""
    if not frames:
        return []
    width, height = max(frame.width for frame in frames), max(frame.height for frame in frames)
    shape = _largest(width, height)
    height = max(height, width / shape)
    return [_resized(frame, shape * height, height) for frame in frames]


def _resized(frame: Frame, width: float, height: float) -> Frame:
    left, bottom = frame.left + (frame.width - width) / 2.0, frame.bottom + (frame.height - height) / 2.0
    return Frame(left, bottom, width, height, frame.heading)


def _turned(points: Floats | Sequence[tuple[float, float]], heading: float) -> Floats:
    cos, sin = math.cos(heading), math.sin(heading)
    x, y = np.asarray(points, dtype=np.float64).reshape(-1, 2).T
    return np.column_stack([cos * x + sin * y, cos * y - sin * x])


def _largest(width: float, height: float) -> float:
    """The shape of picture in which a rectangle is shown largest."""
    return max(STAGES, key=lambda shape: STAGES[shape] * min(1.0 / width, 1.0 / (shape * height)))


def tracks(trajectory: Trajectory) -> Floats:
    """Return the (n, 2) outline corners of each actor at every sample with a finite pose at which it is present [m]."""
    x, y, heading = np.moveaxis(trajectory.states[..., [State.X, State.Y, State.HEADING]], -1, 0)
    there = (trajectory.states[..., State.PRESENT] > 0.5) & np.isfinite(x + y + heading)
    half = 0.5 * np.broadcast_to(trajectory.outlines[:, :2], (*there.shape, 2))[there]
    x, y, cos, sin = x[there], y[there], np.cos(heading[there]), np.sin(heading[there])
    corners = [
        (x + u * half[:, 0] * cos - v * half[:, 1] * sin, y + u * half[:, 0] * sin + v * half[:, 1] * cos)
        for u in (-1.0, 1.0)
        for v in (-1.0, 1.0)
    ]
    return np.concatenate([np.column_stack(each) for each in corners])


def heading_of_road(road: Outline, lanes_width: float, states: Floats) -> float:
    """Return the direction of the road on which the first actor starts, in its sense [rad]; `states` (samples, State).

    Off every road, or inside an intersection, it is that of the road nearest to its direction; 0 without an actor.
    `lanes_width` [m]: of the lanes of one direction.
    """
    there = states[(states[:, State.PRESENT] > 0.5) & np.isfinite(states[:, : State.HEADING + 1]).all(axis=1)]
    if not len(there):
        return 0.0
    x, y, facing = (float(value) for value in there[0, [State.X, State.Y, State.HEADING]])
    pieces = [line[i : i + 2] for line in road.middle_lines for i in range(len(line) - 1)]
    near = [piece for piece in pieces if _apart(piece, x, y) <= lanes_width + REACH]
    lines = near or pieces
    directions = [math.atan2(*(line[-1] - line[0])[::-1].tolist()) for line in lines]
    along = max(directions, key=lambda direction: abs(math.cos(direction - facing)), default=facing)
    return along if math.cos(along - facing) >= 0.0 else math.remainder(along + math.pi, 2.0 * math.pi)


def _apart(line: Floats, x: float, y: float) -> float:
    """Return the distance from a point to a straight line between two points [m]."""
    start, way = line[0], line[-1] - line[0]
    share = float(np.clip((((x, y) - start) * way).sum() / max(float((way * way).sum()), 1e-12), 0.0, 1.0))
    return math.hypot(*((x, y) - start - share * way))
