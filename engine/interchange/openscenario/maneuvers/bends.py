"""Speeds along a way: the target speed, lowered for bends as the simulator's drivers do.

They slow down to sqrt(lateral acceleration / curvature), with a steady `PLANNED` deceleration that ends just before the
bend begins. Where there is no room for that they first brake as hard as they can (`engine.kernels.steering`). After the
bend they speed up again.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.plan import Change, Phase
from engine.kernels.steering import MAX_BRAKING as HARDEST
from engine.kernels.steering import PLANNED_BRAKING as PLANNED

EARLY = 0.25
"""So long before the bend begins its speed is reached [s]: drivers look 0.5 s ahead, and lag by half of it."""
GAP = 0.1
"""Bends that lie closer together are one [m]."""


@dataclass(frozen=True)
class Bend:
    begin: float
    """Where along the way [m], as the next."""
    end: float
    curvature: float
    """[1/m], without sign."""


@dataclass(frozen=True)
class Way:
    """Where an actor goes, as far as it concerns its speed."""

    bends: tuple[Bend, ...] = ()
    along: Formula = formula.ZERO
    """Where on the way it starts [m] …"""
    furthest: float = 0.0
    """… and up to where it may, whatever the parameters [m]."""
    lateral: float = math.inf
    """Lateral acceleration that it accepts [m/s^2]."""
    braking: float = HARDEST
    """What its brakes can do [m/s^2]."""

    def ahead(self, at: float) -> Formula:
        """Way from the start to a place, at least 0 [m]."""
        way = formula.subtract(formula.number(at), self.along)
        return way if at >= self.furthest else formula.positive(way)


def phases_of(way: Way, initial: Formula, free: Change) -> tuple[Phase, ...]:
    """What an actor wants in turn, who starts with a speed [m/s]; `free` is what it does where nothing hinders it."""
    phases = [Phase("drives", formula.ZERO, free)]
    bends = _joined(way.bends) if way.lateral < math.inf else []
    fastest = formula.most(initial, free.speed)
    for number, bend in enumerate(bends, 1):
        braking = _Braking.before(way, bend, fastest)
        if number == 1 and braking.hardest > PLANNED:
            phases += [braking.hard(), braking.after_hard(free.speed)]
        else:
            phases.append(braking.steady(free.speed, f"slows_{number}"))
        phases.append(Phase(f"goes_on_{number}", way.ahead(bend.end), free))
    return tuple(phases)


def _joined(bends: Sequence[Bend]) -> list[Bend]:
    """Bends that follow one another at once are one, as sharp as the sharpest."""
    joined: list[Bend] = []
    for bend in bends:
        if joined and bend.begin - joined[-1].end < GAP:
            last = joined.pop()
            joined.append(Bend(last.begin, bend.end, max(last.curvature, bend.curvature)))
        else:
            joined.append(bend)
    return joined


@dataclass(frozen=True)
class _Braking:
    """Braking from a speed v for a bend that allows b: v^2 - b^2 = 2 a way."""

    excess: Formula
    """v^2 - b^2."""
    room: Formula
    """Way up to where b must be reached [m]."""
    allowed: float
    """b [m/s]."""
    hardest: float
    """[m/s^2]"""

    @staticmethod
    def before(way: Way, bend: Bend, fastest: Formula) -> "_Braking":
        allowed = math.sqrt(way.lateral / bend.curvature)
        excess = formula.subtract(formula.square(fastest), formula.number(allowed * allowed))
        early = min(EARLY * allowed, allowed * allowed / (4.0 * PLANNED))
        room = formula.subtract(way.ahead(bend.begin), formula.number(early))
        return _Braking(excess, room, allowed, min(HARDEST, way.braking))

    @property
    def missing(self) -> Formula:
        """v^2 less what may be driven at the start; who has too little room has more than 0."""
        return formula.subtract(self.excess, formula.multiply(formula.number(2.0 * PLANNED), self.room))

    def steady(self, target: Formula, name: str, later: Formula = formula.ZERO) -> Phase:
        """With the planned deceleration. Who is slow enough keeps its speed."""
        spare = formula.divide(formula.subtract(formula.ZERO, self.missing), formula.number(2.0 * PLANNED))
        begins = formula.add(formula.positive(spare), later)
        change = Change(formula.least(target, formula.number(self.allowed)), formula.number(PLANNED))
        return Phase(name, begins, change)

    def hard(self) -> Phase:
        """Of who has too little room: as hard as it can, until the planned deceleration will do."""
        limit = formula.add(self._squared(), formula.multiply(formula.number(2.0 * PLANNED), self.room))
        share = self.hardest / (self.hardest - PLANNED)
        left = formula.multiply(_rounded(2.0 * PLANNED * share), self.room)
        rest = formula.subtract(left, formula.multiply(_rounded(share - 1.0), self.excess))
        speed = formula.applied("sqrt", formula.add(self._squared(), formula.positive(rest)))
        change = Change(speed, formula.number(self.hardest))
        return Phase("brakes_hard", formula.ZERO, change, formula.applied("sqrt", limit))

    def after_hard(self, target: Formula) -> Phase:
        """The rest with the planned deceleration; at once where the room was enough."""
        over = formula.divide(formula.positive(self.missing), _rounded(2.0 * (self.hardest - PLANNED)))
        return self.steady(target, "slows_1", over)

    def _squared(self) -> Formula:
        return formula.number(self.allowed * self.allowed)


def _rounded(value: float) -> Formula:
    """Without the last digits, which are no news to anybody who reads the file."""
    return formula.number(round(value, formula.DIGITS))
