"""Results do not depend on the direction of north, the side of traffic, names, the order of actors, or units.

An encounter of the ego with three cars and a parked object on a symmetric intersection is written for each of the four
arms, in left-hand traffic with everything mirrored, with other names, in another order, and in other units. All of
these are the same encounter, so every result agrees to 1e-6. A result that differs was decided by the last bit of a
number, as by the sign of `speed * cos(90 deg)`. In some scenes, ties are planted: cars are exactly abreast or arrive at
the same time, and one car heads off the lanes by a multiple of 15 deg.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import islice
from typing import NamedTuple

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.semantics.acting.behaviours import LIBRARY
from cortex_dsl.semantics.names.builtins import BUILTINS
from engine.batch import trajectory
from engine.frozen import frozen
from engine.maps import RoadSpec
from engine.metrics import bodies_of
from engine.metrics.measures import measure_trajectory
from engine.outcomes import OUTCOMES, Outcomes, Per
from engine.road.build import build_network
from engine.road.network import Maneuver, Network, Surface, SurfaceKind
from engine.scenes import Scenes
from engine.search.objectives import BUILT_IN, Runs
from engine.tables import Floats, Ints
from engine.vocabulary import ManeuverType, Side, Verdict
from tests.laws import share

SCENES = share(20)
"""Per behavior and encounter: 2 to 5 while somebody waits, 200 in a night."""
APPROACH = 80.0
LANES = 2
TOLERANCE = 1e-6
METRICS = share(8)
"""Scenes for which the table of metrics is computed as well, which takes longer than to simulate them."""


class Units(NamedTuple):
    """A word of the language and how many of it are one SI unit, for speed and length."""

    speed: tuple[str, float] = ("m/s", 1.0)
    length: tuple[str, float] = ("m", 1.0)


class Names(NamedTuple):
    """Names of the actors other than the ego."""

    other: str = "other"
    third: str = "third"
    askew: str = "askew"
    """A car that crosses the lanes on a straight line."""
    parked: str = "parked"


@frozen
class View:
    """One way to write an encounter."""

    arm: int = 0
    """The ego comes from this arm; arms are numbered counterclockwise."""
    mirrored: bool = False
    names: Names = Names()
    order: tuple[int, ...] = (0, 1, 2, 3)
    """Order of the lines of the actors other than the ego."""
    units: Units = Units()

    def arm_at(self, quarters: int) -> int:
        """The arm so many quarters to the right of the ego's; to the left in the mirror image."""
        return (self.arm + (-quarters if self.mirrored else quarters)) % 4

    def length(self, metres: float) -> str:
        word, each = self.units.length
        return f"{metres * each!r} {word}"

    def speed(self, metres_per_second: float) -> str:
        word, each = self.units.speed
        return f"{metres_per_second * each!r} {word}"


OTHER_UNITS = Units(("km/h", 3.6), ("cm", 100.0))
OTHER_NAMES = Names("zebra", "m", "nobody", "aaa")
VIEWS = {
    "next arm": View(1),
    "all at once": View(2, mirrored=True, names=OTHER_NAMES, order=(3, 2, 1, 0), units=OTHER_UNITS),
    **{f"arm {arm}": View(arm) for arm in (2, 3)},
    **{f"arm {arm}, mirrored": View(arm, mirrored=True) for arm in (0, 1, 3)},
    "renamed": View(names=OTHER_NAMES),
    "in another order": View(order=(1, 3, 2, 0)),
    "other units": View(units=OTHER_UNITS),
}
COMPARED = dict(islice(VIEWS.items(), share(9)))
"""Two of them while somebody waits, all in a night."""


class Encounter(NamedTuple):
    """The ways of both, turns as in right-hand traffic, and the arm of the second one: 0 is the ego's own."""

    mine: ManeuverType
    quarters: int
    theirs: ManeuverType
    lane: int = 1
    """Of the second actor, 1 next to the kerb."""


