"""Avoidability of collisions: each is simulated again with the reference driver of UN R157.

UN Regulation No. 157 (automated lane keeping), Annex 4, Appendix 3, describes a skilled human driver: a risk is
evaluated for 0.4 s, 0.75 s later braking starts, and 0.6 s after that it has reached 0.774 g. The regulation treats
cut-ins on motorways, where a risk begins when an actor has left the middle of its lane by 0.375 m. Here, for crossing
paths, it begins when contact is less than four seconds away if both continue their motion (`engine.kernels.avoidance`);
four seconds separate drivers in control from others, Hirst and Graham (1997), "The format and presentation
of collision warnings", in "Ergonomics and Safety of Intelligent Driver Interfaces".

A leader nearer than that which brakes harder than 5 m/s^2 is a risk, too, as in the regulation.

The driver sees all that is not hidden, up to the weather's range of sight, like drivers of the library: neither
darkness (there are headlamps) nor the ego's own `visibleDistance` limits it. It never steers. It brakes no less than
the ego had begun to, and never harder than 0.774 g, than the ego's own brakes, or than the road allows; its brakes do
not build up sooner than the ego's. Being struck from behind, or while standing where standing is permitted, is no
failure (`engine.kernels.fault`): such a collision is counted separately.

`avoidability` gives complete answers for a few cases, margins included, with tens of simulations each;
`engine.verdicts` decides for thousands of collisions whether this driver and other reference drivers avoid them, with
one simulation each.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.config import ContactConfig, SimulationConfig
from engine.dependence import ignores_ego
from engine.errors import ArgumentError
from engine.host import in_parts, memory, others_touch, plan, requested, samples_of
from engine.kernels.avoidance import (
    LONGEST,
    Checkpoints,
    DriveMemory,
    ReferenceDrive,
    reference_rows,
)
from engine.kernels.bicycle import GRAVITY
from engine.kernels.perception import NEVER, PATH_COLUMNS, Driver
from engine.kernels.rows import Window
from engine.kernels.run_state import Run
from engine.program import Program
from engine.scenes import Scenes, weather_sight
from engine.tables import Bools
from engine.vocabulary import Fault, State

R157 = Driver(
    perception=0.4,
    reaction=0.75,
    deceleration=0.774 * GRAVITY,
    ramp=0.6,
    horizon=4.0,
    alarming=5.0,
    reach=math.inf,
)
"""The reference driver; the horizon is a choice of cortexc."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


class Avoidance(IntEnum):
    """Answer for a collision, the first of these that holds: struck, avoidable, lost, no braking helps, unseen, braked
    as hard.
    """

    AVOIDABLE = 0
    """The reference driver avoids it."""
    UNAVOIDABLE = 1
    """Braking at the reference driver's time was too late."""
    BRAKED_AS_HARD = 2
    """Braking at the reference driver's time was too late, and the ego had braked at least as hard itself."""
    UNSEEN = 3
    """The conflict was not in sight long enough before contact to be perceived, or there was none by the rule: no
    contact within the horizon.
    """
    LOST = 4
    """The scene begins too late: no braking avoids it, not even full braking from the start, when the conflict is in
    sight already, or after which the ego still drives into the actor.
    """
    STRUCK_FROM_BEHIND = 5
    """An actor ran into the ego from behind: no failure of the ego."""
    STRUCK_STANDING = 6
    """An actor ran into the ego while it stood where standing is permitted: no failure of the ego."""
    NO_BRAKING_HELPS = 7
    """No braking avoids it, for a different reason than a late start: the ego stands, or is run into."""


STRUCK = frozenset({Avoidance.STRUCK_FROM_BEHIND, Avoidance.STRUCK_STANDING})
"""Collisions that are no failure of the ego."""
OF_FAULT = {
    Fault.STRUCK_FROM_BEHIND: Avoidance.STRUCK_FROM_BEHIND,
    Fault.STRUCK_STANDING: Avoidance.STRUCK_STANDING,
}


@dataclass(frozen=True)
class Avoidability:
    """One collision with the answer of the reference driver. Times in seconds from the start of the run."""

    avoidance: Avoidance
    contact: float
    """The instant at which the outlines met."""
    perceived: float
    """Time at which the conflict was perceived; NaN if never."""
    braking: float
    """Time at which the reference driver begins to brake; NaN if never."""
    margin: float
    """Time by which braking may be delayed, with contact avoided for each delay up to it. If the reference driver does
    not avoid contact: time by which braking would have to begin earlier (negative), or later if only that helps, as the
    ego then passes first. Minus infinity if braking never helps, NaN if nothing was perceived.
    """

    @property
    def avoidable(self) -> bool:
        return self.avoidance is Avoidance.AVOIDABLE

    @property
    def struck(self) -> bool:
        """Return True if it is no failure of the ego."""
        return self.avoidance in STRUCK


