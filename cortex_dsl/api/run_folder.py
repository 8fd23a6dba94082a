"""A run folder: the journal, tables and worst cases of a search, written while it runs.

    >>> found = search_and_keep(scenario, "niching", Path("runs/mine"))
    >>> found.campaign.distinct_collisions, found.worst_files[0]

A journal is marked `finished` only after all files next to it are complete: if a process ends earlier,
`cortex_dsl.api.resuming.resume` does the remaining work.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from errno import ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from cortex_dsl.api.derived_files import Writable, derived_files, worst_files, write_derived
from cortex_dsl.pipeline import Compiled
from cortex_dsl.plain_text import as_argument
from cortex_dsl.semantics.names.linking import import_statements
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes
from engine.maps import MapFile, digest_of
from engine.program import Program
from engine.search.campaign import Campaign, OnGeneration, Progress
from engine.search.journal import Journal
from engine.search.journal_reader import Record
from engine.search.manifest import DIGEST, Link, Manifest, Origin, Text, changed_versions, make_manifest
from engine.search.objectives import known_objectives, names_of
from engine.search.past import ForeignPastError
from engine.search.protocol import DEFAULT_OBJECTIVES, ObjectiveSpec
from engine.search.ranking import worst_cases, worst_runs
from engine.search.run import Past, search
from engine.search.searchers import canonical
from engine.search.store import (
    JOURNAL,
    RemovedError,
    StoreError,
    hold,
    located,
    new_directory,
    numbered_directory,
    seen_from,
    store_errors,
    without_folders,
)
from engine.search.workers import Workers, workers_for

if TYPE_CHECKING:
    from engine.driving.decisions import Recorder

OnRemoved = Callable[[RemovedError], None]
"""Callback for the removal of a run's folder; the search continues in memory."""
FAILURES = "controller.log"
"""File of a run with the failures of a controller."""


class Searchable(Writable, Protocol):
    """Interface of a scenario for a search: the program, the settings, and writing a case as a file."""

    @property
    def compiled(self) -> Compiled: ...
    @property
    def overrides(self) -> Mapping[str, str]: ...
    @property
    def chosen(self) -> str | None: ...
    def driven_by(self, ego: object, /) -> "Searchable": ...


@dataclass(frozen=True)
class SearchResult:
    """The results of a search. They can be shown even where they could not be stored."""

    campaign: Campaign
    folder: Path
    manifest: Manifest
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""
    failure: StoreError | None = None
    """Why it could not be stored completely."""


@dataclass(frozen=True)
class SearchJob:
    """One search and its storage."""

    scenario: Searchable
    folder: Path
    manifest: Manifest
    on_generation: OnGeneration | None
    on_removed: OnRemoved | None
    workers: Workers
    objective: Sequence[ObjectiveSpec] = ()
    """Objectives; (): those of the manifest."""


@dataclass(frozen=True)
class SearchOptions:
    """Options of a search that is stored, beside the settings of the scenario."""

    profile: str = "paper"
    objective: Sequence[ObjectiveSpec] = DEFAULT_OBJECTIVES
    workers: Workers | None = None
    """How the simulations are run; None: as the settings say."""
    on_generation: OnGeneration | None = None
    on_removed: OnRemoved | None = None
    command_line: Sequence[str] = ()
    tables: bool = False
    """True: the text tables are written for a search of any size."""


AS_THE_SETTINGS = SearchOptions()


def search_and_keep(
    scenario: Searchable, method: str, out: Path | None, options: SearchOptions = AS_THE_SETTINGS
) -> SearchResult:
    """Search a scenario by its own settings, and store everything in the folder `out`, which is new or empty; None: in
    the next numbered one. No folder is made if the driver cannot drive.

    Raises:
        ControllerError: the driver cannot drive.
        StoreError: the folder cannot be written, another process writes it, or the memory is used up.
        UnknownMethodError, MissingExtraError, PluginError: there is no such method here.
        UnknownObjectiveError: there is no such objective.
        ObjectiveError: a function as objective failed; earlier results are stored.
        WorkersLostError: no worker process is left to run simulations.
    """
    method, source = canonical(method), scenario.compiled.source
    reproducible = _is_reproducible(scenario)
    folder = numbered_directory(scenario.program.name, method) if out is None else new_directory(out)
    manifest = make_manifest(
        scenario.program,
        scenario.config,
        method,
        options.profile,
        seen_from(folder, source.name),
        [without_folders(word) for word in options.command_line],
        origin_of(scenario).seen_from(folder),
        options.objective,
        reproducible,
        options.tables,
    )
    workers, aims = options.workers or default_workers(scenario), tuple(options.objective)
    work = SearchJob(scenario, folder, manifest, options.on_generation, options.on_removed, workers, aims)
    with hold(folder), closing(Journal.create(folder / JOURNAL, manifest)) as journal:
        return carry_out(work, journal)


