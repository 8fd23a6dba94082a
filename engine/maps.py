"""What a `map` line asks for: one type for each kind of road, in SI units. `engine.road` builds a network from it."""

from collections.abc import Mapping
from dataclasses import asdict, field
from hashlib import blake2b
from pathlib import Path, PurePath
from typing import Any, ClassVar

from engine.frozen import frozen


@frozen
class RoadSpec:
    """`map intersection(...)`: a grid of intersections."""

    kind: ClassVar[str] = "intersection"

    ways: int = 4
    lanes: int = 1
    """Lanes a direction."""
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
    """How far back from the kerbs blocks of buildings stand between the arms [m]; None: there are none."""
    speed_limit: float | None = field(default=None, repr=False)
    """What signs allow [m/s]; None: there are none."""

    @property
    def intersections(self) -> int:
        return int(self.rows) * int(self.cols)


@frozen
class LoneRoad:
    """`map road(...)`: one road without intersections, straight, curved, or with one bend."""

    kind: ClassVar[str] = "road"
    lanes: int = 1
    """Lanes a direction."""
    length: float = 500.0
    """Along the middle of the road [m]."""
    curve: float | None = None
    """Radius of its bend, positive to the left [m]; None: it is straight."""
    bend: float | None = None
    """Angle of its bend [rad], straight before and behind it; None: the whole road curves."""
    lane_width: float = 3.5
    one_way: bool = False
    left_hand: bool = False
    speed_limit: float | None = field(default=None, repr=False)

    @property
    def intersections(self) -> int:
        return 0


@frozen
class Roundabout:
    """`map roundabout(...)`: a ring that arms lead into; who is in the ring goes first."""

    kind: ClassVar[str] = "roundabout"
    arms: int = 4
    lanes: int = 1
    """Lanes a direction of the arms, and of the ring."""
    radius: float = 20.0
    """Of the outer edge of the ring [m]."""
    corner_radius: float = 12.0
    """Of the kerbs between the arms and the ring [m]."""
    approach: float = 50.0
    """Length of every arm from its line to the end of the road [m]."""
    lane_width: float = 3.5
    left_hand: bool = False
    speed_limit: float | None = field(default=None, repr=False)

    @property
    def intersections(self) -> int:
        """Where an arm meets the ring."""
        return int(self.arms)


@frozen
class MapFile:
    """`map opendrive(...)`: the roads of a file."""

    kind: ClassVar[str] = "opendrive"
    speed_limit: ClassVar[float | None] = None
    """Its lanes have limits of their own."""

    file: str
    """As it is named where it is asked for."""
    path: str = field(repr=False)
    """Where it was found."""
    digest: str
    """Of its contents: another file is another road."""
    intersections: int


MapSpec = RoadSpec | LoneRoad | Roundabout | MapFile
KINDS: Mapping[str, type[MapSpec]] = {spec.kind: spec for spec in (RoadSpec, LoneRoad, Roundabout, MapFile)}
"""By the word behind `map`."""


def map_name(spec: MapFile) -> str:
    """What a copy of its file is called."""
    return PurePath(spec.path).name


def digest_of(path: Path) -> str:
    """32 hexadecimal digits over the contents of a file."""
    return blake2b(path.read_bytes(), digest_size=16).hexdigest()


def map_content(spec: MapSpec) -> dict[str, Any]:
    """A specification as JSON can hold it; without a speed limit as before there were any."""
    said = {name: value for name, value in asdict(spec).items() if name != "speed_limit" or value is not None}
    return {"kind": spec.kind, **said}


def map_from(content: Mapping[str, Any]) -> MapSpec:
    """What `map_content` made; without a kind it is a grid."""
    values = dict(content)
    return KINDS[values.pop("kind", RoadSpec.kind)](**values)
