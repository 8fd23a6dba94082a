"""The tracks of a recording, one for each actor, as every reader returns them."""

from dataclasses import dataclass, replace

from engine.interchange.motion import gaps_between, jump_remark, without_jumps
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import ActorKind


@dataclass(frozen=True)
class TableTrack:
    """One actor of a table; SI units, headings not wrapped, positions of centres."""

    label: str
    """Mark of its rows: a name, or an idx."""
    name: str
    kind: ActorKind
    is_ego: bool
    """True if the table marks it as the ego."""
    time: Floats
    """(samples,) ascending; from the table's first [s]."""
    positions: Floats
    """(samples, 2)"""
    heading: Floats
    """(samples,) NaN where unknown, until `facing` assumes a heading."""
    speed: Floats
    """Speed of the rear axle along the heading."""
    length: float
    width: float
    rear_to_center: float
    slides: Bools | None = None
    """(samples,) True while it slides after an impact; None if unknown."""
    breaks: Bools | None = None
    """(samples,) True before a jump or an unseen step, across which it is absent; None if there is none."""
    ahead: float = 0.0
    """Distance of `positions` ahead of the centre where the heading is NaN [m]."""
    height: Floats | None = None
    """(samples,) z [m], NaN if unknown; None: all actors are in one plane."""
    assumed: Bools | None = None
    """(samples,) True where the heading is an assumption; None: nowhere."""

    @property
    def gaps(self) -> Ints:
        """Return the samples after which it is absent for a while."""
        return gaps_between(self.time, self.breaks)

    def without_jumps(self) -> tuple["TableTrack", tuple[str, ...]]:
        """Return the track with a gap at each jump (see `engine.interchange.motion`), and a remark on them."""
        remaining, breaks, jumps = without_jumps(self.time, self.positions)
        remark = jump_remark(self.name, self.time, self.positions, jumps)
        return replace(self, breaks=breaks).only(remaining), (remark,) if remark else ()

    def only(self, remaining: slice | Bools) -> "TableTrack":
        """Return the track of some of its samples alone."""
        columns = ("time", "positions", "heading", "speed", "slides", "breaks", "height", "assumed")
        cut = {name: values[remaining] for name in columns if (values := getattr(self, name)) is not None}
        return replace(self, **cut)


@dataclass(frozen=True)
class Tracks:
    """All actors of a recording, in its order."""

    tracks: tuple[TableTrack, ...]
    remarks: tuple[str, ...]
    file: str
    begin: float = 0.0
    """First time in the file [s]; tracks count from there."""
    numbered: bool = False
    """True if actors have numbers only, of which 0 is the ego's by default."""
    buildings: Floats | None = None
    """Buildings, see `Recording.buildings`."""
