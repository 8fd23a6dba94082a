"""Specifications of `map` lines: one type per kind of road, SI units. `engine.road` builds a network from it."""

from collections.abc import Mapping
from dataclasses import asdict, field, fields
from hashlib import blake2b
from pathlib import Path, PurePath
from typing import Any, ClassVar

from engine.frozen import frozen

Places = tuple[float, ...]
"""Places along a road [m]."""


@frozen
class Street:
    """Arguments of every road with a maker: the strips beside its lanes, and its crossings; without them there is none.

    From the outer lane outwards: bicycle lane, shoulder, parking row, kerb, sidewalk.
    """

    sidewalk: float | None = field(default=None, repr=False, kw_only=True)
    """Width of the sidewalks behind the kerbs [m]."""
    shoulder: float | None = field(default=None, repr=False, kw_only=True)
    bike_lane: float | None = field(default=None, repr=False, kw_only=True)
    bike_lane_behind_parking: bool = field(default=False, repr=False, kw_only=True)
    """True for a bicycle lane between the parking row and the kerb."""
    parking: float | None = field(default=None, repr=False, kw_only=True)
    """Depth of the parking rows along the kerbs [m]."""
    parked: float = field(default=0.0, repr=False, kw_only=True)
    """Share of the parking places with a parked car."""
    crossings: bool | Places = field(default=False, repr=False, kw_only=True)
    """True for a crossing over each arm; on a road, the places of the middles of its crossings."""
    crossing_width: float = field(default=4.0, repr=False, kw_only=True)
    """Extent of a crossing along the road [m]."""


@frozen
class RoadSpec(Street):
    """`map intersection(...)`: a grid of intersections."""

    kind: ClassVar[str] = "intersection"

    ways: int = 4
    lanes: int = 1
    """Lanes per direction."""
    lane_width: float = 3.5
    corner_radius: float = 6.0
    approach: float = 50.0
    """Length of every arm from its stop line to the end of the road [m]."""
    rows: int = 1
    cols: int = 1
    block: float = 100.0
    """Distance between the centres of neighbouring intersections [m]."""
    left_hand: bool = False
    buildings: float | None = None
    """Distance of blocks of buildings from the kerbs, between the arms [m]; None: no buildings."""
    speed_limit: float | None = field(default=None, repr=False)
    """Speed limit of signs [m/s]; None: no limit."""

    @property
    def intersections(self) -> int:
        return int(self.rows) * int(self.cols)


@frozen
class LoneRoad(Street):
    """`map road(...)`: one road without intersections, straight, curved, or with one bend."""

    kind: ClassVar[str] = "road"
    lanes: int = 1
    """Lanes per direction."""
    length: float = 500.0
    """Length along the middle of the road [m]."""
    curve: float | None = None
    """Radius of its bend, positive to the left [m]; None: it is straight."""
    bend: float | None = None
    """Angle of its bend [rad], with straight ends; None: the whole road is curved."""
    lane_width: float = 3.5
    one_way: bool = False
    left_hand: bool = False
    speed_limit: float | None = field(default=None, repr=False)

    @property
    def intersections(self) -> int:
        return 0


@frozen
class Roundabout(Street):
    """`map roundabout(...)`: a ring with arms that lead into it; traffic in the ring has priority."""

    kind: ClassVar[str] = "roundabout"
    arms: int = 4
    lanes: int = 1
    """Lanes per direction of the arms, and lanes of the ring."""
    radius: float = 20.0
    """Radius of the outer edge of the ring [m]."""
    corner_radius: float = 12.0
    """Radius of the kerbs between the arms and the ring [m]."""
    approach: float = 50.0
    """Length of every arm from its line to the end of the road [m]."""
    lane_width: float = 3.5
    left_hand: bool = False
    speed_limit: float | None = field(default=None, repr=False)

    @property
    def intersections(self) -> int:
        """Return the number of intersections: an arm meets the ring in each."""
        return int(self.arms)


@frozen
class MapFile:
    """`map opendrive(...)`: the roads of a file."""

    kind: ClassVar[str] = "opendrive"
    speed_limit: ClassVar[float | None] = None
    """The file's lanes have their own limits."""

    file: str
    """Name of the file in the scenario."""
    path: str = field(repr=False)
    """Path at which it was found."""
    digest: str
    """Digest of its contents: a different file is a different road."""
    intersections: int


@frozen
class LaneletFile(MapFile):
    """`map lanelet2(...)`: the lanelets of a file."""

    kind: ClassVar[str] = "lanelet2"

    origin: tuple[float, float] | None = None
    """Latitude and longitude of (0, 0) [deg]; None for the local coordinates of the file."""


MapSpec = RoadSpec | LoneRoad | Roundabout | MapFile
KINDS: Mapping[str, type[MapSpec]] = {
    spec.kind: spec for spec in (RoadSpec, LoneRoad, Roundabout, MapFile, LaneletFile)
}
"""Specifications by the word after `map`."""


LATER: Mapping[str, Any] = {"speed_limit": None, **{each.name: each.default for each in fields(Street)}}
"""Fields that old versions lack, with their defaults."""


def map_name(spec: MapFile) -> str:
    """Return the name of a copy of its file."""
    return PurePath(spec.path).name


def digest_of(path: Path) -> str:
    """Return 32 hexadecimal digits over the contents of a file."""
    return blake2b(path.read_bytes(), digest_size=16).hexdigest()


def map_content(spec: MapSpec) -> dict[str, Any]:
    """Return a specification for JSON; fields that old versions lack are omitted where they have their defaults."""
    said = {name: value for name, value in asdict(spec).items() if name not in LATER or value != LATER[name]}
    return {"kind": spec.kind, **said}


def map_from(content: Mapping[str, Any]) -> MapSpec:
    """Return the specification of `map_content`; without a kind it is a grid."""
    values = dict(content)
    for name in ("crossings", "origin"):
        if isinstance(values.get(name), list):
            values[name] = tuple(values[name])
    return KINDS[values.pop("kind", RoadSpec.kind)](**values)