def avoidability(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    driver: Driver = R157,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
) -> tuple[Avoidability | None, ...]:
    """Return one answer per scene; None for a scene that is invalid or without a collision of the ego."""
    shared, rows = plan(program, config, contact), requested(program, scenes)
    reach, independent = weather_sight(program, scenes.variant, scenes.values), ignores_ego(program)
    found = np.full((len(scenes), len(ReferenceDrive._fields)), float(NEVER))

    def drive(window: Window) -> None:
        samples = samples_of(config) + 1
        stored = 0 if independent else samples
        scratch = drive_memory(program, config, samples, independent=independent, stored=stored)
        reference_rows(shared, rows, reach, window, scratch, driver, found)

    in_parts(len(scenes), jobs, drive)
    return tuple(None if row[0] == NEVER else _answer(_drive_of(row), config.time_step) for row in found.tolist())


def _drive_of(row: list[float]) -> ReferenceDrive:
    """Return the drive that a row of numbers describes."""
    contact, time, fault, perceived, braking, avoided, latest, *others = row
    stops = int(contact), time, int(fault), int(perceived), int(braking), bool(avoided), int(latest)
    as_hard, helpless, too_late = map(bool, others)
    return ReferenceDrive(*stops, as_hard, helpless, too_late)


def drive_memory(
    program: Program,
    config: SimulationConfig,
    samples: int,
    *,
    independent: bool = False,
    stored: int = 0,
    models: int = 0,
) -> DriveMemory:
    """Return memory for runs of `samples` samples and `LONGEST` more, with `stored` checkpoints, and for `models`
    reference drivers.

    `independent`: the others ignore the ego.
    """
    run, touching = memory(program, samples + math.ceil(LONGEST / config.time_step)), others_touch(program)
    return DriveMemory(
        run,
        outlines=np.zeros((len(program.actors), 3)),
        path=np.zeros((len(run.states), PATH_COLUMNS)),
        own=np.zeros((len(run.states), len(State))),
        independent=independent,
        touching=touching,
        onsets=np.zeros((models, 2), dtype=np.int64),
        conflicts=np.zeros(samples),
        checkpoints=checkpoints(run, stored, touching=touching),
    )


def checkpoints(run: Run, samples: int, *, touching: bool) -> Checkpoints:
    """Return memory for the state of a run at each of `samples` samples; `touching`: impacts among others included."""

    def of_each(array: NDArray[Any]) -> NDArray[Any]:
        return np.zeros((samples, *array.shape), dtype=array.dtype)

    return Checkpoints(
        registers=of_each(run.registers),
        resume=of_each(run.resume),
        status=of_each(run.status),
        end=of_each(run.end),
        actors=of_each(run.actors),
        segments=of_each(run.segments if touching else run.segments[:0]),
        impacts=of_each(run.impacts if touching else run.impacts[:0]),
        states=of_each(run.states[0]),
        record=of_each(run.states[0]),
    )


def refuse_missing(collided: Bools, answered: Bools) -> None:
    """Raise ArgumentError if a scene with a collision has no answer: scenes or settings differ from the run's."""
    missing = np.flatnonzero(collided & ~answered)
    if len(missing):
        raise ArgumentError(
            f"scene {missing[0]} collided, and run again it does not",
            "take the program and the settings with which it collided",
        )


def _answer(again: ReferenceDrive, time_step: float) -> Avoidability:
    """Return the answer for a repeated case, in seconds."""
    perceived, braking = (_time(k, time_step) for k in (again.perceived, again.braking))
    margin = (again.latest - again.braking) * time_step if again.latest != NEVER else -math.inf
    return Avoidability(
        avoidance=OF_FAULT.get(Fault(again.fault)) or _avoidance(again),
        contact=again.time,
        perceived=perceived,
        braking=braking,
        margin=math.nan if again.perceived == NEVER else margin,
    )


def _avoidance(again: ReferenceDrive) -> Avoidance:
    if again.perceived != NEVER and again.avoided:
        return Avoidance.AVOIDABLE
    if again.helpless:
        return Avoidance.LOST if again.too_late else Avoidance.NO_BRAKING_HELPS
    if again.perceived == NEVER:
        return Avoidance.UNSEEN
    return Avoidance.BRAKED_AS_HARD if again.as_hard else Avoidance.UNAVOIDABLE


def _time(sample: int, time_step: float) -> float:
    return math.nan if sample == NEVER else sample * time_step
