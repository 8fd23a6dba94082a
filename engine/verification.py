"""Verification of cases: each is simulated again with finer steps, and with slipping tyres.

Four runs of the same scene with the same behaviours:

- *run*: as in the search, at its time step;
- *finer*: the kinematic model in steps of 5 ms, with observations and actions of drivers as often as in the run;
- *alert*: as *finer*, with observations and actions every 5 ms; omitted if drivers draw random numbers, as different
  draws would give a different scene;
- *dynamic*: in steps of 5 ms, drivers as in the run, every car with the single-track drift model
  (`engine.kernels.dynamics`), its pedals behind an anti-lock (`engine.kernels.actuation`).

Only cars have cited tyre data: an ego of another kind is *not judged*, other actors of another kind move as before. The
data are those of forward motion: an ego that drives backwards is not judged either, and other actors that do so move as
before. By the collision of the ego, or without one by the risk, the answer is

- *survives*: `dynamic` shows the same danger: a collision with the same actor, with a closing speed within
  `SPEED_APART` or `SPEED_SHARE`; without collision, a risk within `SCORE_APART`;
- *artefact of the step*: `dynamic` lacks the danger (no collision, nor a near miss of the actor struck; a risk lower by
  more), and so does `finer` or `alert`: the danger depends on the time step;
- *artefact of the model*: `dynamic` alone lacks it: the danger depends on the kinematic model;
- *differs*: all other cases: another partner, another speed, a near miss, a higher risk, a run that a requirement makes
  invalid.
"""

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from engine.batch import simulate, trajectory
from engine.config import ContactConfig, SimulationConfig
from engine.host import MAX_SAMPLES, samples_of
from engine.kernels.dynamics import COMMAND_STEP
from engine.opcodes import Op
from engine.outcomes import Outcomes
from engine.program import Program
from engine.risk import LITERATURE, PAPER, RiskProfile, assess
from engine.scenes import Scenes, actor_columns
from engine.tables import Bools
from engine.vocabulary import ActorKind, Column, Command, State, Verdict

SPEED_APART = 2.0
"""Difference up to which closing speeds are alike [m/s]."""
SPEED_SHARE = 0.2
"""Relative difference up to which closing speeds are alike."""
SCORE_APART = 1
"""Difference up to which risks of runs without collision are alike."""
NEAR_MISS = LITERATURE.min_distance[0]
"""Distance from the struck actor from which on the ego is out of danger [m]; three feet, of passing laws."""
DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()
NOBODY = -1


class Answer(IntEnum):
    """Answer of the verification of a case."""

    SURVIVES = 0
    DIFFERS = 1
    MODEL = 2
    """An artefact of the vehicle model."""
    STEP = 3
    """An artefact of the time step."""
    NOT_JUDGED = 4
    """No tyre data exist for its kind."""
    BACKWARDS = 5
    """Not judged: the ego drives backwards."""


@dataclass(frozen=True)
class Drive:
    """Result of a scene in one kind of run."""

    verdict: Verdict
    collided: bool
    """True if the ego collided."""
    partner: int
    """Actor that it touched, else the actor that decides the risk; `NOBODY` if there is none."""
    time: float
    """Time of contact or of the end [s]."""
    closing_speed: float
    """Closing speed of the ego and that actor at contact, or at the closest approach [m/s]."""
    distances: tuple[float, ...]
    """MD of each actor other than the ego [m]."""
    score: int
    combined_grip: float
    """Largest use of grip by the ego, as a share of mu g."""

    @property
    def min_distance(self) -> float:
        """Return the least distance to any actor [m]."""
        return min(self.distances, default=math.inf)


@dataclass(frozen=True)
class Verified:
    """Verification of one case."""

    answer: Answer
    run: Drive
    finer: Drive | None
    """None for a case that is not judged, as are `alert` and `dynamic`."""
    alert: Drive | None
    """None also if drivers draw random numbers."""
    dynamic: Drive | None
    slides: tuple[int, ...]
    """Actors that the dynamic model drove."""


