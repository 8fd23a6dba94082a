"""Packages that only some methods, outputs and formats need: imported when used; an error names the command that
installs them into this Python, from where cortexc came.
"""

import os
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from shlex import quote
from typing import Any

from engine.errors import CortexError

SOURCE = Path(__file__).parents[1]
"""Folder that contains this package: a checkout, or a folder of installed packages."""


def installing(extra: str) -> str:
    """Return the command that installs an extra of cortexc, such as `search`; a checkout by its folder."""
    python = quote(_short(Path(sys.executable)))
    if not (SOURCE / "pyproject.toml").is_file():
        return f"{python} -m pip install 'cortexc[{extra}]'"
    return f"{python} -m pip install -e '{_short(SOURCE)}[{extra}]'"


class MissingExtraError(CortexError):
    """Something needs a package that is not installed."""

    def __init__(self, who: str, package: str, extra: str) -> None:
        super().__init__(f"{who} the package `{package}`, which is not installed", installing(extra))
        self.package = package


def is_installed(package: str) -> bool:
    """Return True if a package can be imported, without its import; True for "", which means no package."""
    return not package or find_spec(package) is not None


def needed(module: str, who: str, extra: str, package: str = "") -> Any:
    """Import and return a module of an optional package; `who`: the component with its verb: `GIFs need`.

    `package`: name under which it is installed, if its modules have a different name.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtraError(who, package or module.split(".")[0], extra) from None


def _short(path: Path) -> str:
    """Return the command as it is typed here."""
    here = Path(os.path.abspath(path))  # noqa: PTH100 - a link, as a virtual environment's python is, stays one
    return str(here.relative_to(Path.cwd())) if here.is_relative_to(Path.cwd()) else str(here)
