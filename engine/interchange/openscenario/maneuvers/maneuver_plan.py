"""What actors intend, as far as OpenSCENARIO can say it: where they start, which way they go, how fast, and what they
react to. Neutral: knows neither the language nor XML. SI units, distances and places are those of rear axles.

Target speeds are lowered for bends as the simulator's drivers do. They slow down to sqrt(lateral acceleration /
curvature), with a steady `PLANNED` deceleration that ends just before the bend begins. Where there is no room for that
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
    """What a condition looks at."""

    TIME = "time"
    """Since the start [s]."""
    TRAVELLED = "travelled"
    """Way of an actor since the start [m]."""
    SPEED = "speed"
    """Of an actor [m/s]."""
    RELATIVE_DISTANCE = "relative distance"
    """From an actor to another, as the crow flies [m]."""
    TIME_TO_COLLISION = "time to collision"
    """Of an actor with another [s]."""
    DISTANCE_TO_START = "distance to its start"
    """From an actor to where it started, as the crow flies [m]."""
    DISTANCE_TO_POINT = "distance to a point"
    """From an actor to a point of the plane, as the crow flies [m]."""
    COLLISION = "collision"
    """Whether an actor touches another; has no limit."""


ONE_SIDED: Mapping[Measure, bool] = {Measure.TRAVELLED: False, Measure.COLLISION: True}
"""Measures with one side only: that an actor has gone so far, or touches another."""


@dataclass(frozen=True)
class Condition:
    """Whether a measure is below a limit (or, not `below`, at or above it)."""

    measure: Measure
    limit: Formula
    below: bool = True
    actor: str = ""
    other: str = ""
    point: tuple[float, float] = (0.0, 0.0)

    @property
    def can_be_said(self) -> bool:
        """Whether OpenSCENARIO has this side of the measure."""
        return ONE_SIDED.get(self.measure, self.below) == self.below

    def negated(self) -> "Condition":
        return Condition(self.measure, self.limit, not self.below, self.actor, self.other, self.point)


Trigger = tuple[tuple[Condition, ...], ...]
"""Holds where all conditions of any one of its groups hold."""
NEVER: Trigger = ()
ALWAYS: Trigger = ((),)


def any_of(triggers: Iterable[Trigger]) -> Trigger:
    return tuple(dict.fromkeys(group for trigger in triggers for group in trigger))


def all_of(triggers: Iterable[Trigger]) -> Trigger:
    groups = product(*triggers)
    return tuple(tuple(dict.fromkeys(each for group in chosen for each in group)) for chosen in groups)


def none_of(trigger: Trigger) -> Trigger:
    """The opposite of a trigger."""
    return all_of(tuple((each.negated(),) for each in group) for group in trigger)


# -- what -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Start:
    """Where an actor begins: on a lane, or where none is near, in the plane."""

    pose: tuple[float, float, float]
    """x, y, heading of this case."""
    lane: int | None = None
    """Id of the lane."""
    s: Formula = ZERO
    """Along its centre line [m]."""
    offset: float = 0.0
    """To the left of it [m]."""
    turned: float = 0.0
    """Anticlockwise against it [rad]."""


@dataclass(frozen=True)
class Change:
    """A speed to go to, and how fast [m/s, m/s^2]."""

    speed: Formula
    rate: Formula


@dataclass(frozen=True)
class Phase:
    """What an actor wants from some point of its way on."""

    name: str
    begins: Formula
    """Way since the start [m]."""
    change: Change
    faster_than: Formula | None = None
    """Only an actor that is faster than this at the start [m/s] has this phase, and once."""


@dataclass(frozen=True)
class Reaction:
    """What replaces the phases while a trigger holds."""

    name: str
    when: Trigger
    change: Change


@dataclass(frozen=True)
class ActorPlan:
    name: str
    start: Start
    speed: Formula
    """At the start [m/s]."""
    route: tuple[int, ...] = ()
    """Ids of the lanes it goes along; empty for an actor that stays where it is."""
    phases: tuple[Phase, ...] = ()
    """In the order of the way."""
    reactions: tuple[Reaction, ...] = ()
    """In the order of precedence; their triggers exclude each other."""
    leaves: Formula | None = None
    """Way after which it leaves the scene [m]."""
    exact: bool = False
    """Whether it goes along its recorded trajectory, because nothing else says what it does."""


@dataclass(frozen=True)
class Parameter:
    """A number that others may vary."""

    name: str
    value: float
    """In this case."""
    low: float = float("-inf")
    high: float = float("inf")
    normal: tuple[float, float] | None = None
    """Mean and standard deviation, where its law is a normal one within the bounds."""
    whole: bool = False
    """Whether it is an integer."""
    is_drawn: bool = True
    """Whether a plain run draws it; else it is known of single cases only."""
    unit: str = ""


@dataclass(frozen=True)
class End:
    """What ends the run."""

    name: str
    when: Trigger


@dataclass(frozen=True)
class ManeuverPlan:
    """Everything that a file in maneuver mode says of one case."""

    actors: tuple[ActorPlan, ...]
    parameters: tuple[Parameter, ...]
    ends: tuple[End, ...]
    remarks: tuple[str, ...] = ()

    @property
    def values(self) -> Mapping[str, float]:
        """Of all parameters, in this case."""
        return {each.name: each.value for each in self.parameters}

    def formulas(self) -> tuple[Formula, ...]:
        """All that stand in the plan."""
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
        """Names of the parameters on which something depends."""
        return frozenset[str]().union(*(each.parameters() for each in self.formulas()))


# -- speeds along a way ------------------------------------------------------------------------------------------------

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
    """Return the phases of an actor that starts with a speed [m/s]; `free` is what it does where nothing hinders it."""
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
        """v^2 less what may be driven at the start; above 0 where there is too little room."""
        return formula.subtract(self.excess, formula.multiply(formula.number(2.0 * PLANNED), self.room))

    def steady(self, target: Formula, name: str, later: Formula = formula.ZERO) -> Phase:
        """With the planned deceleration. An actor that is slow enough keeps its speed."""
        spare = formula.divide(formula.subtract(formula.ZERO, self.missing), formula.number(2.0 * PLANNED))
        begins = formula.add(formula.positive(spare), later)
        change = Change(formula.least(target, formula.number(self.allowed)), formula.number(PLANNED))
        return Phase(name, begins, change)

    def hard(self) -> Phase:
        """With too little room: full braking, until the planned deceleration is enough."""
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
    """Return the number without its last digits, which carry no information."""
    return formula.number(round(value, formula.DIGITS))
