"""Which collisions a competent driver would have avoided: each is driven again by the reference driver of UN R157.

UN Regulation No. 157 (automated lane keeping), Annex 4, Appendix 3, describes a skilled human driver: a risk is
evaluated for 0.4 s, 0.75 s later braking starts, and 0.6 s after that it has reached 0.774 g. The regulation speaks of
cut-ins on motorways, where a risk begins when another has left the middle of its lane by 0.375 m. Here, where paths
cross, it begins when contact is less than four seconds away if both go on as they do (`engine.kernels.avoidance`);
four seconds tell those who are still in control from those who are not, Hirst and Graham (1997), "The format and
presentation of collision warnings", in "Ergonomics and Safety of Intelligent Driver Interfaces".

A leader that brakes harder than 5 m/s^2 is a risk at once, too, as the regulation has it.

The driver sees what nothing hides, never steers, brakes no less than the ego itself had begun to, and never harder than
0.774 g, than the ego's own brakes, or than the road allows; nor do its brakes build up sooner than the ego's. Nobody is
blamed for being struck from behind, or while standing where one may stand (`engine.kernels.fault`): such a collision is
not asked about, and counted apart.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from engine.batch import simulate
from engine.config import SimulationConfig
from engine.host import memory, plan, requested, samples_of
from engine.kernels.avoidance import NEVER, PATH_COLUMNS, Case, Driver, Weighed, weigh
from engine.program import Program
from engine.scenes import Scenes, actor_columns
from engine.tables import Floats
from engine.vehicles import VIEW_DISTANCE
from engine.vocabulary import Column, Fault

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""
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
AFTERWARDS = 6.0
"""How long the case is followed after the time of contact [s]: longer than it takes to stop from 130 km/h."""
DEFAULTS = SimulationConfig()


class Avoidance(IntEnum):
    """What is said of a collision, the first of these that holds: struck, avoidable, lost, unseen, braked as hard."""

    AVOIDABLE = 0
    """The reference driver avoids it."""
    UNAVOIDABLE = 1
    """Braking at the reference driver's time was too late."""
    BRAKED_AS_HARD = 2
    """The same, and the ego had braked at least as hard itself."""
    UNSEEN = 3
    """The conflict was not in sight long enough before contact for anybody to react."""
    LOST = 4
    """The scene begins too late: no braking avoids it, not even full braking from the very start."""
    STRUCK_FROM_BEHIND = 5
    """Another ran into the ego from behind: no failure of the ego."""
    STRUCK_STANDING = 6
    """Another ran into the ego while it stood where one may stand: no failure of the ego."""


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
    lost: bool = False
    """Whether contact cannot be avoided by braking at all: neither by the reference driver from any moment on, nor by
    full braking from the very start, without the time that it takes to press the pedal."""

    @property
    def avoidable(self) -> bool:
        return self.avoidance is Avoidance.AVOIDABLE

    @property
    def struck(self) -> bool:
        """Whether it is no failure of the ego."""
        return self.avoidance in STRUCK


def avoidability(
    program: Program, scenes: Scenes, config: SimulationConfig = DEFAULTS, driver: Driver = R157
) -> tuple[Avoidability | None, ...]:
    """One answer for each scene; None for one that is not valid or without a collision of the ego."""
    shared, rows = plan(program, config), requested(scenes)
    extra = math.ceil(AFTERWARDS / config.time_step)
    run = memory(program, samples_of(config) + 1 + extra)
    path = np.zeros((len(run.states), PATH_COLUMNS))

    outcomes = simulate(program, scenes, config)

    def answer(row: int) -> Avoidability | None:
        if not scenes.valid[row]:
            return None
        case = Case(int(rows.variant[row]), rows.values[row], rows.keys[row])
        eyes = driver._replace(reach=min(driver.reach, _sight(program, rows.values[row])))
        weighed = weigh(shared, run, case, _outlines(program, rows.values[row]), path, extra, eyes)
        if weighed.contact == NEVER:
            return None
        fault = Fault(int(outcomes.fault[row, int(outcomes.contact_actors[row, 1]) - 1]))
        return _told(weighed, fault, float(outcomes.end_time[row]), config.time_step)

    return tuple(answer(row) for row in range(len(scenes)))


def _sight(program: Program, values: Floats) -> float:
    """How far the ego can see [m]: as far as need be, unless its view is shorter than usual, as in fog."""
    view = float(actor_columns(program, values)[0, Column.VIEW_DISTANCE])
    return view if view < VIEW_DISTANCE else math.inf


def _outlines(program: Program, values: Floats) -> Floats:
    """(actors, 3): length, width, distance from rear axle to centre [m]."""
    columns = [Column.LENGTH, Column.WIDTH, Column.REAR_TO_CENTER]
    return np.ascontiguousarray(actor_columns(program, values)[:, columns])


def _told(weighed: Weighed, fault: Fault, contact: float, time_step: float) -> Avoidability:
    perceived, braking = (_time(k, time_step) for k in (weighed.perceived, weighed.braking))
    margin = (weighed.latest - weighed.braking) * time_step if weighed.latest != NEVER else -math.inf
    return Avoidability(
        avoidance=OF_FAULT.get(fault) or _avoidance(weighed),
        contact=contact,
        perceived=perceived,
        braking=braking,
        margin=math.nan if weighed.perceived == NEVER else margin,
        lost=bool(weighed.lost),
    )


def _avoidance(weighed: Weighed) -> Avoidance:
    if weighed.perceived != NEVER and weighed.avoided:
        return Avoidance.AVOIDABLE
    if weighed.lost:
        return Avoidance.LOST
    if weighed.perceived == NEVER:
        return Avoidance.UNSEEN
    return Avoidance.BRAKED_AS_HARD if weighed.as_hard else Avoidance.UNAVOIDABLE


def _time(sample: int, time_step: float) -> float:
    return math.nan if sample == NEVER else sample * time_step
