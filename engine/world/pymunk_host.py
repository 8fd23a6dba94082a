"""The world host: one scene after another. The shared kernels drive, pymunk carries and decides what follows contact.

`simulate` scores, so each scene ends at first contact; `run` goes on through it and tells the whole story. Metrics are
those of the poses that pymunk carried, by the one definition of `engine.kernels.pair`.
"""

import math
from dataclasses import dataclass, fields

import numpy as np
import pymunk

from engine.config import Config
from engine.host import empty_results, memory, outcomes, outlines, plan, requested, samples_of
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Results, measure_run, note_end
from engine.kernels.stage import Plan, Run, Status
from engine.metrics import Recorded, recorded
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes, Trajectory
from engine.tables import Floats
from engine.vocabulary import EndReason, Verdict
from engine.world.aftermath import follow_contact
from engine.world.bodies import carrier, carry, new_space, physiques
from engine.world.events import Event, timeline
from engine.world.impacts import Impact

DEFAULTS = Config()


@dataclass(frozen=True)
class WorldRun:
    """One scene's whole story."""

    outcomes: Outcomes
    """One row."""
    trajectory: Trajectory
    """Through contact to rest."""
    impacts: tuple[Impact, ...]
    events: tuple[Event, ...]
    records: tuple[Recorded, ...]
    """What the file asks to be recorded, up to contact or the end."""
    touching: Floats | None = None
    """(actors, len(State)) at the very instant of first contact, between two samples; None without contact."""

    def __repr__(self) -> str:
        """One line, for notebooks."""
        end = EndReason(int(self.outcomes.end_reason[0])).name.lower().replace("_", " ")
        scored = f"{end} after {float(self.outcomes.end_time[0]):.2f} s"
        return f"WorldRun({scored}; {len(self.trajectory.time)} samples, {len(self.impacts)} impacts)"


@dataclass(frozen=True)
class Host:
    """What the scenes of one program share: made once, used for one scene after another."""

    plan: Plan
    memory: Run
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    scenes: Requested
    results: Results


def simulate(program: Program, scenes: Scenes, config: Config = DEFAULTS, jobs: int = 1) -> Outcomes:
    """Score all valid scenes; rows of invalid ones keep their verdict and hold NaN / -1.

    Whatever `jobs` is, one core works: a step of pymunk from Python is too short for threads to gain anything.
    """
    del jobs
    host = _host(program, scenes, config, extra_samples=0)
    for row in np.flatnonzero(scenes.valid).tolist():
        _score(host, row)
    return outcomes(host.results)


def run(program: Program, scenes: Scenes, row: int = 0, config: Config = DEFAULTS) -> WorldRun:
    """Run one valid scene to its end and, after contact, until everything struck stands still."""
    if not scenes.valid[row]:
        raise ValueError(f"scene {row} is not valid; only a valid one can be run")
    after = math.ceil(config.contact.aftermath / config.simulation.time_step) + 1
    host = _host(program, _one(scenes, row), config, extra_samples=after)
    scored_samples = samples = _score(host, 0)
    contact = host.memory.status[Status.CONTACT_ONE] >= 0
    scored, impacts, rest = outcomes(host.results), (), {}
    last = samples - 1 if contact else -1
    touching = _touching(host.memory, last) if contact else None
    if contact:
        actors = physiques(host.plan.kinds, host.scenes.values[0])
        samples, impacts, rest = follow_contact(host.plan, host.memory, actors, config)
    trajectory = Trajectory(
        time=np.arange(samples, dtype=np.float64) * config.simulation.time_step,
        states=host.memory.states[:samples].copy(),
        outlines=outlines(program, host.scenes.values[0]),
        contact_sample=last,
        watched=host.memory.watched[:scored_samples].copy(),
    )
    events = timeline(scored, trajectory, impacts, rest)
    return WorldRun(scored, trajectory, impacts, events, recorded(program, trajectory), touching)


def _touching(run: Run, sample: int) -> Floats:
    """Everybody's state at first contact, in the step after a sample: motion in a step is linear."""
    before, after = run.states[sample], run.states[sample + 1]
    return before + run.end[1] * (after - before)


def _host(program: Program, scenes: Scenes, config: Config, extra_samples: int) -> Host:
    rows, space = requested(scenes), new_space(config.contact)
    return Host(
        plan=plan(program, config.simulation),
        memory=memory(program, samples_of(config.simulation) + 1 + extra_samples),
        space=space,
        bodies=tuple(carrier(space) for _ in program.actors),
        scenes=rows,
        results=empty_results(len(program.actors), rows),
    )


def _score(host: Host, row: int) -> int:
    """Run one scene to first contact or its end and fill its row; the number of samples up to then."""
    scenes, record = host.scenes, host.memory
    begin(host.plan, record, int(scenes.variant[row]), scenes.values[row], scenes.keys[row])
    advance(host.plan, record, host.plan.layout.last_sample + 1, True)
    valid = note_end(record, row, host.results)
    samples = int(record.status[Status.SAMPLE]) + (0 if record.status[Status.CONTACT_ONE] >= 0 else 1)
    if host.results.verdict[row] == Verdict.ERROR:
        return samples
    carry(host.space, host.bodies, record.states, samples, host.plan.layout.time_step)
    if valid:
        measure_run(host.plan, record, scenes.values[row], row, np.zeros((len(host.bodies), 3)), host.results)
    return samples


def _one(scenes: Scenes, row: int) -> Scenes:
    """The scenes with nothing but one row."""
    return Scenes(**{field.name: getattr(scenes, field.name)[row : row + 1] for field in fields(Scenes)})
