"""Packages that only some methods need: imported when asked for, and missed with a cure."""

from importlib import import_module
from typing import Any

from engine.extras import MissingExtraError


def needed(package: str, method: str, extra: str = "search") -> Any:
    """The package, or the module of one.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtraError(f"`{method}` needs", package.split(".")[0], extra) from None
