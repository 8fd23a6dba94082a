"""A run as others see it: who took part, where each was when, and where the recording comes from. SI units, radians.

Positions are centres of outlines, headings anticlockwise from +x and not wrapped: a vehicle that turns has headings
that run on. Motion between two samples is linear in position and heading, as it is for contact in our own runs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from engine.program import RoadSpec
from engine.tables import Floats
from engine.vocabulary import ActorKind, State


@dataclass(frozen=True)
class RecordedActor:
    """One of those who took part; lengths in metres."""

    name: str
    """Unique in its recording."""
    kind: ActorKind
    length: float
    width: float
    rear_to_center: float
    """How far ahead of the rear axle the centre lies; 0 for kinds without wheels."""
    wheelbase: float
    mass: float
    """[kg]"""
    max_acceleration: float
    """[m/s^2], as the next."""
    max_braking: float
    max_steer: float
    """[rad]"""
    max_speed: float
    """[m/s]; infinite where nothing bounds it."""


@dataclass(frozen=True)
class Contact:
    """First contact of any two, which ends what is scored."""

    time: float
    """[s]"""
    actors: tuple[int, int]


@dataclass(frozen=True)
class SignalTimes:
    """The fixed-time plan of all traffic lights [s]: see `cortex_dsl.semantics.road.signals`.

    Arms that face each other share a phase, north and south first. A phase begins `phase * (green + yellow + all_red)`
    into the plan, is green, yellow, then red until the plan starts again, after two phases.
    """

    green: float
    yellow: float
    all_red: float
    offset: float
    """How far into the plan the run starts."""
    controlled: bool = False
    """Whether the file also lets behaviours or monitors change the lights, which a fixed plan cannot tell."""


@dataclass(frozen=True)
class Provenance:
    """Where a recording comes from, in words that a file can carry."""

    title: str = ""
    """One line: what is to be seen."""
    author: str = "cortexc"
    date: str = "1970-01-01T00:00:00"
    """ISO 8601, of the run or the search; the same case gives the same file."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """By name, in an order for people: scenario, seed, stream, digest, risk, version, command …"""
    genome: Mapping[str, str] = field(default_factory=dict)
    """Value of each param as written in the file, with its unit: `EGO_SPEED` -> `41.5 km/h`."""


@dataclass(frozen=True)
class Recording:
    """Who was where when. Actor 0 is the ego."""

    name: str
    """Fit for a file name."""
    actors: tuple[RecordedActor, ...]
    time: Floats
    """(samples,) ascending [s]: whole steps, and where two touched the instant of first contact."""
    states: Floats
    """(samples, actors, len(State)). What follows first contact is contact physics, and not scored."""
    step: float
    """Time step of the simulation [s]."""
    contact: Contact | None = None
    road: RoadSpec | None = None
    """The road, where it is one of ours."""
    signals: SignalTimes | None = None
    commands: bool = True
    """Whether wheel and pedals were recorded; False where files from elsewhere tell motion alone, and those are 0."""
    provenance: Provenance = field(default_factory=Provenance)

    def __len__(self) -> int:
        return len(self.time)

    def stretches(self, actor: int) -> list[tuple[int, int]]:
        """First and last sample (inclusive) of each stretch of time in which an actor is there."""
        there = np.concatenate([[False], self.states[:, actor, State.PRESENT] != 0.0, [False]])
        edges = np.flatnonzero(there[1:] != there[:-1])
        return [(int(start), int(end) - 1) for start, end in edges.reshape(-1, 2)]

    def on_steps(self) -> "Recording":
        """The same without the instant of contact, for formats that know whole steps only."""
        steps = self.time / self.step
        whole = np.abs(steps - np.round(steps)) < 1e-9
        return replace(self, time=self.time[whole], states=self.states[whole])

    def scored_samples(self) -> int:
        """Samples up to and with first contact, or all."""
        return len(self) if self.contact is None else int(np.searchsorted(self.time, self.contact.time, "right"))

    def rear_axle(self, actor: int) -> Floats:
        """(samples, 3): x, y, heading of the actor's rear axle, the reference point of OpenSCENARIO."""
        x, y, heading = (self.states[:, actor, column] for column in (State.X, State.Y, State.HEADING))
        behind = self.actors[actor].rear_to_center
        return np.column_stack([x - behind * np.cos(heading), y - behind * np.sin(heading), heading])
