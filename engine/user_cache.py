"""The user's cache of what can be computed again: the parser's tables and compiled kernels. Imports nothing heavy."""

import contextlib
import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

ENVIRONMENT_VARIABLE = "CORTEXC_CACHE"
KEPT = 8
"""How many entries of other versions stay: several checkouts may share one user's cache."""
IN_USE = 600.0
"""An entry used more recently than this is never removed [s]: another process may be writing it."""
ROOM = 65536
"""Bytes that must fit into a folder: on a full disk an empty file can still be made."""


def cache_roots() -> Iterator[Path]:
    """Folders to try: `$CORTEXC_CACHE`, then `cortexc` in the user's cache. None of them needs to exist."""
    if chosen := os.environ.get(ENVIRONMENT_VARIABLE):
        yield Path(chosen)
    if base := os.environ.get("XDG_CACHE_HOME"):
        yield Path(base) / "cortexc"
    with contextlib.suppress(RuntimeError):  # no home directory
        yield Path.home() / ".cache" / "cortexc"


def is_writable(folder: Path) -> bool:
    """Whether files can be written in a folder; it is made, and marked as used now."""
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
    """A digest of the contents of these files and those of these folders: other code may be as long, and as old."""
    from hashlib import sha256

    files = (file for path in paths for file in (sorted(path.glob("*.py")) if path.is_dir() else [path]))
    told = (f"{file.name} {sha256(file.read_bytes()).hexdigest()}" for file in files)
    return sha256("\0".join(told).encode()).hexdigest()


def cached_file(name: str, family: str) -> Path | None:
    """Where a file of the cache is or may be written, None where nothing can be; `family` is the pattern of its kind.

    Where it has to be written, files of its kind that are long out of use are removed.
    """
    for root in cache_roots():
        if _marked_as_used(root / name):
            return root / name
        if is_writable(root):
            remove_old(root, family, root / name)
            return root / name
    return None


def _marked_as_used(path: Path) -> bool:
    """Whether a file is there, and ours to use."""
    try:
        os.utime(path)
    except OSError:
        return False
    return True


def remove_old(root: Path, family: str, current: Path) -> None:
    """Keep the most recently used entries of a family and those in use; remove the rest."""
    with contextlib.suppress(OSError):
        others = [(path.stat().st_mtime, path) for path in root.glob(family) if path != current]
        for used, path in sorted(others, reverse=True)[KEPT:]:
            if time.time() - used > IN_USE:
                _remove(path)


def _remove(path: Path) -> None:
    import shutil

    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
