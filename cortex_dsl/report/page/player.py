"""The player of a case: the drawing from above, its controls, synchronous plots, and the data of the replay.

The data are poses and speeds of all actors, and the approach of the deciding pair, over time. Numbers are sent as whole
numbers, each series as its first value and the differences: a hundred samples of one series take some 300 bytes.
Positions are in centimetres, headings in milliradians, speeds in millimetres a second.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cortex_dsl.report.findings.case_replay import Approach, CaseReplay, Shape
from cortex_dsl.report.findings.framing import CARD, Frame
from cortex_dsl.report.findings.readable import fixed
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.charts import Course, Mark, line_chart
from cortex_dsl.report.page.markup import Element, Node, drawing_rules, element, picture
from engine.metrics import scored_samples, time_step
from engine.road.outline import SignalLine
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import Column, State

# -- the data ----------------------------------------------------------------------------------------------------------

PER_METRE = 100.0
PER_RADIAN = 1000.0
PER_SPEED = 1000.0
BOX = ("x", "y", "heading", "length", "width")
"""Properties of a building in the page's data."""
FARTHEST = 1e4
"""Maximum range of a drawn field of view [m]."""


def replay_data(
    trajectory: Trajectory, drawn: Sequence[Shape], near: Approach, key_time: float, speeds: Floats
) -> dict[str, Any]:
    """Return the embedded data for `replay.js`; `speeds` (samples, actors) [m/s], NaN for absent actors."""
    return {
        "step": time_step(trajectory),
        "samples": len(trajectory.time),
        "scored": scored_samples(trajectory),
        "contact": trajectory.contact_sample,
        "key": key_time,
        "actors": [
            _actor(trajectory.states[:, actor], speeds[:, actor], shape.name) for actor, shape in enumerate(drawn)
        ],
        "distance": packed(near.distance, PER_METRE),
        "closing": packed(near.closing_speed, PER_SPEED),
    }


def _actor(states: Floats, speeds: Floats, name: str) -> dict[str, Any]:
    there = states[:, State.PRESENT] > 0.5
    return {
        "name": name,
        "present": _spans(there),
        "x": packed(np.where(there, states[:, State.X], np.nan), PER_METRE),
        "y": packed(np.where(there, states[:, State.Y], np.nan), PER_METRE),
        "heading": packed(np.where(there, _unwound(states[:, State.HEADING]), np.nan), PER_RADIAN),
        "speed": packed(speeds, PER_SPEED),
    }


def _unwound(angles: Floats) -> Floats:
    """Return the angles without jumps of a whole turn, so that interpolation between two samples is correct."""
    return np.unwrap(np.where(np.isfinite(angles), angles, 0.0))


def _spans(flags: np.ndarray) -> list[list[int]]:
    """Half-open stretches of samples where a flag holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2).tolist()


def packed(values: Floats, scale: float) -> list[int | None]:
    """The first number, then differences; None where there is no number, which the next difference passes over."""
    result: list[int | None] = []
    before = 0
    for value in values.tolist():
        if math.isfinite(value):
            now = round(value * scale)
            result.append(now - before)
            before = now
        else:
            result.append(None)
    return result


# -- the player --------------------------------------------------------------------------------------------------------

SCRIPTS = ("series.js", "camera.js", "sight.js", "replay.js")
"""Scripts of a page with players, in order."""
SPEEDS = (0.25, 0.5, 1, 2, 4)


def player(replay: CaseReplay, number: int) -> Element:
    """The drawing with its controls and plots; `replay.js` moves it by the data of the same number."""
    return element(
        "div",
        element("div", _stage(replay), _controls(replay), class_="stage-column"),
        element("div", _plots(replay), class_="plots"),
        class_="player wide" if replay.frame.is_band else "player",
        data_replay=number,
        tabindex=0,
        aria_label="replay: space plays and pauses, arrows step, plus and minus change the speed, "
        "c follows the ego, v shows what it sees",
    )


def player_data(replay: CaseReplay) -> dict[str, Any]:
    """Return the data that the player replays."""
    frame = replay.frame
    moved = replay_data(replay.trajectory, replay.shapes, replay.approach, replay.key_time, replay.speeds)
    return {
        **moved,
        "actors": [{**actor, **_looks(replay, number)} for number, actor in enumerate(moved["actors"])],
        "speed_per_si": replay.unit.per_si,
        "touched": bool(replay.outcomes.collided[0]),
        "frame": [frame.left, -frame.bottom - frame.height, frame.width, frame.height],
        "heading": frame.heading,
        "point": replay.contact_point,
        "signals": [_changes(each, replay.trajectory.time) for each in replay.road.signals],
        "buildings": [dict(zip(BOX, row, strict=True)) for row in replay.program.road.buildings.tolist()],
    }


def _changes(signal: SignalLine, times: Floats) -> list[tuple[float, str]]:
    """Return the changes of a light's colour with their times, at samples."""
    shown = [(round(time, 3), signal.colour(time)) for time in times.tolist()]
    return [now for before, now in zip([(0.0, None), *shown], shown, strict=False) if now[1] != before[1]]


