"""The interface of searcher and campaign: `ask` returns proposals, `tell` takes their results. A searcher sees nothing
else. `GenerationSearcher` is the base class of the searchers of cortexc.

An *individual* is one place in a generation. Its `Birth` is the place where its genome was first simulated: an elite
has the birth of the individual that it repeats, and so the stream of its scenes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple, Protocol

from numpy.random import Generator

from engine.outcomes import Outcomes
from engine.program import ParamSpace
from engine.vocabulary import GeneKind, Verdict

Genome = tuple[float, ...]
"""Gene values in the file's own units, in the order of the file. Equal tuples are equal genomes."""

StreamAt = Callable[[int, int], Generator]
"""(generation, slot) -> the stream of the operator that fills that slot; no two addresses share numbers."""


MEASURES = ("min_distance", "closing_speed", "ego_speed", "other_speed", "approach_angle", "pair", "side")
"""Measures of a result in addition to the risk, of an individual's worst rollout: columns of
`engine.assessment`.
"""


DEFAULT_OBJECTIVES = ("risk",)
"""Default objective of a search: the risk of the paper."""
ObjectiveSpec = str | Callable[[Outcomes], Any]
"""An objective: its name (`engine.search.objectives`), or a function from outcomes to one number per scene."""


def function_name(function: Callable[..., Any]) -> str:
    """Return the name of a function as an objective."""
    return str(getattr(function, "__name__", type(function).__name__))


class Operator(IntEnum):
    """Origin of an individual."""

    RANDOM = 0
    ELITE = 1
    CROSSOVER = 2
    MUTATION = 3
    CROSSOVER_MUTATION = 4
    """A child whose genome was known for all tried parents, so that one of its genes was drawn again."""
    SAMPLED = 5
    """Drawn from a distribution that the search has learnt."""


class Status(IntEnum):
    """Status of an evaluation, as a searcher may know it."""

    VALID = 0
    INVALID = 1
    ERROR = 2
    REUSED = 3
    """An elite's: the stored result of its birth."""


class Birth(NamedTuple):
    """Place where an individual was first simulated: its identity, and its rank by age."""

    generation: int
    place: int


@dataclass(frozen=True)
class Box:
    """The space of a search: each gene in its own closed range, file units."""

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    kinds: tuple[GeneKind, ...]
    """INTEGER and INDEX genes take whole numbers only."""

    def __len__(self) -> int:
        return len(self.names)

    @classmethod
    def of(cls, space: ParamSpace) -> "Box":
        kinds = tuple(GeneKind(kind) for kind in space.kinds)
        return cls(space.names, tuple(space.low.tolist()), tuple(space.high.tolist()), kinds)

    def holds(self, genome: Genome) -> bool:
        """Return True if the genome is in the box, with discrete genes on whole numbers."""
        return len(genome) == len(self) and all(
            low <= value <= high and (kind is GeneKind.CONTINUOUS or value == int(value))
            for value, low, high, kind in zip(genome, self.low, self.high, self.kinds, strict=True)
        )


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a proposal."""

    status: Status
    fitness: float
    """Larger is riskier; NaN unless valid or reused."""
    verdict: Verdict
    continuous: float = float("nan")
    """Continuous risk, which orders runs with equal integer risk; NaN as `fitness`."""
    failure: bool = False
    """True if the run is a find of the search: the ego collided, or the objective calls it a find."""
    measures: tuple[float, ...] = ()
    """Measures of the run, in the order of `MEASURES`; each NaN, or empty, unless valid or reused."""
    objective_values: tuple[float, ...] = ()
    """Values of the objectives for the worst rollout, larger is better; empty for the risk alone."""

    @property
    def selectable(self) -> bool:
        """Return True if the individual may breed or be an elite."""
        return self.status in (Status.VALID, Status.REUSED)

    @property
    def judged(self) -> bool:
        """Return True if the genome was evaluated: it was simulated, or shown to be invalid."""
        return self.status is not Status.ERROR


def measure(result: Result, name: str) -> float:
    """Return one of `MEASURES`; NaN if the result has none."""
    return result.measures[MEASURES.index(name)] if result.measures else float("nan")


@dataclass(frozen=True, slots=True)
class Proposal:
    """One individual that a searcher proposes for the next generation."""

    genome: Genome
    operator: Operator
    birth: Birth
    parents: tuple[Birth, ...] = ()
    """Parents in the order in which they gave genes."""
    reused: Result | None = None
    """The stored result of an individual that need not be simulated again."""


class Searcher(Protocol):
    """Searcher that proposes one generation at a time. `tell` answers the last `ask`, in its order."""

    def ask(self) -> list[Proposal]: ...

    def tell(self, results: Sequence[Result]) -> None: ...


def check_answer(proposals: Sequence[Proposal], results: Sequence[Result]) -> None:
    """Raise ValueError unless there is one result for each proposal."""
    if len(results) != len(proposals):
        raise ValueError(f"results: expected one for each of the {len(proposals)} proposals, got {len(results)}")


class GenerationSearcher:
    """Base class that proposes one generation after another and receives the results of each; a subclass has its own
    `_proposals` and, if it learns, its own `_learn`.
    """

    def __init__(self, population: int, streams: StreamAt) -> None:
        self._population = population
        self._streams = streams
        self._generation = -1
        self._proposed: list[Proposal] = []

    def ask(self) -> list[Proposal]:
        self._generation += 1
        self._proposed = self._proposals()
        return self._proposed

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._proposed, results)
        self._learn(results)

    def _proposals(self) -> list[Proposal]:
        raise NotImplementedError

    def _learn(self, results: Sequence[Result]) -> None:
        """Learn from the results of `_proposed`."""
