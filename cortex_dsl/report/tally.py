"""Counts over sampled scenes: verdicts, attempts, and how often each requirement was tested and failed."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cortex_dsl.report.numbers import ratio
from engine.program import Program
from engine.scenes import Scenes
from engine.search.evaluations import Evaluations
from engine.vocabulary import Verdict

Counts = NDArray[np.int64]


def _zeros() -> Counts:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Tally:
    """Sums over scenes; two tallies of the same program add up."""

    scenes: int = 0
    verdicts: Counts = field(default_factory=lambda: np.zeros(len(Verdict), dtype=np.int64))
    """(len(Verdict),)"""
    attempts: int = 0
    tested: Counts = field(default_factory=_zeros)
    """(requirements,)"""
    failed: Counts = field(default_factory=_zeros)
    """(requirements,) of those tested; a requirement is only tested where the earlier ones passed."""

    def plus(self, scenes: Scenes) -> "Tally":
        tested, failed = scenes.tested.sum(axis=0, dtype=np.int64), scenes.failed.sum(axis=0, dtype=np.int64)
        return Tally(
            self.scenes + len(scenes),
            self.verdicts + np.bincount(scenes.verdict, minlength=len(Verdict)),
            self.attempts + int(scenes.attempts.sum()),
            tested + (self.tested if self.tested.size else 0),
            failed + (self.failed if self.failed.size else 0),
        )

    @classmethod
    def of_search(cls, evaluations: Evaluations) -> "Tally":
        """Every distinct simulation of a search."""
        runs, new = evaluations.rollouts, ~evaluations.reused
        verdicts = np.bincount(runs.verdict[new].ravel(), minlength=len(Verdict))
        tested, failed = (counts[new].sum(axis=(0, 1), dtype=np.int64) for counts in (runs.tested, runs.failed))
        return cls(int(verdicts.sum()), verdicts, int(runs.attempts[new].sum()), tested, failed)

    @property
    def valid(self) -> int:
        return int(self.verdicts[Verdict.VALID])

    @property
    def always(self) -> bool:
        """Whether every attempt was accepted."""
        return self.valid == self.attempts

    @property
    def acceptance(self) -> float:
        """Accepted attempts of all attempts; NaN without any."""
        return ratio(self.valid, self.attempts)

    def pass_rate(self, requirement: int) -> float:
        tested = int(self.tested[requirement])
        return 1.0 - int(self.failed[requirement]) / tested if tested else math.nan


def first_culprit(program: Program, tally: Tally) -> int | None:
    """The requirement that most deserves a look: the first that never passed, else the one that passes least."""
    rated = [
        (tally.pass_rate(i), i) for i in range(min(len(program.requirements), len(tally.failed))) if tally.failed[i] > 0
    ]
    never = [index for rate, index in rated if rate == 0.0]
    return never[0] if never else min(rated)[1] if rated else None
