"""The scenarios, and what a failure is and by which mechanism it came."""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from benchmarks.suite.highway_driver import EXTRA, MODULE, PACKAGE, IdmMobil
from benchmarks.suite.planting import Defect, delayed_by
from cortex_dsl import Scenario, load
from engine.extras import installing, is_installed
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
TUNE, JUDGE, PLANTED, DRIVEN = "tune", "judge", "planted", "outside"
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
    "outside_cut_in": DRIVEN,
    "outside_merge": DRIVEN,
    "outside_stop_and_go": DRIVEN,
}
"""File, without its ending, and its group."""
FOLDERS = {PLANTED: HERE / "planted", DRIVEN: HERE / "highway"}
"""Folder of the files of a group, if it is not this one."""


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
    """Return the names of a group, of `all` groups, or those that stand with commas between them."""
    if names in (TUNE, JUDGE, PLANTED, DRIVEN):
        return [name for name, half in HALVES.items() if half == names]
    return list(HALVES) if names == "all" else names.split(",")


def is_driven(name: str) -> bool:
    """Return True if a driver from outside drives the ego of the file."""
    return HALVES.get(name) == DRIVEN


def runnable(names: Sequence[str]) -> list[str]:
    """Return the names of files that can be simulated here, and say on stderr why the others are left out."""
    left_out = [] if is_installed(MODULE) else [name for name in names if is_driven(name)]
    if left_out:
        cure = f"{', '.join(left_out)}: left out, as {PACKAGE} is not installed ({installing(EXTRA)})"
        print(cure, file=sys.stderr)
    return [name for name in names if name not in left_out]


def scenario(name: str) -> Scenario:
    """Return the scenario of a file, with the driver from outside where the file needs one that is installed."""
    made = load(FOLDERS.get(HALVES.get(name, ""), HERE) / f"{name}.scn")
    return made.driven_by(IdmMobil()) if is_driven(name) and is_installed(MODULE) else made


def digest_of(name: str, program: Program) -> str:
    """Return the digest of a file's program, with the version of a driver from outside: results are of both."""
    return f"{program.digest}, {PACKAGE} {version(PACKAGE)}" if is_driven(name) else program.digest
