"""Intentions of actors, as far as OpenSCENARIO can express them: starts, routes, speeds and reactions. Independent of
the language and of XML. SI units; distances and places are those of rear axles.

Target speeds are lowered for bends as the simulator's drivers do. They slow down to sqrt(lateral acceleration /
curvature), with a steady `PLANNED` deceleration that ends just before the bend begins. If there is no room for that
they first brake fully (`engine.kernels.steering`). After the bend they speed up again.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import product

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import ZERO, Formula
from engine.kernels.steering import MAX_BRAKING as HARDEST
from engine.kernels.steering import PLANNED_BRAKING as PLANNED


# -- when -------------------------------------------------------------------------------------------------------------
class Measure(Enum):
    """Quantity of a condition."""

    TIME = "time"
    """Time since the start [s]."""
    TRAVELLED = "travelled"
    """Distance that an actor has travelled since the start [m]."""
    SPEED = "speed"
    """Speed of an actor [m/s]."""
    RELATIVE_DISTANCE = "relative distance"
    """Straight distance between two actors [m]."""
    TIME_TO_COLLISION = "time to collision"
    """Time to collision of an actor with another actor [s]."""
    DISTANCE_TO_START = "distance to its start"
    """Straight distance from an actor to its start [m]."""
    DISTANCE_TO_POINT = "distance to a point"
    """Straight distance from an actor to a point of the plane [m]."""
    COLLISION = "collision"
    """Contact of an actor with another actor; without a limit."""


ONE_SIDED: Mapping[Measure, bool] = {Measure.TRAVELLED: False, Measure.COLLISION: True}
"""Measures with one side only: travelled distance (at or above), and contact."""


@dataclass(frozen=True)
class Condition:
    """True while a measure is below a limit (or, not `below`, at or above it)."""

    measure: Measure
    limit: Formula
    below: bool = True
    actor: str = ""
    other: str = ""
    point: tuple[float, float] = (0.0, 0.0)

    @property
    def can_be_said(self) -> bool:
        """Return True if OpenSCENARIO has this side of the measure."""
        return ONE_SIDED.get(self.measure, self.below) == self.below

    def negated(self) -> "Condition":
        return Condition(self.measure, self.limit, not self.below, self.actor, self.other, self.point)


Trigger = tuple[tuple[Condition, ...], ...]
"""Trigger that holds if all conditions of any one of its groups hold."""
NEVER: Trigger = ()
ALWAYS: Trigger = ((),)


def any_of(triggers: Iterable[Trigger]) -> Trigger:
    return tuple(dict.fromkeys(group for trigger in triggers for group in trigger))


def all_of(triggers: Iterable[Trigger]) -> Trigger:
    groups = product(*triggers)
    return tuple(tuple(dict.fromkeys(each for group in chosen for each in group)) for chosen in groups)


def none_of(trigger: Trigger) -> Trigger:
    """Return the negation of a trigger."""
    return all_of(tuple((each.negated(),) for each in group) for group in trigger)


# -- what -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Start:
    """Start of an actor: on a lane, or in the plane if no lane is near."""

    pose: tuple[float, float, float]
    """x, y, heading of this case."""
    lane: int | None = None
    """Id of the lane."""
    s: Formula = ZERO
    """Along its centre line [m]."""
    offset: float = 0.0
    """Offset to the left of it [m]."""
    turned: float = 0.0
    """Rotation relative to it [rad], anticlockwise."""


@dataclass(frozen=True)
class Change:
    """Target speed [m/s] and acceleration [m/s^2]."""

    speed: Formula
    rate: Formula


@dataclass(frozen=True)
class Phase:
    """Intention of an actor from some point of its way on."""

    name: str
    begins: Formula
    """Way since the start [m]."""
    change: Change
    faster_than: Formula | None = None
    """Speed at the start [m/s]: only a faster actor has this phase, once."""


@dataclass(frozen=True)
class Reaction:
    """Reaction that replaces the phases while a trigger holds."""

    name: str
    when: Trigger
    change: Change


@dataclass(frozen=True)
class ActorPlan:
    name: str
    start: Start
    speed: Formula
    """Speed at the start [m/s]."""
    route: tuple[int, ...] = ()
    """Ids of the lanes of its route; empty for an actor that does not move."""
    phases: tuple[Phase, ...] = ()
    """Phases in the order of the way."""
    reactions: tuple[Reaction, ...] = ()
    """Reactions in the order of precedence; their triggers exclude each other."""
    leaves: Formula | None = None
    """Way after which it leaves the scene [m]."""
    exact: bool = False
    """True if it follows its recorded trajectory, because its motion has no other description."""


@dataclass(frozen=True)
class Parameter:
    """A number that may be varied."""

    name: str
    value: float
    """Value in this case."""
    low: float = float("-inf")
    high: float = float("inf")
    normal: tuple[float, float] | None = None
    """Mean and standard deviation of a normal law within the bounds; None: uniform."""
    whole: bool = False
    """True for an integer."""
    is_drawn: bool = True
    """True if a plain run samples it; else its values are known for single cases only."""
    unit: str = ""


@dataclass(frozen=True)
class End:
    """Condition that ends the run."""

    name: str
    when: Trigger


@dataclass(frozen=True)
class ManeuverPlan:
    """Content of a file in maneuver mode, for one case."""

    actors: tuple[ActorPlan, ...]
    parameters: tuple[Parameter, ...]
    ends: tuple[End, ...]
    remarks: tuple[str, ...] = ()

    @property
    def values(self) -> Mapping[str, float]:
        """Return the values of all parameters in this case."""
        return {each.name: each.value for each in self.parameters}

    def formulas(self) -> tuple[Formula, ...]:
        """Return all formulas of the plan."""
        found = [each.limit for end in self.ends for group in end.when for each in group]
        for actor in self.actors:
            found += [actor.speed, actor.start.s, *(each.begins for each in actor.phases)]
            found += [] if actor.leaves is None else [actor.leaves]
            found += [each.faster_than for each in actor.phases if each.faster_than is not None]
            for each in (*actor.phases, *actor.reactions):
                found += [each.change.speed, each.change.rate]
            found += [each.limit for reaction in actor.reactions for group in reaction.when for each in group]
        return tuple(found)

    def used(self) -> frozenset[str]:
        """Return the names of the parameters that a formula of the plan uses."""
        return frozenset[str]().union(*(each.parameters() for each in self.formulas()))


# -- speeds along a way ------------------------------------------------------------------------------------------------

EARLY = 0.25
"""Time before a bend at which its speed is reached [s]: drivers look 0.5 s ahead, and lag by half of it."""
GAP = 0.1
"""Distance below which two bends become one [m]."""


@dataclass(frozen=True)
class Bend:
    begin: float
    """Position along the way [m], as is `end`."""
    end: float
    curvature: float
    """[1/m], without sign."""


@dataclass(frozen=True)
class Way:
    """Properties of an actor's way that affect its speed."""

    bends: tuple[Bend, ...] = ()
    along: Formula = formula.ZERO
    """Start on the way [m]."""
    furthest: float = 0.0
    """Largest start on the way [m], for all parameter values."""
    lateral: float = math.inf
    """Lateral acceleration that it accepts [m/s^2]."""
    braking: float = HARDEST
    """Maximum deceleration [m/s^2]."""

    def ahead(self, at: float) -> Formula:
        """Return the way from the start to a place, at least 0 [m]."""
        way = formula.subtract(formula.number(at), self.along)
        return way if at >= self.furthest else formula.positive(way)


