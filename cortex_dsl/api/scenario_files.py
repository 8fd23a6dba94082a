"""Scenario files of a command or call that takes files and folders, each once, in the order of their paths."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path, PurePath

from cortex_dsl.shipped import SUFFIX
from engine.errors import ArgumentError, CortexError, nearest


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario file."""

    path: Path
    found: bool
    """True if it was found in a folder, False if it was named."""


class NoSuchPathError(CortexError):
    """A path that does not exist, cannot be read, or is a folder without scenarios."""


def scenario_files(paths: Iterable[str | Path], exclude: Sequence[str] = ()) -> tuple[ScenarioFile, ...]:
    """Return the named files and all scenarios below the named folders, each once, sorted by path.

    Hidden folders are left out, and so are files that match a pattern of `exclude`: `old/*`, `*_draft.scn`, or the name
    of a folder.

    Raises:
        NoSuchPathError: a path does not exist, a folder has no scenario, or nothing is left.
    """
    files: dict[str, ScenarioFile] = {}
    for path in map(Path, paths):
        inside = _below(path) if os.path.isdir(path) else [path]  # noqa: PTH112 - that of pathlib raises
        if not inside:
            raise NoSuchPathError(f"there is no scenario below `{path}`", f"scenario files end in {SUFFIX}")
        for each in inside:
            if each is path:
                _check_file(path)
            known = files.get(real := os.path.realpath(each))
            if known is None or (known.found and each is path):
                files[real] = ScenarioFile(each, each is not path)
    left = [file for file in files.values() if not any(_matches(file.path, pattern) for pattern in exclude)]
    if not left:
        if files:
            raise NoSuchPathError("--exclude leaves no scenario out of " + f"{len(files)}", "exclude fewer files")
        raise NoSuchPathError("no paths given", "name files or folders, such as `cortexc test scenarios`")
    return tuple(sorted(left, key=lambda file: file.path.parts))


def _below(folder: Path) -> list[Path]:
    """Return the scenarios below a folder, except those in hidden folders."""
    if not os.access(folder, os.R_OK | os.X_OK):
        raise NoSuchPathError(f"cannot read the folder `{folder}`", "its permissions forbid it")
    paths = folder.rglob(f"*{SUFFIX}")
    return [
        path
        for path in paths
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    ]


def _check_file(path: Path) -> None:
    """Check that a named path is a file that can be read.

    Raises:
        NoSuchPathError: it is not.
    """
    try:
        if not os.path.lexists(path):
            raise NoSuchPathError(f"there is no file or folder `{path}`", _similar(path))
        if path.suffix != SUFFIX:
            raise NoSuchPathError(f"`{path}` is not a scenario", f"scenario files end in {SUFFIX}")
        if not path.exists() or not os.access(path, os.R_OK):
            raise NoSuchPathError(f"cannot read `{path}`", "name a file that can be read")
    except (OSError, ValueError):
        raise NoSuchPathError(f"`{path}` cannot be the name of a file", "name files or folders") from None


def _similar(path: Path) -> str:
    """Return the cure that names the file that was probably meant; "" without one."""
    try:
        near = nearest(path.name, [each.name for each in path.parent.iterdir()])
    except OSError:
        return f"there is no folder `{path.parent}` either"
    return f"did you mean `{path.parent / near}`?" if near else ""


def _matches(path: Path, pattern: str) -> bool:
    """Return True if a pattern fits a path, its last parts, or one of its folders."""
    parts = PurePath(path).parts
    ends = ("/".join(parts[start:]) for start in range(len(parts)))
    return any(fnmatchcase(end, pattern) for end in ends) or any(fnmatchcase(part, pattern) for part in parts[:-1])


def pattern(text: str) -> str:
    """Return a pattern of `exclude`.

    Raises:
        ArgumentError: it is empty.
    """
    if not text.strip():
        raise ArgumentError("--exclude is empty", "name files to leave out, such as `drafts/*`")
    return text.strip().rstrip("/")
