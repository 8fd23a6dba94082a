"""Preparation of both hosts around the kernels of `engine.kernels.rollout`: a plan, memory for runs, rows for results,
and threads that share the rows.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from time import perf_counter
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.config import ContactConfig, SimulationConfig
from engine.control import numbers_decided
from engine.errors import ArgumentError, ControllerError
from engine.handles import Handle, Slots
from engine.judged import NAMED_RESULTS
from engine.kernels.actuation import slide
from engine.kernels.crossing import KEPT, Foresight
from engine.kernels.evaluate import geometry_kernels
from engine.kernels.impacts.motion import (
    MAX_IMPACTS,
    ImpactRecord,
    MotionSegment,
    resolve_other_impacts,
    step_post_impact,
)
from engine.kernels.jit import need
from engine.kernels.judging import append_contact_sample, step_on
from engine.kernels.levels import (
    enter_level,
    follow_levels,
    keep_levels,
    look_ahead,
    look_back,
    measure_on_levels,
    recall_levels,
    restore_levels,
    trace_heights,
    trace_levels,
)
from engine.kernels.rollout import judge_temporal
from engine.kernels.rows import Requested, Results, Window, note_gaps, note_objectives
from engine.kernels.run_state import Layout, Memory, Plan, Run, Status
from engine.kernels.senses import DEFERRED
from engine.kernels.slots import continue_run, leave_run, note_commands
from engine.kernels.swept import swept
from engine.opcodes import FUSIONS, Op
from engine.outcomes import OUTCOMES, PAIRS, Outcomes, Per
from engine.program import Program
from engine.scenes import Scenes, actor_columns
from engine.tables import PLAIN, SHADE, CodeTables, Floats, Ints, RoadTables, Segment, Size
from engine.vehicles import MODELS
from engine.vocabulary import STORED, ActorKind, Column, Measure, Reducer, RuleKind, State

MAX_SAMPLES = 100_000
"""Maximum number of steps of a run; a record of that length takes 7 MB per actor."""
CONTACT = ContactConfig()
CHUNK = 1000
"""Most scenes per uninterruptible call."""
FIRST_CHUNK, A_MOMENT = 25, 0.05
"""Scenes in the first call of one thread, and the time that its later calls take [s], so that Ctrl-C is heard soon."""


def plan(
    program: Program,
    config: SimulationConfig,
    contact: ContactConfig = CONTACT,
    hold: int = 1,
    slides: Sequence[int] = (),
    pause: int = 0,
    measures: int = STORED,
) -> Plan:
    """Return the part of a program that its runs read; raise ArgumentError for settings without a simulation.

    `hold`: steps between turns of the behaviours; `slides`: cars with slipping tyres; `pause`: turns between pauses, in
    which controllers are queried; `measures`: `Measure`s of a run that are computed, besides those that objectives of
    the file read.
    """
    _check(config)
    _check_contact(contact)
    code = program.code
    measures |= _read_by_objectives(program)
    need(*deferred_kernels(program, slides, pause, measures))
    return Plan(
        code=_integers(fuse(code.step_code)).ravel(),
        pool=_numbers(code.pool),
        variant_values=_numbers(code.variant_values),
        variant_template=_integers(code.variant_template),
        entries=_integers(code.behaviour_entry),
        main_blocks=_integers(code.main_block),
        rules=_integers(code.rule_segment),
        rule_kinds=_integers(code.rule_kind),
        formula=_integers(code.formula),
        temporal_root=_integers(code.temporal_root),
        temporal_rule=_integers(code.temporal_rule),
        objective_root=_integers(program.judged.tables.root),
        objective_segment=_integers(program.judged.tables.segment),
        readings=_readings(program),
        monitors=_integers(code.monitor_entry),
        monitor_blocks=_integers(code.monitor_block),
        monitor_started=_integers(code.monitor_started),
        present=_integers(code.actor_present),
        kinds=_integers(code.actor_kind),
        gyration=np.array([MODELS[ActorKind(kind)].gyration for kind in code.actor_kind]),
        slides=np.isin(np.arange(len(code.actor_kind)), slides).astype(np.int32),
        road=plain(program.road),
        layout=Layout(
            variant_values=len(code.literals),
            scene_values=len(code.literals) + code.variant_values.shape[1],
            locals=int(code.sizes[Size.LOCALS]),
            time_step=float(config.time_step),
            last_sample=-(-samples_of(config) // hold) * hold,
            budget=int(config.instruction_budget),
            intersections=program.road_spec.intersections,
            lasting=int(len(code.temporal_root) > 0 or len(program.judged) > 0 or _is_watched(code)),
            judged=int(len(program.judged) > 0),
            restitution=float(contact.restitution),
            contact_friction=float(contact.friction),
            rolling=float(contact.rolling_resistance),
            drivers_go_on=int(contact.drivers_go_on),
            hold=hold,
            pedals_stay=int(program.settings.pedals_stay),
            pause=pause,
            measures=measures,
        ),
    )


def fuse(code: Ints) -> Ints:
    """Return step code (rows, ROW_WIDTH) in which the first row of each sequence of `FUSIONS` stands for all of it.

    The rows keep their places and their operands, so that jumps may lead into a sequence. Programs, and all that reads
    their code, keep the single instructions.
    """
    fused, rows = code.copy(), len(code)
    for number, sequence in FUSIONS.items():
        starts = np.ones(max(0, rows - len(sequence) + 1), dtype=bool)
        for place, op in enumerate(sequence):
            starts &= code[place : place + len(starts), 0] == op
        fused[: len(starts)][starts, 0] = number
    return fused


def deferred_kernels(
    program: Program, slides: Sequence[int] = (), pause: int = 0, measures: int = STORED
) -> Iterator[Callable[..., Any]]:
    """Yield the deferred kernels that the runs of a program call."""
    yield from geometry_kernels(program.code.step_code)
    for op in set(program.code.step_code[:, 0].tolist()) & DEFERRED.keys():
        yield from DEFERRED[op]
    if others_touch(program):
        yield from (resolve_other_impacts, step_post_impact)
    if len(slides):
        yield slide
    if len(program.code.temporal_root):
        yield judge_temporal
    if len(program.judged):
        yield from (append_contact_sample, step_on, note_objectives)
    if measures & Measure.GAPS:
        yield note_gaps
    if len(program.road.heights):
        yield from (enter_level, keep_levels, measure_on_levels, restore_levels)
        yield from (trace_levels, recall_levels, follow_levels, look_back, look_ahead)
    if pause:
        yield from (continue_run, leave_run, note_commands)


def _read_by_objectives(program: Program) -> int:
    """Return the `Measure`s that the objectives of a program read."""
    reads, measures = {reading.result for reading in program.judged.readings}, 0
    for row in NAMED_RESULTS:
        measures |= row.measure if row.name in reads else 0
    return measures


def _readings(program: Program) -> Ints:
    """Return (readings, 2) as `run_state.Plan` contains them."""
    names = [row.name for row in NAMED_RESULTS]
    rows = [(r.kind, names.index(r.result) if r.kind is Reducer.RESULT else r.rule) for r in program.judged.readings]
    return np.array(rows, dtype=np.int32).reshape(-1, 2)


def _is_watched(code: CodeTables) -> bool:
    """Return True if a rule that does not merely end the run is evaluated in every sample."""
    looked_at = np.any(code.rule_segment[:, :, Segment.START] >= 0, axis=0)
    return bool(np.any(looked_at & (code.rule_kind != RuleKind.TERMINATE)))


def _check(config: SimulationConfig) -> None:
    if not (math.isfinite(config.time_step) and config.time_step > 0.0):
        raise ArgumentError(
            f"time_step is {config.time_step} s; it must be a positive number", "take 0.05, the default"
        )
    if not (math.isfinite(config.max_time) and config.max_time >= 0.0):
        raise ArgumentError(
            f"max_time is {config.max_time} s; it must be a number that is not negative", "take a longer time"
        )
    if samples_of(config) > MAX_SAMPLES:
        raise ArgumentError(
            f"{config.max_time} s in steps of {config.time_step} s are more than {MAX_SAMPLES:,} steps",
            "take longer steps",
        )


def _check_contact(contact: ContactConfig) -> None:
    for name, value, most in (
        ("restitution", contact.restitution, 1.0),
        ("friction", contact.friction, math.inf),
        ("rolling_resistance", contact.rolling_resistance, math.inf),
    ):
        if not (0.0 <= value <= most and math.isfinite(value)):
            above = f"from 0 to {most:g}" if math.isfinite(most) else "that is not negative"
            raise ArgumentError(f"contact.{name} is {value}; it must be a number {above}", "leave it out: see the docs")


def samples_of(config: SimulationConfig) -> int:
    """Return the sample at which the time limit ends a run; a limit between two samples is rounded up."""
    return math.ceil(config.max_time / config.time_step - 1e-9)


def memory(program: Program, samples: int, measures: int = STORED) -> Run:
    """Return reusable memory for one run, with a record of up to `samples` samples and the literals, in which
    `measures` can be computed.
    """
    code, actors = program.code, len(program.actors)
    watching = bool(np.any(code.rule_kind == RuleKind.WATCH))
    registers = np.zeros(int(code.sizes[Size.STEP_REGISTERS]))
    registers[: len(code.literals)] = code.literals
    return Run(
        states=np.zeros((samples, actors, len(State))),
        registers=registers,
        resume=np.full(int(code.sizes[Size.BLOCKS]), -1, dtype=np.int32),
        actors=np.zeros((actors, len(Memory))),
        status=np.zeros(len(Status), dtype=np.int64),
        end=np.zeros(3),
        key=np.zeros(6, dtype=np.int64),
        segments=np.zeros((actors, len(MotionSegment))),
        impacts=np.zeros((MAX_IMPACTS, len(ImpactRecord))),
        watched=np.zeros((samples, len(code.rule_kind)) if watching else (0, 0)),
        formula_values=np.zeros((2, len(code.formula))),
        formula_decided=np.zeros(len(code.temporal_root), dtype=np.int64),
        beyond=np.zeros((actors if len(program.judged) else 0, len(State))),
        final=np.zeros(len(registers) if len(program.judged) else 0),
        shades=np.zeros(actors * SHADE),
        areas=np.full((actors * actors, KEPT), np.nan),
        swept=swept(samples + 1 if measures & Measure.GAPS else 0),
        sweep_order=np.arange(actors, dtype=np.int32),
        sweep_spans=np.zeros((actors, 2)),
        actions=np.zeros((samples if program.controls else 0, numbers_decided(program.controls))),
        command_columns=np.zeros(actors, dtype=np.int32),
        heights=np.zeros((samples + 1 if len(program.road.heights) else 0, 2 * actors)),
        slot_registers=np.zeros((0, 0)),
        slot_actors=np.zeros((0, 0, 0)),
        slot_end=np.zeros((0, 0)),
        slot_key=np.zeros((0, 0), dtype=np.int64),
        slot_resume=np.zeros((0, 0), dtype=np.int32),
        slot_status=np.zeros((0, 0), dtype=np.int64),
        slot_states=np.zeros((0, 0, 0, 0)),
        slot_watched=np.zeros((0, 0)),
        slot_touching=np.zeros((0, 0)),
        slot_segments=np.zeros((0, 0, 0)),
        slot_actions=np.zeros((0, 0, 0)),
        slot_pages=np.zeros((0, 0), dtype=np.int32),
        command_pages=np.zeros((0, 0, 0, 0)),
    )


def parallel_memory(program: Program, samples: int, count: int, back: int, coming: int, measures: int = STORED) -> Run:
    """Return memory for `count` parallel runs (`kernels.slots`), which are advanced in turn; see `with_slots`.

    `back`: samples before the current sample that are still read; `coming`: rows for turns with known decisions, a
    power of two.
    """
    run = memory(program, samples, measures)

    def of_each(array: NDArray[Any]) -> NDArray[Any]:
        return np.repeat(array[np.newaxis], count, axis=0)

    return run._replace(
        slot_registers=of_each(run.registers),
        slot_actors=of_each(run.actors),
        slot_end=of_each(run.end),
        slot_key=of_each(run.key),
        slot_resume=of_each(run.resume),
        slot_status=of_each(run.status),
        slot_states=np.zeros((count, ring(back + 1), *run.states.shape[1:])),
        slot_watched=np.zeros((count, run.watched.shape[1])),
        slot_touching=np.zeros((count if len(program.judged) else 0, run.watched.shape[1])),
        slot_segments=np.zeros((count, len(run.segments) if others_touch(program) else 0, len(MotionSegment))),
        slot_actions=np.zeros((count, coming, run.actions.shape[1])),
    )


def with_slots(run: Run) -> Run:
    """Return the memory with the states of its parallel runs, as its arrays are now."""
    own = {name: getattr(run, f"slot_{name}") for name in cast("Handle", run).own_fields}
    # Pages are read from the run that has the slots: those of the slots are empty, as addresses of pages do not last.
    shared = run._replace(slots=Slots(), command_pages=run.command_pages[:0], slot_pages=run.slot_pages[:0])
    return run._replace(slots=Slots(shared, **own))


def ring(rows: int) -> int:
    """Return the least power of two that is not less than `rows`."""
    return 1 << (rows - 1).bit_length()


def others_touch(program: Program) -> bool:
    """Return True if actors other than the ego may touch each other, or a building."""
    return len(program.actors) > 2 or (len(program.actors) > 1 and len(program.road.buildings) > 0)


def looking_back(program: Program, time_step: float) -> int:
    """Return the age in steps of the oldest sample that a driver reads: by its `latency`, or 1 for a yaw rate."""
    code, longest = program.code, 0.0
    rows = code.step_code
    least = int(np.isin(rows[:, 0], (Op.TTC, Op.VELOCITY)).any())
    for row in np.flatnonzero(rows[:, 0] == Op.CROSSING).tolist():
        late = int(rows[row, 4]) + Foresight._fields.index("latency")
        packed = rows[:row][rows[:row, 1] == late][-1:]
        known = len(packed) and packed[0, 0] == Op.MOVE and packed[0, 2] < len(code.literals)
        longest = max(longest, float(code.literals[packed[0, 2]]) if known else math.inf)
    return max(least, math.floor(longest / time_step + 0.5)) if longest < math.inf else MAX_SAMPLES


def requested(program: Program, scenes: Scenes) -> Requested:
    """Return the arrays of scenes that a run reads; raise ControllerError if controllers have not driven the scenes."""
    numbers = numbers_decided(program.controls)
    if numbers and scenes.actions.shape[2] != numbers and scenes.valid.any():
        raise undriven(program)
    actions = scenes.actions if scenes.actions.size else np.zeros((len(scenes), 0, numbers))
    return Requested(
        actions=_numbers(actions),
        verdict=_integers(scenes.verdict),
        variant=np.require(scenes.variant, np.int64, PLAIN),  # as wide as integers that Python passes
        values=_numbers(scenes.values),
        keys=np.require(scenes.keys, np.int64, PLAIN),
    )


def coasting(program: Program, scenes: Scenes) -> Scenes:
    """Return the scenes with all external decisions zero."""
    return replace(scenes, actions=np.zeros((len(scenes), 1, numbers_decided(program.controls))))


def undriven(program: Program) -> ControllerError:
    """Return the error for a program with controllers but without a driver."""
    names = " and ".join(f"`{control.controller}` of {program.actors[control.actor]}" for control in program.controls)
    return ControllerError(
        f"{program.name} needs a driver for the controller {names}",
        "name a driver: `--ego python:module:function` on the command line, `ego=` in Python",
    )


def empty_results(program: Program, scenes: Requested, measures: int = STORED) -> Results:
    """Return rows for results of these measures, with NaN, -1 and the verdict of sampling."""
    rows, actors = len(scenes.verdict), len(program.actors)
    arrays = {row.name: row.blank(rows, actors) for row in OUTCOMES if row.per is not Per.PAIR}
    pairs = np.tile(np.array([row.fill for row in PAIRS], dtype=np.float64), (rows, actors - 1, 1))
    objectives = {name: np.full((rows, len(program.judged)), math.nan) for name in ("sought", "broken")}
    gaps = np.full((rows, actors - 1 if measures & Measure.GAPS else 0), math.nan)
    return Results(**arrays | {"verdict": scenes.verdict.copy(), "pairs": pairs, "gaps": gaps, **objectives})


def outcomes(results: Results) -> Outcomes:
    """Return results as `Outcomes`, under their public names."""
    arrays = results._asdict()
    return Outcomes(**pair_arrays(arrays.pop("pairs")), **arrays)


def pair_arrays(metrics: Floats) -> dict[str, NDArray[Any]]:
    """Return the arrays (n, pairs) of `Outcomes` from the measures of `kernels.pair`, (n, pairs, len(PAIRS))."""
    return {row.name: metrics[:, :, number].astype(row.dtype) for number, row in enumerate(PAIRS)}


def outlines(program: Program, values: Floats) -> Floats:
    """Return (actors, 2) length and width of each actor of one scene [m]; `values` is its row of scene values."""
    return np.ascontiguousarray(actor_columns(program, values)[:, [Column.LENGTH, Column.WIDTH]])


def heights_of(road: RoadTables, kinds: Ints, states: Floats) -> Floats | None:
    """Return (samples, actors) heights of the road [m] at the actors of a record; None on a road without bridges.

    `kinds` (actors,) `ActorKind`
    """
    if not len(road.heights):
        return None
    heights = np.zeros(states.shape[:2])
    trace_heights(road, kinds, states, len(states), heights)
    return heights


def plain(road: RoadTables) -> RoadTables:
    """Return the tables of a road in the form that kernels expect."""
    return road._make(np.require(array, requirements=PLAIN) for array in road)


def _numbers(array: Floats) -> Floats:
    return np.require(array, np.float64, PLAIN)


def _integers(array: Ints) -> Ints:
    return np.require(array, np.int32, PLAIN)


def in_parts(rows: int, jobs: int, run: Callable[[Window], None]) -> None:
    """Call `run` for windows of all rows, in `jobs` threads: several windows each, so that they end together."""
    if jobs == 1 or rows < 2:
        _in_moments(rows, run)
        return
    size = max(1, min(CHUNK, -(-rows // (4 * jobs))))
    parts = [Window(*ends) for ends in pairwise([*range(0, rows, size), rows])]
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(run, parts))


def _in_moments(rows: int, run: Callable[[Window], None]) -> None:
    """Call `run` for windows of all rows in this thread; each is as long as the one before suggests."""
    first, size = 0, FIRST_CHUNK
    while first < rows:
        last, start = min(rows, first + size), perf_counter()
        run(Window(first, last))
        seconds = max(perf_counter() - start, 1e-6)
        first, size = last, max(1, min(CHUNK, int((last - first) * A_MOMENT / seconds)))
