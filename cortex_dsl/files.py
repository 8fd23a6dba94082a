"""Sources of imported files. The pipeline is given one of these; tests and editors have their own."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import read_source

SUFFIXES = (".scn", ".scenic")


MAPS = "CORTEXC_MAPS"
"""Environment variable: folders of maps, in which those are found that do not lie where a scenario says."""


def map_among_others(path: str) -> str | None:
    """Return the map of that name in the first folder of `$CORTEXC_MAPS` that has one."""
    folders = [folder for folder in os.environ.get(MAPS, "").split(os.pathsep) if folder]
    name = path.replace("\\", "/").rpartition("/")[2]
    return next((str(place) for folder in folders if name and _is_file(place := Path(folder) / name)), None)


class Files(Protocol):
    """Access to the files next to a file. Names are those in messages."""

    def find(self, importer: str, paths: Sequence[str]) -> str | None:
        """Return the name of the first of these paths that is a file, relative to the importing one."""
        ...

    def read(self, name: str) -> Source:
        """Return its text.

        Raises:
            CompileError: its contents are no scenario.
            OSError: it cannot be read.
        """
        ...

    def identity(self, name: str) -> str:
        """Return a key that is equal for two names of one file."""
        ...

    def beside(self, importer: str, path: str) -> list[str]:
        """Files in the folder in which `path` would lie, relative to the importing file."""
        ...


@dataclass(frozen=True)
class Folder:
    """The files of this computer. `root` is where a text that came from no file is at home."""

    root: Path | None = None

    def find(self, importer: str, paths: Sequence[str]) -> str | None:
        for path in paths:
            place = self._home(importer) / path
            if _is_file(place):
                return os.path.normpath(place)
        return None

    def read(self, name: str) -> Source:
        return read_source(name)

    def identity(self, name: str) -> str:
        return os.path.realpath(name)

    def beside(self, importer: str, path: str) -> list[str]:
        folder = Path(path).parent
        try:
            places = [p for p in (self._home(importer) / folder).iterdir() if p.suffix in SUFFIXES and _is_file(p)]
        except OSError:
            return []
        return [str(folder / name) for name in sorted(p.name for p in places)]

    def _home(self, importer: str) -> Path:
        if self.root is not None and not Path(importer).is_file():
            return self.root
        return Path(importer).parent


def _is_file(place: Path) -> bool:
    try:
        return place.is_file()
    except PermissionError:
        return True  # reading it reports why it cannot be read
    except (OSError, ValueError):
        return False


DISK = Folder()
