"""Going on with a run on disk that was stopped or killed, or making it longer.

>>> import cortex_dsl as cx
>>> cx.resume("runs/left_turn-ga-001", generations=60).campaign.distinct_collisions
"""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cortex_dsl.api.arguments import callback, objectives_of
from cortex_dsl.api.case_files import worst_files
from cortex_dsl.api.restoring import restore
from cortex_dsl.api.run_folder import (
    OnRemoved,
    SearchJob,
    SearchResult,
    campaign_of,
    carry_out,
    default_workers,
    same_objective,
)
from cortex_dsl.api.runs import OpenedRun, open_run
from engine.arguments import whole
from engine.driving.names import driver_hint
from engine.search.campaign import OnGeneration
from engine.search.journal import Journal
from engine.search.journal_reader import Record, read_journal
from engine.search.manifest import Manifest
from engine.search.protocol import ObjectiveSpec
from engine.search.store import JOURNAL, StoreError, hold
from engine.search.workers import Workers


def resume(
    folder: str | Path,
    *,
    generations: int | None = None,
    on_generation: OnGeneration | None = None,
    on_removed: OnRemoved | None = None,
    workers: Workers | None = None,
    objective: ObjectiveSpec | Sequence[ObjectiveSpec] | None = None,
    ego: object = None,
) -> SearchResult:
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
class RemainingWork:
    """What is left to do of a run. Without a journal: nothing, it is finished."""

    run: OpenedRun
    manifest: Manifest
    """Of the run as it is to end."""
    journal: Journal | None = None
    record: Record | None = None
    """What the journal holds."""
    objective: tuple[ObjectiveSpec, ...] = ()
    """What the run looks for."""

    def carry_out(
        self,
        *,
        on_generation: OnGeneration | None = None,
        on_removed: OnRemoved | None = None,
        workers: Workers | None = None,
    ) -> SearchResult:
        """Search to the end, or only report a run that is finished."""
        config = replace(self.manifest.config, driver=self.run.scenario.config.driver)
        folder, scenario = self.run.folder, replace(self.run.scenario, config=config)
        workers = workers or default_workers(scenario)
        work = SearchJob(scenario, folder, self.manifest, on_generation, on_removed, workers, self.objective)
        if self.journal is not None and self.record is not None:
            return carry_out(work, self.journal, self.record)
        campaign = replace(campaign_of(work, self.run.record), elapsed=self.run.record.seconds)
        found = SearchResult(campaign, folder, self.manifest, worst_files(folder))
        try:
            restore(self.run)
        except StoreError as error:
            return replace(found, failure=error)
        return replace(found, worst_files=worst_files(folder))


@contextmanager
def reopened(
    run: OpenedRun, generations: int | None = None, objective: ObjectiveSpec | Sequence[ObjectiveSpec] | None = None
) -> Iterator[RemainingWork]:
    """Hold an open run for as long as the block goes on with it, once nothing stands against that.

    Raises:
        StoreError: it looks for something else, cannot be made so long, its driver is not named, another process is at
            it, or its folder cannot be written.
    """
    longer = _with_generations(run, generations)
    given = None if objective is None else objectives_of(run.scenario.program, objective)
    aims = same_objective(run.folder, run.scenario.program, longer, given)
    if run.record.status == "finished" and longer == run.record.manifest:
        yield RemainingWork(run, longer, objective=aims)
        return
    _insist_on_driver(run)
    with hold(run.folder):
        record = read_journal(run.folder / JOURNAL)  # read again under the lock: no process can change it any more
        with closing(Journal.reopen(run.folder / JOURNAL, longer)) as journal:
            yield RemainingWork(run, longer, journal, record, aims)


def _insist_on_driver(run: OpenedRun) -> None:
    """Refuse to go on where only kept decisions drive, before anything is done."""
    driver = run.scenario.config.driver
    if driver is not None and not driver.can_drive_new_scenes:
        raise StoreError(
            f"`{driver.name}` drove in `{run.folder}`, and drives on in it",
            driver_hint(driver.name),
        )


def _with_generations(run: OpenedRun, generations: int | None) -> Manifest:
    """Return the manifest of the run with so many generations."""
    manifest, done = run.record.manifest, len(run.record.generations)
    settings: dict[str, Any] = manifest.settings
    if generations is None or generations == settings["search"]["generations"]:
        return manifest
    if generations < done:
        raise StoreError(f"`{run.folder}` has {done} generations already", f"give --generations {done} or more")
    return replace(manifest, settings={**settings, "search": {**settings["search"], "generations": generations}})
