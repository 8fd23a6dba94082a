"""The scenarios, and what a failure is and by which mechanism it came."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cortex_dsl import Scenario, load
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Fault, Side

HERE = Path(__file__).parent
TUNE, JUDGE = "tune", "judge"
HALVES = {
    "crossing_hesitates": TUNE,
    "crowd": TUNE,
    "leader_brakes": TUNE,
    "left_across": TUNE,
    "three_partners": TUNE,
    "walker_hesitates": TUNE,
    "blind_corner": JUDGE,
    "crowd_far": JUDGE,
    "cut_in": JUDGE,
    "oncoming_hesitates": JUDGE,
    "three_partners_noisy": JUDGE,
    "two_walkers": JUDGE,
}
"""File, without its ending, and what it is for."""


CROWD = 4
"""Of more actors than these, everybody is a mechanism."""


@dataclass(frozen=True)
class Runs:
    """What is known of simulations, row by row: arrays (n,) of each run's own pair."""

    collided: Bools
    fault: Ints
    pair: Ints
    """The ego and actor `pair` + 1."""
    side: Ints
    ego_speed: Floats
    other_speed: Floats

    @property
    def failed(self) -> Bools:
        return self.collided & (self.fault == Fault.EGO)

    def mechanisms(self, actors: Sequence[str]) -> list[str]:
        """Of the failures, in their order: whom the ego met and on which side of itself; in a crowd whom alone."""
        partners = [(str(actors[int(self.pair[row]) + 1]), Side(self.side[row])) for row in np.flatnonzero(self.failed)]
        return [name if len(actors) > CROWD else f"{name} {side.name.lower()}" for name, side in partners]

    def cells(self, actors: Sequence[str]) -> list[tuple[str, int, int]]:
        """Of the failures: mechanism, and both speeds in steps of 2 m/s."""
        rows = np.flatnonzero(self.failed)
        speeds = np.stack([self.ego_speed[rows], self.other_speed[rows]], axis=1)
        bins = np.floor(np.abs(speeds) / 2.0).astype(int).tolist()
        return [(name, *pair) for name, pair in zip(self.mechanisms(actors), bins, strict=True)]


def named(names: str) -> list[str]:
    """`all`, a half, or names with commas between them."""
    if names in (TUNE, JUDGE):
        return [name for name, half in HALVES.items() if half == names]
    return list(HALVES) if names == "all" else names.split(",")


def scenario(name: str) -> Scenario:
    return load(HERE / f"{name}.scn")
