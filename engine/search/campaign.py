"""A search as its loop (`engine.search.run`) hands it over: what it says after each generation, and what it found."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from engine.config import SearchConfig
from engine.display import facts_table
from engine.program import ParamSpace
from engine.search.evaluations import Evaluations, Figures, GenerationFigures, figures
from engine.search.insight.gene_effects import GeneEffect
from engine.search.insight.kinds import Failures, FoundKind, failures, kinds
from engine.search.protocol import SOUGHT
from engine.search.ranking import Case
from engine.tables import Ints

FINISHED, STOPPED, INTERRUPTED = "finished", "stopped", "interrupted"
"""How a search may end."""


@dataclass(frozen=True)
class Progress:
    """What a campaign says after each generation."""

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
    objective: tuple[str, ...] = SOUGHT
    """What is sought."""

    @property
    def simulations_per_second(self) -> float:
        return self.simulations / self.elapsed if self.elapsed > 0.0 else 0.0

    @property
    def remaining(self) -> float:
        """Time left at the pace so far [s]."""
        done = self.generation + 1
        return self.elapsed / done * (self.generations - done)


OnGeneration = Callable[[Progress], None]


@dataclass(frozen=True)
class Campaign:
    """A search from its first generation to the last that was finished."""

    method: str
    """Its name."""
    preset: str
    """Of the genetic algorithm; "" for other methods."""
    space: ParamSpace
    config: SearchConfig
    evaluations: Evaluations
    generations: tuple[GenerationFigures, ...]
    by_individual: Figures
    """Over the whole campaign, elites counted in each generation that kept them."""
    by_simulation: Figures
    """Over the whole campaign, each simulation once."""
    distinct_collisions: int
    """Different genomes that collided."""
    worst: tuple[Case, ...]
    """Up to ten of many kinds, worst first: risk, then avoidable ones, then continuous risk (see `ranking`)."""
    genes: tuple[GeneEffect, ...]
    elapsed: float
    """[s]"""
    status: str
    """How it ended: `finished`, `stopped` by the user with all analyses of what was done, or `interrupted` in them."""
    blame: Ints
    """(n, k) `Blame`: what the reference driver says of each distinct simulation in which the ego collided."""
    objective: tuple[str, ...] = SOUGHT
    """What was sought."""

    @property
    def stopped(self) -> bool:
        """Whether something is left to do, which `cortexc resume` does."""
        return self.status != FINISHED

    @cached_property
    def kinds(self) -> tuple[FoundKind, ...]:
        """Of its collisions, those that a competent driver would have avoided first."""
        return kinds(self.evaluations, self.blame)

    @cached_property
    def failures(self) -> Failures:
        """What its distinct simulations came to."""
        return failures(self.evaluations, self.blame)

    def __repr__(self) -> str:
        """One line, for notebooks: the whole would be every evaluation."""
        found = self.by_individual
        method = f"{self.method} {self.preset}".strip()
        return f"Campaign({method}: {found.nc} collisions among {found.individuals} individuals, {found.nis} invalid)"

    def facts(self) -> Iterator[tuple[str, str]]:
        """What was found, in a few rows."""
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
        """Figures of the generations among the configured last `count` ones that were run."""
        rows = self.evaluations.places[:, 0] >= self.config.generations - count
        return figures(self.evaluations, rows & self.evaluations.simulated if by_simulation else rows)
