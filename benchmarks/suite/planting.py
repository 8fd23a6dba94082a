"""Planted defects: files whose failures are known, with their causes and rates, because they were put there.

    python -m benchmarks.suite --plant TEXT --folder FOLDER     # the files of a seed, which is any text

The ego of a base scene brakes in time wherever no defect is: at all corners of the space it stays clear of the other,
and in all draws that are made before a file is written. A *defect* delays its brake near a hidden place of a few genes:
at the place it does not brake at all, and from a distance of `REACH` of each range on it brakes as early as elsewhere.
How steeply the delay grows decides how rare the failures are, so that a search is guided from equally far to a failure
of rate 3e-6 and to one of rate 3e-3. Each file has three defects, of which the second and the third fail a half and a
sixth as often as the first.

A first draw shows where a defect fails, from which its steepness is computed; the rate is then drawn anew. It is an
integral over balls, by strata: shells between delays, drawn uniformly, with exact volumes (Cochran 1977, "Sampling
techniques", chapter 5), and needs few runs however rare the failures are.
"""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.random import Generator, default_rng

from engine.portable import power
from engine.tables import Bools, Floats, Ints

HERE = Path(__file__).parent
REACH = 0.5
"""Distance from the place of a defect from which on it has no effect, in units of each range."""
IN_TIME = 5.0
"""Time to collision at which the ego brakes where no defect delays it [s]."""
SHARES = (0.6, 0.3, 0.1)
"""Share of each defect in the failures of a file."""
DECADES = (2, 3, 4, 5)
"""Rates lie between 10^-d and 10^-(d + 1)."""
SIZES = (2, 4)
"""Genes of a defect."""
EDGES = (0.0, 0.04, 0.08, 0.12, 0.16, 0.2, 0.24, 0.28, 0.34, 0.4, 0.5, 0.7, 1.0)
"""Strata: shells between these shares of `IN_TIME`."""
PARAM = re.compile(r"^param (\w+) *= Range\((.+), (.+)\)(.*)$", re.MULTILINE)
FAMILIES = {"leader": 0.24, "cyclist": 0.13, "merger": 0.16}
"""Base scenes, and the share of `IN_TIME` below which their egos fail in half of all draws."""


@dataclass(frozen=True)
class Defect:
    """A place near which the brake of an ego is delayed, and how steeply."""

    genes: tuple[str, ...]
    centre: tuple[float, ...]
    """In units of each range."""
    sharpness: float
    """The brake acts at `IN_TIME` times (distance / `REACH`) to this power."""

    def share(self, units: Floats) -> Floats:
        """Return (n,) the share of `IN_TIME` at which the ego brakes, of its genes (n, k) in units of each range."""
        distance = np.sqrt(((units - np.array(self.centre)) ** 2).sum(axis=1)) / REACH
        return np.minimum(1.0, power(distance, self.sharpness))

    def radius(self, share: float) -> float:
        """Return the distance at which the ego brakes at a share of `IN_TIME`, in units of each range."""
        return REACH * share ** (1.0 / self.sharpness)

    @property
    def ball(self) -> float:
        """Return the volume of a ball of radius 1 in its genes."""
        return math.pi ** (len(self.genes) / 2) / math.gamma(len(self.genes) / 2 + 1)

    def share_at(self, rate: float) -> float:
        """Return the share of `IN_TIME` below which it fails, if it has this rate and fails nowhere else."""
        return float(self._reach_at(rate) ** self.sharpness)

    def at_rate(self, rate: float, fails_below: float) -> "Defect":
        """Return the defect of this place that has a rate, if it fails below this share and nowhere else."""
        return replace(self, sharpness=float(f"{math.log(fails_below) / math.log(self._reach_at(rate)):.6g}"))

    def _reach_at(self, rate: float) -> float:
        """Return the radius of the ball with this volume, in units of `REACH` of each range."""
        return (rate / self.ball) ** (1.0 / len(self.genes)) / REACH

    def shells(self, count: int, stream: Generator) -> Iterator[tuple[float, Floats]]:
        """Yield the volume of each shell, and (count, k) uniform points of it in units of each range."""
        size = len(self.genes)
        radii = [self.radius(edge) for edge in EDGES if self.radius(edge) <= _room(self.centre)]
        for inner, outer in pairwise(radii):
            low, high = inner**size, outer**size
            way = stream.standard_normal((count, size))
            way /= np.sqrt((way**2).sum(axis=1, keepdims=True))
            far = power(low + (high - low) * stream.random(count), 1.0 / size)
            yield self.ball * (high - low), np.array(self.centre) + way * far[:, np.newaxis]


