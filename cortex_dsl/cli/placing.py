"""Files of an export put into their folder: nothing there is overwritten by something else unless it is forced."""

from collections.abc import Mapping
from errno import EDQUOT, ENOSPC
from pathlib import Path

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.files import reason


def place_files(folder: Path, files: Mapping[str, bytes], *, force: bool) -> frozenset[str]:
    """Write all files; the names of those that were there with the same contents.

    Raises:
        UsageError: they cannot be written, or something else stands in their place.
    """
    from engine.atomic import standing, write_all

    try:
        there = standing(folder, files)
        if there.other and not force:
            first, *others = there.other
            more = f" and {len(others):,} more" if others else ""
            raise UsageError(
                f"`{folder / first}`{more} holds something else",
                "name another folder with --out, or write over it with --force",
            )
        write_all(folder, {name: content for name, content in files.items() if name not in there.same})
    except OSError as error:
        place = error.filename2 or error.filename or folder
        raise UsageError(f"cannot write `{place}`: {reason(error)}", _cure(error, folder)) from None
    except ValueError:
        raise UsageError(f"`{folder}` cannot be the name of a folder", "name another one with --out") from None
    return there.same


def _cure(error: OSError, folder: Path) -> str:
    if error.errno in (ENOSPC, EDQUOT):
        return "free some space, or name another disk with --out DIR"
    if isinstance(error, IsADirectoryError):
        return "take that folder away, or name another place with --out DIR"
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"a part of `{folder}` is a file; name another folder with --out DIR"
    return "make it writable, or name another folder with --out DIR"
