"""Are the roads of OpenDRIVE files what Scenic makes of them? And how long does it take to read and build them?

    python -m benchmarks.maps FOLDER [--points 10000] [--python PYTHON] [--json]
    python -m benchmarks.maps FOLDER --steps [--json]
    python -m benchmarks.maps FOLDER --carla PYTHON
    python -m benchmarks.maps FOLDER --standard
    python -m benchmarks.maps FOLDER --compile FILE.scenic [--json]
    python -m benchmarks.maps FOLDER --script FILE.scenic [--scenes 200] [--python PYTHON] [--json]

Each `.xodr` file of the folder is read and built. Then Scenic's own network of it is asked for counts, types of
maneuvers, which of them conflict and which are the reverse of which, centre lines, and at random points for the lane
and for the direction of traffic. Our strip of the same lane has to hold the point, and outside intersections the
directions have to agree. PYTHON is one that has Scenic; without it the one of `make validate` is set up. A file that
either does not read is named, and why.

With `--carla` it is CARLA's parser that is asked, by a Python that has the package `carla`, which lanes lead into which
(`topology`); no simulator runs. With `--standard` the formulas of ASAM OpenDRIVE say where lanes end (`standard`).
With `--steps` nobody asks another tool: what a step costs on each file is held against one on a grid (`steps`). With
`--compile` it is measured how long a script takes to check whose map is in the folder (`compiling`). With `--script`
both tools sample scenes of a script of Scenic, whose map is found in the folder (`distributions`).
"""

import argparse
import json
import math
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.maps.compiling import seconds
from benchmarks.maps.distributions import compare
from benchmarks.maps.relations import Relations, relations
from benchmarks.maps.standard import compare_with_standard
from benchmarks.maps.steps import shares
from benchmarks.maps.topology import compare_with_carla
from benchmarks.validation import environments
from engine.errors import CortexError
from engine.road import Lane, Network, build_network
from engine.road.opendrive.network import map_file
from engine.tables import ROAD_REGION, Floats

ASK = Path(__file__).with_name("ask_scenic.py")
LONGEST = 600.0
"""That Scenic may take for a file [s]."""
EDGE = 0.25
"""From a lane's border, places nearer to it are not compared: both draw borders by chords [m]."""
TURNED = math.radians(2.0)
"""By which directions may differ beyond the turn from chord to chord of Scenic's line, whose directions are those of
chords [rad]."""
JUMP = 5.0
"""A maneuver of Scenic's whose lanes lie further apart is none: in files that link the lanes of both directions, as
some of esmini's do, Scenic lets traffic start from a lane that leads away [m]."""
MOST = 1.3
"""Times a step on a grid that one on a file may cost."""
SEED = 1


@dataclass
class Report:
    """What was found of one file."""

    file: str
    seconds: float = math.nan
    """Of reading and building."""
    ours: tuple[int, int, int] = (0, 0, 0)
    """Lanes, intersections, maneuvers."""
    scenics: tuple[int, int, int] | None = None
    jumping: int = 0
    """Maneuvers of Scenic's, not counted, from or to a lane that ends elsewhere."""
    other_types: int = 0
    """By how many maneuvers the counts of types differ."""
    turns: list[tuple[float, float]] = field(default_factory=list)
    """Of each maneuver of another type, by how much its lane turns from end to end, and by how much Scenic's line
    of it, from its first chord to its last [degrees, to the left]."""
    conflicting: Relations = field(default_factory=Relations)
    reverse: Relations = field(default_factory=Relations)
    """Of maneuvers."""
    line: float = math.nan
    """How far Scenic's centre lines run beside ours at most [m]."""
    ends: float = math.nan
    """How far they end before or beyond ours at most [m]: Scenic lays lanes out at right angles to chords of the
    reference line, a twentieth of each of its pieces long; ASAM OpenDRIVE, to the reference line."""
    points: int = 0
    """Compared."""
    other_lane: int = 0
    other_ways: int = 0
    """Points outside intersections at which directions of traffic differ by more than chords explain."""
    refused: str = ""
    scenic_refused: str = ""


