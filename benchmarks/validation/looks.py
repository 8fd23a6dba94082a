"""Scenes of boxes in which one looks at another past the rest, with our verdicts, for Scenic to give its own.

Scenic casts a ray each fifth of a degree, in space, and lets objects that overlap hide each other. So scenes are left
out in which a verdict hangs on less than `SLIVER`, on an angle or radius that is a little larger or smaller, or on
outlines that overlap.
"""

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.validation.items import Item
from engine.kernels.geometry import View, box_distance
from engine.kernels.sight import SEEN, Shades, look
from tests.engine.kernels.sight_reference import Scene, by_rays, depth_inside, drawn, table

SLIVER = math.radians(1.0)
"""The least width of what is seen of a target [rad]."""
WIDER = math.radians(2.0)
FARTHER = 0.5
"""[m]"""
A_FILE = 250
"""Scenes in one file."""
MOST = 6
"""Outlines that may hide."""
NO_BUILDINGS = np.zeros((0, 5))


def looked(folder: Path, scenes: int, seed: int = 1) -> Iterator[Item]:
    """Files of scenes on whose verdicts rays and intervals can agree."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    left_out = 0
    for number in range(math.ceil(scenes / A_FILE)):
        kept: list[dict[str, object]] = []
        while len(kept) < min(A_FILE, scenes - number * A_FILE):
            scene = drawn(random, int(random.integers(0, MOST + 1)))
            if _is_clear(scene):
                kept.append(_as_json(scene))
            else:
                left_out += 1
        file = folder / f"looks{number + 1}.json"
        file.write_text(json.dumps({"left_out_so_far": left_out, "scenes": kept}, indent=1), encoding="utf-8")
        yield Item("looks", file)


def _is_clear(scene: Scene) -> bool:
    view, target, shades = scene
    if any(box_distance(box, target) < 0.1 or depth_inside(box, view.x, view.y) > -0.1 for box in shades):
        return False
    if depth_inside(target, view.x, view.y) > -0.1:
        return False
    widths = by_rays(scene)
    if 0.0 < widths.seen < SLIVER or 0.0 < widths.in_sector < SLIVER:
        return False
    verdict = _seen(scene)
    return all(_seen(scene._replace(view=each)) == verdict for each in _nearly(view))


def _nearly(view: View) -> Iterator[View]:
    """Views that are a little wider, narrower, longer or shorter."""
    for by in (-1.0, 1.0):
        if view.angle < math.tau:
            yield view._replace(angle=min(max(view.angle + by * WIDER, 0.0), math.tau))
        yield view._replace(distance=max(0.0, view.distance + by * FARTHER))


def _seen(scene: Scene) -> bool:
    view, target, shades = scene
    return look(view, target, Shades(table(shades), 0, len(shades), -1, -1), NO_BUILDINGS) == SEEN


def _as_json(scene: Scene) -> dict[str, object]:
    view, target, shades = scene
    numbers = [[float(value) for value in box] for box in (view, target, *shades)]
    return {"view": numbers[0], "target": numbers[1], "shades": numbers[2:], "seen": _seen(scene)}
