"""What actors intend, as far as OpenSCENARIO can say it: where they start, which way they go, how fast, and what they
react to. Neutral: knows neither the language nor XML. SI units, distances and places are those of rear axles.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import product

from engine.interchange.openscenario.maneuvers.formula import ZERO, Formula

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
"""Measures of which one side alone can be said: that somebody has gone so far, or touches another."""


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
    """Only who is faster than this at the start [m/s] has this phase at all, and once."""


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
    """Ids of the lanes it goes along; empty for who keeps to where it is."""
    phases: tuple[Phase, ...] = ()
    """In the order of the way."""
    reactions: tuple[Reaction, ...] = ()
    """Their triggers exclude each other: who comes first in the order of precedence, has it."""
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
