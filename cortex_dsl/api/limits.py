"""Limits of a test, read from text: `delta_v <= 10 km/h`, `2000` runs, `90s`."""

import math
import re

from cortex_dsl.semantics.quantities.units import UNITS as UNITS_OF_TEXT
from cortex_dsl.syntax.literals import SPOKEN_UNITS
from engine.errors import ArgumentError, nearest
from engine.frozen import frozen
from engine.gates.bounds import COMPARISONS, UNITS, Bound

MOST_RUNS = 1_000_000_000
"""Largest budget; runs of one seed have that many seeds of their own (`cortex_dsl.api.testing`)."""

BUDGET = 200
"""Runs of a file by default."""


@frozen
class Budget:
    """Runs of each file, or time for all files."""

    runs: int = MOST_RUNS
    seconds: float = math.inf
    text: str = ""


def budget_of(text: str | int) -> Budget:
    """Return the budget that a text states: `2000` runs of each file, or `90s`, `5min` for all files.

    Raises:
        ArgumentError: it is neither.
    """
    words = str(text).strip().replace(",", "").replace("_", "")
    number, unit = _number_and_unit(words)
    size = {"s": 1.0, "min": 60.0, "h": 3600.0}.get(unit)
    if not number > 0.0 or (unit and size is None) or not math.isfinite(number) or (not unit and number % 1.0):
        reason = ", and at least one run is needed" if number == 0.0 else ""
        cure = "give a number of runs for each file or cell (2000), or a time for all of them (90s, 5min)"
        raise ArgumentError(f"--budget is `{text}`{reason}", cure)
    if size is not None:
        return Budget(seconds=number * size, text=words)
    if number > MOST_RUNS:
        raise ArgumentError(f"--budget is `{text}`", f"give at most {MOST_RUNS:,} runs")
    return Budget(runs=int(number), text=words)


def bound_of(text: str) -> Bound:
    """Return the bound that a text states: `min_distance >= 1 m`.

    Raises:
        ArgumentError: no comparison, an unknown result, a value without a number, or another dimension than the result.
    """
    found = re.fullmatch(rf"\s*(\w+)\s*({'|'.join(COMPARISONS)})\s*(.+?)\s*", text)
    if found is None:
        raise ArgumentError(f"--bound `{text}` is no bound", 'write it as "min_distance >= 1 m"')
    name, comparison, value = found.groups()
    if name not in UNITS:
        near = nearest(name, UNITS)
        meant = f"; did you mean `{near}`?" if near else ""
        raise ArgumentError(f"--bound: no result is called `{name}`{meant}", f"there are {', '.join(sorted(UNITS))}")
    number, word = _number_and_unit(value)
    if not math.isfinite(number):
        raise ArgumentError(
            f"--bound: `{value}` is no number with a unit", f"write `{name} {comparison} {_example(name)}`"
        )
    unit = UNITS_OF_TEXT.get(SPOKEN_UNITS.get(word, word))
    needed = UNITS_OF_TEXT.get(UNITS[name])
    if (unit and unit.dimension) != (needed and needed.dimension) or (word and unit is None):
        what = f"has the unit {UNITS[name]}" if UNITS[name] else "is a pure number"
        raise ArgumentError(
            f"--bound: `{name}` {what}, `{value}` does not fit", f"write `{name} {comparison} {_example(name)}`"
        )
    scale = unit.factor if unit is not None else 1.0
    shown = unit.word if unit is not None else ""
    return Bound(name, comparison, number * scale, f"{name} {comparison} {value}", shown, scale)


def probability_of(text: str | float, flag: str = "--max-probability", noun: str = "probability") -> float:
    """Return a limit of a probability, above 0 and at most 1: `1e-3` or `0.1%`.

    Raises:
        ArgumentError: it is not.
    """
    example = "1e-3 or 0.1%" if noun == "probability" else "0.95 or 95%"
    number, unit = _number_and_unit(str(text))
    value = number * (0.01 if unit == "%" else 1.0)
    if unit not in ("", "%") or not 0.0 < value <= 1.0:
        raise ArgumentError(f"{flag} is `{text}`", f"give a {noun} above 0 and at most 1, such as {example}")
    return value


def _number_and_unit(text: str) -> tuple[float, str]:
    """Return the number at the beginning of a text and the rest; NaN without a number."""
    found = re.match(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$", text)
    return (float(found[1]), found[2]) if found else (math.nan, text)


def _example(name: str) -> str:
    return f"1 {UNITS[name]}".rstrip()
