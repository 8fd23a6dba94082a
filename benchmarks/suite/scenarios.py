"""The scenarios, and what a failure is and by which mechanism it came."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.suite.planting import Defect, delayed_by
from cortex_dsl import Scenario, load
from engine.program import Program
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Fault, Side

HERE = Path(__file__).parent
HIDDEN = HERE / "planted" / "hidden.json"
"""Defects of the planted files, by file, to tell which of them a failure found."""
DEFECTS = {
    name: tuple(Defect(tuple(row["genes"]), tuple(row["centre"]), row["sharpness"]) for row in rows)
    for name, rows in json.loads(HIDDEN.read_text()).items()
}
TUNE, JUDGE, PLANTED = "tune", "judge", "planted"
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
    **dict.fromkeys(DEFECTS, PLANTED),
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
    genomes: Floats
    """(n, d) in file units."""

    @property
    def failed(self) -> Bools:
        return self.collided & (self.fault == Fault.EGO)

    def mechanisms(self, program: Program, defects: Sequence[Defect] = ()) -> list[str]:
        """Of the failures, in their order: the defect that delays the brake most; in a file without defects whom the
        ego met and on which side of itself, in a crowd whom alone.
        """
        rows, actors = np.flatnonzero(self.failed), program.actors
        if not defects:
            partners = [(str(actors[int(self.pair[row]) + 1]), Side(self.side[row])) for row in rows]
            return [name if len(actors) > CROWD else f"{name} {side.name.lower()}" for name, side in partners]
        space = program.space
        units = (self.genomes[rows] - space.low) / (space.high - space.low)
        own = [units[:, [space.names.index(gene) for gene in defect.genes]] for defect in defects]
        worst, late = delayed_by(defects, own)
        return [
            mechanism_of(number) if any_at_all else NO_DEFECT for number, any_at_all in zip(worst, late, strict=True)
        ]

    def cells(self, program: Program, defects: Sequence[Defect] = ()) -> list[tuple[str, int, int]]:
        """Of the failures: mechanism, and both speeds in steps of 2 m/s."""
        rows = np.flatnonzero(self.failed)
        speeds = np.stack([self.ego_speed[rows], self.other_speed[rows]], axis=1)
        bins = np.floor(np.abs(speeds) / 2.0).astype(int).tolist()
        return [(name, *pair) for name, pair in zip(self.mechanisms(program, defects), bins, strict=True)]


NO_DEFECT = "no defect"


def mechanism_of(defect: int) -> str:
    return f"defect {defect + 1}"


def planted_in(name: str) -> tuple[Defect, ...]:
    """The defects of a file, none of one that was written by hand."""
    return DEFECTS.get(name, ())


def named(names: str) -> list[str]:
    """`all`, a half, or names with commas between them."""
    if names in (TUNE, JUDGE, PLANTED):
        return [name for name, half in HALVES.items() if half == names]
    return list(HALVES) if names == "all" else names.split(",")


def scenario(name: str) -> Scenario:
    return load(HERE / (PLANTED if HALVES.get(name) == PLANTED else "") / f"{name}.scn")
