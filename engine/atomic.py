"""Files written all or not at all: first under other names, then each is put in its place at once."""

import os
import re
import signal
import stat
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import NoReturn

WAITING = re.compile(r"\..*\.(\d{1,9})\.cortexc-part")
"""The name of a file that waits for its place, with the process that writes it."""
LONGEST_NAME = 100
"""Bytes of a file's name in that."""


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
            (same if _holds(path, content) else other).append(name)
    return Standing(frozenset(same), tuple(other))


def _holds(path: Path, content: bytes) -> bool:
    """Nothing is read but a file of that very size: a pipe would wait, a device may never end."""
    try:
        found = path.stat()
    except FileNotFoundError:  # a link that leads nowhere
        return False
    if stat.S_ISDIR(found.st_mode):
        return path.read_bytes() == content  # raises, with the name of what happened
    return stat.S_ISREG(found.st_mode) and found.st_size == len(content) and path.read_bytes() == content


def write_all(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder, which is made if it is not there. Where one cannot be written, none is.

    What an export left behind that was killed there is taken away.

    Raises:
        OSError: with the path that could not be written; no half of a file is left, nor a folder that was made for it.
        SystemExit: the process was told to end meanwhile; as little is left.
    """
    with _ended_by_exception():
        made = _make(folder)
        _clear(folder)
        waiting = {name: folder / _waiting(name) for name in files}
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


def _waiting(name: str) -> str:
    cut = name.encode()[:LONGEST_NAME].decode(errors="ignore")
    return f".{cut}.{os.getpid()}.cortexc-part"


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


# -- ends that come from outside --------------------------------------------------------------------------------------


@contextmanager
def _ended_by_exception() -> Iterator[None]:
    """A request to end, which by itself runs nothing any more, raises SystemExit, as Ctrl-C raises its own."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    signals = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in signals}
    try:
        for number in signals:
            if before[number] is signal.SIG_DFL:  # who ignores it wants to be left alone
                signal.signal(number, _end)
        yield
    finally:
        for number, handler in before.items():
            if handler is not None:
                signal.signal(number, handler)


def _end(number: int, _frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


def _clear(folder: Path) -> None:
    """Take away what waits for a process that is gone."""
    for path in folder.glob(".*.cortexc-part"):
        found = WAITING.fullmatch(path.name)
        if found and not _runs(int(found[1])):
            with suppress(OSError):
                path.unlink()


def _runs(process: int) -> bool:
    """Whether a process is there; where that cannot be asked without harm, it is."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
