"""Results of a search (`engine.search.run`): its progress after each generation, and the finished campaign."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from engine.config import SearchConfig
from engine.display import counted, facts_table
from engine.program import ParamSpace
from engine.search.evaluations import Evaluations, Figures, GenerationFigures, figures
from engine.search.insight.gene_effects import GeneEffect
from engine.search.insight.kinds import Failures, FoundKind, failures, kinds
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import Case
from engine.tables import Ints

FINISHED, STOPPED, INTERRUPTED = "finished", "stopped", "interrupted"
"""Ways in which a search ends."""


@dataclass(frozen=True)
class Progress:
    """Progress report of a campaign after one generation."""

    generation: int
    generations: int
    evaluations: Evaluations
    """This generation alone."""
    figures: GenerationFigures
    best: Case | None
    """The worst case so far; its row counts from the campaign's first individual."""
    simulations: int
    """Distinct simulations so far."""
    elapsed: float
    """[s]"""
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES
    """Names of the objectives."""

    @property
    def simulations_per_second(self) -> float:
        return self.simulations / self.elapsed if self.elapsed > 0.0 else 0.0

    @property
    def remaining(self) -> float:
        """Return the time left at the pace so far [s]."""
        done = self.generation + 1
        return self.elapsed / done * (self.generations - done)


OnGeneration = Callable[[Progress], None]


@dataclass(frozen=True)
class Campaign:
    """A search from its first generation to the last that was finished."""

    method: str
    """Its name."""
    preset: str
    """Preset of the genetic algorithm; "" for all other methods."""
    space: ParamSpace
    config: SearchConfig
    evaluations: Evaluations
    generations: tuple[GenerationFigures, ...]
    by_individual: Figures
    """Figures of the whole campaign; an elite counts in each generation that contains it."""
    by_simulation: Figures
    """Figures of the whole campaign; each simulation counts once."""
    distinct_collisions: int
    """Different genomes that collided."""
    worst: tuple[Case, ...]
    """Up to ten cases of many kinds, worst first: risk, then avoidable ones, then continuous risk (see `ranking`)."""
    genes: tuple[GeneEffect, ...]
    elapsed: float
    """[s]"""
    status: str
    """Status at the end: `finished`; `stopped` by the user, fully analysed; or `interrupted` during the analyses."""
    blame: Ints
    """(n, k) `Blame`: verdict of the reference driver on each distinct simulation in which the ego collided."""
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES
    """Names of the objectives."""

    @property
    def stopped(self) -> bool:
        """Return True if `cortexc resume` has work left to do."""
        return self.status != FINISHED

    @cached_property
    def kinds(self) -> tuple[FoundKind, ...]:
        """Return the kinds of the campaign's collisions, first those that a competent driver would have avoided."""
        return kinds(self.evaluations, self.blame)

    @cached_property
    def failures(self) -> Failures:
        """Return the outcome counts of the distinct simulations."""
        return failures(self.evaluations, self.blame)

    def __repr__(self) -> str:
        """Return one line, for notebooks; a full `repr` would print every evaluation."""
        found = self.by_individual
        method = f"{self.method} {self.preset}".strip()
        sizes = f"{counted(found.nc, 'collision')} among {counted(found.individuals, 'individual')}"
        return f"Campaign({method}: {sizes}, {found.nis} invalid)"

    def facts(self) -> Iterator[tuple[str, str]]:
        """Yield the results in a few rows of label and text."""
        found, simulated = self.by_individual, self.by_simulation
        yield "method", f"{self.method} {self.preset}".strip()
        yield "individuals, distinct simulations", f"{found.individuals:,}, {simulated.runs:,}"
        came = self.failures
        if came.judged:
            yield "avoidable collisions, their kinds", f"{came.avoidable:,}, {came.avoidable_kinds:,}"
        yield "collisions, their kinds", f"{came.collisions:,}, {came.kinds:,}"
        yield "mean risk, mean least distance", f"{found.rl:.2f}, {found.mdg:.2f} m"
        yield "invalid", f"{found.nis:,}"
        for case in self.worst[:3]:
            genome = zip(self.space.names, case.genome, strict=True)
            yield f"worst case {case.rank}", f"risk {case.score}: " + ", ".join(f"{n} {v:.4g}" for n, v in genome)

    def _repr_html_(self) -> str:
        return facts_table(self.facts())

    def last(self, count: int, by_simulation: bool = False) -> Figures:
        """Return the figures of those of the last `count` configured generations that were run."""
        rows = self.evaluations.places[:, 0] >= self.config.generations - count
        return figures(self.evaluations, rows & self.evaluations.simulated if by_simulation else rows)
