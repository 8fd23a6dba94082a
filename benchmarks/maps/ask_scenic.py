"""Scenic's network of a file, as JSON, for `benchmarks.maps`: run by a Python that has Scenic, and nothing of ours.

python ask_scenic.py FILE.xodr < POINTS.json
"""

import json
import math
import sys

from scenic.core.vectors import Vector  # type: ignore[import-not-found]
from scenic.domains.driving.roads import Network  # type: ignore[import-not-found]


def found(path: str, points: list[list[float]]) -> dict:
    """Counts, centre lines, which maneuvers conflict and which are reverse, and at each point the lane, whether it is
    in an intersection, and the way of traffic.
    """
    network = Network.fromFile(path, useCache=False, writeCache=False)
    number = {id(lane): index for index, lane in enumerate(network.lanes)}
    places = [Vector(x, y, 0.0) for x, y in points]
    lanes = [network.laneAt(place) for place in places]
    maneuvers = [maneuver for each in network.intersections for maneuver in each.maneuvers]
    return {
        "lanes": len(network.lanes),
        "intersections": len(network.intersections),
        "ways": [
            [*(number[id(lane)] for lane in (each.startLane, each.connectingLane, each.endLane)), each.type.name]
            for each in maneuvers
        ],
        "conflicts": [_indices(maneuvers, each.conflictingManeuvers) for each in maneuvers],
        "reverse": [_indices(maneuvers, each.reverseManeuvers) for each in maneuvers],
        "lines": [[list(point[:2]) for point in lane.centerline.points] for lane in network.lanes],
        "at": [-1 if lane is None else number[id(lane)] for lane in lanes],
        "inside": [network.intersectionAt(place) is not None for place in places],
        "heading": [
            None if lane is None else lane.orientation.value(place) + 0.5 * math.pi
            for lane, place in zip(lanes, places, strict=True)
        ],
    }


def _indices(maneuvers: list, chosen: tuple) -> list[int]:
    places = {id(each): index for index, each in enumerate(maneuvers)}
    return [places[id(each)] for each in chosen]


if __name__ == "__main__":
    answer = found(sys.argv[1], json.load(sys.stdin))
    sys.stdout.write("\n" + json.dumps(answer) + "\n")