def verify(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    profile: RiskProfile = PAPER,
    jobs: int = 1,
    contact: ContactConfig = CONTACT,
) -> tuple[Verified | None, ...]:
    """Return one answer per scene; None for an invalid scene."""
    # Steps of 5 ms, or longer if the longest record requires it.
    most = MAX_SAMPLES // max(1, samples_of(config))
    hold = max(1, min(math.ceil(config.time_step / COMMAND_STEP - 1e-9), most))
    fine = replace(config, time_step=config.time_step / hold)
    back = backwards(program, scenes, config, contact)
    slides = tuple(car for car in cars(program, scenes) if car == 0 or not back[:, car].any())
    run = drives(simulate(program, scenes, config, jobs, contact), profile)
    finer = drives(simulate(program, scenes, fine, jobs, contact, hold), profile)
    draws = Op.RANDOM in program.code.step_code[:, 0]
    alert = [None] * len(scenes) if draws else drives(simulate(program, scenes, fine, jobs, contact), profile)
    dynamic = drives(simulate(program, scenes, fine, jobs, contact, hold, slides), profile)
    rows = zip(run, finer, alert, dynamic, back[:, 0].tolist(), strict=True)
    return tuple(
        _verified(*row, slides) if valid else None for row, valid in zip(rows, scenes.valid.tolist(), strict=True)
    )


def backwards(program: Program, scenes: Scenes, config: SimulationConfig, contact: ContactConfig) -> Bools:
    """Return (scenes, actors) True for actors that drive backwards; motion after an impact does not count."""
    found = np.zeros((len(scenes), len(program.actors)), dtype=np.bool_)
    takes = program.code.step_code[:, 0] == Op.COMMAND
    if np.isin(program.code.step_code[takes, 2], (Command.REVERSE, Command.BACK)).any():
        for row in np.flatnonzero(scenes.valid).tolist():
            states = trajectory(program, scenes, row, config, contact).states
            driven = states[..., State.PRESENT] == 1.0
            found[row] = np.any(driven & (states[..., State.SPEED] < 0.0), axis=0)
    return found


def cars(program: Program, scenes: Scenes) -> tuple[int, ...]:
    """Return the actors that are cars, with their centre of gravity between their axles in every valid scene."""
    found = np.asarray(program.code.actor_kind) == ActorKind.CAR
    for values in scenes.values[scenes.valid]:
        columns = actor_columns(program, values)
        rear, wheelbase = columns[:, Column.REAR_TO_CENTER], columns[:, Column.WHEELBASE]
        found &= (rear > 0.0) & (rear < wheelbase) & (columns[:, Column.MASS] > 0.0)
    return tuple(np.flatnonzero(found).tolist())


def drives(outcomes: Outcomes, profile: RiskProfile) -> tuple[Drive, ...]:
    """Return the result of each scene."""
    risk = assess(outcomes, profile)
    return tuple(_drive(outcomes, row, int(risk.score[row]), int(risk.pair[row])) for row in range(len(outcomes)))


def _drive(outcomes: Outcomes, row: int, score: int, pair: int) -> Drive:
    collided = bool(outcomes.collided[row])
    partner = int(outcomes.contact_actors[row, 1]) if collided else pair + 1 if pair >= 0 else NOBODY
    met = partner != NOBODY
    return Drive(
        verdict=Verdict(int(outcomes.verdict[row])),
        collided=collided,
        partner=partner,
        time=float(outcomes.end_time[row]),
        closing_speed=float(outcomes.closing_speed[row, partner - 1]) if met else math.nan,
        distances=tuple(outcomes.min_distance[row].tolist()),
        score=score,
        combined_grip=float(outcomes.combined_grip[row, 0]),
    )


def _verified(
    run: Drive, finer: Drive, alert: Drive | None, dynamic: Drive, back: bool, slides: tuple[int, ...]
) -> Verified:
    if 0 not in slides or back:
        return Verified(Answer.BACKWARDS if back else Answer.NOT_JUDGED, run, None, None, None, ())
    return Verified(answer_of(run, finer, alert, dynamic), run, finer, alert, dynamic, slides)


def answer_of(run: Drive, finer: Drive, alert: Drive | None, dynamic: Drive) -> Answer:
    """Return the answer by the rules above."""
    if alike(run, dynamic):
        return Answer.SURVIVES
    if not lacks(run, dynamic):
        return Answer.DIFFERS
    return Answer.STEP if any(lacks(run, each) for each in (finer, alert) if each is not None) else Answer.MODEL


def alike(run: Drive, other: Drive) -> bool:
    """Return True if a second run shows the same danger."""
    if other.verdict != Verdict.VALID or run.collided != other.collided:
        return False
    if not run.collided:
        return abs(other.score - run.score) <= SCORE_APART
    apart = abs(other.closing_speed - run.closing_speed)
    as_fast = apart <= max(SPEED_APART, SPEED_SHARE * abs(run.closing_speed))
    return other.partner == run.partner and as_fast


def lacks(run: Drive, other: Drive) -> bool:
    """Return True if a second run lacks the danger."""
    if other.verdict != Verdict.VALID or other.collided:
        return False
    if run.collided:
        return other.distances[run.partner - 1] > NEAR_MISS
    return other.score < run.score - SCORE_APART
