"""Scenic's reference, row by row: the tables of `docs/reference/scenic.md`, with a program behind each row.

What is the same or differs compiles, what is missing is refused. `UPDATE_GOLDEN=1` writes the page's table again.
"""

import os
import re
from pathlib import Path
from typing import NamedTuple

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "scenic.md"
EGO = "map intersection(lanes=2)\nego = new Car on road, with allowCollisions True\n"


class Row(NamedTuple):
    """A construct of Scenic 3: what it is here (`same`, `differs` or `missing`), how or why, and a program."""

    construct: str
    here: str
    how: str
    program: str


def _same(construct: str, program: str, how: str = "") -> Row:
    return Row(construct, "same", how, program)


def _differs(construct: str, how: str, program: str) -> Row:
    return Row(construct, "differs", how, program)


def _missing(construct: str, why: str, program: str) -> Row:
    return Row(construct, "missing", why, program)


PLAIN = "the world is flat"
BODY = (
    "behavior B():\n    {}\n    wait\n"
    "a = new Car on road, with behavior B(), with allowCollisions True, with foo 3\nrequire a.foo > 2\n"
)
TABLES: dict[str, tuple[Row, ...]] = {
    "specifiers": (
        _same("`with P V`", "a = new Object with foo 3\n",
              "on anything but an `Object`: only properties that the file uses"),
        _same("`at V`", "a = new Object at (20, 3)\n",
              "takes only the place; without a `model` line also the heading of an oriented point"),
        _same("`in R`, `on R`", "a = new Car in road\nb = new Car on road\n"),
        _differs("`in intersection`", "heads along the lane with the nearest centre line; Scenic 3.1.1 takes the first "
                 "lane of its list of maneuvers that contains the point", "a = new Car in intersection\n"),
        _same("`contained in R`", "a = new Car contained in road\n"),
        _same("`offset by V`", "a = new Object offset by (0, 9)\n"),
        _same("`offset along D by V`", "a = new Object offset along 30 deg by (0, 9)\n"),
        _differs("`beyond P by V from Q`", "heads as Q does, as Scenic's reference says; Scenic 3.1.1 heads north",
                 "a = new Object beyond (9, 9) by 3 from ego\n"),
        _same("`visible [from X]`, `not visible [from X]`", "a = new Car visible\nb = new Car not visible from ego\n"),
        _same("`left of`, `right of`, `ahead of`, `behind`", "a = new Object left of (9, 9) by (1, 2)\n"),
        _missing("`above`, `below`", PLAIN, "a = new Object above ego by 3\n"),
        _same("`following F from V for S`", "a = new Car following roadDirection from ego for 9\n",
              "follows the lanes of the road; other fields in steps, as in Scenic"),
        _same("`facing H`, `facing F`", "a = new Object facing 30 deg\nb = new Car on road, facing roadDirection\n"),
        _missing("`facing (yaw, pitch, roll)`", PLAIN, "a = new Object facing (1, 2, 3)\n"),
        _same("`facing toward V`, `facing away from V`", "a = new Object facing toward (9, 9)\n"),
        _same("`facing directly toward V`", "a = new Object facing directly away from (9, 9)\n"),
        _same("`apparently facing H from V`", "a = new Object at (9, 9), apparently facing 3 deg from ego\n"),
        _missing("`using`", "an object has one way to be placed", "a = new Object using f\n"),
    ),
    "operators": (
        _same("`relative heading of H from H`", "x = relative heading of ego from 3 deg\n"),
        _same("`apparent heading of X from V`", "x = apparent heading of ego from (3, 3)\n"),
        _same("`distance from V to V`", "x = distance from ego to (3, 3)\n", "also to regions"),
        _same("`angle from V to V`", "x = angle from (1, 1) to (3, 3)\n"),
        _missing("`altitude from V to V`", PLAIN, "x = altitude from ego to (3, 3)\n"),
        _same("`distance past X of Y`", "x = distance past (3, 3) of ego\n"),
        _same("`X can see Y`", "require not ego can see (90, 90)\n", "in the plane; Scenic casts rays in space"),
        _same("`X in R`", "require ego in road\n"),
        _same("`X intersects R`", "require ego intersects road\n", "not with regions of the file's own"),
        _same("`H relative to H`, `F relative to H`", "x = 3 deg relative to roadDirection\n"),
        _same("`V offset by V`, `V offset along D by V`", "x = (3, 3) offset along 9 deg by (1, 1)\n"),
        _same("`F at V`", "require (roadDirection at ego) > -9\n", "in brackets"),
        _same("`follow F from V for S`", "p = follow roadDirection from ego for 9\n"),
        _same("`front of X` … `back right of X`", "p = back right of ego\n"),
        _missing("`top of X`, `bottom front left of X`", PLAIN, "p = top of ego\n"),
        _same("`visible R`, `not visible R`", "a = new Car on visible road\n"),
        _same("`R visible from X`, `R not visible from X`", "a = new Car in road not visible from ego\n"),
        _same("`a if c else b`, `and`, `or`, `not`, arithmetic", "x = 3 if 2 > 1 and not False else 4 ** 2\n"),
    ),
    "statements": (
        _same("`model`", "model scenic.domains.driving.model\n", "headings and sizes are then Scenic's"),
        _same("`import`, `from … import`", "x = 1\n",
              "of `.scn` and `.scenic` files; Python modules are not available"),
        _same("`param`", "param X = VerifaiRange(1, 2)\nrequire X > 0\n"),
        _same("`class`", "class Post:\n    width: 0.2 m\na = new Post at (9, 9)\n"),
        _missing("attributes of a property, `[additive]`", "a class has one default", "class A:\n    x[additive]: 3\n"),
        _missing("methods of a class", "write a `def` beside it", "class A:\n    def f(self):\n        return 3\n"),
        _same("`require`, `require[p]`", "require[0.5] ego.speed >= 0\n"),
        _same("`require always`, `eventually`, `next`, `until`, `implies`",
              "require always ego.speed < 90\nterminate after 3 s\n", "a scene whose start breaks one is drawn again"),
        _same("`require monitor`", "monitor M():\n    while True:\n        wait\nrequire monitor M()\n"),
        _same("`terminate when`, `terminate after`", "terminate when ego.speed > 9\nterminate after 3 s\n"),
        _same("`record`", "record ego.speed as speed\nterminate after 1 s\n", "numbers and truth values, no lists"),
        _differs("`mutate`", "an object placed relative to a mutated one sees its noise", "mutate ego\n"),
        _same("`if`, `for`, `while`, `def`, `assert`",
              "def f(x):\n    return x + 1\nfor i in range(3):\n    assert f(i) > 0\n",
              "on values that are known at compile time"),
        _missing("`def f(**rest)`, `raise`, `with`, `del`, `global`", "the compiler runs only code that produces data",
                 "x = 3\ndel x\n"),
        _same("`behavior`, `precondition`, `invariant`", BODY.format("pass")),
        _same("`do`, `do … until`, `do … for`", BODY.format("do IdleBehavior() for 1 seconds")),
        _same("`new` in a behavior or in `compose`", BODY.format("new Object ahead of self by 9"),
              "not at a place drawn from a region; an occupied one aborts the run"),
        _same("`do choose`, `do shuffle`", BODY.format("do choose IdleBehavior(), BrakeBehavior()")),
        _same("`take`, `wait`, `wait for`, `wait until`", BODY.format("wait for 2 steps")),
        _same("`try`, `interrupt when`, `abort`",
              BODY.format("try:\n        wait\n    interrupt when self.speed > 9:\n        abort")),
        _missing("`except`", "nothing is raised", BODY.format("try:\n        wait\n    except E:\n        wait")),
        _same("`self.x = V`", BODY.format("self.foo += 1"), "numbers and truth values that the object was made with"),
        _missing("`self.position = V`", "the run moves objects", BODY.format("self.position = (1, 1)")),
        _same("`scenario`, `setup`, `compose`",
              "scenario S():\n    setup:\n        terminate after 1 s\n"
              "scenario Main():\n    compose:\n        do S()\n"),
        _same("`override X with behavior B`, `with foo V`",
              "a = new Object with foo 3\nrecord a.foo as foo\nscenario S():\n    setup:\n"
              "        override ego with behavior BrakeBehavior()\n        override a with foo 4\n"
              "        terminate after 1 s\nscenario Main():\n    compose:\n        do S()\n",
              "numbers and truth values that no behavior sets"),
        _missing("`override X with width V`", "properties that the simulation reads are fixed with the scene",
                 "scenario S():\n    setup:\n        override ego with width 4\n        terminate after 1 s\n"
                 "scenario Main():\n    compose:\n        do S()\n"),
        _same("`param`, `behavior`, `monitor`, `def` in a scenario",
              "scenario Main():\n    setup:\n        param p = Range(3, 4)\n        behavior B():\n            wait\n"
              "        a = new Object with behavior B\n        require p > 2\n    compose:\n        wait\n",
              "a param is fixed with the scene, whenever the scenario starts"),
        _same("`initial scenario`",
              "scenario Main():\n    setup:\n        x = initial scenario\n    compose:\n        wait\n"),
    ),
    "values": (
        _same("`Range`, `Normal`, `TruncatedNormal`",
              "x = Range(1, 2) + Normal(0, 1) + TruncatedNormal(0, 1, -1, 1)\n"),
        _same("`Uniform`, `Discrete`, `DiscreteRange`", "x = Uniform(1, 2) + Discrete({1: 2, 3: 4})\n"),
        _same("`VerifaiRange`, `VerifaiOptions`, `VerifaiDiscreteRange`",
              "param X = VerifaiOptions(1, 2)\nrequire X > 0\n", "as a `param`, a gene of the search"),
        _same("`resample(x)`", "x = Range(1, 2)\ny = resample(x)\n", "of numbers drawn from one distribution"),
        _missing("a `filter` on random values", "the items of a list are known before a scene is drawn",
                 "x = filter(lambda y: y > 0, [Range(-1, 1)])\n"),
        _same("`CircularRegion`, `SectorRegion`, `RectangularRegion`", "a = new Object in CircularRegion((9, 9), 3)\n"),
        _same("`PolygonalRegion`, `PolylineRegion`", "a = new Object on PolylineRegion([(0, 0), (9, 9)])\n",
              "of points known at compile time"),
        _same("`everywhere`, `nowhere`", "a = new Object with regionContainedIn everywhere\n"),
        _same("`R.union(S)`, `R.intersect(S)`, `R.difference(S)`",
              "a = new Object in CircularRegion((9, 9), 3).union(CircularRegion((0, 9), 3))\n",
              "of regions of the file's own"),
        _missing("`MeshRegion`, `VoxelRegion`, `PathRegion`, shapes", PLAIN, "r = MeshVolumeRegion(3)\n"),
        _same("`VectorField`", 'f = VectorField("f", lambda p: 2 * p.x)\na = new Object facing f\n'),
        _missing("`PolygonalVectorField`", "write a `VectorField` that tests where it is",
                 'f = PolygonalVectorField("f", [])\n'),
        _same("`Workspace`", "workspace = Workspace(CircularRegion((0, 0), 300))\n"),
        _same("`sin`, `hypot`, `min`, `max`, `len`, `range`, `round`", "x = max(sin(3), hypot(3, 4), round(2.5))\n"),
        _differs("`str`, `float`, `int`, `isinstance`",
                 "a whole number is always an `int`; texts must be known, and `int` also takes drawn numbers",
                 "assert isinstance(ego, Car) and isinstance(int(2.5), (int, float)) and isinstance(3.0, int)\n"),
        _differs("f-strings",
                 "whole numbers have no `.0`, and numbers have their unit; values are known or a finite choice",
                 'x = f"{3} {2.5:.2f} {6 / 2} {5 m}"\nassert x == "3 2.50 3 5 m"\n'),
        _same("`globalParameters`", "param X = 3\nx = globalParameters.X\n"),
    ),
    "properties": (
        _same("`position`, `heading`", "x = ego.position.x\ny = ego.heading\n"),
        _differs("`heading` of a `Pedestrian` without one", "is north; Scenic 3.1.1 draws one",
                 "a = new Pedestrian at (9, 9)\n"),
        _missing("`yaw`, `pitch`, `roll`, `orientation`, `parentOrientation`", PLAIN, "x = ego.pitch\n"),
        _same("`width`, `length`", "a = new Object with width 3, with length 2\n"),
        _differs("a default that uses another property", "uses the value drawn; of a `Uniform` in `self.foo`, Scenic "
                 "3.1.1 takes the first option in every scene",
                 "class A:\n    foo: Uniform(4, 6)\n    bar: self.foo + 1\na = new A at (9, 9)\n"),
        _differs("`height`, `blueprint`, `color`", "are read and do nothing", "a = new Object with height 3\n"),
        _same("`regionContainedIn`, `allowCollisions`, `requireVisible`",
              "a = new Car on road, with requireVisible True\n"),
        _same("`visibleDistance`, `viewAngle`, `occluding`", "a = new Object with visibleDistance 9\n"),
        _same("`visibleDistance` of a `Point`",
              "p = new Point at (9, 9), with visibleDistance 3\na = new Object visible from p\n",
              "of an `OrientedPoint` also `viewAngle`"),
        _same("`speed`", "a = new Car on road, with speed 3\n"),
        _same("`velocity`", "require ego.velocity.x < 99\n", "`.x` and `.y`; the speed in the direction of motion"),
        _same("`angularSpeed`", "record ego.angularSpeed as w\n", "anticlockwise; 0 for people, who turn at once"),
        _missing("`with angularSpeed V`", "a vehicle turns by its wheels", "a = new Car with angularSpeed 3\n"),
        _missing("`with velocity V`", "write `with speed V`", "a = new Car on road, with velocity (3, 4)\n"),
        _same("`behavior`", "a = new Object with behavior IdleBehavior\n"),
        _missing("`lastActions`", "actions are not values; read `x.throttle`, `x.brake` or `x.steer`",
                 "record ego.lastActions as a\n"),
        _same("`left`, `frontRight`, …", "p = ego.frontRight\n"),
        _same("`visibleRegion`", "a = new Object in ego.visibleRegion\n", "in the plane"),
    ),
    "domain": (
        _same("`road`, `network`, `intersection`", "x = network.lanes[0]\n",
              "with a `model` line, `intersection` of a map with several is their region"),
        _same("`lane.maneuvers`, `lane.sections`, `laneToLeft`, …", "x = network.lanes[0].sections[0].laneToLeft\n"),
        _same("`network.laneAt`, `roadAt`, `laneGroupAt`, `intersectionAt`", "x = network.laneAt(ego)\n"),
        _same("`sidewalk`, `curb`, `shoulder`, `network.sidewalks`, `crossings`, `laneGroup.curb`, `x.crossing`, …",
              "a = new Pedestrian on network.laneGroups[0].curb, with regionContainedIn None\n",
              "[streets](language/streets.md); crossings are read, which Scenic leaves empty; sidewalks and shoulders "
              "on the side of a one-way road without lanes count, too"),
        _same("`network.elements`", 'x = network.elements["south"]\n',
              "roads and intersections by Scenic's names, lanes by their names in reports"),
        _same("`FollowLaneBehavior`, `FollowTrajectoryBehavior`, `LaneChangeBehavior`",
              "a = new Car on road, with behavior FollowLaneBehavior(9)\n",
              "with a precise follower instead of a PID controller"),
        _same("`TurnBehavior`", "m = network.maneuvers[0]\nway = [m.startLane, m.connectingLane, m.endLane]\n"
              "a = new Car in intersection, with behavior TurnBehavior(way)\n", "along lanes, not along a centerline"),
        _differs("`AutopilotBehavior`", "is `GivingWayBehavior`; in Scenic it is the simulator's own driver",
                 "a = new Car on road, with behavior AutopilotBehavior()\n"),
        _same("`SetThrottleAction`, `SetBrakeAction`", BODY.format("take SetBrakeAction(1)"),
              "hold until the next one with a `model` line, otherwise for one step"),
        _same("`SetSteerAction`, `SetSpeedAction`, `SetReverseAction`", BODY.format("take SetSpeedAction(1)")),
        _same("`SetWalkingDirectionAction`, `SetWalkingSpeedAction`",
              BODY.format("take SetWalkingDirectionAction(1), SetWalkingSpeedAction(2)").replace("Car", "Pedestrian"),
              "of pedestrians"),
        _same("`SetVelocityAction`", BODY.format("take SetVelocityAction(0, 0)"),
              "of a vehicle only along its heading: another direction aborts the run"),
        _missing("`SetPositionAction`, `OffsetAction`", "no object jumps: contact is searched for "
                 "on the way between two samples", BODY.format("take SetPositionAction((1, 1))")),
        _missing("`SetHandBrakeAction`", "a vehicle has one brake: `SetBrakeAction`",
                 BODY.format("take SetHandBrakeAction(True)")),
        _same("`withinDistanceToAnyObjs`, `withinDistanceToAnyCars`, …",
              "terminate when withinDistanceToAnyObjs(ego, 9)\n"),
        _same("traffic lights", "signals()\nterminate when withinDistanceToTrafficLight(ego, 9)\n"),
    ),
}  # fmt: skip


