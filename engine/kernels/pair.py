"""MD, MS, D_MS and TTC_MS of a pair (ego, other) from recorded states: the common definition of all hosts.

With p the vector from the ego's centre to the other's and v its rate of change:

    closing speed   c = -(p . v) / |p|                                     centres
    MS              the largest c over the samples of the pair
    instant of MS   the first sample with c >= MS - 0.01 m/s: on a constant-bearing course the arg max is rounding noise
    D_MS            distance between the outlines at that instant
    TTC_MS          D_MS / MS; where MS is no more than rounding noise the two never approach, and D_MS and TTC_MS are
                    infinite
    MD              least distance between the outlines over continuous time; 0 on contact
    instant of MD   the first at which they are no farther than MD + 1e-6 m: while two stand or pass on parallel lines
                    the arg min is rounding noise
    approach        speeds, angle, c and side at the instant of MD, or of contact

The least distance is searched in continuous time: within a step, outlines move as in `kernels.approach`.

Two actors that are never in the scene together have an infinite MD, at no time, and an MS of minus infinity.
"""

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

from engine.kernels.approach import centers_apart, closest_in_step
from engine.kernels.geometry import Box, box_distance, half_diagonal, outline_at, outline_between, shortest_turn
from engine.kernels.jit import inlined, kernel, shared
from engine.outcomes import PAIRS
from engine.tables import SLIDING, Floats
from engine.vocabulary import Side, State

# -- the least distance ------------------------------------------------------------------------------------------------

SAME_DISTANCE = 1e-6
"""Distances that differ by less are equal [m]: rounding decides which of them is the least."""
ROUNDING = 1e-13
"""Distances [m] and parts of a step that differ by less differ by rounding."""
MAX_ROUNDS = 60
"""Maximum number of rounds of the search for the instant of MD; 5 to 15 are usual."""


@kernel
def least_distance(states: Floats, together: int, other: int, outlines: Floats, seed: int) -> tuple[float, float]:
    """Return MD over whole steps [m] and its time in steps. A good first value (at `seed`) lets nearly all steps be
    skipped.
    """
    first, second = outline_at(states, seed, 0, outlines), outline_at(states, seed, other, outlines)
    best, at = box_distance(first, second), float(seed)
    radii = half_diagonal(first) + half_diagonal(second)
    reach2 = (best + radii) ** 2
    for k in range(together - 1):
        a0, a1 = outline_at(states, k, 0, outlines), outline_at(states, k + 1, 0, outlines)
        b0, b1 = outline_at(states, k, other, outlines), outline_at(states, k + 1, other, outlines)
        if centers_apart(a0, a1, b0, b1, reach2):
            continue
        best, fraction = closest_in_step(a0, a1, b0, b1, best)
        if fraction >= 0.0:
            at, reach2 = k + fraction, (best + radii) ** 2
    return best, at


@kernel
def first_as_near(states: Floats, other: int, outlines: Floats, least: float, at: float) -> float:
    """Return the first instant at which the distance is at most MD + `SAME_DISTANCE`, in steps.

    The search goes back from `at`, an instant of MD: first over samples, then in the step before the first sample that
    is as near, so that a small change of the states changes the result little.
    """
    limit = least + SAME_DISTANCE
    radii = half_diagonal(outline_at(states, 0, 0, outlines)) + half_diagonal(outline_at(states, 0, other, outlines))
    reach2 = (limit + radii) ** 2  # centres farther apart than this: no need to look at the outlines
    for k in range(math.ceil(at)):
        ego, them = outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)
        x, y = them.x - ego.x, them.y - ego.y
        if x * x + y * y <= reach2 and box_distance(ego, them) <= limit:
            at = float(k)
            break
    if at == 0.0:
        return at
    before = math.ceil(at) - 1
    return before + _part_until(states, before, other, outlines, limit, at - before)


