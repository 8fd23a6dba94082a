"""Paths that the user named, read with messages that help."""

import errno
import os
from pathlib import Path

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import reading
from cortex_dsl.syntax.errors import MAX_BYTES


def read_source(path: Path) -> Source:
    """The text of a scenario.

    Raises:
        UsageError: missing, a folder, or unreadable.
        CompileError: what it holds is no scenario: not text, empty, too large.
    """
    return reading.decode(str(path), read_bytes(path))


def read_bytes(path: Path) -> bytes:
    """The content of a file, or as much of one that is too large as shows that.

    Raises:
        UsageError: missing, a folder, or unreadable.
    """
    try:
        if is_folder(path):
            raise UsageError(f"`{path}` is a folder", _scenarios_in(path))
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise UsageError(f"there is no file `{path}`", _similar(path)) from None
    except OSError as error:
        raise UsageError(f"cannot read `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None


def is_folder(path: Path) -> bool:
    """Whether a path is known to be a folder; one that may not be looked at is none."""
    return os.path.isdir(path)  # noqa: PTH112 - that of pathlib raises


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
