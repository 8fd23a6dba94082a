"""Errors of specifications. The argument names the word in the `map` line that must change."""

import math
from collections.abc import Iterator, Sequence

from engine.errors import CortexError
from engine.maps import RoadSpec, Street

MAX_LANES = 4
MAX_INTERSECTIONS = 400
SHORTEST_ROAD = 1.0
"""Least length of a road outside the junctions, and least gap behind a road that ends before the next row [m]."""

LENGTHS = {
    "lane_width": (1.0, 20.0),
    "corner_radius": (0.0, 1000.0),
    "approach": (SHORTEST_ROAD, 100_000.0),
    "block": (SHORTEST_ROAD, 100_000.0),
    "buildings": (0.0, 1000.0),
}
"""Limits of the lengths of a specification [m]."""

SPEED_LIMITS = (1.0, 100.0)
"""[m/s]"""


class RoadError(CortexError):
    """A specification that no road fits."""

    def __init__(self, message: str, argument: str, cure: str) -> None:
        super().__init__(message, cure)
        self.argument = argument
        """Name of the field of the specification to blame."""


def wrong_alone(spec: RoadSpec) -> Iterator[RoadError]:
    """Yield the errors of single numbers that no road allows."""
    yield from wrong_choice("ways", spec.ways, (3, 4))
    yield from wrong_choice("lanes", spec.lanes, range(1, MAX_LANES + 1))
    yield from _counts(spec)
    for argument, (low, high) in LENGTHS.items():
        if getattr(spec, argument) is not None:
            yield from wrong_length(argument, getattr(spec, argument), low, high)
    yield from wrong_street_numbers(spec)


def half_width(spec: RoadSpec) -> float:
    """Return the distance from the middle of a road to the border of its outer lane [m]."""
    return spec.lanes * spec.lane_width


def kerb_distance(spec: RoadSpec) -> float:
    """Return the distance from the middle of a road to its kerb [m]."""
    return half_width(spec) + setback(spec)


def stop_distance(spec: RoadSpec) -> float:
    """Return the distance from an intersection's centre to its stop lines [m].

    They lie where the corner fillets begin, or before the crossings there.
    """
    return kerb_distance(spec) + spec.corner_radius + crossing_depth(spec)


def street_wall(spec: RoadSpec) -> float:
    """Return the distance from the middle of a road to the buildings along it [m]."""
    return kerb_distance(spec) + (spec.buildings or 0.0)


# -- strips beside the lanes, and crossings ----------------------------------------------------------------------------

STREET_LENGTHS = {
    "sidewalk": (0.5, 10.0),
    "shoulder": (0.2, 5.0),
    "bike_lane": (0.8, 4.0),
    "parking": (1.8, 5.5),
    "crossing_width": (1.0, 10.0),
}
"""Limits of the lengths beside the lanes [m]."""
CROSSING_GAP = 1.25
"""Distance from a stop line to the crossing behind it [m]: Manual on Uniform Traffic Control Devices (2009), section
3B.16: at least 4 ft."""


def setback(spec: Street) -> float:
    """Return the distance from the border of the outer lane to the kerb [m]."""
    return (spec.shoulder or 0.0) + (spec.bike_lane or 0.0) + (spec.parking or 0.0)


def crossing_depth(spec: Street) -> float:
    """Return the distance from a stop line to the far side of the crossing behind it [m]; 0 without crossings."""
    return spec.crossing_width + CROSSING_GAP if spec.crossings is True else 0.0


def wrong_street_numbers(spec: Street) -> Iterator[RoadError]:
    """Yield the errors of single numbers of the strips and crossings."""
    for argument, (low, high) in STREET_LENGTHS.items():
        if getattr(spec, argument) is not None:
            yield from wrong_length(argument, getattr(spec, argument), low, high)
    if not 0.0 <= spec.parked <= 1.0:
        message = f"`parked` is {spec.parked:g}, but must lie between 0 and 1"
        yield RoadError(message, "parked", "it is the share of the parking places with a car: write `parked=0.5`")


def wrong_street(spec: Street, corner_radius: float) -> Iterator[RoadError]:
    """Yield the errors of strips and crossings beside arms whose corners have that radius [m]."""
    yield from wrong_strips(spec)
    if spec.sidewalk is not None and spec.sidewalk > corner_radius:
        room = f"write `sidewalk={corner_radius:g} m` or less, or" if corner_radius >= 0.5 else "write"
        yield RoadError(
            f"`sidewalk` is {spec.sidewalk:g} m, wider than the corner allows, whose kerb is an arc of "
            f"{corner_radius:g} m",
            "sidewalk",
            f"{room} `corner_radius={spec.sidewalk:g} m` or more",
        )
    if not isinstance(spec.crossings, bool):
        message = "`crossings` lists places, but arms have their crossings at the intersection"
        yield RoadError(message, "crossings", "write `crossings=True`")


