"""Files written whole or not at all: first under a hidden name beside their place, then put there at once.

A reader, at any moment, sees all of the old or all of the new. Nothing here listens to signals: a process that is
killed leaves hidden names behind, and the next one that writes into that folder, while no other does, takes them
away. Writers know of one another by a lock of the folder, which ends with the process that holds it.
"""

import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from engine.errors import Signal

try:
    import fcntl
except ImportError:  # Windows has no such locks: nothing is ever removed there
    fcntl = None

WAITING = re.compile(r"\..*\.[0-9a-f]{8}\.cortexc-part")
"""The name of a file that waits for its place."""
LONGEST_NAME = 100
"""Bytes of a file's name in that."""
PATIENCE, PAUSE = 100, 0.01
"""How often a lock is tried, and the pause in between [s]: removing names takes no longer."""


@dataclass(frozen=True)
class Standing:
    """What stands in the place of files that are to be written."""

    same: frozenset[str]
    """Names of files that already hold what would be written."""
    other: tuple[str, ...]
    """Names of files that hold something else."""


def leads_nowhere(path: Path) -> bool:
    """Whether a path is a link to what is not there; one that cannot be looked at is none."""
    return os.path.islink(path) and not os.path.exists(path)  # noqa: PTH110, PTH114 - those of pathlib raise


def standing(folder: Path, files: Mapping[str, bytes]) -> Standing:
    """Compare a folder, which need not be there, with what is to be written into it.

    Raises:
        OSError: something is there that cannot be read, such as a folder of a file's name.
    """
    same: list[str] = []
    other: list[str] = []
    for name, content in files.items():
        path = folder / name
        if os.path.lexists(path):
            (same if _holds(path, content) else other).append(name)
    return Standing(frozenset(same), tuple(other))


def _holds(path: Path, content: bytes) -> bool:
    """Nothing is read but a file of that very size: a pipe would wait, a device may never end."""
    try:
        found = path.stat()
    except FileNotFoundError:  # a link that leads nowhere
        return False
    if stat.S_ISDIR(found.st_mode):
        return path.read_bytes() == content  # raises the fitting OSError
    return stat.S_ISREG(found.st_mode) and found.st_size == len(content) and path.read_bytes() == content


def write_one(path: Path, content: bytes) -> None:
    """Put a content into a file. Mode and owner of one that is there stay; where a link leads, there it is written.

    Raises:
        OSError: it cannot be written, or may not; what was there is as it was.
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


def write_all(folder: Path, files: Mapping[str, bytes], *, over: bool = True) -> None:
    """Write files into a folder, which is made if it is not there. Where one cannot be written, none is. Without `over`
    each of them must be new: of two processes that write the same names, one is refused.

    Raises:
        TakenError: a file that must be new is there.
        OSError: with the path that could not be written; no half of a file is left, nor a folder that was made for it.
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
            with suppress(OSError):  # not empty: another process uses it by now
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


def _write(waiting: Path, place: Path, content: bytes, mode: int) -> None:
    """A new file, through to the disk: a full one says so here, and not when the name is taken already."""
    try:
        number = os.open(waiting, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    except OSError as error:
        error.filename = str(place)  # the name that people know
        raise
    with os.fdopen(number, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(number)


def _make(folder: Path) -> list[Path]:
    """Make a folder and those above it; the ones that were not there, the innermost first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


# -- what a killed process left behind --------------------------------------------------------------------------------


@contextmanager
def _writing_into(folder: Path) -> Generator[None]:
    """Share the folder's lock with other writers; a process that has it alone first removes what a killed one left."""
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
    """None where folders have no locks, or this one may not be read: then nothing is taken away."""
    with suppress(OSError):
        return None if fcntl is None else os.open(folder, os.O_RDONLY)
    return None


def _share(folder: Path, number: int) -> None:
    assert fcntl is not None
    with suppress(BlockingIOError):  # others write here
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
