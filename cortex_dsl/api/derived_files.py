"""Files that follow from a journal or from a study: tables, summary, guide, and cases as scenarios.

They are a pure function of the journal, and contain its last link. So a run with files that were lost, changed, or
written before an interruption gets the right ones again, and `cortexc verify` can compare them. Other files of a folder
take minutes to compute, or depend on options: a page and the answers of `probability` and `verify --model dynamic`.
They contain a checksum of themselves (`engine.checksums`). A page and the answers of `verify` also contain the link of
their journal; estimates do not, as they depend on the program alone, and contain its digest.
"""

import os
from collections.abc import Collection, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from cortex_dsl.api.concrete import map_copies
from engine.atomic import Content, standing, write_one
from engine.checksums import has_checksum, is_unchanged, journal_of
from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign
from engine.search.manifest import Manifest
from engine.search.probability.estimates import FILE_NAME as ESTIMATES
from engine.search.ranking import Case, lost_cases
from engine.search.result_files import TABLES, result_files
from engine.search.store import StoreError, store_errors

if TYPE_CHECKING:
    from engine.scenes import Scenes


# -- cases as scenarios of their own -----------------------------------------------------------------------------------


WORST_FOLDER, FAILURE_FOLDER = "worst", "failures"


class Writable(Protocol):
    """Interface of a scenario that writing a case uses."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...
    def scene(self, case: Case) -> "Scenes": ...
    def driven_by(self, ego: object, /) -> "Writable": ...
    def concrete_files(self, scenes: "Scenes", row: int = 0, remark: str = "", name: str = "") -> dict[str, str]: ...


CASE = "[0-9][0-9].scn"


def worst_files(folder: Path) -> list[Path]:
    """Return the scenarios of the worst cases, in their order."""
    return sorted((folder / WORST_FOLDER).glob(CASE))


def stale_cases(folder: Path, files: Mapping[str, Content]) -> list[Path]:
    """Return cases that are there from before the run went on, and are none of these files."""
    found = (path for name in (WORST_FOLDER, FAILURE_FOLDER) for path in (folder / name).glob(CASE))
    return [path for path in found if f"{path.parent.name}/{path.name}" not in files]


def case_files(scenario: Writable, campaign: Campaign, file: str, link: str) -> dict[str, bytes]:
    """Return the cases of a search in `file` as scenarios, by paths relative to the run's folder; `link` is the last of
    the journal's chain.
    """
    # a driver that drives again decides anew
    undriven = scenario if scenario.config.driver is None else scenario.driven_by(None)
    cases = ((FAILURE_FOLDER, lost_cases(campaign.evaluations)), (WORST_FOLDER, campaign.worst))
    copies = map_copies(scenario.program)
    files: dict[str, bytes] = {}
    for folder, chosen in cases:
        for case in chosen:
            files |= {f"{folder}/{name}": text for name, text in _case(undriven, case, file, link).items()}
        if chosen:
            files |= {f"{folder}/{name}": content for name, content in copies.items()}
    return files


def _case(scenario: Writable, case: Case, file: str, link: str) -> dict[str, bytes]:
    what = "the driver failed" if case.lost else f"risk {case.score}"
    remark = f"case {case.rank} of a search in {file}: {what}" + (f"\njournal {link}" if link else "")
    files = scenario.concrete_files(scenario.scene(case), remark=remark, name=f"{case.rank:02d}.scn")
    return {name: text.encode() for name, text in files.items()}


def derived_files(
    scenario: Writable, campaign: Campaign, manifest: Manifest, link: str, folder: Path, *, tables: bool = False
) -> dict[str, Content]:
    """Return every such file of a run in `folder`, by its path relative to that.

    Text tables of a large search belong to them if the search or the caller (`tables`) requests them, and where they
    exist already.
    """
    files = {**result_files(campaign, manifest, link), **case_files(scenario, campaign, manifest.file, link)}
    if tables or manifest.has_tables:
        return files
    return {name: files[name] for name in files if name not in TABLES or os.path.lexists(folder / name)}


PAGE, VERIFICATION = "report.html", "verification.json"
AUDIT_PAGE, AUDIT = "audit.html", "audit.json"
WITH_CHECKSUM: Mapping[str, str] = {
    PAGE: "`cortexc report {}` writes the page again",
    ESTIMATES: "remove the estimates; `cortexc probability {}` estimates again",
    VERIFICATION: "`cortexc verify {} --model dynamic` asks for the second opinion again",
    AUDIT_PAGE: "`cortexc report {} --audit` writes the page again",
    AUDIT: "`cortexc report {} --audit` writes the page again",
}
"""Files that contain a checksum of themselves, and the cure for a wrong one."""


class Difference(StrEnum):
    """Difference between a file and the correct one."""

    CHANGED = "is changed"
    MISSING = "is missing"
    SURPLUS = "is no case of this run"
    FOREIGN = "was made from another journal"
    OUTDATED = "was made from an earlier state of the journal"
    UNMARKED = "is not compared: it has no checksum, as files of earlier versions"


REMARKS = (Difference.OUTDATED, Difference.UNMARKED)
"""Differences that are no damage."""


def differing(folder: Path, files: Mapping[str, Content]) -> dict[str, Difference]:
    """Return the files that are missing, hold something else, or should not be there, by their relative paths.

    Raises:
        StoreError: a file cannot be read.
    """
    with store_errors(folder):
        there = standing(folder, files)
        found = {
            name: Difference.CHANGED if name in there.other else Difference.MISSING
            for name in files
            if name not in there.same
        }
        surplus = (f"{path.parent.name}/{path.name}" for path in stale_cases(folder, files))
        return found | dict.fromkeys(surplus, Difference.SURPLUS)


def checked_checksums(folder: Path, links: Sequence[str]) -> dict[str, Difference | None]:
    """Return how each file that contains a checksum differs, None if it does not.

    `links` are those of the journal in all its states, the last one at the end.

    Raises:
        StoreError: a file cannot be read.
    """
    with store_errors(folder):
        files = {name: (folder / name).read_bytes() for name in WITH_CHECKSUM if (folder / name).exists()}
    return {name: _fault(content, links) for name, content in files.items()}


def _fault(content: bytes, links: Sequence[str]) -> Difference | None:
    if not has_checksum(content):
        return Difference.UNMARKED
    if not is_unchanged(content):
        return Difference.CHANGED
    if (journal := journal_of(content)) in ("", *links[-1:]):
        return None
    return Difference.OUTDATED if journal in links else Difference.FOREIGN


def refusal(folder: Path, differences: Mapping[str, Difference]) -> StoreError:
    """Return the error that names every file of a folder that differs, with the commands that write them again."""
    cures = list(dict.fromkeys(cure.format(folder) for name, cure in WITH_CHECKSUM.items() if name in differences))
    if any(name not in WITH_CHECKSUM for name in differences):
        surplus = " and removes what is no case of it" if Difference.SURPLUS in differences.values() else ""
        cures.insert(0, f"`cortexc report {folder}` writes the derived files again{surplus}")
    return StoreError(
        ", ".join(f"`{folder / name}` {difference}" for name, difference in differences.items()),
        f"{'; '.join(cures)}; keep a copy elsewhere of what was changed on purpose",
    )


def write_derived(folder: Path, files: Mapping[str, Content]) -> Collection[str]:
    """Write the files that differ, each as a whole, remove stale ones, and return the names of both.

    Raises:
        StoreError: a file cannot be written.
    """
    names = differing(folder, files)
    for name in names:
        path = folder / name
        with store_errors(path):
            if name in files:
                path.parent.mkdir(exist_ok=True)
                write_one(path, files[name])
            else:
                path.unlink(missing_ok=True)
    return names
