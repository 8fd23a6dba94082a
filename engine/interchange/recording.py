"""A run for other tools: its actors, their states over time, and the provenance. SI units, radians.

Positions are centres of outlines, headings anticlockwise from +x and not wrapped. Motion between two samples is linear
in position and heading, as in the contact search of simulated runs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.errors import InterchangeError
from engine.interchange.road_levels import road_heights
from engine.maps import MapSpec
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes, actor_columns
from engine.tables import SLIDING, Floats, Ints
from engine.vocabulary import ActorKind, Column, State

if TYPE_CHECKING:  # pymunk, which nothing that reads or writes a file needs
    from engine.world import WorldRun

SAME_INSTANT = 1e-9
"""Time difference below which instants are equal [s]: no format can distinguish them."""
MOST_ACTORS = 1000
"""Maximum number of actors in a file; simulated runs have fewer."""


@dataclass(frozen=True)
class RecordedActor:
    """One actor of a recording; lengths in metres."""

    name: str
    """Unique in its recording."""
    kind: ActorKind
    length: float
    width: float
    rear_to_center: float
    """Distance of the centre ahead of the rear axle; 0 for kinds without wheels."""
    wheelbase: float
    mass: float
    """[kg]"""
    max_acceleration: float
    """[m/s^2], as is `max_braking`."""
    max_braking: float
    max_steer: float
    """[rad]"""
    max_speed: float
    """[m/s]; infinite without a limit."""


@dataclass(frozen=True)
class Contact:
    """End of the scored part: the ego's contact with another actor, or with a building, then without a second actor."""

    time: float
    """[s]"""
    actors: tuple[int, ...]
    after: str = "physics"
    """Kind of the samples after it, one of `contract.AFTER_CONTACT`."""


ARMS = ("north", "east", "south", "west")
"""Arms of a junction, clockwise."""
PHASES = 2


@dataclass(frozen=True)
class SignalTimes:
    """The fixed-time plan of all traffic lights [s]: see `cortex_dsl.semantics.evaluation.signals`.

    Arms that face each other share a phase, north and south first. A phase begins `phase * (green + yellow + all_red)`
    into the plan, is green, yellow, then red until the plan starts again, after two phases.
    """

    green: float
    yellow: float
    all_red: float
    offset: float
    """Time in the plan at which the run starts."""
    controlled: bool = False
    """True if behaviours or monitors of the file may change the lights, which a fixed plan cannot express."""

    @property
    def slot(self) -> float:
        """Return the duration of one phase [s]."""
        return self.green + self.yellow + self.all_red

    @property
    def cycle(self) -> float:
        """Return the period of the plan [s]."""
        return PHASES * self.slot

    def begins(self, phase: int) -> float:
        """Return an instant at which the lights of a phase turn green [s]; negative if it was before the run."""
        return phase * self.slot - self.offset


@dataclass(frozen=True)
class Surroundings:
    """Weather of the file, None if unknown: factor on all grip, range of sight [m], factor on views."""

    friction: float | None = None
    sight: float | None = None
    light: float | None = None


@dataclass(frozen=True)
class Provenance:
    """Origin of a recording, in words that a file can contain."""

    title: str = ""
    """One-line description."""
    author: str = "cortexc"
    date: str = "1970-01-01T00:00:00"
    """ISO 8601, date of the run or the search; so equal cases give equal files."""
    facts: Mapping[str, str] = field(default_factory=dict[str, str])
    """Facts by name, in an order for people: scenario, seed, stream, digest, risk, version, command …"""
    genome: Mapping[str, str] = field(default_factory=dict[str, str])
    """Value of each param as written in the file, with its unit: `EGO_SPEED` -> `41.5 km/h`."""


