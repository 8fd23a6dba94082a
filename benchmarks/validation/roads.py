"""Every kind of road that `map` can make."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.validation.items import Item
from engine.interchange import Provenance, SignalTimes
from engine.interchange.opendrive import write_opendrive
from engine.maps import RoadSpec
from engine.road import build_network

LIGHTS = SignalTimes(green=20.0, yellow=3.0, all_red=2.0, offset=7.0)
RADII = (0.0, 0.5, 3.0, 6.0, 15.0)
"""Of kerbs at the corners [m]; 0 is a corner that is none."""
GRIDS = ((1, 2), (2, 1), (2, 2), (2, 3))
ODD = (
    RoadSpec(lane_width=2.0, corner_radius=0.0, approach=1.0),
    RoadSpec(lane_width=6.0, lanes=2, approach=1000.0),
    RoadSpec(lanes=4, corner_radius=1.3, approach=33.3),
    RoadSpec(rows=4, cols=4, block=61.7, approach=7.1),
    RoadSpec(approach=100_000.0),
    RoadSpec(buildings=6.0),
    RoadSpec(ways=3, rows=2, cols=2, lanes=2, block=80.0, approach=30.0, buildings=4.5),
)
"""Sizes at the edge of what is allowed, and such as no map-maker would choose; and buildings."""


def specs() -> Iterator[RoadSpec]:
    """Ways x lanes x radius x hand on one intersection, then grids of them."""
    for ways, lanes, radius, left in product((3, 4), (1, 2, 3, 4), RADII, (False, True)):
        yield RoadSpec(ways=ways, lanes=lanes, corner_radius=radius, left_hand=left)
    for (rows, cols), ways, lanes, left in product(GRIDS, (3, 4), (1, 2), (False, True)):
        yield RoadSpec(ways=ways, lanes=lanes, rows=rows, cols=cols, left_hand=left)
    yield from ODD
    yield from (replace(spec, left_hand=True) for spec in ODD)


def swept(folder: Path) -> Iterator[Item]:
    """All of them as OpenDRIVE, with lights and without."""
    folder.mkdir(parents=True, exist_ok=True)
    for spec, lights in product(specs(), (None, LIGHTS)):
        name = name_of(spec, lights is not None)
        file = folder / f"{name}.xodr"
        file.write_text(write_opendrive(spec, lights, name, Provenance(title="a road")), encoding="utf-8")
        yield Item("road", file, counted(spec))


def counted(spec: RoadSpec) -> dict[str, Any]:
    """What others must find on it: see the checkers."""
    network = build_network(spec)
    turns = Counter((each.start_lane.road, each.end_lane.road) for each in network.maneuvers)
    return {
        "through": sorted(len(each.maneuvers) for each in network.intersections),
        "turns": sorted(turns.values()),
        "left_hand": spec.left_hand,
    }


def name_of(spec: RoadSpec, lights: bool) -> str:
    """Fit for a file name."""
    sizes = f"r{spec.corner_radius:g}-w{spec.lane_width:g}-a{spec.approach:g}"
    grid = f"{spec.rows}x{spec.cols}" + (f"-b{spec.block:g}" if spec.rows * spec.cols > 1 else "")
    hand = "left" if spec.left_hand else "right"
    hand += "" if spec.buildings is None else f"-walls{spec.buildings:g}"
    name = f"{spec.ways}way-{spec.lanes}lane-{sizes}-{grid}-{hand}" + ("-lights" if lights else "")
    return name.replace(".", "_")