def _looks(replay: CaseReplay, actor: int) -> dict[str, Any]:
    """Return the size of an actor, its field of view, and whether it hides others."""
    shape, columns = replay.shapes[actor], replay.columns[actor]
    return {
        "outline": [shape.length, shape.width],
        "view": [float(columns[Column.VIEW_ANGLE]), min(FARTHEST, float(columns[Column.VIEW_DISTANCE]))],
        "hides": bool(columns[Column.OCCLUDING]),
    }


def still(replay: CaseReplay, frame: Frame) -> Element:
    """The scene at its key moment."""
    sample, point = replay.key_sample, replay.contact_point
    return scene_svg.scene(
        frame,
        f"{replay.program.name} from above, {_key_words(replay)}",
        scene_svg.road_layer(replay.road, replay.key_time),
        scene_svg.sight_layer(),
        scene_svg.way_layer(replay.ways),
        _ghosts(replay),
        element("g", scene_svg.actor_layer(replay.shapes, replay.trajectory.states[sample]), class_="actors"),
        scene_svg.contact_mark(*point) if point else None,
    )


def key_picture(replay: CaseReplay) -> str:
    """The scene at its key moment, as an SVG of its own."""
    return picture(still(replay, replay.framed(CARD)), drawing_rules())


def _key_words(replay: CaseReplay) -> str:
    what = "at contact" if replay.collided else "at the closest approach"
    return f"{what}, after {fixed(replay.key_time, 2)} s"


def _ghosts(replay: CaseReplay) -> Node:
    """Return the outlines at contact, which stay visible afterwards."""
    if not replay.collided:
        return None
    states = replay.trajectory.states[replay.trajectory.contact_sample]
    return element("g", scene_svg.actor_layer(replay.shapes, states, "ghost"), class_="ghosts")


def _stage(replay: CaseReplay) -> Element:
    return element(
        "div",
        still(replay, replay.frame),
        element("div", [_chip(shape.name, actor) for actor, shape in enumerate(replay.shapes)], class_="legend"),
        None if replay.town is None else scene_svg.overview(replay.town, _middle(replay)),
        element("div", "after contact: physics for illustration, not scored", class_="after-note", hidden=True),
        class_="stage",
        style=f"--shape:{replay.frame.shape:.3f}",
    )


def _middle(replay: CaseReplay) -> tuple[float, float]:
    """Return the position of the ego at the key moment [m]."""
    x, y = replay.trajectory.states[replay.key_sample, 0, :2].tolist()
    return x, y


def _chip(name: str, actor: int) -> Element:
    """Return a button in an actor's colour, which shows the actor's field of view."""
    tint = f"actor-{scene_svg.colour(actor)}"
    return element(
        "button",
        element("i", class_=f"swatch {tint}"),
        name,
        _eye(),
        type="button",
        class_="chip",
        data_viewer=actor,
        data_colour=tint,
        aria_pressed="false",
        title=f"show what {name} sees",
    )


def _eye() -> Element:
    lids = element("path", d="M1 5Q8-3.4 15 5Q8 13.4 1 5Z")
    return element(
        "svg", lids, element("circle", cx=8, cy=5, r=1.9), viewBox="0 0 16 10", class_="eye", aria_hidden="true"
    )