def main(words: Sequence[str] | None = None) -> int:
    """Compare every file of a folder; 1 where something differs."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.maps", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--python", help="an interpreter that has Scenic")
    parser.add_argument("--steps", action="store_true", help="measure what a step costs instead")
    parser.add_argument("--carla", metavar="PYTHON", help="hold the ways from lane to lane against CARLA's own instead")
    parser.add_argument("--standard", action="store_true", help="hold the ends of lanes against the standard instead")
    parser.add_argument("--compile", type=Path, help="measure how long a script takes to check instead")
    parser.add_argument("--script", type=Path, help="compare sampled scenes of a script of Scenic instead")
    parser.add_argument("--scenes", type=int, default=200, help="of both tools")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(words)
    if options.steps:
        return _steps(sorted(options.folder.glob("*.xodr")), as_json=options.json)
    if options.carla is not None:
        return compare_with_carla(sorted(options.folder.glob("*.xodr")), options.carla)
    if options.standard:
        return compare_with_standard(sorted(options.folder.glob("*.xodr")))
    if options.compile is not None:
        found = seconds(options.compile, options.folder)
        said = (f"{name:16} {took:.2f} s of processor time" for name, took in found.items())
        print(json.dumps(found, indent=1) if options.json else "\n".join(said))
        return 0
    if options.python is None:
        environments.set_up(["scenic"], sys.executable, print)
        options.python = str(environments.python_of("scenic"))
    if options.script is not None:
        return compare(options.script, options.folder, options.scenes, options.python, as_json=options.json)
    reports = []
    for path in sorted(options.folder.glob("*.xodr")):
        reports.append(compared(path, options.points, options.python))
        if not options.json:
            print(sentence(reports[-1]), flush=True)
    if options.json:
        print(json.dumps([asdict(each) for each in reports], indent=1))
    return int(any(map(differs, reports)))


def _steps(paths: Sequence[Path], *, as_json: bool) -> int:
    """1 where a step on a file costs more than `MOST` times one on a grid."""
    grid, found = shares(paths)
    if as_json:
        print(json.dumps({"grid": grid, "times": found}, indent=1))
    else:
        print(f"{'grid':24} {1e9 * grid:.0f} ns an actor-step")
        for name, times in found.items():
            print(f"{name:24} {times:.2f} times that")
    return int(any(times > MOST for times in found.values()))


def differs(report: Report) -> bool:
    if report.refused:
        return not report.scenic_refused
    if report.scenics is None:
        return False
    apart = report.conflicting.differ or report.reverse.differ
    return report.scenics != report.ours or report.other_types > 0 or apart


def sentence(report: Report) -> str:
    if report.refused:
        return f"{report.file:24} refused: {report.refused}"
    counts = " / ".join(map(str, report.ours))
    text = f"{report.file:24} {counts:18} built in {report.seconds:.2f} s"
    if report.scenics is None:
        return f"{text}; Scenic does not read it: {report.scenic_refused}"
    same = "as Scenic" if report.scenics == report.ours else f"Scenic {' / '.join(map(str, report.scenics))}"
    turns = ", ".join(f"{ours:.1f} ({scenics:.1f})" for ours, scenics in report.turns)
    kinds = f"{report.other_types} of other types" if report.other_types else "the same types"
    kinds += f", turning by {turns} degrees" if turns else ""
    kinds += f", {report.jumping} more in Scenic that jump" if report.jumping else ""
    return (
        f"{text}; {same}, {kinds}; pairs of maneuvers that conflict: {report.conflicting}, of reverse ones: "
        f"{report.reverse}; centre lines within {100.0 * report.line:.1f} cm, their ends within "
        f"{100.0 * report.ends:.1f} cm; another lane at {report.other_lane} of {report.points:,} points, another "
        f"direction at {report.other_ways}"
    )


def compared(path: Path, points: int, python: str) -> Report:
    report, network = Report(path.name), None
    begun = time.perf_counter()
    try:
        network = build_network(map_file(path, path.name))
    except CortexError as error:
        report.refused = error.message
    else:
        report.seconds = time.perf_counter() - begun
        report.ours = len(network.lanes), len(network.intersections), len(network.maneuvers)
    places = np.zeros((0, 2)) if network is None else scattered(network, points)
    asked = subprocess.run(
        [python, str(ASK), str(path)],
        input=json.dumps(places.tolist()), capture_output=True, text=True, timeout=LONGEST, check=False,
    )  # fmt: skip
    if asked.returncode:
        report.scenic_refused = (asked.stderr.strip().splitlines() or ["no reason"])[-1][:120]
    elif network is not None:
        _compare(report, network, places, json.loads(asked.stdout.strip().splitlines()[-1]))
    return report


def scattered(network: Network, count: int) -> Floats:
    """(count, 2) places spread evenly over the road."""
    rng, triangles = np.random.default_rng(SEED), network.regions.shape(ROAD_REGION).triangles
    a, b, c = triangles[:, :2], triangles[:, 2:4], triangles[:, 4:]
    areas = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    chosen = rng.choice(len(triangles), size=count, p=areas / areas.sum())
    u, v = rng.random((2, count, 1))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    return a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]


def _compare(report: Report, network: Network, places: Floats, theirs: dict) -> None:
    lines = [np.array(line) for line in theirs["lines"]]
    driven = [kind for *way, kind in theirs["ways"] if jump(*(lines[lane] for lane in way)) < JUMP]
    report.scenics = theirs["lanes"], theirs["intersections"], len(driven)
    report.jumping = len(theirs["ways"]) - len(driven)
    kinds, paths = Counter(each.type.name for each in network.maneuvers), network.paths
    report.other_types = sum((kinds - Counter(driven)).values())
    same = [_same_lane(network, line) for line in lines]
    apart = np.abs(np.concatenate([_beside(network, *each) for each in zip(same, lines, strict=True)]))
    ids = [lane.id for lane in same]
    report.turns = list(_turns_apart(network, ids, lines, theirs["ways"]))
    report.conflicting, report.reverse = relations(network, ids, theirs)
    report.ends, report.line = apart.max(axis=0).tolist()
    for (x, y), at, inside, heading in zip(places, theirs["at"], theirs["inside"], theirs["heading"], strict=True):
        if at < 0:
            continue
        lane, there = same[at], list(_lanes_there(network, x, y))
        deep = paths.distance(lane.path, x, y) < 0.5 * lane.width - EDGE
        if not deep:
            continue
        report.points += 1
        report.other_lane += lane not in there
        if not inside:
            pose = paths.pose(lane.path, paths.project(lane.path, x, y))
            allowed = TURNED + turn_of_chords(lines[at], x, y)
            report.other_ways += abs(math.remainder(pose.heading - heading, math.tau)) > allowed


def jump(start: Floats, connecting: Floats, end: Floats) -> float:
    """How far the ends of three centre lines lie apart that follow each other [m]."""
    return max(math.dist(start[-1], connecting[0]), math.dist(connecting[-1], end[0]))


def _turns_apart(
    network: Network, same: Sequence[int], lines: Sequence[Floats], ways: Sequence[Sequence[Any]]
) -> Iterator[tuple[float, float]]:
    """Of maneuvers that Scenic gives another type: the turn of our lane, and that of Scenic's line."""
    ours = {(each.start, each.connecting, each.end): each for each in network.maneuvers}
    for start, connecting, end, kind in ways:
        mine = ours.get((same[start], same[connecting], same[end]))
        if mine is not None and mine.type.name != kind:
            path, chords = mine.connecting_lane.path, np.diff(lines[connecting], axis=0)
            first, last = (network.paths.pose(path, s).heading for s in (0.0, network.paths.length(path)))
            yield _turn(first, last), _turn(*(math.atan2(y, x) for x, y in chords[[0, -1]].tolist()))


