"""Files that the user named: read with messages that help, written at once or not at all."""

import errno
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from shlex import join

from cortex_dsl.console.terminal import UsageError
from cortex_dsl.plain_text import as_argument
from cortex_dsl.shipped import examples
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import reading
from cortex_dsl.syntax.errors import MAX_BYTES

RECORDING = "a recording, not a scenario", "judge it by `cortexc measure {}`"
OTHER_FILES: Mapping[str, tuple[str, str]] = {
    ".xodr": ("a map, not a scenario", 'use it in a scenario, as in `map opendrive("{}")`'),
    ".osm": ("a map, not a scenario", 'use it in a scenario, as in `map lanelet2("{}", origin=(49.0, 8.4))`'),
    ".xosc": ("a scenario of OpenSCENARIO", "judge it by `cortexc measure {}`, or translate it by `cortexc import {}`"),
    **dict.fromkeys((".csv", ".parquet", ".mcap"), RECORDING),
}
"""Contents of files with other suffixes, and the commands that read them."""


def read_source(path: Path) -> Source:
    """Return the text of a scenario.

    Raises:
        UsageError: missing, a folder, unreadable, or a map or recording by its name.
        CompileError: its contents are no scenario: not text, empty, too large.
    """
    content = read_bytes(path)
    if path.suffix.lower() in OTHER_FILES:
        what, cure = OTHER_FILES[path.suffix.lower()]
        raise UsageError(f"`{path}` is {what}", cure.replace("{}", as_argument(path)))
    return reading.decode(str(path), content)


def read_bytes(path: Path) -> bytes:
    """Return the content of a file; for one that is too large, only so much as shows that.

    Raises:
        UsageError: missing, a folder, or unreadable.
    """
    try:
        if is_folder(path):
            raise UsageError(f"`{path}` is a folder", _scenarios_in(path))
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise UsageError(f"there is no file `{path}`", _shipped(path) or _similar(path)) from None
    except OSError as error:
        raise UsageError(f"cannot read `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None


def is_folder(path: Path) -> bool:
    """Return whether a path is known to be a folder; an inaccessible one is not."""
    return os.path.isdir(path)  # noqa: PTH112 - that of pathlib raises


def _scenarios_in(folder: Path) -> str:
    found = sorted(folder.glob("*.scn"))[:3]
    return "try " + " or ".join(f"`{path}`" for path in found) if found else "name a scenario file (*.scn)"


def _shipped(path: Path) -> str:
    """How to get a scenario that comes with cortexc, and that a page or a person speaks of as if it were here."""
    if path.name not in {example.scenario.name for example in examples()}:
        return ""
    command = join(("cortexc", "examples", path.stem, "--copy", as_argument(path.parent)))
    return f"it comes with cortexc: `{command}` writes it"


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


def user_path(name: str) -> Path:
    """Return a path as typed, with `~` as the home of a user.

    Raises:
        UsageError: it is no valid path.
    """
    if "\0" in name:
        raise UsageError(f"`{name}` cannot be the name of a file")
    try:
        return Path(name).expanduser()
    except RuntimeError:
        raise UsageError(f"there is no home folder `{name.split('/')[0]}`", "write the whole path") from None


# -- writing -----------------------------------------------------------------------------------------------------------


def write_bytes(path: Path, content: bytes) -> None:
    """Replace the content of a file in one step: a reader, at any moment, sees all of the old or all of the new.

    Mode and owner of an existing file stay; a read-only file is unchanged.

    Raises:
        UsageError: it cannot be written.
    """
    from engine.atomic import write_one

    try:
        write_one(path, content)
    except OSError as error:
        raise UsageError(f"cannot write `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None


def check_writable(path: Path, cure: str = "") -> None:
    """Check that a file can be written, before its contents are computed for minutes.

    Raises:
        UsageError: its folder, or the existing file, may not be written.
    """
    for place in (path.parent, path) if path.is_file() or not os.path.lexists(path) else (path,):
        if os.path.exists(place) and not os.access(place, os.W_OK):  # noqa: PTH110 - that of pathlib raises
            raise UsageError(f"cannot write `{path}`: `{place}` is not writable", cure)


def write_output(path: Path, content: str | bytes, cure: str = "") -> None:
    """Write the output of a command to the place that the user named.

    A file is written whole or not at all; the place may also be a pipe or a device.

    Raises:
        UsageError: it cannot be written; an existing file is unchanged.
    """
    from engine.atomic import leads_nowhere, write_one

    content = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if path.is_file() or not os.path.lexists(path):
            write_one(path, content)
        else:
            path.write_bytes(content)
    except OSError as error:
        if leads_nowhere(path):
            raise UsageError(
                f"`{path}` is a link that leads nowhere", cure or "remove it, or name another file"
            ) from None
        raise UsageError(f"cannot write `{path}`: {reason(error)}", cure) from None


# -- files of an export: nothing in their folder is overwritten by something else unless it is forced ------------------


@dataclass(frozen=True)
class OverwriteFlags:
    """Words in cures for another folder, and for overwriting."""

    out: str = "--out"
    force: str = "--force"


FLAGS = OverwriteFlags()


def place_files(
    folder: Path, files: Mapping[str, bytes], *, force: bool, flags: OverwriteFlags = FLAGS
) -> frozenset[str]:
    """Write all files; return the names of those that existed with the same contents.

    Raises:
        UsageError: they cannot be written, or other files are in their place.
    """
    from engine.atomic import leads_nowhere, standing, write_all

    if leads_nowhere(folder):
        raise UsageError(
            f"`{folder}` is a link that leads nowhere", f"remove it, or name another folder with {flags.out}"
        )
    try:
        there = standing(folder, files)
        if there.other and not force:
            first, *others = there.other
            more = f" and {len(others):,} more" if others else ""
            raise UsageError(
                f"`{folder / first}`{more} holds something else",
                f"name another folder with {flags.out}, or write over it with {flags.force}",
            )
        write_all(folder, {name: content for name, content in files.items() if name not in there.same}, over=force)
    except OSError as error:
        place = error.filename2 or error.filename or folder
        raise UsageError(f"cannot write `{place}`: {reason(error)}", _cure(error, folder, flags.out)) from None
    except ValueError:
        raise UsageError(f"`{folder}` cannot be the name of a folder", f"name another one with {flags.out}") from None
    return there.same


def _cure(error: OSError, folder: Path, out: str) -> str:
    from engine.atomic import TakenError

    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"free some space, or name another disk with {out} DIR"
    if isinstance(error, IsADirectoryError):
        return f"take that folder away, or name another place with {out} DIR"
    if isinstance(error, TakenError):
        return f"wait for it to end, or name another folder with {out} DIR"
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"a part of `{folder}` is a file; name another folder with {out} DIR"
    return f"make it writable, or name another folder with {out} DIR"