AHEAD, LEFT, RIGHT = ManeuverType.STRAIGHT, ManeuverType.LEFT_TURN, ManeuverType.RIGHT_TURN
ENCOUNTERS = {
    "crossing from the left": Encounter(AHEAD, 3, AHEAD),
    "crossing from the right": Encounter(AHEAD, 1, AHEAD),
    "oncoming turns left": Encounter(AHEAD, 2, LEFT, lane=2),
    "turning left before oncoming": Encounter(LEFT, 2, AHEAD),
    "merging from the right": Encounter(AHEAD, 1, RIGHT),
    "same lane": Encounter(AHEAD, 0, AHEAD),
    "next lane": Encounter(AHEAD, 0, AHEAD, lane=2),
}

TEXT = """
map intersection(approach={approach}, lanes={lanes}, left_hand={mirrored}{street})
param MINE = Range({near}, {far}) {length}
param THEIRS = Range({near}, {far}) {length}
param THIRD = Range({near}, {far}) {length}
param FAST = Range({slow}, {fast}) {speed}
tie = Range(0, 1) < 0.3
second, third = (MINE if tie else THEIRS), (MINE if tie else THIRD)
fast = {usual} if tie else FAST
turn = 15 deg * DiscreteRange(1, 11)
number = Uniform({numbers})
mine, theirs, last = [{mine}][number], [{theirs}][number], [{last}][number]
ego = new Car before intersection by MINE along mine, with speed {usual}, with behavior {ego}
spot = new OrientedPoint ahead of ego by {ahead}
{lines}
terminate after 8 s
"""
CAR = "{name} = new Car before intersection by {place} along {way}, with speed fast, with behavior {behavior}"
ASKEW = """{name} = new Car {kerb} of spot by {aside}, facing {turn} relative to ego.heading, with speed FAST,
    with behavior ConstantSpeedBehavior(FAST), with regionContainedIn None"""
WALKER = """{name} = new Pedestrian at {place} offset by (0 m, {aside}), facing {turn} relative to ego.heading,
    with behavior {behavior}"""
PROP = "{name} = new Obstacle {kerb} of spot by {beside}, with regionContainedIn None"
TRACK = '"""\ntime,x,y,heading,speed\n0,0,0,0,8\n1,8,{0},{1},8\n3,23,{2},{1},8\n"""'
ARGUMENTS = {
    "trajectory": "{way}",
    "behavior": "FollowTrajectoryBehavior({speed}, {way})",
    "target_speed": "{speed}",
    "speed": "{speed}",
    "laneSectionToSwitch": "{way}[0].sections[0].{inner}",
    "reference_actor": "{partner}",
    "x": "0.4",
    "distance": "{far}",
    "deceleration": "3 m/s^2",
    "track": "{track}",
    "crossing": "{crossing}",
    "sidewalk": "{sidewalk}",
}
"""What is given to each parameter that has no default, and to `trajectory`; a new one needs a row here."""
NONE: Mapping[str, str] = {}
ON_FOOT = ("WalkAlongBehavior", "UseCrossingBehavior")
"""Behaviors of people, which need a street."""
STREET = "sidewalk=2.5 m, crossings=True"


@cache
def network(mirrored: bool) -> Network:
    return build_network(RoadSpec(lanes=LANES, approach=APPROACH, left_hand=mirrored, sidewalk=2.5, crossings=True))


def walkways(view: View) -> tuple[Surface, Surface, int]:
    """Return the crossing over the arm of the ego, the sidewalk beside it, and which end of the crossing is there."""
    road = network(view.mirrored)
    lane = next(m.start_lane for m in road.maneuvers if f"[{m.start_lane.source}," in way(view, 0, AHEAD, 1))
    sidewalk = road.beside(lane.road, SurfaceKind.SIDEWALK, forward=lane.forward)
    assert sidewalk is not None
    (leg,) = [leg for leg in road.intersections[0].legs if lane in leg.incoming_lanes]
    number = road.intersections[0].legs.index(leg)
    crossing = next(each for each in road.surfaces if each.kind is SurfaceKind.CROSSING and each.arm == number)
    end = road.paths.pose(lane.path, lane.length)
    apart = [np.hypot(each.x - end.x, each.y - end.y) for each in crossing.ends_at]
    return crossing, sidewalk, int(np.argmin(apart))