@dataclass(frozen=True)
class Gene:
    """A range of a base scene, as its text has it."""

    name: str
    low: float
    high: float
    unit: str

    def text(self, centre: float) -> str:
        """Return the square of the distance from a place in units of the range, in the language."""
        value, width = self.low + centre * (self.high - self.low), self.high - self.low
        return f"(({self.name} - {value:.6g}{self.unit}) / ({width:.6g}{self.unit})) ** 2"


@dataclass(frozen=True)
class Planted:
    """A file of the suite and what is hidden in it."""

    name: str
    family: str
    rate: float
    """Failures of fair draws that it is meant to have."""
    defects: tuple[Defect, ...]

    @property
    def text(self) -> str:
        base = _base(self.family)
        genes, lines, delays = {gene.name: gene for gene in _genes(base)}, [], []
        for number, defect in enumerate(self.defects, 1):
            terms = [genes[gene].text(place) for gene, place in zip(defect.genes, defect.centre, strict=True)]
            sums = "\n    + ".join(terms)
            lines.append(f"AWAY_{number} = (\n    {sums}\n) ** 0.5 / {REACH}")
            delays.append(f"AWAY_{number} ** {defect.sharpness:.6g}")
        lines.append(f"BRAKES_AT = {IN_TIME} s * min(1, {', '.join(delays)})")
        return base.replace("# DEFECTS", "\n".join(lines))

    def adjusted(self, rates: Sequence[float]) -> "Planted":
        """Return the file with defects as steep as it takes, by the rates that these ones have."""
        pairs = zip(self.defects, rates, SHARES, strict=True)
        return replace(
            self, defects=tuple(each.at_rate(share * self.rate, each.share_at(rate)) for each, rate, share in pairs)
        )


def planted(seed: str) -> list[Planted]:
    """Return the files of a seed before any run: each family, decade and number of genes of a defect once."""
    made = []
    for family, fails_below in FAMILIES.items():
        genes = _genes(_base(family))
        for decade in DECADES:
            for size in SIZES:
                name, rate = f"{family}_{decade}_{size}", 10.0 ** -(decade + 0.5)
                stream = default_rng(list(hashlib.sha256(f"{seed}/{name}".encode()).digest()))
                defects = []
                for share in SHARES:
                    rows = sorted(stream.choice(len(genes), size=size, replace=False))
                    centre = tuple(round(float(place), 6) for place in stream.uniform(0.25, 0.75, size=size))
                    anywhere = Defect(tuple(genes[row].name for row in rows), centre, 1.0)
                    defects.append(anywhere.at_rate(share * rate, fails_below))
                made.append(Planted(name, family, rate, tuple(defects)))
    return made


def _base(family: str) -> str:
    return (HERE / "bases" / f"{family}.txt").read_text()


def _genes(base: str) -> list[Gene]:
    return [Gene(found[1], float(found[2]), float(found[3]), found[4]) for found in PARAM.finditer(base)]


def _room(centre: Sequence[float]) -> float:
    """Return the distance of a place from the edge of the cube."""
    return min(min(place, 1.0 - place) for place in centre)


def undisturbed(family: str) -> str:
    """Return the text of a base scene without a defect."""
    return _base(family).replace("# DEFECTS", f"BRAKES_AT = {IN_TIME} s")


def delayed_by(defects: Sequence[Defect], units: Sequence[Floats]) -> tuple[Ints, Bools]:
    """Return (n,) the defect that delays the brake most, and whether any does; `units` holds (n, k) of each defect."""
    shares = np.stack([defect.share(own) for defect, own in zip(defects, units, strict=True)])
    return np.argmin(shares, axis=0), shares.min(axis=0) < 1.0
