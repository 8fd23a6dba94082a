"""Scenic: what its parser makes of a road, and where its compiler puts the objects of a source."""

import math
from pathlib import Path

import scenic
from answering import answer
from scenic.domains.driving.roads import Network

NEAR = 1e-6
"""Of positions [m] and headings [rad]."""


def check(job: dict) -> list[str]:
    """A road is counted, a source compiled."""
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


answer(check)
