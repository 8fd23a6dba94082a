"""Every `require` is weighed at once."""

import re
import time

from .conftest import LEFT_TURN, Talk

PARAMS = ("param V = Range(0, 100) m/s", "param D = Range(0, 50) m")


def test_acceptance_before_and_after(talk: Talk) -> None:
    """Also without an ego: the shares are those of the params, and what is left of a range is shown."""
    talk(*PARAMS)
    said = talk("require V > 40 m/s")
    before, after = map(float, re.findall(r"([\d.]+) %", said.out)[:2])
    assert before == 100.0
    assert 58.0 < after < 62.0
    assert "left of V 40 .. 100 m/s" in said.out
    assert re.search(r"V > 40 m/s .* 6\d\.\d %|V > 40 m/s .* 59\.\d %", said.out)


def test_nothing_passes_any_more(talk: Talk) -> None:
    """The smallest conflicting set is named."""
    talk(*PARAMS, "require V > 60 m/s", "require D < 40 m")
    said = talk("require V < 50 m/s")
    assert "0.00 % of draws accepted" in said.out
    assert "never together: `V > 60 m/s` (line 3) and `V < 50 m/s` (line 5); proved" in said.out


def test_what_to_relax(talk: Talk) -> None:
    """One requirement and its amount."""
    talk(*PARAMS, "require V > 60 m/s")
    said = talk(":relax 50%")
    assert re.search(r"relax `V > 60 m/s` by (9|10)\.?\d* m/s", said.out)


def test_a_plot(talk: Talk) -> None:
    """Accepted against drawn; a param that does not exist is answered with the nearest."""
    talk(*PARAMS, "require V > 60 m/s")
    assert re.search(r"median (79|80|81)", talk(":plot V").out)
    assert "nine tenths" in talk(":plot V").out
    assert "did you mean" in talk(":plot v").err or talk.state.mistakes


def test_how_long_a_weighing_takes(talk: Talk) -> None:
    """Printed, not judged: machines differ. Ten thousand draws of the worked example, view included."""
    talk(LEFT_TURN.read_text())
    talk("require EGO_SPEED > 20 km/h")
    start = time.perf_counter()
    talk("require EGO_SPEED > 30 km/h")
    print(f"entering and weighing a `require`: {time.perf_counter() - start:.3f} s")  # noqa: T201