def _is_reproducible(scenario: Searchable) -> bool:
    if scenario.config.driver is None:
        return True
    from engine.driving.decisions import is_reproducible

    return is_reproducible(scenario.program, scenario.config)


def same_objective(
    folder: Path, program: Program, manifest: Manifest, given: Sequence[ObjectiveSpec] | None = None
) -> tuple[ObjectiveSpec, ...]:
    """Return the objectives of a run that is to be resumed.

    Raises:
        StoreError: another objective is given, or the run needs a Python function that is not given.
    """
    named = manifest.objective
    aims = named if given is None else tuple(given)
    if names_of(aims) != named:
        given_text = ", ".join(names_of(aims))
        raise StoreError(
            f"`{folder}` looks for {', '.join(named)}, not for {given_text}", "start a new search for that"
        )
    known = known_objectives(program)
    if strange := [each for each in aims if isinstance(each, str) and each not in known]:
        raise StoreError(
            f"`{folder}` looks for `{strange[0]}`, a function of a Python program",
            "go on with it from there: `cx.resume(folder, objective=function)`",
        )
    return aims


def default_workers(scenario: Searchable) -> Workers:
    """Return the workers that the scenario's own settings ask for."""
    search = scenario.config.search
    return workers_for(search.engine, search.jobs)


def carry_out(work: SearchJob, journal: Journal, record: Record | None = None) -> SearchResult:
    """Search, write every generation as it ends, then write the files of the finished run."""
    heard = work.on_generation
    work, recorder = _recorded(work, record)
    removed: list[RemovedError] = []

    def on_generation(progress: Progress) -> None:
        try:
            if not removed:
                journal.write(progress)
                if recorder is not None:
                    recorder.record_worst((*worst_cases(progress.evaluations), *worst_runs(progress.evaluations)))
                journal.keep(recorder.take() if recorder else {})
                _note_failures(work.folder / FAILURES, recorder)
        except RemovedError as error:
            removed.append(error)
            if work.on_removed is not None:
                work.on_removed(error)
        if heard is not None:
            heard(progress)

    try:
        campaign = campaign_of(replace(work, on_generation=on_generation), record)
    except MemoryError:
        raise _out_of_memory(work) from None
    found = SearchResult(campaign, work.folder, work.manifest)
    if removed:
        return replace(found, failure=removed[0])
    try:
        journal.complete(campaign)
        if recorder is not None:
            cases = (*campaign.worst, *worst_runs(campaign.evaluations))
            recorder.record_worst(cases)
            recorder.failures.clear()  # of probes of its genes, which are no simulations of the run
            recorder.record_missing(work.scenario.program, work.scenario.config, campaign.evaluations.rollouts, cases)
            journal.keep(recorder.take())
            _note_failures(work.folder / FAILURES, recorder)
        write_derived(work.folder, derived_files(work.scenario, campaign, work.manifest, journal.link, work.folder))
        journal.finish(campaign)
    except StoreError as error:
        return replace(found, failure=error)
    except MemoryError:
        return replace(found, failure=_out_of_memory(work))
    return replace(found, worst_files=worst_files(work.folder))


def _out_of_memory(work: SearchJob) -> StoreError:
    """Return the remark for a search that cannot go on in this process; its generations are stored."""
    return StoreError(
        f"the search in `{work.folder}` takes more memory than there is",
        f"free some memory, then go on with `cortexc resume {as_argument(work.folder)}`: what was written is kept",
    )


def _note_failures(path: Path, recorder: "Recorder | None") -> None:
    """Keep in words where a controller failed."""
    if recorder is not None and recorder.failures:
        with store_errors(path), path.open("a", encoding="utf-8") as file:
            file.writelines(f"{failure}\n" for failure in recorder.failures)
        recorder.failures.clear()