@kernel
def _part_until(states: Floats, k: int, other: int, outlines: Floats, limit: float, end: float) -> float:
    """Return the part of the step after sample k at which the distance falls to `limit` [m], by the Illinois method.

    The distance is larger at the sample, and at most `limit` at the part `end`. Source: Dowell and Jarratt (1971), "A
    modified regula falsi method for computing the root of an equation", BIT 11.
    """
    low, high = 0.0, end
    above = box_distance(outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)) - limit
    below = _distance_within(states, k, end, other, outlines) - limit
    side = 0
    for _ in range(MAX_ROUNDS):
        if high - low <= ROUNDING:
            break
        part = (low * below - high * above) / (below - above)
        excess = _distance_within(states, k, part, other, outlines) - limit
        if abs(excess) <= ROUNDING:
            return part
        if excess > 0.0:
            low, above = part, excess
            below = 0.5 * below if side > 0 else below
            side = 1
        else:
            high, below = part, excess
            above = 0.5 * above if side < 0 else above
            side = -1
    return high


@inlined
def _distance_within(states: Floats, k: int, part: float, other: int, outlines: Floats) -> float:
    """Return the distance between the outlines at a part of the step after sample k [m]."""
    ego = outline_between(states, k, k + 1, part, 0, outlines)
    return box_distance(ego, outline_between(states, k, k + 1, part, other, outlines))


@kernel
def least_in_ending(
    states: Floats, k: int, other: int, outlines: Floats, ending: float, best: float, at: float
) -> tuple[float, float]:
    """Return MD and its time, including the part `ending` of the step after sample k, in which a third actor was in
    contact.
    """
    a0, b0 = outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)
    a1 = outline_between(states, k, k + 1, ending, 0, outlines)
    b1 = outline_between(states, k, k + 1, ending, other, outlines)
    best, fraction = closest_in_step(a0, a1, b0, b1, best)
    return best, (k + fraction * ending if fraction >= 0.0 else at)


CLOSING_SPEED_TOLERANCE = 0.01
"""Largest difference from the maximum closing speed at the instant of MS [m/s]."""
NOISE_FLOOR = 1e-9
"""Closing speed above which two actors approach [m/s]: at a constant distance it is rounding noise of about 1e-15 of
either sign, on which D_MS must not depend.
"""
FRONT, LEFT, REAR, RIGHT = map(int, Side)


ROWS = [row.name for row in PAIRS]
NOT_OF_MOTION = ("first_seen", "ttc_at_first_sight", "hidden_time", "fault")
"""Metrics that depend on views and the road: `kernels.rows` adds them."""

if TYPE_CHECKING:

    class PairMetrics(Any):
        """Metrics of a pair's motion, by the table in `engine.outcomes`: floats. Times count from its start."""

else:
    PairMetrics = namedtuple("PairMetrics", [name for name in ROWS if name not in NOT_OF_MOTION])

PLACES: tuple[int, ...] = tuple(ROWS.index(name) for name in PairMetrics._fields)
"""Column of each metric in the row of a pair."""


class Approach(NamedTuple):
    """State of the pair at the instant of MD, or of contact."""

    ego_speed: float
    """Speed of the ego's rear axle, along its heading [m/s]."""
    other_speed: float
    """[m/s]"""
    angle: float
    """The other's heading minus the ego's, -pi .. pi [rad]: 0 the same way, +-pi head-on, positive to the left."""
    closing_speed: float
    """Closing speed of the centres [m/s]."""
    side: int
    """`Side` of the ego's outline at which the other is."""


class Rate(NamedTuple):
    """Centre's velocity in world axes [m/s]."""

    x: float
    y: float


