"""What is held against the checkers: cases of A to F, and of every construct of the language, in every format."""

import shutil
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.validation.items import Item
from benchmarks.validation.roads import counted
from cortex_dsl import Scenario, load, open_run
from cortex_dsl.interchange.cases import ExportCase, case_of_run, case_of_scene
from cortex_dsl.interchange.formats import gather
from engine.interchange import ExportOptions, InterchangeError
from engine.interchange.after_contact import shown_after_contact
from engine.interchange.contract import OSC_VERSIONS
from engine.interchange.openscenario.document import entity_names
from engine.interchange.recording import states_at
from engine.vocabulary import State, Verdict

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.scn"))
"""A to F of the paper."""
CONSTRUCTS = sorted((ROOT / "tests" / "agreement").glob("*.scn"))
"""Scenarios that use everything else that the language has: other roads, other actors, lights."""
ATTEMPTS = 400
"""Scenes that are drawn to find some that come to nothing."""


@dataclass(frozen=True)
class Wanted:
    """One way to write a case."""

    kind: str
    format: str
    suffix: str
    """Of the files that are held against the checkers."""
    options: ExportOptions = field(default_factory=ExportOptions)
    version: str = ""


WANTED = (
    *(Wanted("replay", "xosc", ".xosc", ExportOptions(osc), osc) for osc in OSC_VERSIONS),
    *(Wanted("maneuver", "xosc", ".xosc", ExportOptions(osc, "maneuver"), osc) for osc in OSC_VERSIONS),
    Wanted("carla", "xosc", ".xosc", ExportOptions("1.0", player="carla")),
    Wanted("road", "xodr", ".xodr"),
    Wanted("commonroad", "commonroad", ".cr.xml"),
    Wanted("scenic", "scenic", ".scenic"),
    Wanted("csv", "csv", ".csv"),
    Wanted("parquet", "parquet", ".parquet"),
)


def cases(file: Path, folder: Path, top: int, others: int) -> list[ExportCase]:
    """The worst cases of a search with a fixed seed, and some scenes in which the ego touches nobody."""
    scenario = load(file)
    if not scenario.program.space.names:
        return _quiet(scenario, file, top + others, anything=True)
    shutil.rmtree(folder, ignore_errors=True)
    campaign = scenario.search("ga", out=folder, seed=1)
    run = open_run(folder)
    return [case_of_run(run, case) for case in campaign.worst[:top]] + _quiet(scenario, file, others)


def _quiet(scenario: Scenario, file: Path, count: int, anything: bool = False) -> list[ExportCase]:
    """Scenes of the first seeds whose runs are valid, without contact unless anything will do."""
    found: list[ExportCase] = []
    for seed in range(ATTEMPTS):
        if len(found) == count:
            break
        scenes = scenario.sample(1, seed=seed)
        outcomes = scenario.simulate(scenes)
        if outcomes.verdict[0] == Verdict.VALID and (anything or not outcomes.collided[0]):
            found.append(case_of_scene(scenario, scenes, file, seed, f"cortexc {file.name} --seed {seed}"))
    return found


def written(found: Sequence[ExportCase], folder: Path, kinds: Collection[str] | None = None) -> Iterator[Item]:
    """Every case in every way, or in those of some kinds, each way in a folder of its own."""
    for way in (way for way in WANTED if kinds is None or way.kind in kinds):
        place = folder / f"{way.kind}{way.version}"
        place.mkdir(parents=True, exist_ok=True)
        for case in found:
            yield from _written(case, way, place)


def _written(case: ExportCase, way: Wanted, folder: Path) -> Iterator[Item]:
    """An item for each file that ends as is wanted: maneuvers bring files of parameter values. Scenic, which knows no
    left-hand roads, is not asked about them.
    """
    road = case.recording.road
    if way.kind == "scenic" and road is not None and road.left_hand:
        return
    try:
        files = gather([case], [way.format], way.options).files
    except InterchangeError as error:
        yield Item(way.kind, folder / case.recording.name, problem=str(error), version=way.version)
        return
    for name, content in files.items():
        (folder / name).write_bytes(content)
    for name in files:
        if name.endswith(way.suffix):
            told = {**facts(case), **ticks(case, list(files))} if way.kind == "carla" else facts(case)
            yield Item(way.kind, folder / name, told, case, version=way.version)


def ticks(case: ExportCase, files: Sequence[str]) -> dict[str, Any]:
    """Where a player must have everybody at each tick of our step, and the road that it plays on."""
    recording = shown_after_contact(case.replay, "through").from_zero()
    times = np.arange(int(recording.time[-1] / recording.step + 1e-9) + 1) * recording.step
    rows = states_at(recording, times)
    return {
        "road": next(name for name in files if name.endswith(".xodr")),
        "names": entity_names(recording),
        "tick": recording.step,
        "ticks": [[row[: State.SPEED].tolist() if row[State.PRESENT] else None for row in rows_of] for rows_of in rows],
    }


def facts(case: ExportCase) -> dict[str, Any]:
    """What others must find in a case: where everybody starts, who is there, who touches whom when."""
    recording, contact = case.recording, case.recording.contact
    there = recording.states[:, :, State.PRESENT] != 0.0
    ego = recording.actors[0]
    return {
        "places": recording.states[0][there[0]][:, [State.X, State.Y, State.HEADING]].tolist(),
        "movers": int(there.any(axis=0).sum()),
        "buildings": 0 if recording.buildings is None else len(recording.buildings),
        "rows": int(there.sum()),
        "size": [ego.length, ego.width],
        "step": recording.step,
        "begins": float(recording.time[int(there[:, 0].argmax())]),
        "contact": None if contact is None else {"time": contact.time, "actors": list(contact.actors)},
        **({} if recording.road is None else counted(recording.road)),
    }