def _lines(rows: tuple[Row, ...]) -> str:
    lines = ["| Scenic | here | |", "|---|---|---|"]
    return "\n".join([*lines, *(f"| {row.construct} | {row.here} | {row.how} |" for row in rows)])


@pytest.mark.parametrize("name", TABLES)
def test_the_page_holds_the_table(name: str) -> None:
    """The page's table is the one made from the rows."""
    pattern = re.compile(rf"(<!-- table: {name} -->\n).*?(\n<!-- end -->)", re.DOTALL)
    text = PAGE.read_text(encoding="utf-8")
    wanted = pattern.sub(lambda match: f"{match[1]}{_lines(TABLES[name])}{match[2]}", text)
    if os.environ.get("UPDATE_GOLDEN"):
        PAGE.write_text(wanted, encoding="utf-8")
    assert f"<!-- table: {name} -->" in text
    assert text == wanted or os.environ.get("UPDATE_GOLDEN")


@pytest.mark.parametrize("row", [row for rows in TABLES.values() for row in rows], ids=lambda row: row.construct)
def test_a_row_is_true(row: Row) -> None:
    """The program of a row compiles, and is refused where the construct is missing."""
    source = Source("row.scn", EGO + row.program)
    if row.here != "missing":
        compile_source(source)
        return
    with pytest.raises(CompileError):
        compile_source(source)
