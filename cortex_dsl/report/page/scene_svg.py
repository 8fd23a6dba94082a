"""Roads and scenes from above as SVG. The world is drawn in metres, y up; a style sheet gives it colours.

Units inside the drawing are metres, so that a script can move an actor by its position alone. The whole world is turned
as its frame says; north arrow and scale bar stand upright in a corner (`camera.js` keeps them there in close-up).
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from cortex_dsl.report.findings.case_replay import Shape, colour
from cortex_dsl.report.findings.framing import Frame
from cortex_dsl.report.page.markup import Element, Node, element
from engine.road.outline import Outline
from engine.tables import Floats
from engine.vocabulary import ActorKind, State

SEAM = 0.05
"""Overlap of asphalt below its neighbours on all sides, so that no light shows between smoothed edges [m]."""


def number(value: float, decimals: int = 2) -> str:
    """A coordinate, as short as it can be."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def points_text(points: Iterable[Sequence[float]] | Floats, decimals: int = 2) -> str:
    """Points of a polyline."""
    return " ".join(f"{number(x, decimals)},{number(y, decimals)}" for x, y in points)


def scene(frame: Frame, title: str, *layers: Node, compass: bool = True, **attributes: str) -> Element:
    """A whole drawing: layers in world coordinates, the first one below; with north arrow and scale bar."""
    return element(
        "svg",
        element("title", title),
        element("g", *layers, transform=f"scale(1,-1) rotate({number(frame.turn_degrees, 4)})", class_="world"),
        _compass(frame) if compass else None,
        viewBox=_view_box(frame),
        class_="scene",
        role="img",
        preserveAspectRatio="xMidYMid meet",
        xmlns="http://www.w3.org/2000/svg",
        **attributes,
    )


def _view_box(frame: Frame) -> str:
    """Return the view box of SVG: y down, turned by the group `world`."""
    return " ".join(map(number, (frame.left, -frame.bottom - frame.height, frame.width, frame.height)))


def _lengthened(line: Floats, by: float) -> Floats:
    """A polyline that goes straight on at both ends [m]."""
    ends, inner = line[[0, -1]], line[[1, -2]]
    apart = np.hypot(*(ends - inner).T)[:, None]
    if not apart.all():
        return line
    first, last = ends + by * (ends - inner) / apart
    return np.concatenate([[first], line[1:-1], [last]])


def road_layer(road: Outline, time: float = 0.0) -> Element:
    """Return all that is painted or built, and the colours of lights at a time [s]."""
    return element(
        "g",
        [element("polygon", points=points_text(ring), class_="building") for ring in road.buildings],
        [element("polygon", points=points_text(ring), class_=kind.value) for kind, ring in road.strips],
        [
            _line(_lengthened(line, SEAM), "asphalt", stroke_width=number(width + 2.0 * SEAM))
            for line, width in zip(road.center_lines, road.widths, strict=True)
        ],
        [element("polygon", points=points_text(ring), class_="junction") for ring in road.areas],
        [_line(line, "kerb") for line in road.kerbs],
        [_line(line, "lane-line") for line in road.lane_lines],
        [_line(line, "middle-line") for line in road.middle_lines],
        [_line(line, "stop-line") for line in road.stop_lines],
        [element("polygon", points=points_text(ring), class_="stripe") for ring in road.stripes],
        [element("polygon", points=points_text(ring), class_="parked") for ring in road.parked],
        [_line(each.line, f"signal {each.colour(time)}".rstrip()) for each in road.signals],
        _deck_layer(road),
        class_="road",
    )


def _deck_layer(road: Outline) -> list[Element]:
    """Return the bridges above the other roads: their shadow, their edges, their asphalt."""
    shadow, edge = "stroke:#000;stroke-opacity:.3", "stroke:var(--kerb)"
    coats = road.deck_coats({"style": shadow}, {"style": edge}, {})
    return [_line(line, "asphalt", stroke_width=number(width), **style) for line, width, style in coats]


def way_layer(ways: Sequence[Floats]) -> Element:
    """The ways of all actors; the ego's lies on top."""
    lines = [_line(way, f"way actor-{colour(actor)}") for actor, way in enumerate(ways) if len(way)]
    return element("g", reversed(lines), class_="ways")


def sight_layer() -> Element:
    """Return an empty layer for an actor's field of view, which a script draws on request: the area and its shadows."""
    paths = [element("path", class_="shadow", fill_rule="evenodd"), element("path", class_="seen")]
    return element("g", paths, class_="sight", style="display:none")


def actor_layer(drawn: Sequence[Shape], states: Floats, name: str = "actor") -> list[Element]:
    """Every actor at its place; `states` (actors, len(State)) of one sample. The ego lies on top."""
    return [_actor(drawn[actor], actor, states[actor], name) for actor in reversed(range(len(drawn)))]


