"""Scenic: what its parser makes of a road, and where its compiler puts the objects of a source."""

import json
import math
from pathlib import Path

import scenic
from answering import answer
from scenic.core.object_types import Object, OrientedPoint
from scenic.core.vectors import Vector
from scenic.domains.driving.roads import Network

NEAR = 1e-6
"""Of positions [m] and headings [rad]."""


def check(job: dict) -> list[str]:
    """A road is counted, a source compiled, looks are taken."""
    if job["file"].endswith(".json"):
        return take_looks(job)
    return count(job) if job["file"].endswith(".xodr") else place(job)


def count(job: dict) -> list[str]:
    """Intersections and the maneuvers through each, against ours."""
    network = Network.fromFile(job["file"], useCache=False, writeCache=False)
    seen = sorted(len(each.maneuvers) for each in network.intersections)
    found = []
    if len(seen) != len(job["through"]):
        found.append(f"Scenic sees {len(seen)} intersections of {len(job['through'])}")
    elif seen != job["through"]:
        found.append(f"Scenic sees {seen} maneuvers through the intersections, not {sorted(job['through'])}")
    return found


def place(job: dict) -> list[str]:
    """Objects at the start, against ours; Scenic's heading 0 points along +y."""
    scenario = scenic.scenarioFromFile(job["file"], mode2D=True)
    scene, _ = scenario.generate(maxIterations=1)
    if len(scene.objects) != len(job["places"]):
        return [f"Scenic places {len(scene.objects)} objects of {len(job['places'])}"]
    found = []
    for thing, (x, y, heading) in zip(scene.objects, job["places"], strict=True):
        off = math.hypot(thing.position.x - x, thing.position.y - y)
        turned = math.remainder(thing.heading + math.pi / 2 - heading, math.tau)
        if off > NEAR or abs(turned) > NEAR:
            found.append(f"{Path(job['file']).name}: an object is off by {off:.3g} m and {turned:.3g} rad")
    return found


HEIGHT = 2.0
"""Of all objects, the viewer at half of it: what hides in the plane then hides in space [m]."""


def take_looks(job: dict) -> list[str]:
    """Whether each target is seen, against ours. Objects are boxes around one height, and so is the viewer."""
    scenes = json.loads(Path(job["file"]).read_text())["scenes"]
    wrong = [number for number, scene in enumerate(scenes) if can_see(scene) != scene["seen"]]
    return [f"Scenic says otherwise of {len(wrong)} of {len(scenes)} looks: {wrong[:10]}"] if wrong else []


def can_see(scene: dict) -> bool:
    """From the origin: Scenic 3.1.1 turns a target's centre into the viewer's frame before it subtracts the viewer's
    place, so that viewers elsewhere see centres that are behind them.
    """
    x, y, heading, angle, distance = scene["view"]
    viewer = OrientedPoint._with(
        position=Vector(0.0, 0.0, 0.0),
        yaw=heading - math.pi / 2,
        viewAngles=(angle, math.pi),
        visibleDistance=distance,
    )
    shades = tuple(box(each, x, y) for each in scene["shades"])
    return bool(viewer.canSee(box(scene["target"], x, y), shades))


def box(numbers: list[float], from_x: float, from_y: float) -> Object:
    x, y, heading, length, width = numbers
    place = {"position": Vector(x - from_x, y - from_y, 0.0), "yaw": heading - math.pi / 2}
    return Object._with(**place, length=length, width=width, height=HEIGHT)


answer(check)
