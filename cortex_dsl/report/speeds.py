"""Speeds as the file writes them: km/h where it says km/h. What programs read stays in m/s."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from cortex_dsl.report.numbers import fixed
from engine.program import Program

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


def speed_unit(program: Program) -> SpeedUnit:
    """That of most of the file's params, else the one that its text names most; m/s, as bare numbers are, if none."""
    named = Counter(unit for unit in program.space.units if unit in UNITS) or Counter(_written(program))
    return UNITS[max(named, key=lambda unit: (named[unit], unit == KM_H.name))] if named else M_S


def _written(program: Program) -> Iterator[str]:
    for text in (program.source_text, *(file.text for file in program.imported)):
        yield from WORD.findall(COMMENT.sub("", text))
