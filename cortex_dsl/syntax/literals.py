"""Numbers, strings and units: from their text to their value, and back."""

import re
from collections.abc import Mapping
from types import MappingProxyType

from engine.errors import Signal

_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "\\": "\\", "'": "'", '"': '"', "0": "\0", "\n": "", "\r\n": ""}
_ESCAPE = re.compile(r"\\(?:x([0-9a-fA-F]{2})|u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(\r\n|[\s\S]))")


class EscapeError(Signal):
    """A backslash in a string that begins no escape; `offset` is where, from the start of the literal."""

    def __init__(self, text: str, offset: int) -> None:
        super().__init__(text)
        self.text = text
        self.offset = offset


def string_value(literal: str, quotes: int | None = None) -> str:
    """The text that a quoted literal means, or one within quotes (0). Its line breaks are line feeds in any file."""
    if quotes is None:
        quotes = 3 if literal[:3] in ('"""', "'''") else 1
    pieces, last = [], quotes
    body = literal[: len(literal) - quotes]
    for match in _ESCAPE.finditer(body, quotes):
        pieces += [body[last : match.start()], _unescape(match)]
        last = match.end()
    return "".join([*pieces, body[last:]]).replace("\r\n", "\n")


def _unescape(match: re.Match[str]) -> str:
    code = match[1] or match[2] or match[3]
    if code:
        if int(code, 16) > 0x10FFFF:
            raise EscapeError(match.group(), match.start())
        return chr(int(code, 16))
    if match[4] not in _ESCAPES:
        raise EscapeError(match.group(), match.start())
    return _ESCAPES[match[4]]


def write_string(value: str) -> str:
    """A one-line literal for a text."""
    return '"' + "".join(_escaped(character) for character in value) + '"'


def write_docstring(value: str) -> str:
    """A triple-quoted literal for a text."""
    body = "".join("\n" if character == "\n" else _escaped(character) for character in value)
    return f'"""{body}"""'


def _escaped(character: str) -> str:
    if character in '\\"':
        return "\\" + character
    if character == "\n":
        return "\\n"
    if character == "\t" or (character.isprintable() and character != "\ufeff"):
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def write_number(value: float) -> str:
    """The shortest literal that reads as this number."""
    return str(int(value)) if value == int(value) and value < 1e16 else repr(value)


# -- The words that are read as units, by dimension. Their sizes belong to the semantics -------------------------------

UNITS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "length": ("mm", "cm", "m", "km", "ft"),
        "time": ("ms", "s", "min"),
        "speed": ("m/s", "km/h", "mph"),
        "acceleration": ("m/s^2", "g"),
        "angle": ("deg", "rad"),
        "angular speed": ("deg/s", "rad/s"),
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
"""Common spellings of units, and the unit that they mean."""


def unit_list() -> str:
    """All units on one line, by dimension, for a diagnostic."""
    return "; ".join(f"{dimension}: {' '.join(words)}" for dimension, words in UNITS.items())
