"""Packages that only some outputs need: imported when asked for, and missed with a cure."""

from importlib import import_module
from typing import Any

from engine.extras import MissingExtraError


def needed(module: str, package: str, what: str) -> Any:
    """A module of an optional package; `what` needs it, in the plural.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtraError(f"{what} need", package, "report") from None