@dataclass(frozen=True)
class Recording:
    """States of all actors over time. Actor 0 is the ego."""

    name: str
    """Name that is valid as a file name."""
    actors: tuple[RecordedActor, ...]
    time: Floats
    """(samples,) ascending [s]: whole steps, and the instant of first contact."""
    states: Floats
    """(samples, actors, len(State)): metres, m/s, radians, pedals from 0 to 1; x east and y north, as the road has it.

    States of an absent actor are meaningless. Samples after first contact are contact physics, and not scored.
    """
    step: float
    """Time step of the simulation [s]."""
    contact: Contact | None = None
    road: MapSpec | None = None
    """Road of the recording, if it has one."""
    buildings: Floats | None = None
    """(n, 5): centre x, y [m], heading [rad], length along it and width [m]; None if unknown."""
    signals: SignalTimes | None = None
    surroundings: Surroundings | None = None
    commands: bool = True
    """True if wheel and pedals were recorded; False for files with motion alone, where they are 0."""
    provenance: Provenance = field(default_factory=Provenance)
    first_lanes: Ints | None = None
    """`RoadTables.first_lanes` of a scenario that names levels."""

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def heights(self) -> Floats | None:
        """Return (samples, actors) heights of the road at all actors [m]; None on a road without bridges."""
        kinds = np.array([int(actor.kind) for actor in self.actors], dtype=np.int32)
        return road_heights(self.road, kinds, self.states, self.first_lanes)

    @property
    def there(self) -> NDArray[np.bool_]:
        """Return (samples, actors) True while an actor is present."""
        return self.states[:, :, State.PRESENT] != 0.0

    @property
    def slides(self) -> NDArray[np.bool_]:
        """Return (actors,) True for actors that slide after an impact; only their positions describe that motion."""
        return (self.states[:, :, State.PRESENT] == SLIDING).any(axis=0)

    @property
    def never_there(self) -> tuple[int, ...]:
        """Return the actors that never appear, because the run ended before."""
        return tuple(np.flatnonzero(~self.there.any(axis=0)).tolist())

    def refuse_broken(self) -> None:
        """Raise InterchangeError if there is no actor, times do not ascend, or a state is not a number."""
        if not len(self) or not self.there.any():
            raise InterchangeError(f"`{self.name}` holds no actor at any time", "record one actor at least")
        if not (np.isfinite(self.time).all() and (np.diff(self.time) > 0.0).all()):
            raise InterchangeError(f"the times of `{self.name}` do not ascend", "record each instant once, in order")
        broken = np.argwhere(self.there & ~np.isfinite(self.states).all(axis=2))
        if len(broken):
            who, when = self.actors[int(broken[0, 1])].name, self.time[broken[0, 0]]
            raise InterchangeError(f"`{who}` has no finite state at {when:g} s", "take a run that did not break")

    def taking_part(self) -> "Recording":
        """Return the recording without actors that never appear, which a replay cannot contain.

        Raises:
            InterchangeError: the ego never appears.
        """
        if not (away := self.never_there):
            return self
        if 0 in away:
            raise InterchangeError(
                "the ego never comes in: there is nothing to replay", "take a scene in which it does"
            )
        left = [index for index in range(len(self.actors)) if index not in away]
        contact = self.contact and replace(self.contact, actors=tuple(map(left.index, self.contact.actors)))
        actors = tuple(self.actors[index] for index in left)
        return replace(self, actors=actors, states=self.states[:, left], contact=contact)

    def from_zero(self) -> "Recording":
        """Return the recording with times from 0, including those of contact and of the signals' plan."""
        if not (begin := float(self.time[0])):
            return self
        contact = self.contact and replace(self.contact, time=self.contact.time - begin)
        signals = self.signals and replace(self.signals, offset=self.signals.offset + begin)
        return replace(self, time=self.time - begin, contact=contact, signals=signals)

    def stretches(self, actor: int) -> list[tuple[int, int]]:
        """Return first and last sample (inclusive) of each stretch of time in which an actor is present."""
        there = np.concatenate([[False], self.there[:, actor], [False]])
        edges = np.flatnonzero(there[1:] != there[:-1])
        return [(int(start), int(end) - 1) for start, end in edges.reshape(-1, 2)]

    def on_steps(self) -> "Recording":
        """Return the recording without the instant of contact, for formats with whole steps only."""
        steps = self.time / self.step
        whole = np.abs(steps - np.round(steps)) < 1e-9
        return replace(self, time=self.time[whole], states=self.states[whole])

    def scored_samples(self) -> int:
        """Return the number of samples up to and including first contact, or of all samples."""
        return len(self) if self.contact is None else int(np.searchsorted(self.time, self.contact.time, "right"))

    def rear_axle(self, actor: int) -> Floats:
        """Return (samples, 3) x, y, heading of the actor's rear axle, the reference point of OpenSCENARIO."""
        x, y, heading = (self.states[:, actor, column] for column in (State.X, State.Y, State.HEADING))
        behind = self.actors[actor].rear_to_center
        return np.column_stack([x - behind * np.cos(heading), y - behind * np.sin(heading), heading])


