"""The user's cache of reproducible data: the parser's tables and compiled kernels. It imports no large module."""

import contextlib
import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

ENVIRONMENT_VARIABLE = "CORTEXC_CACHE"
MAX_OTHERS = 8
"""Number of entries of other versions that stay: several checkouts may share one user's cache."""
IN_USE = 600.0
"""Time since its last use within which an entry is never removed [s]: another process may be writing it."""
ROOM = 65536
"""Bytes that must fit into a folder: on a full disk an empty file can still be created."""


def cache_roots() -> Iterator[Path]:
    """Yield the folders to try: `$CORTEXC_CACHE`, then `cortexc` in the user's cache. They need not exist."""
    if chosen := os.environ.get(ENVIRONMENT_VARIABLE):
        yield Path(chosen)
    if base := os.environ.get("XDG_CACHE_HOME"):
        yield Path(base) / "cortexc"
    with contextlib.suppress(RuntimeError):  # no home directory
        yield Path.home() / ".cache" / "cortexc"


def is_writable(folder: Path) -> bool:
    """Return True if files can be written in a folder; it is created, and marked as used now."""
    import tempfile

    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(ROOM))
        os.utime(folder)
    except OSError:
        return False
    return True


def is_ours(folder: Path) -> bool:
    """Return True if no other user made or may write this folder: compiled kernels in it are code that will be run."""
    status = folder.lstat()
    return not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o022)


def fingerprint(paths: Iterable[Path]) -> str:
    """Return a digest of the contents of these files and those of these folders; size and date could be equal."""
    from hashlib import sha256

    files = (file for path in paths for file in (sorted(path.glob("*.py")) if path.is_dir() else [path]))
    reported = (f"{file.name} {sha256(file.read_bytes()).hexdigest()}" for file in files)
    return sha256("\0".join(reported).encode()).hexdigest()


def cached_file(name: str, family: str) -> Path | None:
    """Return the path of a file of the cache, existing or writable; None if there is none. `family`: pattern of its
    kind.

    If it is not there yet, old unused files of its kind are removed.
    """
    for root in cache_roots():
        if _marked_as_used(root / name):
            return root / name
        if is_writable(root):
            remove_old(root, family, root / name)
            return root / name
    return None


def _marked_as_used(path: Path) -> bool:
    """Return True if a file exists and can be marked as used."""
    try:
        os.utime(path)
    except OSError:
        return False
    return True


def remove_old(root: Path, family: str, current: Path) -> None:
    """Remove the entries of a family except the most recently used ones and those in use."""
    with contextlib.suppress(OSError):
        others = [(path.stat().st_mtime, path) for path in root.glob(family) if path != current]
        for used, path in sorted(others, reverse=True)[MAX_OTHERS:]:
            if time.time() - used > IN_USE:
                _remove(path)


def _remove(path: Path) -> None:
    import shutil

    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