@shared
def measure_pair(
    states: Floats,
    samples: int,
    time_step: float,
    other: int,
    outlines: Floats,
    contacted: bool,
    ending: float = 0.0,
) -> PairMetrics:
    """Return the metrics of the pair (actor 0, `other`), from their first common sample until one of them is absent.

    `states` (rows, actors, len(State)), of which the first `samples` (at least 1) belong to the run; `outlines`
    (actors, 3): length, width, distance from rear axle to centre [m]. If first contact (of any pair) ended the run
    inside a step, `ending` in (0, 1] is the part of the step before it, and row `samples` holds the states that all
    actors would have without contact. `contacted`: this pair was in contact.
    """
    first = _first_together(states, samples, other)
    if first == samples:
        return _never_together()
    states, samples = states[first:], samples - first
    together = _samples_together(states, samples, other)
    survey = _survey(states, together, time_step, other, outlines)
    seed, fastest = survey.nearest, survey.fastest
    at = _first_as_fast(states, together, time_step, other, outlines, survey)
    distance_at_ms, ttc_at_ms = math.inf, math.inf
    if fastest > NOISE_FLOOR:
        distance_at_ms = box_distance(outline_at(states, at, 0, outlines), outline_at(states, at, other, outlines))
        ttc_at_ms = distance_at_ms / fastest
    beyond = together == samples and ending > 0.0 and states[samples, other, State.PRESENT] != 0.0
    if contacted:
        least, least_at = 0.0, together - 1 + ending
    else:
        least, least_at = least_distance(states, together, other, outlines, seed)
        if beyond:
            least, least_at = least_in_ending(states, samples - 1, other, outlines, ending, least, least_at)
        least_at = first_as_near(states, other, outlines, least, least_at)
    least_time, fastest_time = (first + least_at) * time_step, (first + at) * time_step
    approach = _approach(states, together + (1 if beyond else 0), least_at, time_step, other, outlines)
    return PairMetrics(
        min_distance=least,
        min_distance_time=least_time,
        max_closing_speed=fastest,
        max_closing_time=fastest_time,
        distance_at_ms=distance_at_ms,
        ttc_at_ms=ttc_at_ms,
        ego_speed=approach.ego_speed,
        other_speed=approach.other_speed,
        approach_angle=approach.angle,
        closing_speed=approach.closing_speed,
        side=float(approach.side),
    )


@inlined
def _never_together() -> PairMetrics:
    """Return the metrics of two that are never in the scene together; their approach has no numbers."""
    return PairMetrics(
        min_distance=math.inf,
        min_distance_time=math.nan,
        max_closing_speed=-math.inf,
        max_closing_time=math.nan,
        distance_at_ms=math.inf,
        ttc_at_ms=math.inf,
        ego_speed=math.nan,
        other_speed=math.nan,
        approach_angle=math.nan,
        closing_speed=math.nan,
        side=-1.0,
    )


@inlined
def _first_together(states: Floats, samples: int, other: int) -> int:
    """Return the first sample at which both are present; `samples` if there is none."""
    for k in range(samples):
        if states[k, 0, State.PRESENT] != 0.0 and states[k, other, State.PRESENT] != 0.0:
            return k
    return samples


@inlined
def _samples_together(states: Floats, samples: int, other: int) -> int:
    """Return the number of samples, from a common one on, at which both are present without a gap."""
    for k in range(1, samples):
        if states[k, 0, State.PRESENT] == 0.0 or states[k, other, State.PRESENT] == 0.0:
            return k
    return samples


class Survey(NamedTuple):
    """The samples of a pair at a glance."""

    nearest: int
    """Sample at which the centres are nearest."""
    fastest: float
    """Largest closing speed [m/s]."""
    begin: int
    """A sample before which no closing speed is within the tolerance of the largest."""


@kernel
def _survey(states: Floats, together: int, time_step: float, other: int, outlines: Floats) -> Survey:
    """Return the survey of the samples.

    Closing speeds before a sample that exceeds all of them are below the tolerance once that sample is.
    """
    nearest, seed, fastest = math.inf, 0, -math.inf
    begin, mark, marked = 0, 0, -math.inf
    for k in range(together):
        x, y = states[k, other, State.X] - states[k, 0, State.X], states[k, other, State.Y] - states[k, 0, State.Y]
        square = x * x + y * y
        if square < nearest:
            nearest, seed = square, k
        speed = closing_speed(states, together, k, time_step, other, outlines)
        if speed > fastest:
            if marked < speed - CLOSING_SPEED_TOLERANCE:
                begin, mark, marked = mark, k, speed
            fastest = speed
    return Survey(seed, fastest, begin)


@kernel
def _first_as_fast(
    states: Floats, together: int, time_step: float, other: int, outlines: Floats, survey: Survey
) -> int:
    """Return the first sample whose closing speed is within the tolerance of the largest."""
    for k in range(survey.begin, together):
        if closing_speed(states, together, k, time_step, other, outlines) >= survey.fastest - CLOSING_SPEED_TOLERANCE:
            return k
    return 0


