"""A moment of a scene as pixels, from above around the ego: the result of `render()` of Gymnasium environments."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.page.film import RoadPainter
from engine.extras import needed
from engine.road.outline import Outline
from engine.tables import Floats
from engine.vocabulary import State

SIZE = (640, 480)
"""Pixels, across and up."""
SCALE = 10.0
"""Pixels in a metre."""
GROUND, ROAD, KERB, MIDDLE, LINE = "#e8ebe4", "#c9ccd1", "#8a9099", "#d9a400", "#ffffff"
BUILDING, EGO, OTHERS = "#a9a294", "#1f6feb", "#d1495b"


class Painter:
    """Draws states on one road. Raises MissingExtraError: Pillow is not installed."""

    def __init__(self, road: Outline) -> None:
        self._road = road
        self._image = needed("PIL.Image", "pictures need", "gym")
        self._draw = needed("PIL.ImageDraw", "pictures need", "gym")

    def picture(self, states: Floats, outlines: Floats) -> NDArray[np.uint8]:
        """Return (height, width, 3) pixels of `states` (actors, len(State)) and `outlines` (actors, 2) in metres.

        The ego is in the middle, and north is up.
        """
        image = self._image.new("RGB", SIZE, GROUND)
        draw, center = self._draw.Draw(image), states[0, [State.X, State.Y]]
        self._paint_road(draw, center)
        for number, (state, (length, width)) in enumerate(zip(states, outlines, strict=True)):
            if state[State.PRESENT] != 0.0:
                x, y, heading = state[State.X], state[State.Y], state[State.HEADING]
                corners = outline_corners(x, y, heading, length, width)
                draw.polygon(_pixels(corners, center), fill=OTHERS if number else EGO, outline="black")
                front = outline_corners(
                    x + 0.4 * length * np.cos(heading), y + 0.4 * length * np.sin(heading), heading, 0.2 * length, width
                )
                draw.polygon(_pixels(front, center), fill="black")
        return np.asarray(image, dtype=np.uint8)

    def _paint_road(self, draw: Any, center: Floats) -> None:
        road, painter = self._road, RoadPainter(draw, partial(_pixels, center=center), SCALE)
        painter.ground(road, ROAD)
        for lines, colour in ((road.kerbs, KERB), (road.middle_lines, MIDDLE), (road.lane_lines, LINE)):
            painter.lines(lines, colour, 2)
        painter.lines(road.stop_lines, LINE, 4)
        painter.above(road, LINE, BUILDING, KERB, ROAD)
        painter.fill(road.buildings, BUILDING)


def _pixels(points: Floats | Sequence[tuple[float, float]], center: Floats) -> list[tuple[float, float]]:
    across, up = (np.asarray(points) - center).T * SCALE
    return list(zip((SIZE[0] / 2 + across).tolist(), (SIZE[1] / 2 - up).tolist(), strict=True))
