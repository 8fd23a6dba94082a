"""Two cars meet on every kind of road, for the formats that carry a road and its traffic in one."""

from collections.abc import Iterator
from dataclasses import fields
from itertools import cycle
from pathlib import Path

from benchmarks.validation.roads import name_of, specs
from cortex_dsl import compile_text
from cortex_dsl.interchange.cases import ExportCase, case_of_scene
from engine.maps import RoadSpec
from engine.road import build_network

ROOM = 15.0
"""Length of an arm on which two cars can start [m]."""
UNITS = {"lane_width": "m", "corner_radius": "m", "approach": "m", "block": "m"}
SCENE = """
map intersection({road})
{lights}
here = network.intersections[0]
way = here.maneuvers[{way}]
other_way = way.conflictingManeuvers[0]
ego = new Car before here by 8 m along way, with speed 8 m/s, with behavior FollowTrajectoryBehavior(8 m/s, way)
other = new Car before here by 9 m along other_way, with speed 8 m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, other_way)
terminate after 5 s
"""


def drives() -> Iterator[tuple[ExportCase, tuple[str, ...]]]:
    """A case for each road on which two cars have room to start, every other one with lights, and how to write it.

    Scenic takes every road for one with right-hand traffic, and its export refuses others.
    """
    for spec, lights in zip((spec for spec in specs() if spec.approach > ROOM), cycle((False, True)), strict=False):
        text = SCENE.format(road=_arguments(spec), lights="signals(offset=7 s)" if lights else "", way=_crossed(spec))
        name = name_of(spec, lights)
        scenario = compile_text(text, name)
        scenes = scenario.sample(1)
        if scenes.valid[0]:
            kinds = ("replay", "commonroad") if spec.left_hand else ("replay", "commonroad", "scenic")
            yield case_of_scene(scenario, scenes, Path(f"{name}.scn"), None, f"cortexc {name}.scn"), kinds


def _crossed(spec: RoadSpec) -> int:
    """The first maneuver of an intersection that meets another."""
    maneuvers = build_network(spec).intersections[0].maneuvers
    return next(index for index, maneuver in enumerate(maneuvers) if maneuver.conflicting_maneuvers)


def _arguments(spec: RoadSpec) -> str:
    """As `map intersection(...)` takes them."""
    values = ((field.name, getattr(spec, field.name)) for field in fields(spec))
    said = ((name, value) for name, value in values if value is not None)
    return ", ".join(f"{name}={value} {UNITS.get(name, '')}".rstrip() for name, value in said)
