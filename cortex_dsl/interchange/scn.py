"""A case as a scenario of our own: a copy that runs to the same outcome, and the check that it does, bit for bit."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from cortex_dsl.api.concrete import map_copies
from cortex_dsl.api.scenario import load
from cortex_dsl.interchange.cases import ExportCase
from engine.interchange.contract import OURS, Export, ExportOptions, Finding
from engine.interchange.recording import Recording, recorded_run
from engine.outcomes import Outcomes
from engine.streams import parse_key


def write_scn(case: "ExportCase", stem: str, _options: ExportOptions) -> Export:
    """Return the concrete scenario, and copies of its imports."""
    facts = case.recording.provenance.facts
    remark = "\n".join(f"{name}: {facts[name]}" for name in ("scenario", "risk", "search", "command") if name in facts)
    texts = case.scenario.concrete_files(case.scenes, remark=remark, name=f"{stem}.scn")
    return Export({**texts, **map_copies(case.scenario.program)})


def check_scn(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """The copy, compiled and run, is the run, bit for bit; external drivers decide as they did."""
    for name in (each for each in names if each == f"{case.recording.name}.scn"):
        copy = load(folder / name)
        key = np.array(parse_key(copy.program.settings.stream or ""), dtype=np.int64)
        scenes = copy.scene_of(np.zeros(len(copy.program.space)), key)
        if not scenes.valid[0]:
            yield Finding(name, "its scene is not valid", OURS)
            continue
        run = copy.watch(replace(scenes, actions=case.scenes.actions))
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