@inlined
def closing_speed(states: Floats, samples: int, k: int, time_step: float, other: int, outlines: Floats) -> float:
    """Return -(p . v) / |p| at sample k [m/s]; 0 if the centres coincide."""
    x, y = states[k, other, State.X] - states[k, 0, State.X], states[k, other, State.Y] - states[k, 0, State.Y]
    mine = center_velocity(states, samples, k, time_step, 0, outlines[0, 2])
    theirs = center_velocity(states, samples, k, time_step, other, outlines[other, 2])
    distance = math.sqrt(x * x + y * y)
    if distance == 0.0:
        return 0.0
    return -(x * (theirs.x - mine.x) + y * (theirs.y - mine.y)) / distance


@kernel
def _approach(states: Floats, samples: int, at: float, time_step: float, other: int, outlines: Floats) -> Approach:
    """Return the state of the pair `at` steps after the first of `samples` samples, interpolated linearly."""
    k = min(int(at), samples - 1)
    after, part = min(k + 1, samples - 1), at - k
    ego = outline_between(states, k, after, part, 0, outlines)
    them = outline_between(states, k, after, part, other, outlines)
    start = closing_speed(states, samples, k, time_step, other, outlines)
    end = closing_speed(states, samples, after, time_step, other, outlines)
    return Approach(
        _mix(states[k, 0, State.SPEED], states[after, 0, State.SPEED], part),
        _mix(states[k, other, State.SPEED], states[after, other, State.SPEED], part),
        shortest_turn(ego.heading, them.heading),
        _mix(start, end, part),
        side_of(ego, them),
    )


@inlined
def _mix(start: float, end: float, part: float) -> float:
    return start + part * (end - start)


@inlined
def side_of(ego: Box, other: Box) -> int:
    """Return the `Side` beyond which the other is farthest; of overlapping outlines, the side that it has crossed
    least.

    Of two equally far sides, as for touching corners, front or rear.
    """
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    x, y = other.x - ego.x, other.y - ego.y
    ahead, aside = cos * x + sin * y, cos * y - sin * x
    turned_cos = abs(math.cos(other.heading - ego.heading))
    turned_sin = abs(math.sin(other.heading - ego.heading))
    along = 0.5 * (ego.length + other.length * turned_cos + other.width * turned_sin)
    across = 0.5 * (ego.width + other.length * turned_sin + other.width * turned_cos)
    if abs(ahead) - along >= abs(aside) - across - SAME_DISTANCE:
        return FRONT if ahead >= 0.0 else REAR
    return LEFT if aside > 0.0 else RIGHT


@inlined
def center_velocity(states: Floats, samples: int, k: int, time_step: float, actor: int, to_center: float) -> Rate:
    """Return the velocity of an outline's centre at sample k: the rear axle's speed along the heading, and the swing
    about it.

    For a body that slides after an impact it is the central difference of its centre; at the first sample after the
    impact the forward difference, so that motion before the impact has no influence.

    The yaw rate is the central difference of the headings, which holds for any limit of the turn; at the last sample it
    is that of the step before.
    """
    before, after = max(k - 1, 0), min(k + 1, samples - 1)
    if states[k, actor, State.PRESENT] == SLIDING and after > before:
        if states[before, actor, State.PRESENT] != SLIDING and after > k:
            before = k
        time = (after - before) * time_step
        way_x = states[after, actor, State.X] - states[before, actor, State.X]
        return Rate(way_x / time, (states[after, actor, State.Y] - states[before, actor, State.Y]) / time)
    turn = shortest_turn(states[before, actor, State.HEADING], states[after, actor, State.HEADING])
    swing = 0.0
    if turn != 0.0:
        swing = to_center * turn / ((after - before) * time_step)
    return swung(states[k, actor, State.HEADING], states[k, actor, State.SPEED], swing)


@inlined
def swung(heading: float, speed: float, swing: float) -> Rate:
    """Return the velocity of a centre that swings about a rear axle, which moves along the heading [m/s]."""
    cos, sin = math.cos(heading), math.sin(heading)
    return Rate(speed * cos - swing * sin, speed * sin + swing * cos)
