"""Files written all or not at all: first under other names, then each is put in its place at once."""

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Standing:
    """What stands in the place of files that are to be written."""

    same: frozenset[str]
    """Names of files that already hold what would be written."""
    other: tuple[str, ...]
    """Names of files that hold something else."""


def standing(folder: Path, files: Mapping[str, bytes]) -> Standing:
    """Compare a folder, which need not be there, with what is to be written into it.

    Raises:
        OSError: something is there that cannot be read, such as a folder of a file's name.
    """
    same, other = [], []
    for name, content in files.items():
        path = folder / name
        if os.path.lexists(path):
            (same if path.read_bytes() == content else other).append(name)
    return Standing(frozenset(same), tuple(other))


def write_all(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder, which is made if it is not there. Where one cannot be written, none is.

    Raises:
        OSError: with the path that could not be written; no half of a file is left, nor a folder that was made for it.
    """
    made = _make(folder)
    waiting = {name: folder / f".{name[:100]}.{os.getpid()}.part" for name in files}
    try:
        for name, content in files.items():
            _write(waiting[name], content)
        for name, path in waiting.items():
            path.replace(folder / name)
    except BaseException:
        for path in waiting.values():
            with suppress(OSError):
                path.unlink(missing_ok=True)
        for path in made:
            with suppress(OSError):  # not empty: somebody else uses it by now
                path.rmdir()
        raise


def _write(path: Path, content: bytes) -> None:
    """Through to the disk: a full one says so here, and not when the name is taken already."""
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _make(folder: Path) -> list[Path]:
    """Make a folder and those above it; the ones that were not there, the innermost first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing
