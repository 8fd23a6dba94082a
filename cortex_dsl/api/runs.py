"""Runs on disk: a journal alone is enough to compile its scenario again and to go on with what was done with it.

>>> import cortex_dsl as cx
>>> run = cx.open_run("runs/left_turn-ga-001")
>>> run.record.evaluations.collided.sum()
>>> run.scenario.watch(run.scenario.scene_of(genome, key))
>>> cx.resume("runs/left_turn-ga-001", generations=60).campaign.distinct_collisions
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cortex_dsl.api.arguments import callback, kind, objectives_of, path_of
from cortex_dsl.api.loading import load
from cortex_dsl.api.run_folder import (
    Found,
    KeptFiles,
    OnRemoved,
    Work,
    campaign_of,
    carry_out,
    check_map,
    default_workers,
    same_objective,
    worst_files,
)
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax.reading import read_source
from engine.arguments import whole
from engine.display import facts_table
from engine.search.campaign import Campaign, OnGeneration
from engine.search.insight.kinds import blamed
from engine.search.journal import Journal
from engine.search.journal_reader import Record, damaged, read_journal
from engine.search.manifest import Manifest, Text, check_program
from engine.search.past import follow, who_drove
from engine.search.protocol import Box, Sought
from engine.search.ranking import Case, order_of_risk, worst_cases
from engine.search.searchers import build_searcher, find_searcher, seek
from engine.search.store import JOURNAL, StoreError, example_run, hold
from engine.search.typed import ManifestError
from engine.search.workers import Workers
from engine.study.database import is_study
from engine.tables import Ints

if TYPE_CHECKING:
    from engine.scenes import Scenes

WORST = 10
"""Cases of which the run's folder has a scenario each, of many kinds."""


@dataclass(frozen=True)
class OpenedRun:
    """A run and the scenario that it searched, compiled from the texts that its journal keeps."""

    folder: Path
    record: Record
    scenario: Scenario
    """With the settings of the run."""
    edited: tuple[str, ...]
    """Files that say something else now; the run goes by what they said when it was started."""

    def __repr__(self) -> str:
        """One line, for notebooks."""
        method, count = self.record.manifest.method, len(self.record.evaluations)
        return f"OpenedRun({self.folder}: {method}, {count} individuals, {self.record.status})"

    def _repr_html_(self) -> str:
        record, evaluations = self.record, self.record.evaluations
        facts = [("run", str(self.folder)), ("scenario", record.manifest.file), ("method", record.manifest.method)]
        counts = [("individuals", f"{len(evaluations):,}"), ("collisions", f"{int(evaluations.collided.sum()):,}")]
        return facts_table([*facts, ("status", record.status), *counts])

    @cached_property
    def blame(self) -> Ints:
        """(n, k) what the reference driver says of each collision; see `engine.search.insight.kinds`."""
        from engine.search.evaluator import make_blaming

        return blamed(self.record.evaluations, make_blaming(self.scenario.program, self.scenario.config))

    def scene(self, case: Case) -> "Scenes":
        """Return the scene of one of its cases, drawn again.

        Raises:
            StoreError: by the settings and the seed of the journal there is no such scene.
        """
        scenes = self.scenario.scene(case)
        if not scenes.valid[0]:
            raise damaged(self.folder / JOURNAL, f"by its settings there is no scene of case {case.rank}")
        return scenes


def search(
    scenario: str | Path | Scenario,
    method: str = "ga",
    *,
    profile: str = "paper",
    preset: str = "cortex",
    objective: Sought | Sequence[Sought] = "risk",
    on_generation: OnGeneration | None = None,
    workers: Workers | None = None,
    out: str | Path | None = None,
    ego: object = None,
    **settings: Any,
) -> Campaign:
    """Search a scenario, loaded or named by its path, for its worst cases; everything else is as in `Scenario.search`.

    Raises:
        CompileError: the file has errors.
        UnreadableFileError: it cannot be read.
        and as `Scenario.search`.
    """
    kind("scenario", scenario, (str, Path, Scenario), "name a scenario by its path, or load it")
    subject = scenario if isinstance(scenario, Scenario) else load(scenario)
    return subject.search(
        method,
        profile=profile,
        preset=preset,
        objective=objective,
        on_generation=on_generation,
        workers=workers,
        out=out,
        ego=ego,
        **settings,
    )


def open_run(folder: str | Path, ego: object = None) -> OpenedRun:
    """Read a run directory and compile its scenario.

    `ego`: who drove for the controllers of the file, as for `Scenario.driven_by`. Without it only those scenes can be
    driven again whose decisions the journal keeps: collisions and the worst cases.

    Raises:
        StoreError: there is no readable journal, or this version of cortexc compiles the scenario to something else.
    """
    folder = _run_folder(path_of("folder", folder, "name the folder of a run"))
    record = read_journal(folder / JOURNAL)
    manifest = record.manifest
    compiled = _compiled(folder, manifest)
    origin = manifest.origin
    config = replace(manifest.config, driver=who_drove(folder, manifest.driver, record.actions, ego))
    scenario = Scenario(compiled, config, origin.overrides, origin.scenario)
    return OpenedRun(folder, record, scenario, tuple(_edited(manifest)))


def check_journal(run: OpenedRun) -> None:
    """Check that a journal follows from its own beginning: a new searcher, given the results one generation after the
    other, must propose every individual of it, by the same operator and from the same parents. Nothing is simulated.

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
        compiled = compile_source(source, overrides, scenario=origin.scenario, files=KeptFiles(origin))
    except CompileError as error:
        raise StoreError(f"this version of cortexc does not compile the scenario of `{folder}`", cure) from error
    if compiled.program.digest != manifest.program_digest:
        raise StoreError(f"this version of cortexc compiles the scenario of `{folder}` to another program", cure)
    try:
        check_program(manifest, compiled.program)
    except ManifestError as error:
        raise damaged(folder / JOURNAL, error) from error
    return compiled


def _edited(manifest: Manifest) -> Iterator[str]:
    """Return the files of the run that exist with another content now."""
    for file in (Text(manifest.file, manifest.file_text), *manifest.origin.imports):
        with suppress(OSError, ValueError):
            if _text_of(file.name) != file.text:
                yield file.name


def _text_of(name: str) -> str | None:
    """Return the text of a file as the compiler reads it; None where that fails."""
    try:
        return read_source(name).text
    except CompileError:
        return None


# -- going on with one -----------------------------------------------------------------------------------------------


def resume(
    folder: str | Path,
    *,
    generations: int | None = None,
    on_generation: OnGeneration | None = None,
    on_removed: OnRemoved | None = None,
    workers: Workers | None = None,
    objective: Sought | Sequence[Sought] | None = None,
    ego: object = None,
) -> Found:
    """Continue a run that was stopped or killed, to the journal that an undisturbed one would have written.

    `objective`: what the run looks for, which is known but for functions: these must be given again, by the same name.

    `ego`: who drove in it, who must be named again where one did.

    `generations`: as many in all as this, more or fewer than the run was started with. Of a finished run nothing is
    written, and nothing simulated but the probes of its genes.

    Raises:
        StoreError: there is no run to go on with, this version would go on otherwise, or another process is at it.
        and as `search_and_keep`.
    """
    generations = None if generations is None else whole("generations", generations, 0)
    callback("on_generation", on_generation)
    callback("on_removed", on_removed)
    with reopened(open_run(folder, ego), generations, objective) as rest:
        return rest.carry_out(on_generation=on_generation, on_removed=on_removed, workers=workers)


@dataclass(frozen=True)
class Rest:
    """What is left to do of a run. Without a journal: nothing, it is finished."""

    run: OpenedRun
    manifest: Manifest
    """Of the run as it is to end."""
    journal: Journal | None = None
    record: Record | None = None
    """What the journal holds."""
    objective: tuple[Sought, ...] = ()
    """What the run looks for."""

    def carry_out(
        self,
        *,
        on_generation: OnGeneration | None = None,
        on_removed: OnRemoved | None = None,
        workers: Workers | None = None,
    ) -> Found:
        """Search to the end, or only report a run that is finished."""
        config = replace(self.manifest.config, driver=self.run.scenario.config.driver)
        folder, scenario = self.run.folder, replace(self.run.scenario, config=config)
        workers = workers or default_workers(scenario)
        work = Work(scenario, folder, self.manifest, on_generation, on_removed, workers, self.objective)
        if self.journal is not None and self.record is not None:
            return carry_out(work, self.journal, self.record)
        campaign = replace(campaign_of(work, self.run.record), elapsed=self.run.record.seconds)
        return Found(campaign, folder, self.manifest, worst_files(folder))


@contextmanager
def reopened(
    run: OpenedRun, generations: int | None = None, objective: Sought | Sequence[Sought] | None = None
) -> Iterator[Rest]:
    """Hold an open run for as long as the block goes on with it, once nothing stands against that.

    Raises:
        StoreError: it looks for something else, cannot be made so long, another process is at it, or its folder
            cannot be written.
    """
    longer = _with_generations(run, generations)
    given = None if objective is None else objectives_of(run.scenario.program, objective)
    aims = same_objective(run.folder, run.scenario.program, longer, given)
    if run.record.status == "finished" and longer == run.record.manifest:
        yield Rest(run, longer, objective=aims)
        return
    with hold(run.folder):
        record = read_journal(run.folder / JOURNAL)  # read again under the lock: no process can change it any more
        with closing(Journal.reopen(run.folder / JOURNAL, longer)) as journal:
            yield Rest(run, longer, journal, record, aims)


def _with_generations(run: OpenedRun, generations: int | None) -> Manifest:
    """Return the manifest of the run with so many generations."""
    manifest, done = run.record.manifest, len(run.record.generations)
    settings: dict[str, Any] = manifest.settings
    if generations is None or generations == settings["search"]["generations"]:
        return manifest
    if generations < done:
        raise StoreError(f"`{run.folder}` has {done} generations already", f"give --generations {done} or more")
    if find_searcher(manifest.method).paced:
        planned = settings["search"]["generations"]
        raise StoreError(
            f"{manifest.method} paces itself by the number of its generations, and this run was planned for {planned}",
            f"start a search of {generations} generations; without --generations this one goes on as it was planned",
        )
    return replace(manifest, settings={**settings, "search": {**settings["search"], "generations": generations}})


# -- its cases by number: those of its folder `worst` first, then all others, worst first ------------------------------


def every_case(run: OpenedRun) -> tuple[Case, ...]:
    """Return every genome with a valid simulation. Number 7 is `worst/07.scn`; from 11 on all others, worst first."""
    evaluations = run.record.evaluations
    first = worst_cases(evaluations, WORST, run.blame)
    taken = {case.row for case in first}
    every = worst_cases(evaluations, len(order_of_risk(evaluations)), run.blame)
    rest = [case for case in every if case.row not in taken]
    return (*first, *(replace(case, rank=rank) for rank, case in enumerate(rest, start=len(first) + 1)))


def first_cases(run: OpenedRun, count: int) -> tuple[Case, ...]:
    """Return the first `count` cases."""
    return every_case(run)[:count]
