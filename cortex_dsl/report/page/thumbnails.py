"""Small pictures of a run's cases at their key moments: of one size and one scale, the ego driving to the right."""

from collections.abc import Iterator, Sequence

import numpy as np

from cortex_dsl.report.findings.case_replay import CaseReplay, outline_corners
from cortex_dsl.report.findings.framing import CARD, Frame, alike
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.markup import Element, Node, element
from engine.vocabulary import State

ROAD = "road"
"""Name of the road that all pictures of a page share."""
POINTS = 40
"""Maximum number of points of a way in a small picture."""


def shared_road(replay: CaseReplay) -> Element:
    """The road, drawn once for all pictures of its page."""
    road = scene_svg.road_layer(replay.road)
    return element("svg", element("defs", element("g", road, id=ROAD)), class_="shared", aria_hidden="true")


def thumbnails(replays: Sequence[CaseReplay]) -> list[Element]:
    """Return one picture per case: the ego, its nearest actor, and the ways of all actors."""
    frames = alike([_close(replay) for replay in replays])
    return [_thumbnail(replay, frame) for replay, frame in zip(replays, frames, strict=True)]


def _close(replay: CaseReplay) -> Frame:
    """Return the frame around the deciding pair at the key moment."""
    points = [corner for actor in {0, replay.pair + 1} for corner in _corners(replay, actor)]
    return Frame.around(np.array(points or [(0.0, 0.0)]), replay.heading, CARD)


def _corners(replay: CaseReplay, actor: int) -> Iterator[tuple[float, float]]:
    if actor < len(replay.shapes):
        state, shape = replay.trajectory.states[replay.key_sample, actor], replay.shapes[actor]
        x, y, heading = (float(value) for value in state[[State.X, State.Y, State.HEADING]])
        if state[State.PRESENT] > 0.5 and np.isfinite(x + y + heading):
            yield from outline_corners(x, y, heading, shape.length, shape.width)


def _thumbnail(replay: CaseReplay, frame: Frame) -> Element:
    ways = [way[:: max(1, -(-len(way) // POINTS))] for way in replay.ways]
    layers: list[Node] = [
        element("use", href=f"#{ROAD}"),
        scene_svg.way_layer(ways),
        scene_svg.actor_layer(replay.shapes, replay.trajectory.states[replay.key_sample]),
        scene_svg.contact_mark(*replay.contact_point) if replay.contact_point else None,
    ]
    return scene_svg.scene(frame, f"{replay.program.name} at its key moment", *layers, compass=False)
