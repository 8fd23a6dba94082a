"""Run directories: where a search stores its results. Nothing that is there is ever overwritten."""

import errno
import os
import re
import sqlite3
import unicodedata
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path, PurePath

from filelock import FileLock, Timeout

from engine.atomic import TakenError, leads_nowhere
from engine.errors import CortexError

JOURNAL = "journal.sqlite"
"""File with all data of a run; the other files next to it are exports of it."""
UNBORN = ".new"
"""Ends the name of a journal that is being made."""
LOCK = ".lock"
"""Lock file, held by the process that writes a run; the operating system releases it when the process ends."""
PROBE = ".write-test"
"""Empty file that is made and removed to learn whether a folder can be written."""
LONGEST_NAME = 200
"""Maximum length [bytes] of the part of a folder's name before the method; file systems allow 255 for a name."""


SPACE = "free some space, then go on with `cortexc resume`: what was written is kept; or name another disk with --out"
SPACE_TO_BEGIN = "free some space, or name another disk with --out"
"""Cure for a full disk where nothing is written yet."""


class StoreError(CortexError):
    """Results cannot be stored or read; the message has the reason and the cure."""


# -- names of files in results that are passed on ----------------------------------------------------------------------


def without_folders(word: str) -> str:
    """Return a word of a command line with the name of a file in the place of an absolute path."""
    option, equals, value = word.rpartition("=")
    return f"{option}{equals}{PurePath(value).name}" if PurePath(value).is_absolute() else word


def seen_from(folder: Path, name: str) -> str:
    """Return an absolute path relative to a run's folder, or its file name if both have no folder in common.

    A relative path is returned unchanged.
    """
    if not PurePath(name).is_absolute():
        return name
    home = folder.absolute()
    alike = home.parts[:2] == PurePath(name).parts[:2]
    return os.path.relpath(name, home) if alike else without_folders(name)


def located(folder: Path, name: str) -> str:
    """Return the path of a file that a run names as `seen_from` its folder."""
    place = Path(os.path.normpath(folder / name))
    return str(place) if place.is_file() else name


def numbered_directory(name: str, method: str, root: Path = Path("runs")) -> Path:
    """Make and return the next of `runs/<name>-<method>-001`, `-002`, …; safe while other commands do the same."""
    stem = f"{_portable(name)}-{_portable(method)}"
    with store_errors(root, SPACE_TO_BEGIN):
        root.mkdir(parents=True, exist_ok=True)
        number = _last_number(root, stem)
        while True:
            number += 1
            directory = root / f"{stem}-{number:03d}"
            try:
                directory.mkdir()
            except FileExistsError:
                continue
            return directory


def example_run(root: Path = Path("runs")) -> Path:
    """Return a run to name in a message: the latest existing run, or one that a search would create."""
    there = [(journal.stat().st_mtime, journal.parent) for journal in root.glob(f"*/{JOURNAL}")]
    return max(there)[1] if there else root / "left_turn-ga-001"


def new_directory(directory: Path) -> Path:
    """Create the run directory at the requested place; it may exist if it is empty."""
    with store_errors(directory, SPACE_TO_BEGIN):
        if leads_nowhere(directory):
            raise StoreError(f"`{directory}` is a link that leads nowhere", "remove it, or name another --out")
        directory.mkdir(parents=True, exist_ok=True)
        if (directory / JOURNAL).exists():
            raise StoreError(f"`{directory}` already holds a run", "name another --out; a run is never overwritten")
        if not all(_is_of_unborn(path.name) for path in directory.iterdir()):
            raise StoreError(f"`{directory}` is not empty", "name a new or an empty folder with --out")
        probe = directory / PROBE
        probe.touch()
        probe.unlink()
    return directory


def _is_of_unborn(name: str) -> bool:
    """Return True for files that a run leaves which is killed before it has a journal."""
    return name in (LOCK, PROBE) or name.startswith(JOURNAL + UNBORN)


class RemovedError(StoreError):
    """The open file was removed by another process; the data are in memory only."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"`{path}` was removed, or replaced, while it was being written", "do it again from the start")


def check_not_removed(path: Path, inode: int) -> None:
    """Check that an open file still has its name; a removed file could be written but not found again.

    Raises:
        RemovedError: a different file has this name, or none.
    """
    try:
        same = path.stat().st_ino == inode
    except OSError:
        same = False
    if not same:
        raise RemovedError(path)


def refuse_empty(path: Path) -> None:
    """Refuse a database without contents, which SQLite takes for a new one.

    Raises:
        StoreError: the file has 0 bytes.
    """
    if path.stat().st_size == 0:
        raise StoreError(f"`{path}` has 0 bytes: its contents are lost", "restore it from a copy, or search again")


@contextmanager
def hold(directory: Path) -> Generator[None]:
    """Prevent other processes from writing the same run while the block runs.

    Raises:
        StoreError: another process writes it, or the folder cannot be written.
    """
    lock = FileLock(directory / LOCK)
    with store_errors(directory, SPACE_TO_BEGIN):
        try:
            lock.acquire(timeout=0)
        except Timeout:
            raise StoreError(
                f"`{directory}` is being written by another process", "wait for it to end, or name another folder"
            ) from None
    try:
        yield
    finally:
        lock.release()


def _last_number(root: Path, stem: str) -> int:
    pattern = re.compile(re.escape(stem) + r"-(\d{3,})")
    return max((int(match[1]) for path in root.iterdir() if (match := pattern.fullmatch(path.name))), default=0)


def _portable(name: str) -> str:
    """Return the name without characters that a file system may reject; other letters stay if names may have them."""
    try:
        os.fsencode("ü")
        plain = "".join(each if _is_plain(each) else " " for each in unicodedata.normalize("NFC", name))
    except UnicodeEncodeError:
        plain = re.sub(r"[^A-Za-z0-9_.-]", " ", name)
    short = "-".join(plain.split())[:80].encode()[:LONGEST_NAME].decode(errors="ignore")
    return short.strip("-.") or "scenario"


def _is_plain(letter: str) -> bool:
    """Return True for letters with their marks, digits, and signs without a meaning for shells and file systems."""
    return letter in "_.-" or unicodedata.category(letter)[0] in "LMN"


@contextmanager
def store_errors(path: Path, space: str = SPACE) -> Generator[None]:
    """Turn errors of the file system or of SQLite about `path` into a StoreError; `space`: the cure for a full disk."""
    try:
        yield
    except OSError as error:
        raise StoreError(f"cannot write `{path}`: {error.strerror or error}", _cure_of(error, space)) from error
    except sqlite3.Error as error:
        raise _journal_error(path, error, space) from error


def _cure_of(error: OSError, space: str) -> str:
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return space
    if isinstance(error, TakenError):
        return "wait for it to end, or name another folder"
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "a part of this path is a file; name another folder with --out"
    return "make it writable, or name another folder"


def _journal_error(path: Path, error: sqlite3.Error, space: str) -> StoreError:
    text = str(error)
    if "full" in text:
        return StoreError(f"no space left for `{path}`", space)
    if "disk I/O" in text:
        return StoreError(f"the disk does not take what is written to `{path}`: it may be full, or failing", space)
    if "not a database" in text or "malformed" in text:
        return StoreError(f"`{path}` is not a readable journal: {text}", "restore it from a copy, or repeat the run")
    if "locked" in text:
        return StoreError(f"`{path}` is in use by another process", "wait for it, or name another --out")
    if "unable to open" in text or "readonly" in text:
        return StoreError(f"cannot open `{path}`: {text}", "make it writable, or name another folder with --out")
    return StoreError(f"`{path}`: {text}", "name another folder with --out")
