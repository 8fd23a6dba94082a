"""The network of an OpenDRIVE file.

Slow work is done once per content of a file, and stored in the user's cache (`contents`); the network is made from that
each time, since a scenario joins its own paths. Modules that read files are imported on demand.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from engine.atomic import write_one
from engine.maps import MapFile, digest_of
from engine.road.network import Network
from engine.road.opendrive.contents import Contents, from_bytes, to_bytes, unpacked
from engine.user_cache import cached_file, fingerprint


def map_file(path: Path, name: str) -> MapFile:
    """Return the specification of the roads of a file; `name` is its name in the scenario.

    Raises:
        InterchangeError: it is not an OpenDRIVE file with drivable roads.
    """
    digest = digest_of(path)
    return MapFile(name, str(path), digest, contents_of(str(path), digest).intersections)


def file_network(spec: MapFile) -> Network:
    """Return the network of a file.

    Raises:
        InterchangeError: the file is missing or has changed.
    """
    checked_path(spec)
    return unpacked(contents_of(spec.path, spec.digest), spec)


def checked_path(spec: MapFile) -> None:
    """Raise InterchangeError if the file of a map is missing or has changed."""
    path = Path(spec.path)
    found = digest_of(path) if path.is_file() else None
    if found != spec.digest:
        from engine.errors import InterchangeError

        what = "is not there" if found is None else f"has changed: its digest is {found}, not {spec.digest}"
        raise InterchangeError(f"the map {spec.file} {what}", "put the file back that the scenario was compiled with")


# -- stored networks ---------------------------------------------------------------------------------------------------

FAMILY = "roads-*.bin"
ENGINE = Path(__file__).parents[2]
CODE = (
    *(ENGINE / folder for folder in ("road/opendrive", "road", "opendrive")),
    *(ENGINE / f"{name}.py" for name in ("errors", "frozen", "maps", "tables", "unread", "vocabulary", "xml")),
)
"""Files, and folders of files, that determine the result."""


@lru_cache(maxsize=8)
def contents_of(path: str, digest: str) -> Contents:
    """Return the contents of the file with this digest, from the cache if it was read before.

    Raises:
        InterchangeError: it is not an OpenDRIVE file with drivable roads.
    """

    def read_file() -> Contents:
        from engine.road.opendrive.making import read

        return read(path, digest)

    return stored(digest, CODE, read_file)


def stored(name: str, code: Sequence[Path], read: Callable[[], Contents]) -> Contents:
    """Return the result of `read`, from the cache if it was stored under this name by the same code and libraries."""
    libraries = (version(library) for library in ("numpy", "shapely"))
    key = sha256("\0".join([name, *libraries, fingerprint(code)]).encode()).hexdigest()
    entry = cached_file(f"roads-{key[:24]}.bin", FAMILY)
    if entry is not None:
        with suppress(OSError):
            if (found := from_bytes(entry.read_bytes(), key)) is not None:
                return found
    contents = read()
    if entry is not None:
        with suppress(OSError):
            write_one(entry, to_bytes(contents, key))
    return contents
