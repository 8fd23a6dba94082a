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
from cortex_dsl.api.derived_files import worst_files
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
from engine.driving.names import driver_hint
from engine.errors import whole
from engine.search.campaign import OnGeneration
from engine.search.journal import Journal
from engine.search.journal_reader import Record, read_again
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
    """Continue a run that was stopped or killed, to the journal that an undisturbed run would have.

    `objective`: the objective of the run, which is known except for functions: these must be given again, under the
    same name.

    `ego`: the driver of the run, which must be named again.

    `generations`: total number, more or fewer than at the start of the run. For a finished run nothing is written, and
    only the probes of its genes are simulated.

    Raises:
        StoreError: there is no run to continue, this version would continue differently, or another process writes it.
        and as `search_and_keep`.
    """
    generations = None if generations is None else whole("generations", generations, 0)
    callback("on_generation", on_generation)
    callback("on_removed", on_removed)
    with reopened(open_run(folder, ego), generations, objective) as rest:
        return rest.carry_out(on_generation=on_generation, on_removed=on_removed, workers=workers)


@dataclass(frozen=True)
class RemainingWork:
    """Remaining work of a run. Without a journal: none, it is finished."""

    run: OpenedRun
    manifest: Manifest
    """Manifest of the run at its end."""
    journal: Journal | None = None
    record: Record | None = None
    """Contents of the journal."""
    objective: tuple[ObjectiveSpec, ...] = ()
    """Objectives of the run."""

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
        if campaign.status != self.run.record.status:  # its analysis was interrupted
            return found
        try:
            restore(self.run, campaign)
        except StoreError as error:
            return replace(found, failure=error)
        return replace(found, worst_files=worst_files(folder))


@contextmanager
def reopened(
    run: OpenedRun, generations: int | None = None, objective: ObjectiveSpec | Sequence[ObjectiveSpec] | None = None
) -> Iterator[RemainingWork]:
    """Lock an unfinished run while the block continues it, if nothing prevents that.

    Raises:
        StoreError: it has another objective, cannot have this length, its driver is not named, another process writes
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
        record = read_again(run.folder / JOURNAL, run.record)  # under the lock no process can change it any more
        with closing(Journal.reopen(run.folder / JOURNAL, longer)) as journal:
            yield RemainingWork(run, longer, journal, record, aims)


def _insist_on_driver(run: OpenedRun) -> None:
    """Refuse early to continue a run if only recorded decisions drive."""
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
