"""A search that keeps what it finds: journal, tables and worst cases in a run directory, and how it goes on later.

    >>> from cortex_dsl.hunting import hunt, resume
    >>> found = hunt(scenario, "niching", new_directory(Path("runs/mine")))
    >>> found = resume("runs/mine", generations=60)
    >>> found.campaign.distinct_collisions, found.worst_files[0]

`finished` stands in a journal only once everything beside it is in place: whatever ends a process earlier, `resume`
does the rest.
"""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cortex_dsl.runs import OpenedRun, open_run, origin_of
from cortex_dsl.session import Scenario
from engine.search.journal import Journal
from engine.search.journal_reader import Record, read_journal
from engine.search.manifest import Manifest, changed_versions, make_manifest
from engine.search.ranking import Case
from engine.search.result_files import write_exports
from engine.search.run import Campaign, ForeignPastError, OnGeneration, Progress, search
from engine.search.searchers import canonical, find_searcher
from engine.search.store import JOURNAL, RemovedError, StoreError, hold, store_errors
from engine.search.workers import Workers, workers_for

OnRemoved = Callable[[RemovedError], None]
"""Hears, as soon as it is noticed, that a run's folder is gone; the search goes on in memory."""
WORST = "worst"
"""Folder of the concrete scenarios inside a run directory."""


@dataclass(frozen=True)
class Found:
    """What a search came to. What went wrong when it was put away does not keep it from being shown."""

    campaign: Campaign
    folder: Path
    manifest: Manifest
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""
    trouble: StoreError | None = None


@dataclass(frozen=True)
class _Work:
    """One search and where it is kept."""

    scenario: Scenario
    folder: Path
    manifest: Manifest
    on_generation: OnGeneration | None
    on_removed: OnRemoved | None
    workers: Workers


def hunt(
    scenario: Scenario,
    method: str,
    folder: Path,
    *,
    profile: str = "paper",
    command_line: Sequence[str] = (),
    on_generation: OnGeneration | None = None,
    on_removed: OnRemoved | None = None,
    workers: Workers | None = None,
) -> Found:
    """Search a scenario by its own settings, and keep everything in an empty folder.

    Raises:
        StoreError: the folder cannot be written, or another process writes it.
        UnknownMethodError, MissingExtraError, PluginError: there is no such method here.
        WorkersLostError: nobody is there to run simulations, or no longer.
    """
    method, source = canonical(method), scenario.compiled.source
    manifest = make_manifest(
        scenario.program, scenario.config, method, profile, source.name, command_line, origin_of(scenario)
    )
    work = _Work(scenario, folder, manifest, on_generation, on_removed, workers or _workers(scenario))
    with hold(folder), closing(Journal.create(folder / JOURNAL, manifest)) as journal:
        return _carry_out(work, journal)


def resume(
    folder: str | Path,
    *,
    generations: int | None = None,
    on_generation: OnGeneration | None = None,
    on_removed: OnRemoved | None = None,
    workers: Workers | None = None,
) -> Found:
    """Go on with a run that was stopped or killed, to the journal that an undisturbed one would have written.

    `generations`: as many in all as this, more or fewer than the run was started with. Of a finished run nothing is
    written, and nothing simulated but the probes of its genes.

    Raises:
        StoreError: there is no run to go on with, this version would go on otherwise, or another process is at it.
        and as `hunt`.
    """
    return go_on(
        open_run(folder), generations=generations, on_generation=on_generation, on_removed=on_removed, workers=workers
    )


def go_on(
    run: OpenedRun,
    *,
    generations: int | None = None,
    on_generation: OnGeneration | None = None,
    on_removed: OnRemoved | None = None,
    workers: Workers | None = None,
) -> Found:
    """`resume`, of a run that is open already."""
    manifest = run.record.manifest
    longer = _with_generations(run, generations)
    scenario = replace(run.scenario, config=longer.config)
    work = _Work(scenario, run.folder, longer, on_generation, on_removed, workers or _workers(scenario))
    if run.record.status == "finished" and longer == manifest:
        campaign = replace(_search(work, run.record), elapsed=run.record.seconds)
        return Found(campaign, run.folder, manifest, _worst_files(run.folder))
    with hold(run.folder):
        record = read_journal(run.folder / JOURNAL)  # as nobody can change it any more
        with closing(Journal.reopen(run.folder / JOURNAL, longer)) as journal:
            return _carry_out(work, journal, record)


def _workers(scenario: Scenario) -> Workers:
    search = scenario.config.search
    return workers_for(search.engine, search.jobs)


def _with_generations(run: OpenedRun, generations: int | None) -> Manifest:
    """The manifest of the run as it is to end."""
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


def _carry_out(work: _Work, journal: Journal, record: Record | None = None) -> Found:
    """Search, with every generation written as it ends; then put everything in its place."""
    heard = work.on_generation

    removed: list[RemovedError] = []

    def on_generation(progress: Progress) -> None:
        try:
            if not removed:
                journal.write(progress)
        except RemovedError as error:
            removed.append(error)
            if work.on_removed is not None:
                work.on_removed(error)
        if heard is not None:
            heard(progress)

    campaign = _search(replace(work, on_generation=on_generation), record)
    found = Found(campaign, work.folder, work.manifest)
    if removed:
        return replace(found, trouble=removed[0])
    try:
        journal.complete(campaign)
        write_exports(work.folder, campaign, work.manifest)
        files = _write_worst(work, campaign)
        journal.finish(campaign)
    except StoreError as error:
        return replace(found, trouble=error)
    return replace(found, worst_files=files)


def _search(work: _Work, record: Record | None) -> Campaign:
    manifest = work.manifest
    try:
        return search(
            work.scenario.program,
            manifest.method,
            manifest.config,
            manifest.profile,
            work.on_generation,
            past=record.past() if record else (),
            spent=record.spent if record else 0.0,
            workers=work.workers,
            number=manifest.method_number,
        )
    except ForeignPastError as error:
        raise _foreign(work, error) from error


def _foreign(work: _Work, error: ForeignPastError) -> StoreError:
    """What to say where the journal does not follow from its own beginning."""
    changed = changed_versions(work.manifest)
    what = f"generation {error.generation} in the journal of `{work.folder}` is not the one that follows here"
    if changed:
        return StoreError(what, f"use the versions that it was started with: {', '.join(changed)}")
    return StoreError(
        what, f"start the search again; {work.manifest.method} does not repeat itself, or the file is damaged"
    )


def _worst_files(folder: Path) -> list[Path]:
    return sorted((folder / WORST).glob("[0-9][0-9].scn"))


def _write_worst(work: _Work, campaign: Campaign) -> list[Path]:
    """The worst cases, and none of those that were the worst before the run went on."""
    files = [_write_case(work, case) for case in campaign.worst]
    with store_errors(work.folder / WORST):
        for path in set(_worst_files(work.folder)) - set(files):
            path.unlink()
    return files


def _write_case(work: _Work, case: Case) -> Path:
    """One of the worst as a scenario that runs to the same outcome."""
    remark = f"case {case.rank} of a search in {work.manifest.file}: risk {case.score}"
    path = work.folder / WORST / f"{case.rank:02d}.scn"
    files = work.scenario.concrete_files(work.scenario.scene(case), remark=remark, name=path.name)
    with store_errors(path):
        path.parent.mkdir(exist_ok=True)
        for name, text in files.items():
            path.with_name(name).write_text(text, encoding="utf-8")
    return path
