"""Files of a run that follow from its journal: tables, summary, guide and cases.

They are a pure function of the journal, whose last link they carry. So a run whose files were lost, changed, or written
before an interruption gets the right ones again, and `cortexc verify` can compare them.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.api.case_files import Writable, case_files, stale_cases
from engine.search.campaign import FINISHED, INTERRUPTED, STOPPED, Campaign
from engine.search.journal import Journal
from engine.search.manifest import Manifest
from engine.search.result_files import result_files
from engine.search.run import summarize
from engine.search.store import JOURNAL, hold, store_errors

if TYPE_CHECKING:
    from cortex_dsl.api.runs import OpenedRun

SUMMARY = "summary.json"


def derived_files(scenario: Writable, campaign: Campaign, manifest: Manifest, link: str) -> dict[str, bytes]:
    """Return every such file of a run, by its path relative to the run's folder."""
    return {**result_files(campaign, manifest, link), **case_files(scenario, campaign, manifest.file, link)}


def differing(folder: Path, files: Mapping[str, bytes]) -> list[str]:
    """Return the names of files that are missing, hold something else, or should not be there.

    Raises:
        StoreError: a file cannot be read.
    """
    with store_errors(folder):
        changed = [name for name, content in files.items() if not _holds(folder / name, content)]
        return [*changed, *(f"{path.parent.name}/{path.name}" for path in stale_cases(folder, files))]


def write_derived(folder: Path, files: Mapping[str, bytes]) -> list[str]:
    """Write the files that differ, remove stale ones, and return the names of both.

    Raises:
        StoreError: a file cannot be written.
    """
    names = differing(folder, files)
    for name in names:
        path = folder / name
        with store_errors(path):
            if name in files:
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(files[name])
            else:
                path.unlink(missing_ok=True)
    return names


def _holds(path: Path, content: bytes) -> bool:
    return path.is_file() and path.stat().st_size == len(content) and path.read_bytes() == content


# -- of a run that is opened -------------------------------------------------------------------------------------------


def campaign_of_journal(run: "OpenedRun", status: str) -> Campaign:
    """Return what a run came to by its journal alone, which ended with this status; see `summarize`."""
    from engine.risk import PROFILES
    from engine.search.evaluator import make_blaming, make_evaluator

    record, program, config = run.record, run.scenario.program, run.scenario.config
    manifest = record.manifest
    campaign = summarize(
        program.space,
        make_evaluator(program, config, PROFILES[manifest.profile], ()),
        manifest.config.search,
        manifest.method,
        manifest.preset,
        list(zip(record.past(), record.generations, strict=True)),
        make_blaming(program, config),
        status,
    )
    return replace(campaign, objective=manifest.objective, elapsed=record.seconds)


def compared(run: "OpenedRun") -> tuple[list[str], list[str], str]:
    """Compare the files of a run with those that follow from its journal: return the names that were compared, those of
    them that differ, and why some could not be compared, if so.

    Raises:
        StoreError: a file cannot be read.
    """
    if not _is_written(run):
        why = "the run is not finished" if run.record.proved else "an earlier version wrote them"
        return [], [], f"the files beside the journal are not compared: {why}"
    files, remark = _files_of(run, campaign_of_journal(run, run.record.status))
    return list(files), differing(run.folder, files), remark


def restore(run: "OpenedRun") -> list[str]:
    """Write the files of a run again where they are not those that follow from its journal; return their names. A run
    whose analysis was interrupted is analysed now.

    Raises:
        StoreError: a file cannot be written, or another process writes the run.
    """
    record = run.record
    if not _is_written(run):
        return []
    whole = len(record.generations) == record.manifest.config.search.generations
    ended = (FINISHED if whole else STOPPED) if record.status == INTERRUPTED else record.status
    campaign = campaign_of_journal(run, ended)
    files, _ = _files_of(run, campaign)
    if not differing(run.folder, files):
        return []
    with hold(run.folder):
        names = write_derived(run.folder, files)
        if campaign.status not in (record.status, INTERRUPTED):
            Journal.reopen(run.folder / JOURNAL).finish(campaign)
    return names


def _is_written(run: "OpenedRun") -> bool:
    """Whether the files of a run are there, written by a version with a chain."""
    return run.record.proved and run.record.status in (FINISHED, STOPPED, INTERRUPTED)


def _files_of(run: "OpenedRun", campaign: Campaign) -> tuple[dict[str, bytes], str]:
    files = derived_files(run.scenario, campaign, run.record.manifest, run.record.link)
    driver = run.scenario.config.driver
    if driver is not None and not driver.anew:
        del files[SUMMARY]
        return files, f"`{SUMMARY}` is not compared: `{driver.name}` is needed to probe genes"
    return files, ""
