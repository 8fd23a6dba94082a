"""Which collisions a competent driver would have avoided: each is driven again by the reference driver of UN R157.

UN Regulation No. 157 (automated lane keeping), Annex 4, Appendix 3, describes a skilled human driver: a risk is
evaluated for 0.4 s, 0.75 s later braking starts, and 0.6 s after that it has reached 0.774 g. The regulation speaks of
cut-ins on motorways, where a risk begins when another has left the middle of its lane by 0.375 m. Here, where paths
cross, it begins when contact is less than four seconds away if both go on as they do (`engine.kernels.avoidance`);
four seconds tell those who are still in control from those who are not, Hirst and Graham (1997), "The format and
presentation of collision warnings", in "Ergonomics and Safety of Intelligent Driver Interfaces".

A leader nearer than that which brakes harder than 5 m/s^2 is a risk, too, as the regulation has it.

The driver sees what nothing hides, as far as the weather lets anybody see, as drivers of the library do: neither
darkness, for there are headlamps, nor the ego's own `visibleDistance` limits it. It never steers, brakes no less than
the ego itself had begun to, and never harder than 0.774 g, than the ego's own brakes, or than the road allows; nor do
its brakes build up sooner than the ego's. Nobody is blamed for being struck from behind, or while standing where one
may stand (`engine.kernels.fault`): such a collision is counted apart.

`avoidability` says all there is to say of a few cases, margins included, which take tens of drives each; `blame` says
of thousands of collisions whether the driver avoids them, in one drive each.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from engine.config import ContactConfig, SimulationConfig
from engine.errors import ArgumentError
from engine.host import in_parts, memory, plan, requested, samples_of
from engine.kernels.avoidance import LONGEST, Case, ReferenceDrive, avoidability_rows, resimulate_with_reference
from engine.kernels.bicycle import GRAVITY
from engine.kernels.perception import NEVER, PATH_COLUMNS, Driver
from engine.kernels.run_state import Run
from engine.program import Program
from engine.scenes import Scenes, weather_sight
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Blame, Fault

R157 = Driver(
    perception=0.4,
    reaction=0.75,
    deceleration=0.774 * GRAVITY,
    ramp=0.6,
    horizon=4.0,
    alarming=5.0,
    reach=math.inf,
)
"""The reference driver; the horizon is ours."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


class Avoidance(IntEnum):
    """What is said of a collision, the first of these that holds: struck, avoidable, lost, no braking helps, unseen,
    braked as hard.
    """

    AVOIDABLE = 0
    """The reference driver avoids it."""
    UNAVOIDABLE = 1
    """Braking at the reference driver's time was too late."""
    BRAKED_AS_HARD = 2
    """The same, and the ego had braked at least as hard itself."""
    UNSEEN = 3
    """The conflict was not in sight long enough before contact for anybody to perceive it, or there was none by the
    rule: no contact within the horizon."""
    LOST = 4
    """The scene begins too late: no braking avoids it, not even full braking from the very start, where the conflict is
    in sight already, or after which the ego still drives into the other."""
    STRUCK_FROM_BEHIND = 5
    """Another ran into the ego from behind: no failure of the ego."""
    STRUCK_STANDING = 6
    """Another ran into the ego while it stood where one may stand: no failure of the ego."""
    NO_BRAKING_HELPS = 7
    """No braking avoids it, but not because the scene begins too late: the ego stands, or another drives into it."""


STRUCK = frozenset({Avoidance.STRUCK_FROM_BEHIND, Avoidance.STRUCK_STANDING})
"""Collisions that are no failure of the ego."""
OF_FAULT = {
    Fault.STRUCK_FROM_BEHIND: Avoidance.STRUCK_FROM_BEHIND,
    Fault.STRUCK_STANDING: Avoidance.STRUCK_STANDING,
}


@dataclass(frozen=True)
class Avoidability:
    """One collision, driven again. Times in seconds from the start of the run."""

    avoidance: Avoidance
    contact: float
    """The instant at which the outlines met."""
    perceived: float
    """When the conflict had been perceived; NaN if never."""
    braking: float
    """When the reference driver begins to brake; NaN if never."""
    margin: float
    """By how much braking may wait, each moment until then avoiding contact. Where the reference driver does not avoid
    it: by how much earlier braking would have to begin (negative), or later where only that helps, as one then passes
    before the other. Minus infinity where braking never helps, NaN where nothing was perceived."""

    @property
    def avoidable(self) -> bool:
        return self.avoidance is Avoidance.AVOIDABLE

    @property
    def struck(self) -> bool:
        """Whether it is no failure of the ego."""
        return self.avoidance in STRUCK


def avoidability(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    driver: Driver = R157,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
) -> tuple[Avoidability | None, ...]:
    """One answer for each scene; None for one that is not valid or without a collision of the ego."""
    shared, rows = plan(program, config, contact), requested(program, scenes)
    reach = weather_sight(program, scenes.variant, scenes.values)
    said: list[Avoidability | None] = [None] * len(scenes)

    def drive(first: int, last: int) -> None:
        run, outlines, path = room(program, config, samples_of(config) + 1)
        for row in (first + np.flatnonzero(scenes.valid[first:last])).tolist():
            case = Case(int(rows.variant[row]), rows.values[row], rows.keys[row], rows.actions[row])
            sees = driver._replace(reach=min(driver.reach, float(reach[row])))
            again = resimulate_with_reference(shared, run, case, outlines, path, sees)
            said[row] = None if again.contact == NEVER else _answer(again, config.time_step)

    in_parts(len(scenes), jobs, drive)
    return tuple(said)


def blame(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
) -> Ints:
    """(n,) `Blame` of each scene, `NONE` of one that is not valid or without a collision of the ego."""
    shared, rows, reach = (
        plan(program, config, contact),
        requested(program, scenes),
        weather_sight(program, scenes.variant, scenes.values),
    )
    said = np.full(len(scenes), int(Blame.NONE), dtype=np.int32)

    def drive(first: int, last: int) -> None:
        avoidability_rows(shared, rows, reach, first, last, *room(program, config, samples_of(config) + 1), R157, said)

    in_parts(len(scenes), jobs, drive)
    return said


def room(program: Program, config: SimulationConfig, samples: int) -> tuple[Run, Floats, Floats]:
    """Memory for one drive after another: of the run of so many samples and `LONGEST` more, of outlines, and of the
    ego's path.
    """
    run = memory(program, samples + math.ceil(LONGEST / config.time_step))
    return run, np.zeros((len(program.actors), 3)), np.zeros((len(run.states), PATH_COLUMNS))


def refuse_missing(collided: Bools, answers: Sequence[Avoidability | None]) -> None:
    """Raises ArgumentError where a scene that collided has no answer: these are not the scenes, or not the settings."""
    missing = [row for row, (there, answer) in enumerate(zip(collided, answers, strict=True)) if there and not answer]
    if missing:
        raise ArgumentError(
            f"scene {missing[0]} collided, and run again it does not",
            "take the program and the settings with which it collided",
        )


def _answer(again: ReferenceDrive, time_step: float) -> Avoidability:
    """What is said of a case that was driven again, in seconds."""
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
