"""Things that were worked out for many scenes, to be plotted: one value a scene, and which of them collided."""

from collections.abc import Sequence
from dataclasses import dataclass

from engine.tables import Bools, Floats


@dataclass(frozen=True)
class Plotted:
    """One expression. Values are in the unit that is shown; NaN or infinite where a scene has none."""

    name: str
    unit: str
    values: Floats
    """(n,)"""
    options: Sequence[str] = ()
    """Meanings of the values 0, 1, … of a truth or a finite choice; () for a number."""
    kept: Bools | None = None
    """(n,) of a formula over the run: its verdict, the values being its robustness."""


@dataclass(frozen=True)
class Shown:
    """One thing, or two."""

    things: Sequence[Plotted]
    collided: Bools
    """(n,)"""
    ran: bool
    """Whether the scenes were run at all."""
    over_run: bool
    """Whether a thing speaks of the run: then only valid runs are shown."""
    seed: int

    @property
    def noun(self) -> str:
        return "run" if self.over_run else "scene"

    @property
    def note(self) -> str:
        """Return the number of runs or scenes."""
        what = "instant runs" if self.over_run else "accepted scenes"
        return f"{len(self.collided):,} {what} of seed {self.seed}"
