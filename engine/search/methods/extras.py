"""Packages that only some methods need: imported when asked for, and missed with a cure."""

from importlib import import_module
from typing import Any

from engine.extras import installing


class MissingExtra(Exception):  # noqa: N818 - says what is missing
    """A method, or a way to work, needs a package that is not installed."""

    def __init__(self, package: str, method: str, extra: str = "search") -> None:
        self.package = package.split(".")[0]
        self.method = method
        self.what = f"`{method}` needs the package `{self.package}`, which is not installed"
        self.cure = installing(extra)
        super().__init__(f"{self.what}: {self.cure}")


def needed(package: str, method: str, extra: str = "search") -> Any:
    """The package, or the module of one.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtra(package, method, extra) from None