def _turn(before: float, after: float) -> float:
    """[degrees], to the left."""
    return math.degrees(math.remainder(after - before, math.tau))


def _beside(network: Network, lane: Lane, line: Floats) -> Floats:
    """(n, 2): how far points lie ahead and to the left of the nearest place of a lane."""
    poses = [network.paths.pose(lane.path, float(s)) for s in network.paths.feet(lane.path, *line.T).s]
    x, y, heading = np.array([(pose.x, pose.y, pose.heading) for pose in poses]).T
    (dx, dy), cos, sin = (line - np.stack([x, y], axis=1)).T, np.cos(heading), np.sin(heading)
    return np.stack([dx * cos + dy * sin, dy * cos - dx * sin], axis=1)


def turn_of_chords(line: Floats, x: float, y: float) -> float:
    """The largest turn from one chord of a line to the next, at the three vertices nearest to a place [rad]."""
    chords = np.diff(line, axis=0)
    chords = chords[np.hypot(*chords.T) > 0.0]
    turns = np.abs(np.remainder(np.diff(np.arctan2(chords[:, 1], chords[:, 0])) + math.pi, math.tau) - math.pi)
    nearest = int(np.hypot(*(line[1:-1] - (x, y)).T).argmin()) if len(line) > 2 else 0
    return float(turns[max(nearest - 1, 0) : nearest + 2].max(initial=0.0))


def _same_lane(network: Network, line: Floats) -> Lane:
    """Ours that runs along a centre line of Scenic's."""

    def off(lane: Lane) -> float:
        first, last = (network.paths.pose(lane.path, s) for s in (0.0, lane.length))
        return math.hypot(first.x - line[0, 0], first.y - line[0, 1]) + math.hypot(
            last.x - line[-1, 0], last.y - line[-1, 1]
        )

    return min(network.lanes, key=off)


def _lanes_there(network: Network, x: float, y: float) -> Iterator[Lane]:
    """The lanes whose strips hold a point."""
    for lane in network.lanes:
        edges = network.regions.shape(lane.region).edges[:, :2]
        (west, south), (east, north) = edges.min(axis=0), edges.max(axis=0)
        if west <= x <= east and south <= y <= north and network.regions.contains(lane.region, x, y):
            yield lane


if __name__ == "__main__":
    sys.exit(main())
