"""A file that is held against a checker."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cortex_dsl.interchange.cases import ExportCase


@dataclass(frozen=True)
class Item:
    """A file, and what a checker must find in it."""

    kind: str
    """Which checks it is for; see `CHECKS` of `checks`."""
    file: Path
    facts: Mapping[str, Any] = field(default_factory=dict)
    """What is to be found, as JSON."""
    case: ExportCase | None = None
    """Where the file is one of a case."""
    problem: str = ""
    """Why there is no file."""
    version: str = ""
    """Of the format."""
