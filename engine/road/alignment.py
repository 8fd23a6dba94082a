"""Paths from lines, arcs and clothoids, as chains of lines and arcs.

A clothoid is a curve whose curvature changes linearly along it. It is stored as biarcs through exact poses, so that the
ends of a path are exact; the curvature of the chain differs from that of the clothoid by at most `STEP`.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from engine.frozen import frozen
from engine.opendrive.curves import Pose, clothoid
from engine.road.opendrive.fitting import biarc
from engine.road.paths import Primitive

STEP = 0.002
"""Largest difference of curvature between a clothoid and its arcs [1/m]: 0.3 degrees of the front wheels of a car."""
CHORD = 5.0
"""Largest length of a biarc [m]; the distance between chain and clothoid is then below a millimetre."""


@frozen
class Segment:
    """A piece of a path whose curvature changes linearly: a line, an arc or a clothoid."""

    length: float
    """[m]"""
    start: float = 0.0
    """Curvature at its start, positive to the left [1/m]."""
    end: float = 0.0
    """Curvature at its end [1/m]."""

    @property
    def sharpest(self) -> float:
        """Largest magnitude of the curvature [1/m]."""
        return max(abs(self.start), abs(self.end))

    def pose(self, s: float) -> Pose:
        """Return the pose at a length from the start, in the frame of the start."""
        return clothoid(s, self.start, (self.end - self.start) / self.length)


def aligned(start: Pose, segments: Sequence[Segment]) -> tuple[Primitive, ...]:
    """Return the chain of lines and arcs of a path that begins at a pose."""
    chain = list[Primitive]()
    for segment in segments:
        chain += _arcs(start, segment) if segment.start == segment.end else _biarcs(start, segment)
        start = start.moved(*segment.pose(segment.length))
    return tuple(chain)


def _arcs(start: Pose, segment: Segment) -> Iterator[Primitive]:
    """Yield arcs of at most half a turn, or one line."""
    count = max(1, math.ceil(abs(segment.start) * segment.length / math.pi))
    length = segment.length / count
    for number in range(count):
        yield Primitive(*start.moved(*segment.pose(number * length)), segment.start, length)


def _biarcs(start: Pose, segment: Segment) -> Iterator[Primitive]:
    # The curvatures of the two arcs differ from the middle one by a third of the change: the largest difference.
    count = max(1, math.ceil(max(abs(segment.end - segment.start) / (3.0 * STEP), segment.length / CHORD)))
    poses = [start.moved(*segment.pose(segment.length * number / count)) for number in range(count + 1)]
    for first, last in pairwise(poses):
        yield from biarc(first, last)
