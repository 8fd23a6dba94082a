"""Packages that only some methods and outputs need: imported when asked for, and missed with the command that installs
them into this Python, from where cortexc came.
"""

import os
import sys
from importlib import import_module
from pathlib import Path
from shlex import quote
from typing import Any

from engine.errors import CortexError

SOURCE = Path(__file__).parents[1]
"""Where this package lies: a checkout, or a folder of installed packages."""


def installing(extra: str) -> str:
    """The command that brings an extra of cortexc, such as `search`; of a checkout, whose name no index knows, its own
    folder.
    """
    python = quote(_short(Path(sys.executable)))
    if not (SOURCE / "pyproject.toml").is_file():
        return f"{python} -m pip install 'cortexc[{extra}]'"
    return f"{python} -m pip install -e '{_short(SOURCE)}[{extra}]'"


class MissingExtraError(CortexError):
    """Something needs a package that is not installed."""

    def __init__(self, who: str, package: str, extra: str) -> None:
        super().__init__(f"{who} the package `{package}`, which is not installed", installing(extra))
        self.package = package


def _short(path: Path) -> str:
    """As one would type it here."""
    here = Path(os.path.abspath(path))  # noqa: PTH100 - a link, as a virtual environment's python is, stays one
    return str(here.relative_to(Path.cwd())) if here.is_relative_to(Path.cwd()) else str(here)


def needed(package: str, method: str, extra: str = "search") -> Any:
    """The package that a method of search needs, or the module of one.

    Raises:
        MissingExtraError: it is not installed.
    """
    return imported(package, package.split(".")[0], f"`{method}` needs", extra)


def imported(module: str, package: str, who: str, extra: str) -> Any:
    """A module of an optional package; `who` says what needs it, such as `figures need`.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtraError(who, package, extra) from None
