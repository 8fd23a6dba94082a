"""The words that are read as units, by dimension. Their sizes belong to the semantics."""

from collections.abc import Mapping
from types import MappingProxyType

UNITS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "length": ("mm", "cm", "m", "km", "ft"),
        "time": ("ms", "s", "min"),
        "speed": ("m/s", "km/h", "mph"),
        "acceleration": ("m/s^2", "g"),
        "angle": ("deg", "rad"),
        "mass": ("kg", "t"),
        "frequency": ("Hz",),
    }
)

UNIT_WORDS: tuple[str, ...] = tuple(word for words in UNITS.values() for word in words)

SPOKEN_UNITS: Mapping[str, str] = MappingProxyType(
    {
        "meter": "m", "meters": "m", "metre": "m", "metres": "m", "millimetre": "mm", "millimetres": "mm",
        "centimeter": "cm", "centimeters": "cm", "centimetre": "cm", "centimetres": "cm",
        "kilometer": "km", "kilometers": "km", "kilometre": "km", "kilometres": "km",
        "feet": "ft", "foot": "ft",
        "sec": "s", "secs": "s", "second": "s", "minute": "min", "minutes": "min",
        "msec": "ms", "millisecond": "ms", "milliseconds": "ms",
        "kph": "km/h", "kmh": "km/h", "kmph": "km/h", "km/hr": "km/h", "km/hour": "km/h", "mps": "m/s",
        "m/sec": "m/s", "m/second": "m/s", "m/s2": "m/s^2", "m/s**2": "m/s^2", "m/s²": "m/s^2",
        "mi/h": "mph", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad",
        "kilogram": "kg", "kilograms": "kg", "kilo": "kg", "ton": "t", "tons": "t", "tonne": "t", "tonnes": "t",
        "hertz": "Hz",
    }
)  # fmt: skip
"""What people write, and the unit that they mean."""


def unit_list() -> str:
    """All units on one line, by dimension, for a diagnostic."""
    return "; ".join(f"{dimension}: {' '.join(words)}" for dimension, words in UNITS.items())
