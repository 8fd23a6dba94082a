"""One stretch of an actor's motion as a timed polyline."""

from dataclasses import dataclass

import numpy as np

from engine.interchange.openscenario.document import world_position
from engine.interchange.openscenario.versions import Version
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child
from engine.tables import Floats


@dataclass(frozen=True)
class Stretch:
    """A time in which an actor is there without a break."""

    time: Floats
    """(samples,) [s]."""
    poses: Floats
    """(samples, 3): x, y, heading of the reference point."""
    starts_late: bool
    """Whether the actor was not there from the beginning."""
    gone: float | None
    """The first sample without it [s]; None if it stays to the end."""

    @property
    def moves(self) -> bool:
        """A stretch at one pose needs no trajectory."""
        return bool((self.poses != self.poses[0]).any())

    def vertices(self) -> tuple[Floats, Floats]:
        """Times and poses without those in the middle of a standstill, which say nothing and make readers spin."""
        same = (self.poses[1:] == self.poses[:-1]).all(axis=1)
        standing = np.concatenate([[False], same]) & np.concatenate([same, [False]])
        return self.time[~standing], self.poses[~standing]

    def shortest_way(self) -> float:
        """From one vertex to the next [m]; infinite for a single one."""
        _, poses = self.vertices()
        return float(np.hypot(*np.diff(poses[:, :2], axis=0).T).min(initial=np.inf))


def stretches(recording: Recording, actor: int) -> list[Stretch]:
    """All stretches of an actor, in order."""
    poses, last = recording.rear_axle(actor), len(recording) - 1
    return [
        Stretch(
            time=recording.time[start : end + 1],
            poses=poses[start : end + 1],
            starts_late=start > 0,
            gone=None if end == last else float(recording.time[end + 1]),
        )
        for start, end in recording.stretches(actor)
    ]


def follow_trajectory(action: Element, stretch: Stretch, name: str, version: Version) -> None:
    """The private action that replays a stretch: absolute times and the mode `position`, so that nothing steers."""
    routing = child(child(action, "PrivateAction"), "RoutingAction")
    follow = child(routing, "FollowTrajectoryAction")
    holder = child(follow, "TrajectoryRef") if version.trajectory_in_reference else follow
    trajectory = child(holder, "Trajectory", name=name, closed="false")
    polyline = child(child(trajectory, "Shape"), "Polyline")
    for time, pose in zip(*stretch.vertices(), strict=True):
        world_position(child(polyline, "Vertex", time=float(time)), pose)
    child(child(follow, "TimeReference"), "Timing", domainAbsoluteRelative="absolute", scale=1, offset=0)
    child(follow, "TrajectoryFollowingMode", followingMode="position")
