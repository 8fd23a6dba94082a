"""What both hosts prepare before the kernels of `engine.kernels.rollout` can run: a plan, and memory for runs."""

import math
from typing import TypeVar

import numpy as np

from engine.config import SimulationConfig
from engine.kernels.stage import Layout, Plan, Run, Slot, Status
from engine.program import Program
from engine.tables import Floats, RoadTables
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, State

MAX_SAMPLES = 100_000
"""Steps that a run may have; a record of so many takes 7 MB an actor."""

Array = TypeVar("Array", bound=np.ndarray)


def plan(program: Program, config: SimulationConfig) -> Plan:
    """The part of a program that its runs read. Raises ValueError for settings that make no simulation."""
    if not (math.isfinite(config.time_step) and config.time_step > 0.0):
        raise ValueError(f"time_step is {config.time_step} s; it must be a positive number")
    if not (math.isfinite(config.max_time) and config.max_time >= 0.0):
        raise ValueError(f"max_time is {config.max_time} s; it must be a number that is not negative")
    if samples_of(config) > MAX_SAMPLES:
        raise ValueError(f"{config.max_time} s in steps of {config.time_step} s are more than {MAX_SAMPLES:,} steps")
    code = program.code
    scene_values = len(code.literals) + code.variant_values.shape[1]
    models = [MODELS[ActorKind(kind)] for kind in code.actor_kind]
    return Plan(
        code=_plain(code.step_code),
        pool=_plain(code.pool),
        variant_values=_plain(code.variant_values),
        variant_template=_plain(code.variant_template),
        entries=_plain(code.behaviour_entry),
        main_blocks=_plain(code.main_block),
        rules=_plain(code.rule_segment),
        kinds=_plain(code.actor_kind),
        limits=np.array([(model.steer_rate, model.max_speed) for model in models]),
        road=RoadTables(*(_plain(array) for array in program.road)),
        layout=Layout(
            variant_values=len(code.literals),
            scene_values=scene_values,
            locals=int(code.sizes[4]),
            time_step=float(config.time_step),
            last_sample=samples_of(config),
            budget=int(config.instruction_budget),
        ),
    )


def samples_of(config: SimulationConfig) -> int:
    """Number of the sample at which the time limit ends a run; a limit between two samples counts as the later."""
    return math.ceil(config.max_time / config.time_step - 1e-9)


def memory(program: Program, samples: int) -> Run:
    """Memory for one run after another, with a record of up to `samples` samples; literals are in place."""
    code = program.code
    actors = len(program.actors)
    registers = np.zeros(int(code.sizes[3]))
    registers[: len(code.literals)] = code.literals
    return Run(
        states=np.zeros((samples, actors, len(State))),
        registers=registers,
        resume=np.full(int(code.sizes[5]), -1, dtype=np.int32),
        actors=np.zeros((actors, len(Slot))),
        status=np.zeros(len(Status), dtype=np.int64),
        end=np.zeros(2),
        key=np.zeros(6, dtype=np.int64),
    )


def outlines(program: Program, values: Floats) -> Floats:
    """(actors, 2): length and width of each actor of one scene [m]; `values` is its row of scene values."""
    columns = values[: len(program.actors) * len(Column)].reshape(len(program.actors), len(Column))
    return np.ascontiguousarray(columns[:, [Column.LENGTH, Column.WIDTH]])


def _plain(array: Array) -> Array:
    """Contiguous and writable: numba would compile the kernels anew for any other."""
    return np.require(array, requirements="CAW")