@dataclass(frozen=True)
class RecordedCase:
    """A simulated run for the writers of formats: its recording and its outcomes."""

    recording: Recording
    outcomes: Outcomes
    """Outcomes of the recorded run; one row."""
    profile: str
    """Risk profile."""

    @property
    def replay(self) -> Recording:
        """Return the recording with those actors alone that appear.

        Raises:
            InterchangeError: the ego never appears.
        """
        return self.recording.taking_part()

    @property
    def left_out(self) -> tuple[str, ...]:
        """Return the remark on a replay that leaves actors out."""
        actors = self.recording.actors
        return tuple(f"`{actors[each].name}` never comes in, and is left out" for each in self.recording.never_there)


# -- a recording at other instants: motion between two samples is linear -----------------------------------------------

OF_STEPS = [State.ACCELERATION, State.THROTTLE, State.BRAKE]
"""Columns of a sample that describe the step that ended there, so that they hold all through that step."""


def states_at(recording: Recording, instants: Floats) -> Floats:
    """Return (instants, actors, len(State)): all actors at instants within the recording [s].

    A sample no farther than `SAME_INSTANT` away is used as it is. Between two samples an actor is present if it is
    present at both.
    """
    time, states = recording.time, recording.states
    after = np.minimum(np.searchsorted(time, instants - SAME_INSTANT), len(time) - 1)
    sampled = (np.abs(time[after] - instants) <= SAME_INSTANT) | (after == 0)
    before = np.where(sampled, after, after - 1)
    way = np.where(sampled, 1.0, time[after] - time[before])
    part = np.where(sampled, 0.0, (instants - time[before]) / way)[:, np.newaxis, np.newaxis]
    found = states[before] + part * (states[after] - states[before])
    found[:, :, OF_STEPS] = states[after][:, :, OF_STEPS]
    there = (states[before, :, State.PRESENT] != 0.0) & (states[after, :, State.PRESENT] != 0.0)
    found[:, :, State.PRESENT] = np.where(there, states[before, :, State.PRESENT], 0.0)
    return found


# -- from a run of ours to a recording ---------------------------------------------------------------------------------

NO_PROVENANCE = Provenance()


def recorded_run(
    program: Program,
    scenes: Scenes,
    run: "WorldRun",
    *,
    row: int = 0,
    step: float,
    name: str = "",
    surroundings: Surroundings | None = None,
) -> Recording:
    """Return the recording of scene `row` from the world host with a time step [s], through contact to rest."""
    time, states = _with_contact(run, step)
    met = tuple(actor for actor in run.outcomes.contact_actors[0].tolist() if actor >= 0)
    return Recording(
        name=name or program.name,
        actors=recorded_actors(program, scenes.values[row]),
        time=time,
        states=states,
        step=step,
        contact=None if run.touching is None else Contact(float(run.outcomes.end_time[0]), met),
        road=program.road_spec,
        buildings=program.road.buildings,
        surroundings=surroundings,
        first_lanes=program.road.first_lanes,
    )


def recorded_actors(program: Program, values: Floats) -> tuple[RecordedActor, ...]:
    """Return the actors of one scene; `values` is its row of scene values."""
    columns = actor_columns(program, values)
    kinds = map(ActorKind, program.code.actor_kind.tolist())
    return tuple(map(_recorded_actor, program.actors, kinds, columns))


def _recorded_actor(name: str, kind: ActorKind, columns: Floats) -> RecordedActor:
    return RecordedActor(
        name=name,
        kind=kind,
        length=float(columns[Column.LENGTH]),
        width=float(columns[Column.WIDTH]),
        rear_to_center=float(columns[Column.REAR_TO_CENTER]),
        wheelbase=float(columns[Column.WHEELBASE]),
        mass=float(columns[Column.MASS]),
        max_acceleration=float(columns[Column.MAX_ACCELERATION]),
        max_braking=float(columns[Column.MAX_BRAKING]),
        max_steer=float(columns[Column.MAX_STEER]),
        max_speed=float(columns[Column.TOP_SPEED]),
    )


def _with_contact(run: "WorldRun", step: float) -> tuple[Floats, Floats]:
    """Return times and states of all samples, and of first contact if it is between two of them."""
    states = run.trajectory.states
    time: Floats = np.arange(len(states), dtype=np.float64) * step
    if (touching := run.touching) is None:
        return time, states
    instant, after = float(run.outcomes.end_time[0]), run.trajectory.contact_sample + 1
    for sample in (after - 1, after):
        if sample < len(time) and abs(time[sample] - instant) < SAME_INSTANT:
            states = states.copy()
            states[sample] = touching
            return time, states
    return np.insert(time, after, instant), np.insert(states, after, touching, axis=0)
