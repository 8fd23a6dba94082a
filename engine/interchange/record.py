"""From a run of ours to a recording."""

import numpy as np

from engine.interchange.recording import SAME_INSTANT, Contact, Provenance, RecordedActor, Recording, SignalTimes
from engine.program import Program
from engine.scenes import Scenes, actor_columns
from engine.tables import Floats
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, State
from engine.world import WorldRun

NO_PROVENANCE = Provenance()


def recorded_run(
    program: Program,
    scenes: Scenes,
    run: WorldRun,
    *,
    row: int = 0,
    step: float,
    name: str = "",
    signals: SignalTimes | None = None,
    provenance: Provenance = NO_PROVENANCE,
) -> Recording:
    """The recording of scene `row` as the world host ran it with a time step [s], through contact to rest."""
    time, states = _with_contact(run, step)
    pair = (int(run.outcomes.contact_actors[0, 0]), int(run.outcomes.contact_actors[0, 1]))
    return Recording(
        name=name or program.name,
        actors=recorded_actors(program, scenes.values[row]),
        time=time,
        states=states,
        step=step,
        contact=None if run.touching is None else Contact(float(run.outcomes.end_time[0]), pair),
        road=program.road_spec,
        signals=signals,
        provenance=provenance,
    )


def recorded_actors(program: Program, values: Floats) -> tuple[RecordedActor, ...]:
    """The actors of one scene; `values` is its row of scene values."""
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
        max_speed=MODELS[kind].max_speed,
    )


def _with_contact(run: WorldRun, step: float) -> tuple[Floats, Floats]:
    """Times and states of all samples, and of first contact where it lies between two of them."""
    states = run.trajectory.states
    time: Floats = np.arange(len(states), dtype=np.float64) * step
    if run.touching is None:
        return time, states
    instant, after = float(run.outcomes.end_time[0]), run.trajectory.contact_sample + 1
    touching = run.touching.copy()
    touching[:, State.PRESENT] = touching[:, State.PRESENT] == 1.0  # who leaves in this step is on its way out
    for sample in (after - 1, after):
        if sample < len(time) and abs(time[sample] - instant) < SAME_INSTANT:
            states = states.copy()
            states[sample] = touching
            return time, states
    return np.insert(time, after, instant), np.insert(states, after, touching, axis=0)
