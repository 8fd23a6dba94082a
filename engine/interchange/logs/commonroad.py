"""A CommonRoad scenario: obstacles with their trajectories, buildings as walls, and the ego as its solution, if a
solution is next to it.

Source: CommonRoad, "XML format 2020a" (and 2018b, whose obstacles have a role): positions are centres of rectangles,
times count steps of the file's `timeStepSize`, angles are radians. States that are intervals contain no motion.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.errors import InterchangeError, quoted
from engine.interchange.commonroad.write import VEHICLES
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.layouts import Layout, Point
from engine.interchange.tables.track import Tracks
from engine.opendrive.near_roads import LARGEST_BUILDING
from engine.unread import unread_elements
from engine.vocabulary import ActorKind
from engine.xml import Limits, Node, read_xml

LIMITS = Limits(megabytes=200.0, elements=12_000_000)
KEYS = ("time", "actor", "x", "y", "heading", "speed", "length", "width", "type")
OBSTACLES = ("dynamicObstacle", "staticObstacle", "obstacle")
SCENARIO, SOLUTION = (".cr.xml", ".xml"), ".solution.xml"
EGO = "ego"
READ: Mapping[str, None] = dict.fromkeys(
    (
        *("commonRoad", *OBSTACLES, "environmentObstacle", "role", "type", "shape", "rectangle", "length", "width"),
        *("initialState", "trajectory", "state", "position", "point", "x", "y", "orientation", "center", "time"),
        *("velocity", "exact", "intervalStart", "intervalEnd"),
    )
)
"""Elements that are read; attributes are numbers of obstacles, and descriptions of the scenario."""
LAYOUT = Layout(
    name="CommonRoad",
    known_by=(),
    columns={"actor": "id", "heading": "orientation", "speed": "velocity"},
    point=Point.CENTER,
    said="times count steps; the ego is its solution, where one lies beside it",
    kinds={
        "parkedvehicle": ActorKind.CAR,
        "priorityvehicle": ActorKind.CAR,
        "train": ActorKind.BUS,
        "constructionzone": ActorKind.OBSTACLE,
        "roadboundary": ActorKind.OBSTACLE,
        "unknown": ActorKind.OBSTACLE,
    },
    ego=EGO,
)


def read_commonroad(path: Path) -> Tracks:
    """Return the tracks of a scenario.

    Raises:
        InterchangeError: unreadable, not a scenario, an outline that is not a rectangle, or a state that is not a
            number.
    """
    root = read_xml(path, "commonRoad", LIMITS, texts=True)
    step = root.number("timeStepSize", low=1e-6)
    last = _last(root)
    rows = [*_ego(path, step), *(row for node in root.every(*OBSTACLES) for row in _obstacle(node, step, last))]
    tracks = _with_buildings(tracks_of_rows(path, LAYOUT, KEYS, rows), root)
    return replace(tracks, remarks=(*tracks.remarks, *unread_elements(root, READ)))


def _with_buildings(tracks: Tracks, root: Node) -> Tracks:
    """Return the tracks with rectangular buildings as walls; a remark names the other obstacles of the environment."""
    walls: list[tuple[float, ...]] = []
    left: list[str] = []
    for node in root.every("environmentObstacle"):
        shape = node.need("shape")
        if _type(node) == "building" and [each.tag for each in shape.children] == ["rectangle"]:
            walls.append(_wall(shape.children[0]))
        else:
            left.append(node.text("id"))
    what = "obstacles of the environment that are not rectangular buildings are left out"
    remarks = (f"{what}: the first is {quoted(left[0])}",) if left else ()
    return replace(tracks, remarks=(*tracks.remarks, *remarks), buildings=np.array(walls) if walls else None)


def _wall(box: Node) -> tuple[float, ...]:
    """Return its row of `Recording.buildings`.

    Raises:
        InterchangeError: a value is missing or not a number, or a size is outside the limits of a building.
    """
    heading, center = box.find("orientation"), box.find("center")
    place = (center.need(axis).content_number() if center else 0.0 for axis in ("x", "y"))
    sizes = [box.need(name) for name in ("length", "width")]
    for each in sizes:
        if not 0.0 < each.content_number() <= LARGEST_BUILDING:
            raise each.error(f"a building of {each.content_number():g} m", f"correct the {each.tag}")
    return *place, heading.content_number() if heading else 0.0, *(each.content_number() for each in sizes)


def _last(root: Node) -> int:
    """Return the last step of all actors; a standing actor is present until then."""
    times = [node.find("exact") for node in root.walk() if node.tag == "time"]
    return max((int(node.content_number()) for node in times if node is not None), default=0)


def _obstacle(node: Node, step: float, last: int) -> Iterator[Row]:
    rectangle = node.need("shape", "rectangle")
    length, width = (rectangle.need(name).content_number() for name in ("length", "width"))
    states = [node.need("initialState"), *_trajectory(node)]
    is_static = node.tag == "staticObstacle" or (node.find("role") is not None and not states[1:])
    for state in states:
        for count in (0, last) if is_static and last else (_exact(state, "time"),):
            yield (
                state.line,
                {
                    "time": count * step,
                    "actor": node.text("id"),
                    "x": state.need("position", "point", "x").content_number(),
                    "y": state.need("position", "point", "y").content_number(),
                    "heading": _exact(state, "orientation"),
                    "speed": _exact(state, "velocity", 0.0 if is_static else None),
                    "length": length,
                    "width": width,
                    "type": _type(node),
                },
            )


def _type(node: Node) -> str:
    found = node.find("type")
    return "" if found is None else found.content.strip()


def _trajectory(node: Node) -> list[Node]:
    found = node.find("trajectory")
    return [] if found is None else found.every("state")


def _exact(state: Node, name: str, default: float | None = None) -> float:
    """Return a value of a state.

    Raises:
        InterchangeError: it is missing, or an interval.
    """
    node = state.find(name, "exact")
    if node is None and default is not None and state.find(name) is None:
        return default
    return state.need(name, "exact").content_number() if node is None else node.content_number()


def _ego(path: Path, step: float) -> Iterator[Row]:
    """Yield the ego's rows; none without a solution."""
    ends = next(end for end in SCENARIO if path.name.endswith(end))
    beside = path.with_name(path.name.removesuffix(ends) + SOLUTION)
    if not beside.is_file():
        return
    root = read_xml(beside, "CommonRoadSolution", LIMITS, texts=True)
    length, width = _size(root)
    if len(root.children) != 1:
        raise root.error(f"it solves {len(root.children)} problems", "leave one of them")
    for state in root.children[0].children:
        values = {node.tag: node for node in state.children}
        missing = next((name for name in ("x", "y", "orientation", "velocity", "time") if name not in values), None)
        if missing:
            raise state.error(f"<{state.tag}> has no <{missing}>", "take a solution of the models KS, ST or MB")
        yield (
            state.line,
            {
                "time": values["time"].content_number() * step,
                "actor": EGO,
                "x": values["x"].content_number(),
                "y": values["y"].content_number(),
                "heading": values["orientation"].content_number(),
                "speed": values["velocity"].content_number(),
                "length": length,
                "width": width,
                "type": "car",
            },
        )


def _size(root: Node) -> tuple[float, float]:
    """Return length and width [m] of the vehicle in the benchmark's name: `KS2:…` is that of number 2."""
    said = root.text("benchmark_id").partition(":")[0][-1:]
    if not said.isdigit() or int(said) not in VEHICLES:
        numbers = ", ".join(map(str, VEHICLES))
        raise InterchangeError("its vehicle is none of CommonRoad's", f"there are {numbers}, as in `KS2:…`", root.place)
    return VEHICLES[int(said)]