def way(view: View, quarters: int, turn: ManeuverType, lane: int) -> str:
    """The lanes of a way, as text."""
    road = network(view.mirrored)
    if view.mirrored:
        turn = {LEFT: RIGHT, RIGHT: LEFT}.get(turn, turn)

    def angle(each: Maneuver) -> float:
        end = road.paths.pose(each.start_lane.path, 0.0)
        return float(np.arctan2(end.y, end.x)) % (2.0 * np.pi)

    arm = view.arm_at(quarters)
    ways = [m for m in road.maneuvers if m.type is turn and round(angle(m) / (0.5 * np.pi)) % 4 == arm]
    found = min(ways, key=lambda m: abs(m.start_lane.number - lane))
    return f"[{', '.join(each.source for each in found.lanes)}]"


def call(name: str, view: View, way: str, partner: str, speed: str, more: Mapping[str, str] = NONE) -> str:
    """A behavior with the arguments that it needs, and more."""
    sign = -1.0 if view.mirrored else 1.0
    track = TRACK.format(sign * 0.5, sign * 0.2, sign * 3.5)
    inner = "_laneToRight" if view.mirrored else "_laneToLeft"
    crossing, sidewalk, _ = walkways(view)
    given = {
        "crossing": crossing.source,
        "sidewalk": sidewalk.source,
        "way": way,
        "partner": partner,
        "speed": speed,
        "track": track,
        "inner": inner,
        "far": view.length(30.0),
    }
    needed = [p.name for p in BUILTINS[name].parameters if p.default is None or p.name == "trajectory"]
    arguments = {each: ARGUMENTS[each].format(**given) for each in needed} | dict(more)
    return f"{name}({', '.join(f'{each}={text}' for each, text in arguments.items())})"


def text(name: str, view: View) -> str:
    """All encounters, with a behavior at the wheel of the ego, in a view."""
    usual, blind, names = view.speed(11.0), "FollowTrajectoryBehavior({}, {})", view.names
    if any(each.name == "reference_actor" for each in BUILTINS[name].parameters):
        drivers = blind.format(usual, "mine"), call(name, view, "theirs", "ego", usual)
    else:
        drivers = call(name, view, "mine", names.other, usual), blind.format("fast", "theirs")
    kerb = "left" if view.mirrored else "right"
    walker, street = "", ""
    if name in ON_FOOT:
        walks = call(name, view, "mine", names.other, usual, {"speed": view.speed(1.5)})
        (crossing, _, end), street = walkways(view), f", {STREET}"
        drivers = blind.format(usual, "mine"), drivers[1]
        place, aside = f"{crossing.source}.centerline.{('start', 'end')[end]}", view.length(2.0 if end else -2.0)
        turn = "-turn" if view.mirrored else "turn"
        walker = WALKER.format(name=names.askew, place=place, aside=aside, turn=turn, behavior=walks)
    lines = (
        CAR.format(name=names.other, place="second", way="theirs", behavior=drivers[1]),
        CAR.format(name=names.third, place="third", way="last", behavior=blind.format("fast", "last")),
        walker
        or ASKEW.format(
            name=names.askew, kerb=kerb, aside=view.length(15.0), turn="-turn" if view.mirrored else "turn"
        ),
        PROP.format(name=names.parked, kerb=kerb, beside=view.length(1.2)),
    )
    return TEXT.format(
        approach=view.length(APPROACH),
        lanes=LANES,
        mirrored=view.mirrored,
        street=street,
        near=15.0 * view.units.length[1],
        far=60.0 * view.units.length[1],
        length=view.units.length[0],
        slow=4.0 * view.units.speed[1],
        fast=14.0 * view.units.speed[1],
        speed=view.units.speed[0],
        numbers=", ".join(map(str, range(len(ENCOUNTERS)))),
        mine=", ".join(way(view, 0, each.mine, 2 if each.mine is LEFT else 1) for each in ENCOUNTERS.values()),
        theirs=", ".join(way(view, each.quarters, each.theirs, each.lane) for each in ENCOUNTERS.values()),
        last=", ".join(way(view, each.quarters % 3 + 1, AHEAD, 2) for each in ENCOUNTERS.values()),
        usual=usual,
        ego=drivers[0],
        ahead=view.length(12.0),
        lines="\n".join(lines[number] for number in view.order),
    )


