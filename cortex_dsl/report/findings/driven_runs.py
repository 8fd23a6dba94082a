"""Results of sampled scenes with an external driver: counts of endings, and the rate of collisions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from cortex_dsl.report.findings.readable import ratio
from cortex_dsl.report.findings.tally import Counts
from engine.outcomes import Outcomes
from engine.program import Program
from engine.search.statistics import Interval, clopper_pearson
from engine.tables import Ints
from engine.vocabulary import Blame, EndReason, Sense, Verdict


class Ending(IntEnum):
    """How a driven scene ended. Scenes that were aborted or whose driver failed are no runs that count."""

    NO_COLLISION = 0
    AVOIDABLE = 1
    UNAVOIDABLE = 2
    STRUCK = 3
    BUILDING = 4
    ABORTED = 5
    CONTROLLER = 6
    DISPUTED = 7
    NO_MODEL = 8


ENDINGS = {
    Ending.NO_COLLISION: ("no collision", "good", ""),
    Ending.AVOIDABLE: ("collision", "bad", "avoidable: all reference drivers stop or pass in time"),
    Ending.UNAVOIDABLE: ("collision", "warn", "not avoidable by any reference driver"),
    Ending.DISPUTED: ("collision", "bad", "disputed: some reference drivers avoid it"),
    Ending.NO_MODEL: ("collision", "quiet", "no reference driver covers it"),
    Ending.STRUCK: ("collision", "quiet", "the ego was struck from behind, or while it stood: not its failure"),
    Ending.BUILDING: ("building", "bad", "the ego ran into one"),
    Ending.ABORTED: ("aborted", "warn", "broke a requirement on the run, and does not count"),
    Ending.CONTROLLER: ("failed", "bad", "the driver failed: what would have become of these is not known"),
}
"""Word, style and meaning of each ending."""
DRIVEN = (Verdict.VALID, Verdict.ABORTED, Verdict.CONTROLLER)
"""Verdicts of runs that began."""
COLLISIONS = (Ending.AVOIDABLE, Ending.DISPUTED, Ending.UNAVOIDABLE, Ending.NO_MODEL, Ending.STRUCK)
OF_BLAME = {
    Blame.AVOIDABLE: Ending.AVOIDABLE,
    Blame.DISPUTED: Ending.DISPUTED,
    Blame.NO_MODEL: Ending.NO_MODEL,
    Blame.STRUCK: Ending.STRUCK,
}


@dataclass(frozen=True)
class DrivenRuns:
    """Sums over driven scenes; two of the same program and driver add up."""

    counts: Counts = field(default_factory=lambda: np.zeros(len(Ending), dtype=np.int64))
    """(len(Ending),)"""
    broken: Mapping[str, int] = field(default_factory=dict[str, int])
    """Number of valid runs that break each expectation of the file."""

    def plus(self, program: Program, outcomes: Outcomes, blame: Ints) -> "DrivenRuns":
        """Return the counts with further runs; `blame` (n,) as by `engine.verdicts.blame`."""
        endings = np.where(outcomes.collided, int(Ending.UNAVOIDABLE), int(Ending.NO_COLLISION))
        for said, ending in OF_BLAME.items():
            endings[blame == said] = ending
        endings[outcomes.end_reason == EndReason.BUILDING] = Ending.BUILDING
        endings[outcomes.verdict == Verdict.ABORTED] = Ending.ABORTED
        endings[outcomes.verdict == Verdict.CONTROLLER] = Ending.CONTROLLER
        driven = np.isin(outcomes.verdict, DRIVEN)
        broken = {
            each.name: self.broken.get(each.name, 0) + int((outcomes.broken[:, number] == 1.0).sum())
            for number, each in enumerate(program.judged.objectives)
            if each.sense is Sense.EXPECT
        }
        return DrivenRuns(self.counts + np.bincount(endings[driven], minlength=len(Ending)), broken)

    def __getitem__(self, ending: Ending) -> int:
        return int(self.counts[ending])

    @property
    def driven(self) -> int:
        """Return the number of scenes with an external driver."""
        return int(self.counts.sum())

    @property
    def valid(self) -> int:
        """Runs that count."""
        return self.driven - self[Ending.ABORTED] - self[Ending.CONTROLLER]

    @property
    def collisions(self) -> int:
        return sum(self[each] for each in COLLISIONS)

    @property
    def interval(self) -> Interval:
        """Return the 95 % interval of the collision rate.

        Its ends count scenes with a failed driver as safe, and as collisions.
        """
        return clopper_pearson(self.collisions, self.valid, unknown=self[Ending.CONTROLLER])


def runs_content(runs: DrivenRuns, driver: str) -> dict[str, Any]:
    """Return the counts as a JSON document."""
    return {
        "driver": driver,
        "scenes": runs.driven,
        "endings": {each.name.lower(): runs[each] for each in Ending},
        "collisions": runs.collisions,
        "collision_rate": {"of": runs.valid, "value": ratio(runs.collisions, runs.valid), "interval": runs.interval},
        "broken": dict(runs.broken),
    }
