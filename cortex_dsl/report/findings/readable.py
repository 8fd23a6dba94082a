"""Numbers, values of params, speeds and titles for readers.

Few digits, equal in a column, a dash for a missing value. Speeds are in the unit of the file: km/h if the file uses
km/h; machine-readable output is in m/s.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from textwrap import shorten
from typing import TYPE_CHECKING

from engine.display import counted as counted
from engine.vocabulary import GeneKind

if TYPE_CHECKING:
    from engine.program import ParamSpace, Program

ABSENT = "–"
NOT_LEVEL = "not on one level"
"""Words instead of a distance of two actors that are on different levels whenever both are in the scene."""


def fixed(value: float, decimals: int) -> str:
    """A number with a fixed count of decimals and thousands apart; `–` for NaN, `∞` for infinity."""
    if math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    text = f"{value:,.{decimals}f}"
    return text.removeprefix("-") if re.fullmatch(r"-0(\.0*)?", text) else text


def whole(value: float) -> str:
    return fixed(value, 0)


def percent(share: float, decimals: int = 1) -> str:
    """Return a share in percent: 0.257 -> `25.7 %`."""
    return ABSENT if math.isnan(share) else f"{fixed(100.0 * share, decimals)} %"


def ratio(part: float, whole_: float) -> float:
    """The quotient, NaN where there is nothing."""
    return part / whole_ if whole_ else math.nan


def significant(value: float, digits: int = 4) -> str:
    """A parameter's value: `digits` significant digits, no exponent over the usual range, no idle zeros."""
    if not math.isfinite(value):
        return fixed(value, 0)
    if value != 0 and not 1e-4 <= abs(value) < 1e7:
        return f"{value:.{digits - 1}e}"
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def column_decimals(low: float, high: float) -> int:
    """Decimals that show a range [low, high] to about a thousandth of its width."""
    width = abs(high - low)
    if not math.isfinite(width) or width == 0:
        return 2
    return max(0, min(6, math.ceil(-math.log10(width / 999.0))))


def duration(seconds: float) -> str:
    """`0.8 s`, `42 s`, `3 min 05 s`, `2 h 10 min`."""
    if not math.isfinite(seconds):
        return ABSENT
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    if seconds < 59.5:
        return f"{seconds:.0f} s"
    if seconds < 3600:
        minutes, rest = divmod(round(seconds), 60)
        return f"{minutes} min {rest:02d} s"
    hours, rest = divmod(round(seconds / 60), 60)
    return f"{hours} h {rest:02d} min"


def format_gene(space: "ParamSpace", gene: int, value: float) -> str:
    """A gene's value without its unit, with the decimals that its range deserves."""
    kind = space.kinds[gene]
    if kind == GeneKind.INDEX:
        options = space.options[gene]
        return options[int(value)] if 0 <= int(value) < len(options) else str(int(value))
    if kind == GeneKind.INTEGER:
        return fixed(value, 0)
    return fixed(value, column_decimals(float(space.low[gene]), float(space.high[gene])))


def gene_value(space: "ParamSpace", gene: int, value: float) -> str | float:
    """A gene's value for other programs: the text of the option that was chosen, or the number."""
    return space.options[gene][int(value)] if space.kinds[gene] == GeneKind.INDEX else value


def shortened(text: str, room: int) -> str:
    """Return as many whole words as fit, and a sign if some are left out."""
    words = shorten(text, room, placeholder=" …") if room > 2 else "…"
    return words if words.strip() != "…" else text[: max(0, room - 1)] + "…"


def short_names(names: Sequence[str], room: int) -> list[str]:
    """Return names of at most `room` characters without the middle of longer ones; different names stay different."""
    begin, end = room // 2, (room - 1) // 2
    short = [name if len(name) <= room else f"{name[:begin]}…{name[len(name) - end :]}" for name in names]
    return short if len(set(short)) == len(set(names)) else short_names(names, room + 1)


# -- speeds as the file writes them ------------------------------------------------------------------------------------

WORD = re.compile(r"(?<![\w/])(?:km/h|mph|m/s)(?![\w/^*])")
COMMENT = re.compile(r"#.*")


@dataclass(frozen=True)
class SpeedUnit:
    """A unit of speed, by how many of it make 1 m/s."""

    name: str
    per_si: float

    def number(self, speed: float, decimals: int = 1) -> str:
        """A speed [m/s] in this unit, without its name."""
        return fixed(self.per_si * speed, decimals)

    def text(self, speed: float, decimals: int = 1) -> str:
        """A speed [m/s] in this unit."""
        return f"{self.number(speed, decimals)} {self.name}"


KM_H = SpeedUnit("km/h", 3.6)
M_S = SpeedUnit("m/s", 1.0)
UNITS = {unit.name: unit for unit in (KM_H, M_S, SpeedUnit("mph", 1.0 / 0.44704))}


def speed_unit(program: "Program") -> SpeedUnit:
    """Return the unit of most of the file's params, else the most frequent one of its text, else m/s."""
    named = Counter(unit for unit in program.space.units if unit in UNITS) or Counter(_written(program))
    return UNITS[max(named, key=lambda unit: (named[unit], unit == KM_H.name))] if named else M_S


def _written(program: "Program") -> Iterator[str]:
    for text in (program.source_text, *(file.text for file in program.imported)):
        yield from WORD.findall(COMMENT.sub("", text))


# -- title of a scenario's report --------------------------------------------------------------------------------------

CASE_REMARK = re.compile(r"# case (\d+) of a search in (.+): risk ")
"""The first line of a case that a search has written; its file is called by its number alone."""


def name_of(program: "Program") -> str:
    """The stem of its file; of a case the stem of the file that was searched, and its number."""
    case = CASE_REMARK.match(program.source_text)
    if case is None or not program.name.isdigit():
        return program.name
    return f"{PurePath(case[2]).stem}, case {int(case[1])}"


def first_line(description: str) -> str:
    """The first line of a docstring."""
    return description.strip().splitlines()[0] if description.strip() else ""
