"""The same Scenic scripts on the same exported road, sampled here and by Scenic: are the scenes of one law?

Of every object x, y and heading (by its cosine and sine), and of every two their distance, are held against one
another, by Kolmogorov and Smirnov's test of two samples. All tests together find a difference where there is none once
in a hundred times (Bonferroni). Numbers and seeds are fixed, so that a finding comes again. Two headings are given, in
which Scenic 3.1.1 departs from its reference: `beyond` a point it heads north, and in an intersection along the first
lane, in the order of its maneuvers, that holds the point, where ours is the one whose middle is nearest.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from benchmarks.validation.checkers.quantities import quantities
from benchmarks.validation.items import Item
from cortex_dsl import Scenario, load
from engine.interchange import Provenance
from engine.interchange.opendrive import write_opendrive
from engine.maps import RoadSpec
from engine.scenes import Scenes, actor_columns
from engine.tables import Floats
from engine.vocabulary import Column

SCENES = 400
"""Of each script, from each side."""
LEVEL = 0.01
"""Of all tests together."""
ROAD = RoadSpec(ways=4, lanes=2)
HEAD = "param map = localPath('road.xodr')\nmodel scenic.domains.driving.model\n"
FREE = "with regionContainedIn None, with allowCollisions True"
EGO = f"ego = new Object at (Range(-9, 9), Range(0, 5)), facing Range(-60, 60) deg, {FREE}\n"
SCRIPTS = {
    "ranges": f"x = Range(4, 9)\nego = new Object at (x, Range(0, x)), facing Range(0, 90) deg, {FREE}\n",
    "normals": f"ego = new Object at (Normal(3, 2), TruncatedNormal(1, 2, 0, 4)), {FREE}\n",
    "discrete": f"ego = new Object at (Range(2, 3) + Uniform(10, 20, 40), Discrete({{1: 1, 7: 3}})), {FREE}\n"
    f"a = new Object at (DiscreteRange(1, 6), 9), facing Uniform(10, 30) deg, {FREE}\n",
    "resampled": f"x = Range(4, 9)\nego = new Object at (x, resample(x)), {FREE}\n",
    "road": f"ego = new Car on road, {FREE}\na = new Car in intersection, facing 0 deg, {FREE}\n",
    "lanes": f"lane = Uniform(*network.lanes)\nego = new Car on lane.centerline, {FREE}\na = new Car in lane, {FREE}\n",
    "maneuvers": "ways = network.intersections[0].maneuvers\n"
    "m = Uniform(*filter(lambda each: each.type is ManeuverType.STRAIGHT, ways))\n"
    f"ego = new Car on m.startLane.centerline, {FREE}\na = new Car on m.endLane, {FREE}\n",
    "contained": "ego = new Car on road\na = new Car on road\nrequire (distance from ego to a) < 40\n",
    "following": f"ego = new Car on road, {FREE}\n"
    f"a = new Car following roadDirection from (30, 1.75) for Range(1, 9), {FREE}\n",
    "beside": EGO + f"a = new Object left of ego by Range(1, 4), {FREE}\nb = new Object ahead of a by (1, 2), {FREE}\n"
    f"c = new Object offset by (Range(2, 3), 5), {FREE}\n",
    "along": EGO + f"a = new Object offset along 30 deg by (Range(2, 3), 5), {FREE}\n"
    f"b = new Object beyond a by Range(2, 4) from ego, facing 9 deg, {FREE}\n",
    "facing": EGO + f"a = new Object at (20, 9), facing toward ego, {FREE}\n"
    f"b = new Object at (-20, 9), facing Range(-20, 20) deg relative to ego.heading, {FREE}\n"
    f"c = new Object at (-20, 19), apparently facing Range(0, 90) deg from 3 @ 4, {FREE}\n",
    "field": f"ego = new Car on road, facing Range(-5, 5) deg relative to roadDirection, {FREE}\n",
    "regions": f"ego = new Object in CircularRegion(0 @ 0, Range(8, 9)), {FREE}\n"
    f"a = new Object in SectorRegion(5 @ 5, 10, 30 deg, 60 deg), {FREE}\n"
    f"b = new Object in RectangularRegion(1 @ 2, 40 deg, 6, 20), {FREE}\n"
    f"c = new Object in PolygonalRegion([0 @ 0, 20 @ 0, 20 @ 5, 0 @ 30]), {FREE}\n"
    f"d = new Object on PolylineRegion([0 @ 0, 20 @ 0, 20 @ 5]), {FREE}\n",
    "joined": "r = CircularRegion(0 @ 0, 8)\ns = RectangularRegion(5 @ 0, 0, 9, 9)\n"
    f"ego = new Object in r.intersect(s), {FREE}\na = new Object in r.difference(s), {FREE}\n",
    "mutated": f"ego = new Object at (3, 4), facing 30 deg, {FREE}\na = new Object at (9, 9), {FREE}\n"
    "mutate ego by 2\n",
    "soft": EGO + "require[0.5] ego.position.x < 0\nrequire ego.position.y > 1\n",
    "car at a point": "p = new OrientedPoint at (Range(-40, -30), -1.75), facing Range(0, 90) deg\n"
    f"ego = new Car at p, {FREE}\n",
    "thing at a point": f"p = new OrientedPoint at (30, Range(0, 9)), facing 40 deg\nego = new Object at p, {FREE}\n",
    "seen": f"ego = new Car at (0, -30), facing 0 deg, with viewAngle 60 deg, with visibleDistance 40, {FREE}\n"
    f"a = new OrientedPoint in visible road\nb = new Object at a offset by (Range(0, 1), 0), facing 9 deg, {FREE}\n",
}  # fmt: skip


def sampled(folder: Path, scenes: int = SCENES, scripts: Mapping[str, str] = SCRIPTS) -> Iterator[Item]:
    """A file for each script beside the road that all share, with what was sampled here."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "road.xodr").write_text(write_opendrive(ROAD, None, "road", Provenance(title="a road")), encoding="utf-8")
    drawn = {}
    for name, script in scripts.items():
        file = folder / f"{name}.scenic"
        file.write_text(HEAD + script, encoding="utf-8")
        drawn[file] = starts(file, scenes)
    level = LEVEL / sum(len(columns) for columns in drawn.values())
    for file, columns in drawn.items():
        yield Item("samples", file, asked(columns, scenes, level))


def asked(columns: Mapping[str, Floats], scenes: int, level: float) -> dict[str, object]:
    """What Scenic is asked to hold against as many scenes of its own."""
    return {"level": level, "scenes": scenes, "drawn": {name: each.tolist() for name, each in columns.items()}}


def starts(file: Path, scenes: int) -> Mapping[str, Floats]:
    """What is compared of as many scenes of a file."""
    scenario = load(file)
    return of_valid(scenario, scenario.sample(scenes, seed=1))


def of_valid(scenario: Scenario, drawn: Scenes) -> Mapping[str, Floats]:
    values = np.array([actor_columns(scenario.program, row) for row in drawn.values[drawn.valid]])
    return quantities(values[:, :, [Column.X, Column.Y, Column.HEADING]])
