"""`FollowTrajectoryAction` with a timed polyline as a `Path`. Polylines without times are told to be so.

Source: ASAM OpenSCENARIO XML 1.2, classes FollowTrajectoryAction, Polyline, Vertex, Timing. In 1.0 the trajectory
stands in the action itself, later in a `TrajectoryRef`.
"""

from collections.abc import Sequence

import numpy as np

from engine.interchange.reading.catalogs import Catalogs
from engine.interchange.reading.node import Node
from engine.interchange.reading.positions import Surroundings, place
from engine.interchange.reading.tracks import Path, along_polyline, final_speed
from engine.tables import Floats

TOO_NEAR = 1e-10
"""Vertices this near in time [s] say a jump."""
TIMED = 'only a timed polyline is replayed: <Polyline> with time="…" on each vertex'


def read_path(action: Node, start: float, around: Surroundings, catalogs: Catalogs) -> Path:
    """The path of an action that starts at a time [s].

    Raises:
        InterchangeError: not a polyline, without times, fewer than one vertex, times that do not ascend.
    """
    trajectory = _trajectory(action, catalogs)
    shape = trajectory.need("Shape")
    polyline = shape.find("Polyline")
    if polyline is None:
        said = shape.children[0].tag if shape.children else "no shape"
        raise shape.error(f"the trajectory `{trajectory.text('name', '')}` is a <{said}>", TIMED)
    offset, scale, relative = _timing(action)
    if action.number("initialDistanceOffset", 0.0):
        raise action.error("initialDistanceOffset is not read here", "leave out the vertices before it")
    vertices = polyline.every("Vertex")
    if not vertices:
        raise polyline.error("the polyline has no vertex", "write <Vertex> elements into it")
    times = (start if relative else 0.0) + offset + scale * np.array([_time(vertex) for vertex in vertices])
    _check_order(times, vertices)
    return _path(start, times, vertices, around)


def _path(start: float, times: Floats, vertices: Sequence[Node], around: Surroundings) -> Path:
    placed = [place(vertex.need("Position"), around) for vertex in vertices]
    given = [each.given for each in placed]
    raw = np.array([each.pose for each in placed], dtype=np.float64)
    if len(vertices) == 1 and not given[0]:
        given = [True]  # one place: it looks where that place looks
    poses = along_polyline(raw, given, vertices[0])
    return Path(start, times, poses, final_speed(times, poses))


def _trajectory(action: Node, catalogs: Catalogs) -> Node:
    holder = action.find("TrajectoryRef") or action
    if (trajectory := holder.find("Trajectory")) is not None:
        return trajectory
    reference = holder.find("CatalogReference")
    if reference is None:
        raise action.error("the action names no trajectory", "write a <Trajectory> into its <TrajectoryRef>")
    return catalogs.entry(reference)


def _timing(action: Node) -> tuple[float, float, bool]:
    """Offset, scale and whether times count from the start of the action."""
    timing = action.find("TimeReference", "Timing")
    if timing is None:
        raise action.error(
            "the trajectory has no times: its <TimeReference> is <None/> or missing, so how fast it is driven "
            "depends on a simulator",
            'write <Timing domainAbsoluteRelative="absolute" offset="0" scale="1"/> and a time on each vertex',
        )
    domain = timing.text("domainAbsoluteRelative")
    if domain not in ("absolute", "relative"):
        raise timing.error(f"there is no time domain `{domain[:40]}`", "write `absolute` or `relative`")
    scale = timing.number("scale", low=0.0)
    if scale == 0.0:
        raise timing.error("times scaled by 0 are all one", "write a positive scale")
    return timing.number("offset"), scale, domain == "relative"


def _time(vertex: Node) -> float:
    if "time" not in vertex.attributes:
        raise vertex.error("a vertex has no time", 'write time="…" [s] on each <Vertex>')
    return vertex.number("time")


def _check_order(times: Floats, vertices: Sequence[Node]) -> None:
    wrong = np.flatnonzero(np.diff(times) <= TOO_NEAR)
    if len(wrong):
        here = int(wrong[0])
        said = f"{times[here + 1]:g} s after {times[here]:g} s"
        raise vertices[here + 1].error(f"times must ascend, and this vertex comes at {said}", "sort the vertices")
