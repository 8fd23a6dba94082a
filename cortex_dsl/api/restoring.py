"""Files next to the journal of a run, or next to a study: compared with it, and restored (`derived_files`)."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from cortex_dsl.api.derived_files import (
    REMARKS,
    WITH_CHECKSUM,
    Difference,
    checked_checksums,
    derived_files,
    differing,
    write_derived,
)
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.plain_text import as_argument
from engine.atomic import Content
from engine.search.campaign import FINISHED, INTERRUPTED, STOPPED, Campaign
from engine.search.insight.kinds import collisions_of
from engine.search.journal import Journal
from engine.search.journal_reader import read_journal
from engine.search.run import Task, summarize
from engine.search.store import JOURNAL, hold
from engine.study.database import Study, is_study, read_study
from engine.study.study_files import study_files
from engine.study.verdict import Findings, findings

SUMMARY = "summary.json"


def campaign_of_journal(run: OpenedRun, status: str) -> Campaign:
    """Return the campaign of a run from its journal alone, with the given status; see `summarize`.

    Raises:
        KeyboardInterrupt: the analysis was interrupted.
    """
    from engine.risk import PROFILES
    from engine.search.evaluator import make_evaluator

    record, program, config = run.record, run.scenario.program, run.scenario.config
    manifest = record.manifest
    search = manifest.config.search
    if _only_repeats(run):
        search = replace(search, probes=0)
    task = Task(
        program.space,
        make_evaluator(program, config, PROFILES[manifest.profile], ()),
        search,
        manifest.method,
        manifest.preset,
        manifest.objective,
        lambda _genomes, _keys: run.blame[collisions_of(record.evaluations)],
    )
    campaign = summarize(task, record.evaluations, record.generations, status)
    if campaign.status != status:
        raise KeyboardInterrupt
    return replace(campaign, elapsed=record.seconds)


def compared(run: OpenedRun) -> tuple[dict[str, Difference | None], list[str]]:
    """Compare the files of a run with those that follow from its journal: return how each differs, None for not at all,
    and remarks on those that could not be compared.

    Raises:
        StoreError: a file cannot be read.
    """
    found, remarks = _checked(run.folder, run.record.links)
    if not _is_written(run):
        why = "the run is not finished" if run.record.proved else "an earlier version wrote them"
        return found, [*remarks, f"the files that are derived from the journal are not compared: {why}"]
    files, remark = _files_of(run, campaign_of_journal(run, run.record.status))
    derived = dict.fromkeys(files) | differing(run.folder, files)
    return found | derived, [*remarks, remark] if remark else remarks


def _checked(folder: Path, links: Sequence[str]) -> tuple[dict[str, Difference | None], list[str]]:
    """Return how each file with a checksum differs, and remarks on those that are not damaged for all that."""
    found = checked_checksums(folder, links)
    named = [name for name, difference in found.items() if difference in REMARKS]
    return found, [_remark(folder, name, found.pop(name)) for name in named]


def _remark(folder: Path, name: str, difference: Difference | None) -> str:
    cure = f"; {WITH_CHECKSUM[name].format(as_argument(folder))}" if difference is Difference.OUTDATED else ""
    return f"`{name}` {difference}{cure}"


def outdated(folder: Path, links: Sequence[str] | None = None) -> list[str]:
    """Return a remark on each file that was made from an earlier state of the journal or the study beside it.

    `links` are those of the journal, or the seals of the study, where they are known; None: they are read.

    Raises:
        StoreError: there is no readable run or study, or a file cannot be read.
    """
    if not any((folder / name).exists() for name in WITH_CHECKSUM):
        return []
    if links is None:
        links = read_study(folder).seals if is_study(folder) else read_journal(folder / JOURNAL).links
    found = checked_checksums(folder, links).items()
    return [_remark(folder, name, difference) for name, difference in found if difference is Difference.OUTDATED]


def compared_study(study: Study) -> tuple[dict[str, Difference | None], list[str]]:
    """Compare the files of a study with those that follow from it, as `compared` does for a run.

    Raises:
        StoreError: a file cannot be read.
    """
    found, remarks = _checked(study.folder, study.seals)
    if not study.proved:
        return found, [*remarks, "the tables of the study are not compared: an earlier version wrote them"]
    files = study_files(study, findings(study.plan, study.records))
    return found | dict.fromkeys(files) | differing(study.folder, files), remarks


def restore_study(study: Study, found: Findings) -> Collection[str]:
    """Write the tables of a study that do not follow from it and its findings; return their names.

    Raises:
        StoreError: a file cannot be written.
    """
    return write_derived(study.folder, study_files(study, found))


def restore(run: OpenedRun, campaign: Campaign | None = None, *, tables: bool = False) -> Collection[str]:
    """Restore the files of a run that do not follow from its journal; return their names.

    `campaign` is that of the finished run, if it is known. `tables`: the text tables of a large search, too. A run with
    an interrupted analysis is analysed now.

    Raises:
        StoreError: a file cannot be written, or another process writes the run.
    """
    record = run.record
    if not _is_written(run):
        return []
    if campaign is None:
        whole = len(record.generations) == record.manifest.config.search.generations
        ended = (FINISHED if whole else STOPPED) if record.status == INTERRUPTED else record.status
        campaign = campaign_of_journal(run, ended)
    files, _ = _files_of(run, campaign, tables=tables)
    if not differing(run.folder, files):
        return []
    with hold(run.folder):
        names = write_derived(run.folder, files)
        if campaign.status != record.status:
            Journal.reopen(run.folder / JOURNAL).finish(campaign)
    return names


def _is_written(run: OpenedRun) -> bool:
    """Return whether a run has ended, with files of a version that has a chain."""
    return run.record.proved and run.record.status in (FINISHED, STOPPED, INTERRUPTED)


def _files_of(run: OpenedRun, campaign: Campaign, *, tables: bool = False) -> tuple[dict[str, Content], str]:
    files = derived_files(run.scenario, campaign, run.record.manifest, run.record.link, run.folder, tables=tables)
    if _only_repeats(run):
        del files[SUMMARY]
        driver = run.scenario.config.driver
        return files, f"`{SUMMARY}` is not compared: `{driver.name if driver else ''}` is needed to probe genes"
    return files, ""


def _only_repeats(run: OpenedRun) -> bool:
    """Return whether only recorded decisions drive, so that the scenes that probe genes cannot be driven."""
    driver = run.scenario.config.driver
    return driver is not None and not driver.can_drive_new_scenes
