"""The concrete copy of every valid scene of a generated program compiles, and runs to the same outcome, bit for bit.

A program is put together from a map, ways to place objects relative to others, properties, behaviors with arguments,
interrupts, choices, lights, noise and requirements, each with values that are drawn or searched.
"""

from hypothesis import given
from hypothesis import strategies as st

from tests.laws import examples
from tests.test_drawn_domains import check_copies

LANE = "Uniform(*network.lanes)"
TURN = "way = Uniform(*intersection.maneuvers)\nturn = [way.startLane, way.connectingLane, way.endLane]"
MAPS = {
    "map intersection(lanes=2, approach=80 m)": True,
    "map intersection(ways=3, lanes=1, left_hand=True)": True,
    "map roundabout(arms=4, radius=20 m)": False,
    "map road(lanes=2, length=300 m, curve=200 m)": False,
}
"""Maps, and whether they have one intersection."""
LENGTHS = (
    "4 m",
    "Range(2, 9) m",
    "Normal(6, 1) m",
    "Uniform(3, 8) * 1 m",
    "D * 1 m",
    "(3 m if Range(0, 1) < 0.5 else 7 m)",
)
SPEEDS = ("6 m/s", "Range(2, 12) m/s", "TruncatedNormal(8, 2, 3, 13) m/s", "V", "DiscreteRange(2, 9) * 1 m/s")
EGO = (
    f"in {LANE}.centerline",
    "on road",
    f"following roadDirection from {LANE}.centerline.start for (5 m + {{length}})",
)
AT_INTERSECTION = ("before intersection by (5 m + {length}) along turn",)
PLACES = (
    "ahead of ego by {length}",
    "behind ego by {length}, facing Range(-5, 5) deg",
    "left of ego by {length}, with regionContainedIn None",
    "at ego offset by ({length}, 10 m), facing toward ego, with regionContainedIn None",
    "offset along 30 deg by (8 m, {length}), with regionContainedIn None",
    "following roadDirection from ego for (10 m + {length})",
    "beyond ego by (10 m + {length}), with regionContainedIn None",
    "in CircularRegion((0, 0), 10 m + {length}), facing 0 deg, with regionContainedIn None",
    "at (Range(-40, 40), 30 m), apparently facing 20 deg from ego, with regionContainedIn None",
    "visible from ego, with regionContainedIn None, with visibleDistance 40 m",
)
BEHAVIORS = (
    "FollowLaneBehavior({speed}, obey_signals=True)",
    "ConstantSpeedBehavior({speed})",
    "EmergencyBrakeBehavior(FollowLaneBehavior({speed}), delay=Range(0, 0.3) s)",
    "Waits({length} / (5 m/s), {speed})",
    "Yields({speed}, {length})",
    "Picks({speed})",
    "Wobbles(Range(-2, 2) deg)",
)
LIBRARY = """
behavior Waits(time, speed):
    do IdleBehavior() for time
    do FollowLaneBehavior(speed) until self.speed > 0.9 * speed
    wait for DiscreteRange(1, 3) steps
behavior Yields(speed, gap):
    try:
        do FollowLaneBehavior(speed)
    interrupt when withinDistanceToAnyObjs(self, gap + 2 m):
        take SetBrakeAction(Range(0.3, 1))
behavior Picks(speed):
    do choose {FollowLaneBehavior(speed): Range(1, 2), ConstantSpeedBehavior(0.5 * speed): 1}
behavior Wobbles(angle):
    while True:
        take SetSteerAction(angle * Normal(1, 0.1)), SetThrottleAction(Range(0, 0.3))
"""
EXTRAS = (
    "signals(green=Range(2, 6) s, yellow=1 s)",
    "environment(friction=Range(0.4, 1), sight=40 m + {length})",
    "mutate other by Range(0.1, 0.5)",
    "require[0.7] (distance from ego to other) > 6 m",
    "require always ego.speed < 60 m/s",
    "require eventually ego.speed > 0.1 m/s",
    "record ego.speed",
    "terminate when ego.speed > 11 m/s",
)
FIRST = ("signals", "environment")
PROPERTIES = ("", ", with width Range(1.5, 2.2) m", ", with length {length}", ", with friction Range(0.5, 1)")


@st.composite
def programs(draw: st.DrawFn) -> str:
    """A program of two or three actors."""
    road = draw(st.sampled_from(sorted(MAPS)))

    def one(texts: tuple[str, ...]) -> str:
        values = {"length": draw(st.sampled_from(LENGTHS)), "speed": draw(st.sampled_from(SPEEDS))}
        return draw(st.sampled_from(texts)).format(**values)

    extras = [one((text,)) for text in draw(st.lists(st.sampled_from(EXTRAS), unique=True, max_size=4))]
    first = [text for text in extras if text.startswith(FIRST)]
    lines = [road, "param V = Range(3, 12) m/s", "param D = VerifaiDiscreteRange(2, 8)", *first, LIBRARY]
    if MAPS[road]:
        lines.append(TURN)
    speed = draw(st.sampled_from(SPEEDS))
    ego = one(EGO + AT_INTERSECTION if MAPS[road] else EGO)
    lines.append(f"ego = new Car {ego}, with speed {speed}, with behavior {one(BEHAVIORS)}{one(PROPERTIES)}")
    for name in ("other", "third")[: draw(st.integers(1, 2))]:
        kind = draw(st.sampled_from(("Car", "Truck", "Motorcycle")))
        rest = f"with behavior {one(BEHAVIORS)}{one(PROPERTIES)}, with allowCollisions True"
        lines.append(f"{name} = new {kind} {one(PLACES)}, {rest}")
    lines += [text for text in extras if text not in first]
    text = "\n".join([*lines, "terminate after 2 s\n"])
    return text if "signals(" in text else text.replace(", obey_signals=True", "")


@given(programs())
@examples(16)
def test_the_copy_of_a_generated_program_is_its_scene(text: str) -> None:
    """Whatever its scenes are made of."""
    check_copies(text, 2)
