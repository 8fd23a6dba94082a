"""Paths that the user named, read with messages that help."""

import errno
from pathlib import Path

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest

SIZE_LIMIT = 4 * 1024 * 1024
"""Bytes of the largest scenario file; the largest that was ever written by hand has some kilobytes."""


def read_source(path: Path) -> Source:
    """The text of a scenario.

    Raises:
        UsageError: missing, a folder, unreadable, too large, or not text.
    """
    try:
        if path.is_dir():
            raise UsageError(f"`{path}` is a folder", _scenarios_in(path))
        with path.open("rb") as file:
            data = file.read(SIZE_LIMIT + 1)
    except FileNotFoundError:
        raise UsageError(f"there is no file `{path}`", _similar(path)) from None
    except OSError as error:
        raise UsageError(f"cannot read `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None
    if len(data) > SIZE_LIMIT:
        raise UsageError(f"`{path}` is larger than {SIZE_LIMIT // 2**20} MB", "a scenario is a short text")
    return Source(str(path), _decode(path, data))


def _decode(path: Path, data: bytes) -> str:
    if b"\0" in data:
        raise UsageError(f"`{path}` is not a text file", "a scenario is UTF-8 text, usually named *.scn")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise UsageError(f"`{path}` is not UTF-8 text (line {line})", "save it as UTF-8") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _scenarios_in(folder: Path) -> str:
    found = sorted(folder.glob("*.scn"))[:3]
    return "try " + " or ".join(f"`{path}`" for path in found) if found else "name a scenario file (*.scn)"


def _similar(path: Path) -> str:
    """The file that was probably meant."""
    try:
        names = [p.name for p in path.parent.iterdir() if p.suffix == ".scn"]
    except OSError:
        return f"there is no folder `{path.parent}` either"
    match = nearest(path.name, names)
    if match is None:
        return _scenarios_in(path.parent) if names else ""
    return f"did you mean `{path.parent / match}`?"


def reason(error: OSError) -> str:
    """An operating system's complaint in small letters, e.g. `permission denied`."""
    if error.errno == errno.ENOSPC:
        return "the disk is full"
    return (error.strerror or str(error)).lower()
