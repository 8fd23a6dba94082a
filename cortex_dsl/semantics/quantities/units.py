"""Units and dimensions: meanings of the unit words, and names of dimensions in messages. SI inside."""

import math

from cortex_dsl.ir import PURE, Dimension
from engine.frozen import frozen

LENGTH = Dimension(length=1)
TIME = Dimension(time=1)
SPEED = Dimension(length=1, time=-1)
ACCELERATION = Dimension(length=1, time=-2)
ANGLE = Dimension(angle=1)
ANGULAR_SPEED = Dimension(angle=1, time=-1)
MASS = Dimension(mass=1)
FREQUENCY = Dimension(time=-1)


@frozen
class Unit:
    """SI value = written value * factor."""

    word: str
    dimension: Dimension
    factor: float


UNITS: dict[str, Unit] = {
    unit.word: unit
    for unit in (
        Unit("mm", LENGTH, 0.001),
        Unit("cm", LENGTH, 0.01),
        Unit("m", LENGTH, 1.0),
        Unit("km", LENGTH, 1000.0),
        Unit("ft", LENGTH, 0.3048),
        Unit("ms", TIME, 0.001),
        Unit("s", TIME, 1.0),
        Unit("min", TIME, 60.0),
        Unit("m/s", SPEED, 1.0),
        Unit("km/h", SPEED, 1.0 / 3.6),
        Unit("mph", SPEED, 0.44704),
        Unit("m/s^2", ACCELERATION, 1.0),
        Unit("g", ACCELERATION, 9.80665),
        Unit("deg", ANGLE, math.pi / 180.0),
        Unit("rad", ANGLE, 1.0),
        Unit("deg/s", ANGULAR_SPEED, math.pi / 180.0),
        Unit("rad/s", ANGULAR_SPEED, 1.0),
        Unit("kg", MASS, 1.0),
        Unit("t", MASS, 1000.0),
        Unit("Hz", FREQUENCY, 1.0),
    )
}

_NAMES = {
    PURE: "a pure number",
    LENGTH: "a length",
    TIME: "a time",
    SPEED: "a speed",
    ACCELERATION: "an acceleration",
    ANGLE: "an angle",
    ANGULAR_SPEED: "an angular speed",
    MASS: "a mass",
    FREQUENCY: "a frequency",
}

_EXAMPLES = {
    PURE: "0.5",
    LENGTH: "10 m",
    TIME: "2 s",
    SPEED: "10 m/s",
    ACCELERATION: "3 m/s^2",
    ANGLE: "5 deg",
    ANGULAR_SPEED: "10 deg/s",
    MASS: "1500 kg",
    FREQUENCY: "10 Hz",
}

_SI_WORDS = {unit.dimension: unit.word for unit in UNITS.values() if unit.factor == 1.0}


def dimension_name(dimension: Dimension | None) -> str:
    """`a length`; None is a number written without a unit."""
    if dimension is None:
        return "a number without unit"
    return _NAMES.get(dimension) or f"a quantity in {si_formula(dimension)}"


def si_word(dimension: Dimension | None) -> str:
    """The unit word that writes an SI number of this dimension; "" where there is none."""
    return "" if dimension is None else _SI_WORDS.get(dimension, "")


def si_formula(dimension: Dimension) -> str:
    """`m^2/s`-like text for any dimension."""
    exponents = (
        ("m", dimension.length),
        ("kg", dimension.mass),
        ("rad", dimension.angle),
        ("s", dimension.time),
    )
    above = [_power(word, n) for word, n in exponents if n > 0]
    below = [_power(word, -n) for word, n in exponents if n < 0]
    text = " ".join(above) or "1"
    return f"{text}/{' '.join(below)}" if below else text


def _power(word: str, exponent: int) -> str:
    return word if exponent == 1 else f"{word}^{exponent}"


def unit_examples(dimension: Dimension) -> str:
    """Unit words of a dimension, for a cure: "`m/s`, `km/h`, `mph`"."""
    return ", ".join(f"`{unit.word}`" for unit in UNITS.values() if unit.dimension == dimension)


def example(dimension: Dimension) -> str:
    """A usual number of a dimension: `10 m/s`; "" of one without a name."""
    return _EXAMPLES.get(dimension, "")


def product(a: Dimension, b: Dimension) -> Dimension:
    return Dimension(a.length + b.length, a.time + b.time, a.mass + b.mass, a.angle + b.angle)


def power(a: Dimension, exponent: int) -> Dimension:
    return Dimension(a.length * exponent, a.time * exponent, a.mass * exponent, a.angle * exponent)


def quotient(a: Dimension, b: Dimension) -> Dimension:
    return product(a, power(b, -1))


def root(a: Dimension) -> Dimension | None:
    """Dimension of a square root; None where it has none."""
    if a.length % 2 or a.time % 2 or a.mass % 2 or a.angle % 2:
        return None
    return Dimension(a.length // 2, a.time // 2, a.mass // 2, a.angle // 2)
