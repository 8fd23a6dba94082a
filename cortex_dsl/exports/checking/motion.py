"""Files that tell a motion: read back by our own readers, and held against the run by samples, metrics and risk."""

from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from cortex_dsl.api.scenario import load
from cortex_dsl.exports.cases import ExportCase
from cortex_dsl.exports.checking import documents
from cortex_dsl.exports.findings import Finding
from engine.interchange.errors import InterchangeError
from engine.interchange.export import ExportOptions
from engine.interchange.measuring import measure
from engine.interchange.record import recorded_run
from engine.interchange.recording import Recording
from engine.risk import Risk
from engine.scenes import Outcomes
from engine.tables import Floats
from engine.vocabulary import State, Verdict

NEAR = 1e-3
"""A place that is read back may be so far off [m]; a heading [rad], a speed [m/s]."""
SAME = 1e-6
"""A metric may be so far off, of its size."""
METRICS = {
    "MD": "min_distance",
    "MS": "max_closing_speed",
    "D_MS": "distance_at_ms",
    "TTC_MS": "ttc_at_ms",
}
OURS = "this is a bug in cortexc: please report it"


def openscenario(case: ExportCase, folder: Path, names: Sequence[str], options: ExportOptions) -> Iterator[Finding]:
    """The rules of OpenSCENARIO; a replay is the run, to a millimetre."""
    from engine.interchange.reading import read_openscenario

    for name in (each for each in names if each.endswith(".xosc")):
        yield from documents.scenario_rules(folder, name)
        if options.mode != "trajectory":  # maneuvers are for a simulator to play
            continue
        try:
            read = read_openscenario(folder / name).recording
        except InterchangeError as error:
            yield Finding(error.place or name, error.message, error.cure)
            continue
        yield from _same_run(case, read, name)
    yield from documents.opendrive(case, folder, names, options)


def table(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """The rows are the run, to a millimetre."""
    from engine.interchange.tables import read_table

    for name in (each for each in names if each.endswith((".csv", ".parquet"))):
        try:
            read = read_table(folder / name, step=case.recording.step).recording
        except InterchangeError as error:
            yield Finding(error.place or name, error.message, error.cure)
            continue
        yield from _same_run(case, read, name)


def scenario(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """The copy, compiled and run, is the run, bit for bit."""
    from engine.streams import parse_key

    for name in (each for each in names if each == f"{case.recording.name}.scn"):
        copy = load(folder / name)
        key = np.array(parse_key(copy.program.settings.stream or ""), dtype=np.int64)
        scenes = copy.scene_of(np.zeros(len(copy.program.space)), key)
        if not scenes.valid[0]:
            yield Finding(name, "its scene is not valid", OURS)
            continue
        run = copy.watch(scenes)
        again = recorded_run(copy.program, scenes, run, step=copy.config.simulation.time_step)
        yield from _same_bits(case, again, run.outcomes, name)


def _same_bits(case: ExportCase, again: Recording, outcomes: Outcomes, name: str) -> Iterator[Finding]:
    """Every state of every sample, and every number of the outcome."""
    if not (_same(again.time, case.recording.time) and _same(again.states, case.recording.states)):
        yield Finding(name, "it does not run the same way", OURS)
    differ = [
        each.name for each in fields(outcomes) if not _same(*(getattr(o, each.name) for o in (outcomes, case.outcomes)))
    ]
    if differ:
        yield Finding(name, f"it does not run to the same outcome: {', '.join(differ)}", OURS)


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Bit for bit, where no number is no number."""
    return one.shape == other.shape and bool(((one == other) | ((one != one) & (other != other))).all())


def _same_run(case: ExportCase, read: Recording, name: str) -> Iterator[Finding]:
    """Everybody where they were, and the same metrics and risk."""
    ours = case.replay
    if len(read.actors) != len(ours.actors):
        count = f"{len(ours.actors)} took part, {len(read.actors)} are read back"
        yield Finding(name, count, OURS)
        return
    for number, actor in enumerate(ours.actors):
        yield from _same_way(ours, read, number, f"{name}, {actor.name}")
    yield from _same_risk(case, read, name)


def _same_way(ours: Recording, read: Recording, actor: int, place: str) -> Iterator[Finding]:
    """One actor's states at every sample of the run at which it was there; a speed after contact has no one meaning."""
    scored = ours.scored_samples()
    for what, column in (("place", State.X), ("place", State.Y), ("heading", State.HEADING), ("speed", State.SPEED)):
        for first, last in ours.stretches(actor):
            end = min(last + 1, scored) if what == "speed" else last + 1
            times, states = ours.time[first:end], ours.states[first:end, actor, column]
            off = np.abs(np.interp(times, *_course(read, actor, column)) - states)
            off = np.abs((off + np.pi) % (2 * np.pi) - np.pi) if what == "heading" else off
            worst = int(off.argmax()) if len(off) else 0
            if len(off) and not off[worst] <= NEAR:
                yield Finding(place, f"the {what} at {times[worst]:.3f} s is {off[worst]:.3g} off", OURS)


def _course(read: Recording, actor: int, column: State) -> tuple[Floats, Floats]:
    there = read.there[:, actor]
    values = read.states[there, actor, column]
    return read.time[there], np.unwrap(values) if column == State.HEADING else values


def _same_risk(case: ExportCase, read: Recording, name: str) -> Iterator[Finding]:
    """What was read back is judged as the run was, if that could be judged."""
    if case.outcomes.verdict[0] != Verdict.VALID:
        return
    try:
        measured = measure(read, case.profile)
    except InterchangeError as error:
        yield Finding(name, error.message, error.cure)
        return
    pairs = [actor - 1 for actor in range(1, len(case.recording.actors)) if actor not in case.recording.never_there]
    yield from _same_metrics(case.outcomes, pairs, measured.outcomes, name)
    ours: Risk = case.scenario.assess(case.outcomes, case.profile)
    if int(ours.score[0]) != int(measured.risk.score[0]):
        yield Finding(name, f"the risk is {ours.score[0]}, read back {measured.risk.score[0]}", OURS)


def _same_metrics(ours: Outcomes, pairs: Sequence[int], read: Outcomes, name: str) -> Iterator[Finding]:
    """`pairs` of ours are those of which both took part."""
    if bool(ours.collided[0]) != bool(read.collided[0]):
        yield Finding(name, "the run collided or not, read back it is otherwise", OURS)
    for metric, column in METRICS.items():
        one, other = getattr(ours, column)[0, pairs], getattr(read, column)[0]
        if not np.allclose(one, other, rtol=SAME, atol=SAME, equal_nan=True):
            yield Finding(name, f"{metric} is {_listed(one)}, read back {_listed(other)}", OURS)


def _listed(values: Floats) -> str:
    return ", ".join(f"{value:.6g}" for value in values.tolist())