def phases_of(way: Way, initial: Formula, free: Change) -> tuple[Phase, ...]:
    """Return the phases of an actor that starts with a speed [m/s]; `free` is its speed without a bend."""
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
    """Return bends where adjacent ones are one, with the largest of their curvatures."""
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
    """Braking from a speed v for a bend with the permitted speed b: v^2 - b^2 = 2 a way."""

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
        """Return v^2 less the largest permitted square at the start; above 0 if there is too little room."""
        return formula.subtract(self.excess, formula.multiply(formula.number(2.0 * PLANNED), self.room))

    def steady(self, target: Formula, name: str, later: Formula = formula.ZERO) -> Phase:
        """Return the phase with the planned deceleration. A sufficiently slow actor keeps its speed."""
        spare = formula.divide(formula.subtract(formula.ZERO, self.missing), formula.number(2.0 * PLANNED))
        begins = formula.add(formula.positive(spare), later)
        change = Change(formula.least(target, formula.number(self.allowed)), formula.number(PLANNED))
        return Phase(name, begins, change)

    def hard(self) -> Phase:
        """Return the phase with too little room: full braking, until the planned deceleration suffices."""
        limit = formula.add(self._squared(), formula.multiply(formula.number(2.0 * PLANNED), self.room))
        share = self.hardest / (self.hardest - PLANNED)
        left = formula.multiply(_rounded(2.0 * PLANNED * share), self.room)
        rest = formula.subtract(left, formula.multiply(_rounded(share - 1.0), self.excess))
        speed = formula.applied("sqrt", formula.add(self._squared(), formula.positive(rest)))
        change = Change(speed, formula.number(self.hardest))
        return Phase("brakes_hard", formula.ZERO, change, formula.applied("sqrt", limit))

    def after_hard(self, target: Formula) -> Phase:
        """Return the rest of the braking, with the planned deceleration; at once if the room sufficed."""
        over = formula.divide(formula.positive(self.missing), _rounded(2.0 * (self.hardest - PLANNED)))
        return self.steady(target, "slows_1", over)

    def _squared(self) -> Formula:
        return formula.number(self.allowed * self.allowed)


def _rounded(value: float) -> Formula:
    """Return the number without its last digits, which carry no information."""
    return formula.number(round(value, formula.DIGITS))
