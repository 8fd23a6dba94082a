"""Files of a run that follow from its journal: tables, summary, guide and cases.

They are a pure function of the journal, whose last link they carry. So a run whose files were lost, changed, or written
before an interruption gets the right ones again, and `cortexc verify` can compare them.
"""

from collections.abc import Mapping
from pathlib import Path

from cortex_dsl.api.case_files import Writable, case_files, stale_cases
from engine.search.campaign import Campaign
from engine.search.manifest import Manifest
from engine.search.result_files import result_files
from engine.search.store import store_errors


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
