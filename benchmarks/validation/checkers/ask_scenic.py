"""Scenic: what its parser makes of a road, where its compiler puts the objects of a source, what it samples."""

# Its packages live in an environment of their own, where no type checker looks.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false, reportCallIssue=false, reportArgumentType=false

import json
import math
import random
from pathlib import Path

import numpy as np
import scenic
from answering import answer
from quantities import quantities
from scenic.core.object_types import Object, OrientedPoint
from scenic.core.vectors import Vector
from scenic.domains.driving.roads import Network
from scipy.stats import ks_2samp

NEAR = 1e-6
"""Of positions [m] and headings [rad]."""


def check(job: dict) -> list[str]:
    """A road is counted, a source compiled, looks are taken, scenes sampled."""
    if "drawn" in job:
        return sample(job)
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


ROUND = 4
"""Digits that are compared: where something has one value, both have it but for rounding."""
MOST_TRIES = 100_000


def sample(job: dict) -> list[str]:
    """As many scenes as asked for, on the map that is named; which quantities have another law than ours."""
    random.seed(1)
    np.random.seed(1)  # Scenic draws from it
    if "map" in job:  # what Verifai would search is drawn evenly
        text = Path(job["file"]).read_text(encoding="utf-8").replace("Verifai", "")
        model = "scenic.domains.driving.model"
        scenario = scenic.scenarioFromString(text, params={"map": job["map"]}, model=model, mode2D=True)
    else:
        scenario = scenic.scenarioFromFile(job["file"], mode2D=True)
    scenes = [scenario.generate(maxIterations=MOST_TRIES)[0].objects for _ in range(job["scenes"])]
    places = [[(each.position.x, each.position.y, each.heading + math.pi / 2) for each in scene] for scene in scenes]
    theirs = quantities(np.array(places))
    if theirs.keys() != job["drawn"].keys():
        return [f"Scenic has {len(places[0])} objects"]
    return [finding for name in theirs if (finding := differs(name, job["drawn"][name], theirs[name], job["level"]))]


def differs(name: str, ours: list[float], theirs: np.ndarray, level: float) -> str:
    rounded = [np.round(np.array(each) + math.pi * 10.0 ** -(ROUND + 1), ROUND) for each in (ours, theirs)]
    p = ks_2samp(*rounded, method="asymp").pvalue
    means = [f"{np.mean(each):.3g}" for each in rounded]
    return f"{name}: p = {p:.1e}, means {means[0]} here and {means[1]} there" if p < level else ""


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
