"""Files of a comparison: the examples as scenarios of their own, with drawings, the document, and the pairs."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cortex_dsl.api.concrete import map_copies
from cortex_dsl.api.contenders import Contender
from cortex_dsl.api.pairs import Pairing
from cortex_dsl.report.blocks import Drawing
from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.cases_found import drawing_of_scene
from cortex_dsl.report.findings.comparison_report import (
    Change,
    ComparisonReport,
    FileComparison,
    FoundChange,
    comparison_content,
)
from cortex_dsl.report.page.comparison_page import comparison_page
from engine.batch import simulate
from engine.interchange.tables.parquet import parquet_bytes
from engine.scenes import Scenes
from engine.search.result_files import csv_table

MOST_CASES = 20
"""Kinds of each change that are kept as scenarios."""
MOST_DRAWINGS = 4
"""Kinds of each change that are drawn."""
PAGE, DOCUMENT = "compare.html", "compare.json"
TABLES = ("csv", "parquet")
"""Formats of the table of pairs."""


def with_cases(pairing: Pairing, changes: Sequence[FoundChange], stem: str) -> tuple[FoundChange, ...]:
    """Return changes with the files and drawings of their examples; the names of the files begin with `stem`."""
    numbers = Counter[Change]()
    return tuple(_with_case(pairing, each, stem, numbers) for each in changes)


def without_scenes(changes: Sequence[FoundChange]) -> tuple[FoundChange, ...]:
    """Return changes without the scenes of their examples, which no report needs."""
    return tuple(replace(each, example=replace(each.example, scenes=())) for each in changes)


def _with_case(pairing: Pairing, found: FoundChange, stem: str, numbers: Counter[Change]) -> FoundChange:
    numbers[found.change] += 1
    number = numbers[found.change]
    if found.change is Change.KEPT or number > MOST_CASES:
        return found
    files: dict[str, bytes] = {}
    cases: list[str] = []
    for label, side, scenes in zip("ab", pairing.sides, found.example.scenes, strict=True):
        if label == "b" and pairing.same:
            continue
        name = f"{stem}-{number:02d}{'' if pairing.same else f'.{label}'}.scn"
        texts = side.scenario.concrete_files(scenes, remark=f"{found.change} failure: {found.kind}", name=name)
        files |= {f"{found.change}/{each}": text.encode() for each, text in texts.items()}
        files |= {f"{found.change}/{each}": content for each, content in map_copies(side.program).items()}
        cases.append(f"{found.change}/{name}")
    drawings: tuple[Drawing, ...] = ()
    if number <= MOST_DRAWINGS:
        pairs = zip(pairing.sides, found.example.scenes, strict=True)
        drawings = tuple(_drawing(side, scenes) for side, scenes in pairs)
    return replace(found, cases=tuple(cases), files=files, drawings=drawings)


def _drawing(side: Contender, scenes: Scenes) -> Drawing:
    """Return a run at its contact, else where the ego comes nearest to another actor."""
    config = side.scenario.config
    outcomes = simulate(side.program, scenes, config.simulation, 1, config.contact)
    if not outcomes.min_distance.shape[1]:
        return drawing_of_scene(side.scenario, scenes, -1)
    pair = int(np.argmin(np.where(np.isnan(outcomes.min_distance[0]), np.inf, outcomes.min_distance[0])))
    return drawing_of_scene(side.scenario, scenes, pair, float(outcomes.min_distance_time[0, pair]))


SEARCHED = "-search"
"""End of the names of cases from a search for differences."""


def stems(paths: Sequence[Path]) -> dict[str, str]:
    """Return a name for each file: its stem, with a number if another file has it, too."""
    taken, found = set[str](), dict[str, str]()
    for path in paths:
        name, number = path.stem, 2
        while {name, f"{name}{SEARCHED}"} & taken:
            name, number = f"{path.stem}-{number}", number + 1
        taken |= {name, f"{name}{SEARCHED}"}
        found[str(path)] = name
    return found


def comparison_files(report: ComparisonReport, table: str) -> Mapping[str, bytes]:
    """Return the files of a comparison by their places below its folder; `table` is a format of `TABLES`.

    Raises:
        InterchangeError: pyarrow is not installed.
    """
    text = document("compare", comparison_content(report))
    files: dict[str, bytes] = {PAGE: comparison_page(report).encode(), DOCUMENT: f"{text}\n".encode()}
    tables = [file for file in report.files if file.table]
    for number, file in enumerate(tables, start=1):
        name = f"pairs{'' if len(tables) == 1 else f'-{number}'}.{table}"
        files[name] = csv_table(file.table) if table == "csv" else _parquet(file)
    for file in report.files:
        searched = () if file.searched is None else file.searched.changes
        for each in (*file.changes, *searched):
            files |= each.files
    return files


def _parquet(file: FileComparison) -> bytes:
    columns = {
        name: np.array(["" if value is None else value for value in values]) for name, values in file.table.items()
    }
    return parquet_bytes(columns, file.actors)