def _recorded(work: SearchJob, record: Record | None) -> "tuple[SearchJob, Recorder | None]":
    """Return the work with a recorder of a controller's decisions, if one drives."""
    driver = work.scenario.config.driver
    if driver is None:
        return work, None
    from engine.driving.decisions import Recorder

    recorder = Recorder(driver, known=set(record.actions) if record else set())
    return replace(work, scenario=work.scenario.driven_by(recorder)), recorder


def campaign_of(work: SearchJob, record: Record | None) -> Campaign:
    """The search itself, from its beginning or from where its journal ends."""
    manifest, driver = work.manifest, work.scenario.config.driver
    config = replace(manifest.config, driver=driver)
    if driver is not None and not driver.can_drive_new_scenes:
        config = replace(config, search=replace(config.search, probes=0))
    try:
        return search(
            work.scenario.program,
            manifest.method,
            config,
            manifest.profile,
            work.on_generation,
            past=_past(record, manifest),
            workers=work.workers,
            objective=work.objective or manifest.objective,
        )
    except ForeignPastError as error:
        raise _foreign(work, error) from error


def _past(record: Record | None, manifest: Manifest) -> Past:
    if record is None or not len(record.evaluations):
        return Past(number=manifest.method_number)
    return Past(record.past(), record.spent, manifest.method_number, record.evaluations)


def _foreign(work: SearchJob, error: ForeignPastError) -> StoreError:
    """Return the remark for a journal that does not follow from its own beginning."""
    changed = changed_versions(work.manifest)
    what = f"generation {error.generation} in the journal of `{work.folder}` is not the one that follows here"
    if changed:
        return StoreError(what, f"use the versions that it was started with: {', '.join(changed)}")
    return StoreError(
        what, f"start the search again; {work.manifest.method} does not repeat itself, or the file is damaged"
    )


@dataclass(frozen=True)
class KeptFiles:
    """The imported files of a manifest, as a compiler asks for them (see `cortex_dsl.files.Files`)."""

    origin: Origin
    folder: Path
    """The run's."""

    def find(self, importer: str, paths: Sequence[str]) -> str | None:
        links = (link for link in self.origin.links if (link.importer, link.path) == (importer, paths[0]))
        name = next((link.name for link in links), None)
        maps = {link.importer for link in self.origin.links if link.path == DIGEST}
        return located(self.folder, name) if name in maps else name

    def read(self, name: str) -> Source:
        for file in self.origin.imports:
            if file.name == name:
                return Source(name, file.text)
        raise FileNotFoundError(ENOENT, "the journal does not hold its text", name)

    def identity(self, name: str) -> str:
        return name

    def beside(self, importer: str, path: str) -> list[str]:  # noqa: ARG002 - for cures of spelling; a journal has none
        return []


def origin_of(scenario: Searchable) -> Origin:
    """Return the part of a manifest on the origin of a scenario, except its main text."""
    compiled = scenario.compiled
    imports = tuple(Text(file.name, file.text) for file in compiled.source.imported)
    links = (*_links(compiled), *_map_links(compiled))
    return Origin(imports, links, dict(scenario.overrides), scenario.chosen)


def _map_links(compiled: Compiled) -> Iterator[Link]:
    """Yield the path of the map file and the digest of its contents."""
    spec = compiled.program.road_spec
    if isinstance(spec, MapFile):
        yield Link(compiled.source.name, spec.file, spec.path)
        yield Link(spec.path, DIGEST, spec.digest)


def _links(compiled: Compiled) -> Iterator[Link]:
    """Yield the file of each import statement, of the main file and of all others."""
    modules: dict[str, nodes.Module] = {compiled.source.name: compiled.module}
    modules |= {file.name: file.module for file in compiled.imports.values()}
    for importer, module in modules.items():
        for statement in import_statements(module):
            if statement.span in compiled.imports:
                yield Link(importer, _first_path(statement), compiled.imports[statement.span].name)


def _first_path(node: nodes.Import | nodes.ImportFrom) -> str:
    return node.path if node.quoted else node.path.replace(".", "/") + ".scn"


def check_map(folder: Path, manifest: Manifest) -> None:
    """Refuse to continue a run on another road.

    Raises:
        StoreError: the file of the map is gone, or holds something else.
    """
    for path, digest in ((link.importer, link.name) for link in manifest.origin.links if link.path == DIGEST):
        try:
            found = digest_of(Path(located(folder, path)))
        except OSError:
            found = "none, for it is not there"
        if found != digest:
            raise StoreError(
                f"`{folder}` was found on the roads of {path} with the digest {digest}, which is {found} now",
                "put that file back: another road is another search",
            )