def results(name: str, view: View) -> dict[str, Floats]:
    """Every outcome, objective and metric of the scenes, as arrays whose first axis is the scene."""
    scenario = cx.compile_text(text(name, view))
    if name == "ExternalBehavior":
        scenario = scenario.driven_by("python:examples.own_driver.planner:drive")
    scenes = scenario.sample(SCENES, seed=8)
    outcomes = scenario.simulate(scenes)
    assert (outcomes.verdict == Verdict.VALID).all()
    places = np.array([0, *(1 + np.argsort(view.order))])
    found = {row.name: in_order(np.asarray(getattr(outcomes, row.name)), row.per, places) for row in OUTCOMES}
    runs = Runs(scenario.program, scenario.config, scenes, outcomes, scenario.assess(outcomes))
    found |= {each: getattr(runs.risk, each).astype(float) for each in ("score", "continuous", "parts")}
    found["deciding actor"] = 1.0 + np.asarray(view.order)[runs.risk.pair]
    found |= {f"objective {row.name}": np.asarray(row.value(runs), dtype=float) for row in BUILT_IN}
    return upright(found, view) | dict(metrics(scenario, scenes, outcomes, places))


def in_order(values: np.ndarray, per: Per, places: Ints) -> Floats:
    """Results with the actors in the order of `Names`; `places`: the number that each has in the file."""
    if per is Per.PAIR:
        values = values[:, places[1:] - 1]
    if per is Per.ACTOR:
        values = values[:, places]
    if per is Per.CONTACT:
        numbers = np.append(np.argsort(places), -1)
        values = np.sort(numbers[values], axis=1)
    return values.astype(float)


def upright(found: dict[str, Floats], view: View) -> dict[str, Floats]:
    """The same with directions as in right-hand traffic; an angle as its cosine and sine."""
    angle, side = found.pop("approach_angle"), found["side"]
    if view.mirrored:
        angle = -angle
        found["side"] = np.select([side == Side.LEFT, side == Side.RIGHT], [Side.RIGHT, Side.LEFT], side)
    return found | {"cos": np.cos(angle), "sin": np.sin(angle)}


def metrics(scenario: cx.Scenario, scenes: Scenes, outcomes: Outcomes, places: Ints) -> Iterator[tuple[str, Floats]]:
    """The table of metrics of the first scenes."""
    numbers = np.argsort(places)
    rows = range(min(METRICS, len(scenes)))
    simulation = scenario.config.simulation
    tables = [
        measure_trajectory(
            trajectory(scenario.program, scenes, row, simulation),
            outcomes,
            bodies_of(scenario.program, scenes.values[row]),
            row,
        )
        for row in rows
    ]
    for row, table in enumerate(tables):
        for each in table:
            actors = tuple(int(numbers[actor]) for actor in each.actors)
            yield f"{each.name} of {actors} in scene {row}", np.array([each.value])


@pytest.mark.parametrize("name", LIBRARY)
def test_results_do_not_depend_on_the_point_of_view(name: str) -> None:
    """Of every behavior of the library."""
    expected = results(name, View())
    for what, view in COMPARED.items():
        found = results(name, view)
        assert found.keys() == expected.keys()
        for key, values in expected.items():
            np.testing.assert_allclose(found[key], values, TOLERANCE, TOLERANCE, err_msg=f"{key} of {name}, {what}")
