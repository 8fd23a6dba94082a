"""The network of a Lanelet2 map; slow work is done once per content of a file, and stored in the user's cache."""

from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from engine.maps import LaneletFile, digest_of
from engine.road.network import Network
from engine.road.opendrive.contents import Contents, unpacked
from engine.road.opendrive.network import CODE, ENGINE, checked_path, stored

OWN_CODE = (*CODE, ENGINE / "road/lanelet2", ENGINE / "lanelet2")


def lanelet_file(path: Path, name: str, origin: tuple[float, float] | None) -> LaneletFile:
    """Return the specification of the lanelets of a file; `name` is its name in the scenario, `origin` [deg].

    Raises:
        InterchangeError: it is no Lanelet2 map with lanes for vehicles.
        MissingExtraError: the package is not installed.
    """
    spec = LaneletFile(name, str(path), digest_of(path), 0, origin)
    return LaneletFile(name, spec.path, spec.digest, _contents(spec).intersections, origin)


def lanelet_network(spec: LaneletFile) -> Network:
    """Return the network of a file.

    Raises:
        InterchangeError: the file is missing or has changed.
    """
    checked_path(spec)
    return unpacked(_contents(LaneletFile(spec.file, spec.path, spec.digest, 0, spec.origin)), spec)


@lru_cache(maxsize=8)
def _contents(spec: LaneletFile) -> Contents:
    """Return the contents of a map, from the cache if it was read before by the same package."""

    def read() -> Contents:
        from engine.road.lanelet2.making import read

        return read(spec)

    try:
        package = version("lanelet2")
    except PackageNotFoundError:
        return read()
    return stored(f"{spec.digest}\0{spec.origin}\0{package}", OWN_CODE, read)
