"""The tracks of a recording, one for each actor, as every reader returns them."""

from dataclasses import dataclass, replace

from engine.interchange.motion import gaps_between, jump_remark, without_jumps
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import ActorKind


@dataclass(frozen=True)
class TableTrack:
    """One actor as a table describes it; SI units, headings not wrapped, positions of centres."""

    label: str
    """What its rows are marked with: a name, or an idx."""
    name: str
    kind: ActorKind
    is_ego: bool
    """Whether the table marks it as the ego."""
    time: Floats
    """(samples,) ascending; from the table's first [s]."""
    positions: Floats
    """(samples, 2)"""
    heading: Floats
    """(samples,) NaN where nothing shows it, until `facing` assumes one."""
    speed: Floats
    """Speed of the rear axle along the heading."""
    length: float
    width: float
    rear_to_center: float
    slides: Bools | None = None
    """(samples,) where it is loose after an impact; None where nothing says so."""
    breaks: Bools | None = None
    """(samples,) after which a jump or an unseen step follows, over which it is absent; None: after none."""
    ahead: float = 0.0
    """How far ahead of the centre `positions` lie where the heading is NaN [m]."""
    height: Floats | None = None
    """(samples,) z, NaN where it is unknown [m]; None: all actors are in one plane."""
    assumed: Bools | None = None
    """(samples,) where the heading is an assumption; None: nowhere."""

    @property
    def gaps(self) -> Ints:
        """Return the samples after which it is absent for a while."""
        return gaps_between(self.time, self.breaks)

    def without_jumps(self) -> tuple["TableTrack", tuple[str, ...]]:
        """Return the track with a gap at each jump (see `engine.interchange.motion`), and a remark on them."""
        kept, breaks, jumps = without_jumps(self.time, self.positions)
        remark = jump_remark(self.name, self.time, self.positions, jumps)
        return replace(self, breaks=breaks).only(kept), (remark,) if remark else ()

    def only(self, kept: slice | Bools) -> "TableTrack":
        """Return the track of some of its samples alone."""
        columns = ("time", "positions", "heading", "speed", "slides", "breaks", "height", "assumed")
        cut = {name: values[kept] for name in columns if (values := getattr(self, name)) is not None}
        return replace(self, **cut)


@dataclass(frozen=True)
class Tracks:
    """All actors of a recording, in the order in which it names them."""

    tracks: tuple[TableTrack, ...]
    remarks: tuple[str, ...]
    file: str
    begin: float = 0.0
    """The first time, as the file counts [s]; tracks count from there."""
    numbered: bool = False
    """Whether actors have numbers alone, of which 0 is the ego's unless something else is said."""
    buildings: Floats | None = None
    """Buildings, see `Recording.buildings`."""
