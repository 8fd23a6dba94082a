"""Packages that only some outputs need: imported when asked for, and missed with a cure."""

from importlib import import_module
from typing import Any

from engine.extras import installing


class MissingExtra(Exception):  # noqa: N818 - says what is missing
    """An output needs a package that is not installed."""

    def __init__(self, package: str, what: str) -> None:
        self.cure = installing("report")
        super().__init__(f"{what} need the package `{package}`, which is not installed")


def needed(module: str, package: str, what: str) -> Any:
    """A module of an optional package; `what` needs it, in the plural.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtra(package, what) from None