def _controls(replay: CaseReplay) -> Element:
    last = len(replay.trajectory.time) - 1
    return element(
        "div",
        element("button", "▶", type="button", class_="play", aria_label="play or pause", title="play or pause (space)"),
        element("button", "◂", type="button", class_="step", data_by=-1, title="one step back (left arrow)"),
        element("button", "▸", type="button", class_="step", data_by=1, title="one step on (right arrow)"),
        element(
            "div",
            element("div", list(_ticks(replay)), class_="ticks", aria_hidden="true"),
            element(
                "input",
                type="range",
                class_="scrub",
                min=0,
                max=last,
                step="any",
                value=replay.key_sample,
                aria_label="time",
            ),
            class_="track",
        ),
        element("output", f"{fixed(replay.key_time, 2)} s", class_="clock"),
        element(
            "span",
            [
                element(
                    "button",
                    f"{speed:g}×",
                    type="button",
                    class_="speed",
                    data_speed=speed,
                    aria_pressed=(speed == 1 and "true") or "false",
                )
                for speed in SPEEDS
            ],
            class_="speeds",
            role="group",
            aria_label="speed",
        ),
        element(
            "button",
            "sight",
            type="button",
            class_="see",
            aria_pressed="false",
            title="what the ego sees, then another (v)",
        ),
        element("button", "close-up", type="button", class_="zoom", aria_pressed="false", title="follow the ego (c)"),
        class_="controls",
    )


def _ticks(replay: CaseReplay) -> Iterator[Element]:
    """Yield marks on the scrubber for events and for the time after the scored run."""
    time = replay.trajectory.time
    end = float(time[-1]) or 1.0
    if replay.collided and time[-1] > replay.key_time:
        start = 100 * replay.key_time / end
        yield element("i", class_="after", style=f"left:{start:.2f}%;width:{100 - start:.2f}%")
    for moment in replay.moments:
        if moment.kind in ("brake", "closest", "contact", "fastest", "left_road"):
            text = f"{moment.time:.2f} s {moment.text}"
            yield element("i", class_=f"tick {moment.kind}", style=f"left:{100 * moment.time / end:.2f}%", title=text)


def _plots(replay: CaseReplay) -> Iterator[Element]:
    time, near = replay.trajectory.time, replay.approach
    marks = [Mark(replay.key_time, "after", to_end=True)] if replay.collided else []
    marks.append(Mark(replay.key_time, "contact" if replay.collided else "closest"))
    speeds = [_speed(replay, actor) for actor in range(len(replay.shapes))]
    yield _plot("speed", replay.unit.name, speeds, [c.name for c in speeds], replay, marks)
    if len(replay.shapes) > 1:
        other = replay.shapes[replay.pair + 1].name
        distance = _distance(replay)
        closing = Course("closing", "first", time, replay.unit.per_si * near.closing_speed)
        yield _plot("distance", "m", [distance], [f"outlines of ego and {other}"], replay, marks)
        yield _plot(
            "closing speed", replay.unit.name, [closing], ["centres, positive while they approach"], replay, marks
        )


def _distance(replay: CaseReplay) -> Course:
    """Down to 0 at the moment of contact, which lies between two samples."""
    time, near = replay.trajectory.time, replay.approach.distance
    if bool(replay.outcomes.collided[0]):
        after = replay.trajectory.contact_sample + 1
        time, near = np.insert(time, after, replay.key_time), np.insert(near, after, 0.0)
    return Course("apart", "warn", time, near)


def _speed(replay: CaseReplay, actor: int) -> Course:
    values = replay.unit.per_si * replay.speeds[:, actor]
    return Course(replay.shapes[actor].name, f"actor-{scene_svg.colour(actor)}", replay.trajectory.time, values)


def _plot(
    name: str, unit: str, courses: Sequence[Course], labels: Sequence[str], replay: CaseReplay, marks: Sequence[Mark]
) -> Element:
    end = float(replay.trajectory.time[-1]) or 1.0
    chart = line_chart(courses, name, size=(380, 132), x_range=(0.0, end), marks=marks, cursor=True)
    readings = [
        element(
            "span",
            element("i", class_=f"swatch {course.style}"),
            element("span", label, class_="of"),
            element("output", "", data_reading=f"{name}:{index}"),
            class_="reading",
        )
        for index, (course, label) in enumerate(zip(courses, labels, strict=True))
    ]
    head = element("figcaption", element("b", name), element("span", f" {unit}", class_="unit"), readings)
    return element("figure", head, chart, class_="plot")
