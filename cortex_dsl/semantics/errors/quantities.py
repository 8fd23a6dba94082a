"""SCN478 and SCN479: quantities that are right as numbers, and probably not what is meant."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import note, warning

CONVERTED_TWICE = warning(
    "SCN478",
    "{kind} is converted from {start} to {end} by hand",
    "a quantity keeps its unit in arithmetic, so this changes its size and does not convert it",
    "leave the factor out; a bare number gets its unit where it is written, as in `50 km/h` or `30 deg`",
    page=Page(
        "unit converted by hand",
        "A speed, a length or an angle is a quantity with its unit, and each place that takes one reads it in that "
        "unit. The factor between two units (3.6, pi/180) makes it another quantity: 36 km/h times 3.6 is 130 km/h.",
        "param V = Range(5, 9) m/s\nego = new Car on road, with speed V / 3.6\n",
        "param V = Range(5, 9) m/s\nego = new Car on road, with speed V\n",
    ),
)
TARGET_ABOVE_TOP = note(
    "SCN479",
    "the target speed of {target} is above the top speed of this {name}, {top}",
    "no throttle takes it beyond that",
    "lower the target, or raise the top speed, as in `with topSpeed {enough}`",
    page=Page(
        "target speed above the top speed",
        "Each class has a `topSpeed`, which no throttle exceeds; `with topSpeed` sets another. A behavior that aims at "
        "more drives at that speed.",
        "ego = new Bicycle on road, with behavior FollowLaneBehavior(80 km/h)\n",
        "ego = new Bicycle on road, with behavior FollowLaneBehavior(20 km/h)\n",
    ),
)
