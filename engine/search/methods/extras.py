"""Packages that only some methods need: imported when asked for, and missed with a cure."""

from importlib import import_module
from typing import Any


class MissingExtra(Exception):  # noqa: N818 - says what is missing
    """A method needs a package that is not installed."""

    def __init__(self, package: str, method: str) -> None:
        self.package = package
        self.method = method
        super().__init__(f"method `{method}` needs the package `{package}`: pip install 'cortexc[search]'")


def needed(package: str, method: str) -> Any:
    """The package.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtra(package, method) from None
