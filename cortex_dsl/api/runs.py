"""Runs on disk: a journal alone is enough to compile its scenario again, with every case that was found in it.

>>> import cortex_dsl as cx
>>> run = cx.open_run("runs/left_turn-ga-001")
>>> run.record.evaluations.collided.sum()
>>> run.scenario.watch(run.scenario.scene_of(genome, key))
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np

from cortex_dsl.api.arguments import SearchSettings, kind, path_of, with_keywords
from cortex_dsl.api.derived_files import VERIFICATION, WORST_FOLDER
from cortex_dsl.api.run_folder import (
    FAILURES,
    KeptFiles,
    check_map,
)
from cortex_dsl.api.scenario import Scenario, load
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax.reading import read_source
from engine.checksums import has_checksum, is_unchanged
from engine.display import counted, facts_table
from engine.search.campaign import Campaign
from engine.search.insight.kinds import blamed
from engine.search.journal_reader import Record, damaged, read_again, read_journal
from engine.search.manifest import Manifest, ManifestError, Text, check_program
from engine.search.past import follow, who_drove
from engine.search.protocol import Box, ObjectiveSpec
from engine.search.ranking import WORST, Case, case_of, worst_cases, worst_rows
from engine.search.searchers import build_searcher, seek
from engine.search.store import JOURNAL, StoreError, example_run, located
from engine.tables import Ints

if TYPE_CHECKING:
    from engine.scenes import Scenes


@dataclass(frozen=True)
class OpenedRun:
    """A run and the scenario that it searched, compiled from the texts that its journal keeps."""

    folder: Path
    record: Record
    scenario: Scenario
    """Scenario with the settings of the run."""
    edited: tuple[str, ...]
    """Files that have changed since the start of the run, which uses their contents at that time."""

    def __repr__(self) -> str:
        """One line, for notebooks."""
        method, count = self.record.manifest.method, counted(len(self.record.evaluations), "individual")
        return f"OpenedRun({self.folder}: {method}, {count}, {self.record.status})"

    def _repr_html_(self) -> str:
        record, evaluations = self.record, self.record.evaluations
        facts = [("run", str(self.folder)), ("scenario", record.manifest.file), ("method", record.manifest.method)]
        counts = [("individuals", f"{len(evaluations):,}"), ("collisions", f"{int(evaluations.collided.sum()):,}")]
        return facts_table([*facts, ("status", record.status), *counts])

    @cached_property
    def blame(self) -> Ints:
        """Return the answers (n, k) of the reference driver for each collision; see `engine.search.insight.kinds`.

        They are those of the journal, if it has them.
        """
        return self.blame_again if self.record.blame is None else self.record.blame

    @cached_property
    def blame_again(self) -> Ints:
        """Return the answers of the reference driver, which drives once more."""
        from engine.search.evaluator import make_blaming

        return blamed(self.record.evaluations, make_blaming(self.scenario.program, self.scenario.config))

    @cached_property
    def opinions(self) -> dict[str, str]:
        """Return the answers of `cortexc verify --model dynamic` that are stored next to the journal, by case key.

        Answers for another program, and changed files, are ignored.
        """
        try:
            file = (self.folder / VERIFICATION).read_bytes()
            found = json.loads(file)
            if (has_checksum(file) and not is_unchanged(file)) or found["program"] != self.scenario.program.digest:
                return {}
            return {case["key"]: case["answer"] for case in found["cases"]}
        except (OSError, ValueError, KeyError, TypeError):
            return {}

    def every_case(self) -> tuple[Case, ...]:
        """Return every genome with a valid simulation or, if the search looked for these, with a failure of a
        controller.

        Number 7 is `worst/07.scn`; from 11 on all others, worst first.
        """
        return tuple(self._cases())

    def _cases(self) -> Iterator[Case]:
        """Yield the cases of `every_case`."""
        evaluations = self.record.evaluations
        first = worst_cases(evaluations, WORST, self.blame)
        yield from first
        rows = worst_rows(evaluations, len(evaluations), self.blame)
        rest = rows[~np.isin(rows, [case.row for case in first])].tolist()
        yield from (case_of(evaluations, row, rank) for rank, row in enumerate(rest, start=len(first) + 1))

    def first_cases(self, count: int) -> tuple[Case, ...]:
        """Return the first `count` cases of which there is a run: not those over which a controller failed."""
        return tuple(islice((case for case in self._cases() if not case.lost), count))

    def scene(self, case: Case) -> "Scenes":
        """Return the scene of one of its cases, sampled again.

        Raises:
            StoreError: there is no such scene under the settings and the seed of the journal, or a controller failed in
                it.
        """
        if case.lost:
            raise StoreError(
                f"the driver failed over case {case.rank}, so that there is no run of it",
                f"`cortexc {self.folder / WORST_FOLDER / f'{case.rank:02d}.scn'} --ego NAME` drives it again"
                if case.rank <= WORST
                else f"its scene and its failure stand in `{self.folder / FAILURES}`",
            )
        scenes = self.scenario.scene(case)
        if not scenes.valid[0]:
            raise damaged(self.folder / JOURNAL, f"by its settings there is no scene of case {case.rank}")
        return scenes


@with_keywords
def search(
    scenario: str | Path | Scenario,
    method: str = "ga",
    *,
    objective: ObjectiveSpec | Sequence[ObjectiveSpec] = "risk",
    out: str | Path | None = None,
    ego: object = None,
    **settings: Unpack[SearchSettings],
) -> Campaign:
    """Search a scenario, loaded or named by its path, for its worst cases; everything else is as in `Scenario.search`.

    Raises:
        CompileError: the file has errors.
        UnreadableFileError: it cannot be read.
        and as `Scenario.search`.
    """
    kind("scenario", scenario, (str, Path, Scenario), "name a scenario by its path, or load it")
    subject = scenario if isinstance(scenario, Scenario) else load(scenario)
    return subject.search(method, objective=objective, out=out, ego=ego, **settings)


def open_run(folder: str | Path, ego: object = None) -> OpenedRun:
    """Read a run directory and compile its scenario.

    `ego`: the driver for the controllers of the file, as for `Scenario.driven_by`. Without it, only scenes with
    recorded decisions can be driven again: collisions and the worst cases.

    Raises:
        StoreError: there is no readable journal, or this version of cortexc compiles the scenario differently.
    """
    folder = _run_folder(path_of("folder", folder, "name the folder of a run"))
    record = read_journal(folder / JOURNAL)
    manifest = record.manifest
    compiled = _compiled(folder, manifest)
    origin = manifest.origin
    config = replace(manifest.config, driver=who_drove(folder, manifest.driver, record.actions, ego))
    scenario = Scenario(compiled, config, origin.overrides, origin.scenario)
    return OpenedRun(folder, record, scenario, tuple(_edited(folder, manifest)))


def reread(run: OpenedRun) -> OpenedRun:
    """Return a run with what its journal holds now; its scenario stays."""
    record = read_again(run.folder / JOURNAL, run.record)
    return run if record is run.record else replace(run, record=record)


def check_journal(run: OpenedRun) -> None:
    """Check that a journal follows from its own beginning.

    A new searcher, given the results one generation after the other, must propose every individual of it, by the same
    operator and from the same parents. Nothing is simulated.

    Raises:
        ForeignPastError: it does not.
        UnknownMethodError, MissingExtraError, PluginError: there is no such searcher here.
    """
    space, config = run.scenario.program.space, run.scenario.config
    manifest = run.record.manifest
    searcher = build_searcher(manifest.method, Box.of(space), config, manifest.method_number)
    seek(searcher, manifest.method, manifest.aims)
    follow(searcher, run.record.past())


def _run_folder(path: Path) -> Path:
    """Return the folder of a run, which may be named by its journal."""
    folder = path.parent if path.name == JOURNAL else path
    if (folder / JOURNAL).exists():
        return folder
    if not folder.exists():
        names = [each.name for each in folder.parent.iterdir() if each.is_dir()] if folder.parent.is_dir() else []
        near = nearest(folder.name, names)
        cure = (
            f"did you mean `{folder.with_name(near)}`?"
            if near
            else f"name the folder of a run, such as {example_run()}"
        )
        raise StoreError(f"there is no folder `{folder}`", cure)
    if not folder.is_dir():
        raise StoreError(f"`{folder}` is not a folder", f"name the folder of a run, such as {example_run()}")
    if inside := sorted(each.parent for each in folder.glob(f"*/{JOURNAL}")):
        raise StoreError(f"`{folder}` holds {len(inside)} runs", f"name one of them, such as `{inside[0]}`")
    from engine.study.database import is_study

    if is_study(folder):
        raise StoreError(f"`{folder}` is a study, and no single run", f"`cortexc report {folder}` shows it")
    raise StoreError(
        f"there is no journal in `{folder}`", "if a search into it was ended before it began, start that search again"
    )


def _compiled(folder: Path, manifest: Manifest) -> Compiled:
    """Compile the scenario of a manifest; it must give the very program that was searched."""
    wrote = manifest.versions.get("cortexc", "unknown")
    cure = f"use the version that started it, cortexc {wrote}; what it found can still be read from its journal"
    source, origin = Source(manifest.file, manifest.file_text), manifest.origin
    overrides: Mapping[str, str] = origin.overrides
    check_map(folder, manifest)
    try:
        compiled = compile_source(source, overrides, scenario=origin.scenario, files=KeptFiles(origin, folder))
    except CompileError as error:
        raise StoreError(f"this version of cortexc does not compile the scenario of `{folder}`", cure) from error
    if compiled.program.digest != manifest.program_digest:
        raise StoreError(f"this version of cortexc compiles the scenario of `{folder}` to another program", cure)
    try:
        check_program(manifest, compiled.program)
    except ManifestError as error:
        raise damaged(folder / JOURNAL, error) from error
    return compiled


def _edited(folder: Path, manifest: Manifest) -> Iterator[str]:
    """Yield the files of the run that exist with another content now."""
    for file in (Text(manifest.file, manifest.file_text), *manifest.origin.imports):
        with suppress(OSError, ValueError):
            if _text_of(located(folder, file.name)) != file.text:
                yield file.name


def _text_of(name: str) -> str | None:
    """Return the text of a file as the compiler reads it; None where that fails."""
    try:
        return read_source(name).text
    except CompileError:
        return None