def _actor(shape: Shape, actor: int, state: Floats, name: str) -> Element:
    there = state[State.PRESENT] > 0.5 and bool(np.isfinite(state[: State.HEADING + 1]).all())
    x, y, heading = (float(v) for v in state[[State.X, State.Y, State.HEADING]]) if there else (0.0, 0.0, 0.0)
    return element(
        "g",
        element("title", shape.name),
        _body(shape),
        class_=f"{name} actor-{colour(actor)}",
        data_actor=actor,
        transform=f"translate({number(x, 3)} {number(y, 3)}) rotate({number(np.degrees(heading), 2)})",
        display=None if there else "none",
    )


def _body(shape: Shape) -> Node:
    """An outline seen from above, its front to the right: the outline itself is true to the simulation."""
    length, width = shape.length, shape.width
    corner = min(0.25 * width, 0.5)
    outline = _box(0.0, 0.0, length, width, corner, "body")
    if shape.kind == ActorKind.PEDESTRIAN:
        return [outline, element("circle", cx=0, cy=0, r=number(0.3 * min(length, width)), class_="glass")]
    if length < 2.6 or width < 1.0:
        return [outline, element("circle", cx=number(-0.05 * length), cy=0, r=number(0.28 * width), class_="glass")]
    return [
        outline,
        _box(0.14 * length, 0.0, 0.16 * length, 0.76 * width, 0.2, "glass"),
        _box(-0.33 * length, 0.0, 0.09 * length, 0.66 * width, 0.15, "glass"),
        [_box(0.47 * length, side * 0.34 * width, 0.05 * length, 0.18 * width, 0.08, "lamp") for side in (-1, 1)],
    ]


def _box(x: float, y: float, length: float, width: float, corner: float, name: str) -> Element:
    return element(
        "rect",
        x=number(x - length / 2, 3),
        y=number(y - width / 2, 3),
        width=number(length, 3),
        height=number(width, 3),
        rx=number(corner),
        class_=name,
    )


def contact_mark(x: float, y: float) -> Element:
    """A cross in a ring, where two outlines met."""
    return element(
        "g",
        element("title", "contact"),
        element("circle", r=1.5, class_="contact-halo"),
        element("path", d="M-.6-.6L.6.6M-.6.6L.6-.6", class_="contact-cross"),
        transform=f"translate({number(x)} {number(y)})",
        class_="contact",
    )


OVERVIEW = 104
"""Width and height [px]."""
OVERVIEW_STYLE = (
    "position:absolute;bottom:42px;right:10px;border-radius:6px;background:var(--card);opacity:.92;pointer-events:none"
)


def overview(town: Outline, place: Sequence[float]) -> Element:
    """A town as a small picture, north up, with a ring where something takes place."""
    points = np.vstack([*town.center_lines, np.array([place])])
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    scale = (OVERVIEW - 16) / max(size, 1.0)
    margin = 0.5 * (OVERVIEW - scale * np.ptp(points, axis=0))

    def small(line: Floats) -> Floats:
        x, y = (margin + scale * (line - low)).T
        return np.column_stack([x, OVERVIEW - y])

    roads = " ".join(f"M{points_text(_thinned(small(line)), 1)}" for line in town.center_lines)
    (x, y), thin = small(np.array([place]))[0], {"fill": "none", "stroke": "var(--quiet)", "stroke_width": ".8"}
    return element(
        "svg",
        element("title", "where in the town this is, north up"),
        element("path", d=roads, **thin),
        element("circle", cx=number(x, 1), cy=number(y, 1), r=5, fill="none", stroke="var(--hot)", stroke_width="1.8"),
        viewBox=f"0 0 {OVERVIEW} {OVERVIEW}",
        width=OVERVIEW,
        height=OVERVIEW,
        class_="overview",
        style=OVERVIEW_STYLE,
    )


def _thinned(line: Floats) -> Floats:
    """Return the ends of a line, and points at least a pixel from the previous one."""
    thinned = [line[0]]
    for point in line[1:-1]:
        if math.hypot(*(point - thinned[-1])) >= 1.0:
            thinned.append(point)
    return np.array([*thinned, line[-1]])


def _compass(frame: Frame) -> Element:
    """A north arrow and a bar of a round length, at the lower left. Their unit is a pixel of a page with room."""
    x, y = frame.left + 14 * frame.pixel, -frame.bottom - 14 * frame.pixel
    north = math.radians(frame.north_degrees)
    turn = f"translate(18,-18) rotate({number(frame.north_degrees)})"
    return element(
        "g",
        element("title", f"north, and a bar of {frame.bar} m"),
        element(
            "path",
            d="M0-11L6 8L0 4L-6 8Z",
            class_="needle",
            transform=turn,
        ),
        element("text", "N", x=number(18 + 19 * math.sin(north)), y=number(-14 - 19 * math.cos(north)), class_="north"),
        element("path", d=f"M48-5V0H{number(48 + frame.bar / frame.pixel, 1)}V-5", class_="bar"),
        element("text", f"{frame.bar} m", x=54, y=-7, class_="length"),
        transform=f"translate({number(x)} {number(y)}) scale({number(frame.pixel, 5)})",
        class_="compass",
    )


def _line(points: Floats | Sequence[Sequence[float]], name: str, **attributes: str) -> Element:
    return element("polyline", points=points_text(points), class_=name, **attributes)
