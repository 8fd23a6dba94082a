"""Atomic writes: a file is first written under a hidden name in its folder, then moved to its place at once.

A reader sees the complete old or the complete new file at any moment. Signals are not handled: a killed process leaves
hidden files, and the next process that writes into that folder alone removes them. Writers share a lock of the folder,
which ends with the process that holds it.
"""

import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from engine.errors import Signal

try:
    import fcntl
except ImportError:  # Windows has no such locks: nothing is ever removed there
    fcntl = None

Content = bytes | Iterable[bytes]
"""Content of a file, or its parts in their order; it can be iterated more than once."""
WAITING = re.compile(r"\..*\.[0-9a-f]{8}\.cortexc-part")
"""Pattern of the name of a file that is not yet in its place."""
LONGEST_NAME = 100
"""Maximum length of the file's name in that name [bytes]."""
PATIENCE, PAUSE = 100, 0.01
"""Number of attempts at a lock, and the pause between them [s]: the removal of names takes no longer."""


@dataclass(frozen=True)
class Standing:
    """Files that exist in the place of files to be written."""

    same: frozenset[str]
    """Names of files that already have the new content."""
    other: tuple[str, ...]
    """Names of files that have a different content."""


def leads_nowhere(path: Path) -> bool:
    """Return True if a path is a link without a target; False if it cannot be inspected."""
    return os.path.islink(path) and not os.path.exists(path)  # noqa: PTH110, PTH114 - those of pathlib raise


def standing(folder: Path, files: Mapping[str, Content]) -> Standing:
    """Compare a folder, which may be missing, with the files to be written into it.

    Raises:
        OSError: an object there cannot be read, such as a folder of a file's name.
    """
    same: list[str] = []
    other: list[str] = []
    for name, content in files.items():
        path = folder / name
        if os.path.lexists(path):
            (same if _holds(path, content) else other).append(name)
    return Standing(frozenset(same), tuple(other))


def _holds(path: Path, content: Content) -> bool:
    """Return True if the file has this content. Only a regular file is read: a pipe may block."""
    try:
        found = path.stat()
    except FileNotFoundError:  # a link without a target
        return False
    if stat.S_ISDIR(found.st_mode):
        return path.read_bytes() == content  # raises the fitting OSError
    if not stat.S_ISREG(found.st_mode) or (isinstance(content, bytes) and found.st_size != len(content)):
        return False
    with path.open("rb") as file:
        return all(file.read(len(part)) == part for part in _parts(content)) and not file.read(1)


def _parts(content: Content) -> Iterable[bytes]:
    return (content,) if isinstance(content, bytes) else content


def write_one(path: Path, content: Content) -> None:
    """Write a content to a file. An existing file keeps mode and owner; a link is followed.

    Raises:
        OSError: the file cannot be written; its old content is unchanged.
    """
    target = Path(os.path.realpath(path))
    old = target.stat() if target.exists() else None
    if old is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    with _writing_into(target.parent):
        waiting = _waiting(target)
        try:
            _write(waiting, target, content, 0o666 if old is None else 0o600)
            if old is not None:
                waiting.chmod(stat.S_IMODE(old.st_mode))
                with suppress(OSError):  # only root gives files away
                    os.chown(waiting, old.st_uid, old.st_gid)
            waiting.replace(target)
        except BaseException:
            waiting.unlink(missing_ok=True)
            raise


class TakenError(FileExistsError, Signal):
    """Another process wrote a file meanwhile."""


def write_all(folder: Path, files: Mapping[str, Content], *, over: bool = True) -> None:
    """Write files into a folder, which is created if it is missing; after an error no file is written.

    Without `over` each file must be new: of two processes that write the same names, one is refused.

    Raises:
        TakenError: a file that must be new exists.
        OSError: with the path that could not be written; no partial file and no new folder is left.
    """
    made = _make(folder)
    waiting = {name: _waiting(folder / name) for name in files}
    placed: list[Path] = []
    try:
        with _writing_into(folder):
            for name, content in files.items():
                _write(waiting[name], folder / name, content, 0o666)
            for name, path in waiting.items():
                _place(path, folder / name, over)
                placed.append(folder / name)
    except BaseException:
        for path in (*waiting.values(), *(() if over else placed)):
            with suppress(OSError):
                path.unlink(missing_ok=True)
        for path in made:
            with suppress(OSError):  # another process uses it by now
                path.rmdir()
        raise


def _place(waiting: Path, place: Path, over: bool) -> None:
    """Give a file its name."""
    if not over:
        try:
            os.link(waiting, place)
        except FileExistsError:
            raise TakenError(errno.EEXIST, "another process wrote it meanwhile", str(place)) from None
        except OSError:  # a file system without links
            pass
        else:
            waiting.unlink()
            return
    waiting.replace(place)


def _waiting(place: Path) -> Path:
    cut = place.name.encode()[:LONGEST_NAME].decode(errors="ignore")
    return place.with_name(f".{cut}.{secrets.token_hex(4)}.cortexc-part")


def _write(waiting: Path, place: Path, content: Content, mode: int) -> None:
    """Write a new file through to the disk, so that a full disk is reported before the name is taken."""
    try:
        number = os.open(waiting, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    except OSError as error:
        error.filename = str(place)  # the name that people know
        raise
    with os.fdopen(number, "wb") as file:
        file.writelines(_parts(content))
        file.flush()
        os.fsync(number)


def _make(folder: Path) -> list[Path]:
    """Create a folder and its parents; return the created folders, the innermost first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


# -- remains of a killed process --------------------------------------------------------------------------------------


@contextmanager
def _writing_into(folder: Path) -> Generator[None]:
    """Share the folder's lock with other writers; with the sole lock, remove files of killed processes first."""
    number = _opened(folder)
    try:
        if number is not None:
            with suppress(OSError):  # a file system without locks
                _share(folder, number)
        yield
    finally:
        if number is not None:
            os.close(number)


def _opened(folder: Path) -> int | None:
    """Return a descriptor of the folder; None without locks of folders, or if unreadable: then nothing is removed."""
    with suppress(OSError):
        return None if fcntl is None else os.open(folder, os.O_RDONLY)
    return None


def _share(folder: Path, number: int) -> None:
    assert fcntl is not None
    with suppress(BlockingIOError):  # other processes write here
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _clear(folder)
    for _ in range(PATIENCE):
        with suppress(BlockingIOError):
            fcntl.flock(number, fcntl.LOCK_SH | fcntl.LOCK_NB)
            return
        time.sleep(PAUSE)


def _clear(folder: Path) -> None:
    for path in folder.glob(".*.cortexc-part"):
        if WAITING.fullmatch(path.name):
            with suppress(OSError):
                path.unlink()
