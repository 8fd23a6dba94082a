"""Speeds are displayed in the unit that the file writes."""

import pytest

from cortex_dsl import compile_text
from cortex_dsl.report.findings.readable import UNITS, speed_unit

FILE = "{param}ego = new Car on road, with speed {speed}{comment}\n"


@pytest.mark.parametrize(
    ("param", "speed", "comment", "unit"),
    [
        ("param S = Range(5, 50) km/h\n", "S", "", "km/h"),
        ("param S = Range(5, 50) mph\n", "S", "", "mph"),
        ("param S = Range(5, 20) m/s\n", "S", "", "m/s"),
        ("", "40 km/h", "", "km/h"),
        ("", "40 mph", "  # not 20 m/s, not 30 m/s", "mph"),
        ("", "10", "", "m/s"),
        ("param S = Range(5, 20) m/s\nparam T = Range(5, 20) km/h\n", "S + T", "", "km/h"),
    ],
)
def test_the_files_own_unit(param: str, speed: str, comment: str, unit: str) -> None:
    """Params decide, then the text without its comments, then bare numbers, which are SI."""
    assert speed_unit(compile_text(FILE.format(param=param, speed=speed, comment=comment)).program) == UNITS[unit]


def test_an_acceleration_is_no_speed() -> None:
    """`m/s^2` holds `m/s`, and says nothing of speeds."""
    text = "brake = 4 m/s^2\nego = new Car on road, with speed 40 km/h\n"
    assert speed_unit(compile_text(text).program).name == "km/h"


@pytest.mark.parametrize(("unit", "text"), [("km/h", "36.0 km/h"), ("m/s", "10.0 m/s"), ("mph", "22.4 mph")])
def test_ten_metres_a_second(unit: str, text: str) -> None:
    """By what each unit is."""
    assert UNITS[unit].text(10.0) == text
