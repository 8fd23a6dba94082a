"""The interface of searcher and campaign: `ask` returns proposals, `tell` takes their results. A searcher sees no more.
`GenerationSearcher` is what ours have in common.

An *individual* is one place in a generation. Its `Birth` is the place where its genome was first simulated: an elite
keeps the birth of the individual that it repeats, and with it the stream of its scenes.
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
"""What a result holds beside the risk, of an individual's worst rollout: columns of `engine.search.assessment`."""


SOUGHT = ("risk",)
"""What a search looks for where nothing else is named: the risk of the paper."""
Sought = str | Callable[[Outcomes], Any]
"""An objective: by its name (`engine.search.objectives`), or a function from outcomes to one number a scene."""


def function_name(function: Callable[..., Any]) -> str:
    """What a function is called as an objective."""
    return str(getattr(function, "__name__", type(function).__name__))


class Operator(IntEnum):
    """How an individual came to be."""

    RANDOM = 0
    ELITE = 1
    CROSSOVER = 2
    MUTATION = 3
    CROSSOVER_MUTATION = 4
    """A child that was known whatever its parents, so that one of its genes was drawn again."""
    SAMPLED = 5
    """Drawn from a distribution that the search has learnt."""


class Status(IntEnum):
    """What a searcher may know of the result of an evaluation."""

    VALID = 0
    INVALID = 1
    ERROR = 2
    REUSED = 3
    """An elite's: the stored result of its birth."""


class Birth(NamedTuple):
    """Where an individual was first simulated; its identity, and its place in the order of age."""

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
        """Whether the genome lies in the box, discrete genes on whole numbers."""
        return len(genome) == len(self) and all(
            low <= value <= high and (kind is GeneKind.CONTINUOUS or value == int(value))
            for value, low, high, kind in zip(genome, self.low, self.high, self.kinds, strict=True)
        )


@dataclass(frozen=True, slots=True)
class Result:
    """What became of a proposal."""

    status: Status
    fitness: float
    """Larger is riskier; NaN unless valid or reused."""
    verdict: Verdict
    continuous: float = float("nan")
    """The continuous risk, by which a search may climb inside a band of the integer one; NaN as `fitness`."""
    failure: bool = False
    """Whether it is what the search is for: the ego collided, or what the objective calls a find."""
    measures: tuple[float, ...] = ()
    """What else is known of the run, in the order of `MEASURES`; each NaN, or none at all, unless valid or reused."""
    sought: tuple[float, ...] = ()
    """How much of each objective the worst rollout has, the larger the better; none where the risk alone is sought."""

    @property
    def selectable(self) -> bool:
        """Whether the individual may breed or be kept."""
        return self.status in (Status.VALID, Status.REUSED)

    @property
    def judged(self) -> bool:
        """Whether something is known of the genome: it was simulated, or shown to be invalid."""
        return self.status is not Status.ERROR


def measure(result: Result, name: str) -> float:
    """One of `MEASURES`; NaN where the result has none."""
    return result.measures[MEASURES.index(name)] if result.measures else float("nan")


@dataclass(frozen=True, slots=True)
class Proposal:
    """One individual that a searcher wants in the next generation."""

    genome: Genome
    operator: Operator
    birth: Birth
    parents: tuple[Birth, ...] = ()
    """In the order in which they gave genes."""
    reused: Result | None = None
    """The stored result of an individual that need not be simulated again."""


class Searcher(Protocol):
    """Proposes one generation at a time. `tell` answers the last `ask`, in its order."""

    def ask(self) -> list[Proposal]: ...

    def tell(self, results: Sequence[Result]) -> None: ...


def check_answer(proposals: Sequence[Proposal], results: Sequence[Result]) -> None:
    """Raise ValueError unless there is one result for each proposal."""
    if len(results) != len(proposals):
        raise ValueError(f"results: expected one for each of the {len(proposals)} proposals, got {len(results)}")


class GenerationSearcher:
    """Proposes one generation after the other, and gets the results of each; each kind has its own `_proposals` and, if
    it learns anything, its own `_learn`.
    """

    def __init__(self, population: int, streams: StreamAt) -> None:
        self._population = population
        self._streams = streams
        self._generation = -1
        self._asked: list[Proposal] = []

    def ask(self) -> list[Proposal]:
        self._generation += 1
        self._asked = self._proposals()
        return self._asked

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        self._learn(results)

    def _proposals(self) -> list[Proposal]:
        raise NotImplementedError

    def _learn(self, results: Sequence[Result]) -> None:
        """Take in what became of `_asked`."""