def wrong_strips(spec: Street) -> Iterator[RoadError]:
    """Yield the errors of strips and crossings that lack another strip."""
    if spec.bike_lane_behind_parking and (spec.bike_lane is None or spec.parking is None):
        missing = "bike_lane=2 m" if spec.bike_lane is None else "parking=2 m"
        message = "`bike_lane_behind_parking` needs a bicycle lane and a parking row"
        yield RoadError(message, "bike_lane_behind_parking", f"add `{missing}`")
    if spec.parked > 0.0 and spec.parking is None:
        yield RoadError("`parked` needs a parking row", "parked", "add `parking=2 m`")
    if spec.crossings and spec.sidewalk is None:
        yield RoadError("a crossing leads from sidewalk to sidewalk", "crossings", "add `sidewalk=2 m`")


# -- checks of single numbers ------------------------------------------------------------------------------------------


def wrong_choice(argument: str, value: int, choices: Sequence[int]) -> Iterator[RoadError]:
    if value not in choices:
        names = " or ".join(map(str, choices)) if len(choices) < 3 else f"{choices[0]} to {choices[-1]}"
        nearest = min(choices, key=lambda choice: abs(choice - value))
        yield RoadError(f"`{argument}` is {value:g}, but must be {names}", argument, f"write `{argument}={nearest}`")


def _counts(spec: RoadSpec) -> Iterator[RoadError]:
    for argument, value in (("rows", spec.rows), ("cols", spec.cols)):
        if not (1 <= value <= MAX_INTERSECTIONS and value == int(value)):
            message = f"`{argument}` is {value:g}, but must be a whole number from 1 to {MAX_INTERSECTIONS}"
            yield RoadError(message, argument, f"write `{argument}=1`")


def wrong_length(argument: str, value: float, low: float, high: float, unit: str = "m") -> Iterator[RoadError]:
    # Written so that NaN, for which every comparison is false, fails too.
    if not low <= value <= high or math.isinf(value):
        yield RoadError(
            f"`{argument}` is {value:g} {unit}, but must lie between {low:g} {unit} and {high:g} {unit}",
            argument,
            "leave it out to get the default",
        )


def wrong_together(spec: RoadSpec) -> Iterator[RoadError]:
    """Yield the errors of numbers that are valid alone but not together."""
    if (count := spec.rows * spec.cols) > MAX_INTERSECTIONS:
        argument = "rows" if spec.rows > spec.cols else "cols"
        yield RoadError(
            f"{spec.rows} x {spec.cols} are {count} intersections, more than {MAX_INTERSECTIONS}",
            argument,
            f"at most {MAX_INTERSECTIONS // min(spec.rows, spec.cols)} fit here",
        )
    least = 2.0 * stop_distance(spec) + SHORTEST_ROAD
    if spec.rows * spec.cols > 1 and spec.block < least:
        yield RoadError(
            f"`block` is {spec.block:g} m, but two neighbouring junctions of {2.0 * stop_distance(spec):g} m from stop "
            f"line to stop line and a road between them need {least:g} m",
            "block",
            f"write `block={math.ceil(least)} m` or more, or a smaller `corner_radius`",
        )
    # The stem of a T leads to the row below, whose junctions have no arm to meet it: the road ends there.
    room = spec.block - stop_distance(spec) - kerb_distance(spec) - (spec.sidewalk or 0.0) - SHORTEST_ROAD
    if spec.ways == 3 and spec.rows > 1 and spec.approach > room:
        yield RoadError(
            f"`approach` is {spec.approach:g} m, but the south arm of a T-junction must end before the road of the row "
            f"below, at most {room:g} m from its stop line",
            "approach",
            f"write `approach={math.floor(room)} m` or less, or `block` larger",
        )
    yield from wrong_street(spec, spec.corner_radius)
    if spec.buildings is not None:
        yield from _wrong_buildings(spec, spec.buildings)


def _wrong_buildings(spec: RoadSpec, away: float) -> Iterator[RoadError]:
    """Yield the errors of blocks that overlap the road, or do not fit between the roads."""
    # The corner of a block is sqrt(2) (r - away) from the centre of the fillet, whose kerb is r from it.
    least = spec.corner_radius * (1.0 - math.sqrt(0.5))
    if spec.sidewalk is not None and away < spec.sidewalk:
        yield RoadError(
            f"`buildings` is {away:g} m, and a block that near would stand on the sidewalk of {spec.sidewalk:g} m",
            "buildings",
            f"write `buildings={spec.sidewalk:g} m` or more, or a narrower `sidewalk`",
        )
    if away < least:
        yield RoadError(
            f"`buildings` is {away:g} m, and a block that near would stand on the road at the corner, whose kerb is "
            f"an arc of {spec.corner_radius:g} m",
            "buildings",
            f"write `buildings={math.ceil(10.0 * least) / 10.0:g} m` or more, or a smaller `corner_radius`",
        )
    room = stop_distance(spec) + spec.approach - kerb_distance(spec)
    if spec.rows * spec.cols > 1:
        room = min(room, 0.5 * spec.block - kerb_distance(spec))
    if away > room - SHORTEST_ROAD:
        yield RoadError(
            f"`buildings` is {away:g} m, but only {room:g} m lie between the kerb and the end of the road, or half "
            "way to the next road",
            "buildings",
            f"write `buildings={max(0, math.floor(room - SHORTEST_ROAD))} m` or less, or leave it out",
        )
