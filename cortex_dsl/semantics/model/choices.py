"""Finite choices: a replayed list of decisions, the enumeration of all combinations, and the pool of their numbers.

The file is elaborated once per combination. The oracle answers the first choices by its script and takes the first
option of all later ones; the enumeration then changes the last decision that has options left, and starts again, or
continues at that choice (`marks`).
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from cortex_dsl import ir
from cortex_dsl.semantics.errors.values import TOO_MANY_VARIANTS
from cortex_dsl.source import Span
from engine.errors import Signal
from engine.frozen import frozen

VARIANT_LIMIT = 4096
"""Largest product of the option counts of the choices that one variant makes."""


@frozen
class Decision:
    """A choice as it was met: `probabilities` by option, 1.0 each where a gene decides."""

    name: str
    span: Span
    probabilities: tuple[float, ...]
    taken: int
    gene: int | None = None
    drawable: bool = False
    """Whether it is a lane, which the scene may draw instead."""


def check_count(count: int, span: Span) -> None:
    """Refuse a count that would exceed the maximum number of variants, before it is reached."""
    if count > VARIANT_LIMIT:
        raise TOO_MANY_VARIANTS.mistake(span, limit=VARIANT_LIMIT, sizes=f"this one has {count} options")


CHOSEN_LANES_LIMIT = 1024
"""Number of variants above which lanes are sampled with the scene, if possible; below, random numbers are unchanged."""


class TooManyVariants(Signal):
    """The choices met along one way already multiply to more than the limit."""

    def __init__(self, decisions: tuple[Decision, ...]) -> None:
        super().__init__(len(decisions))
        self.decisions = decisions


@dataclass
class Oracle:
    """Answers the choices of one variant, in the order in which they are met."""

    script: tuple[int, ...] = ()
    lanes_limit: float = VARIANT_LIMIT
    """Maximum number of variants if some of the choices are lanes."""
    limit: float = VARIANT_LIMIT
    decisions: list[Decision] = field(default_factory=list)
    ways: int = 1

    def choose(
        self,
        name: str,
        span: Span,
        probabilities: tuple[float, ...],
        gene: int | None = None,
        *,
        drawable: bool = False,
    ) -> int:
        """Index of the option to take; `drawable`: of a lane, which the scene may draw instead."""
        position = len(self.decisions)
        taken = self.script[position] if position < len(self.script) else 0
        self.decisions.append(Decision(name, span, probabilities, taken, gene, drawable))
        self.ways *= len(probabilities)
        limit = self.lanes_limit if any(each.drawable for each in self.decisions) else self.limit
        if self.ways > limit:
            raise TooManyVariants(tuple(self.decisions))
        return taken

    def repeat(self, other: "Oracle", count: int) -> None:
        """Begin with the first choices of another variant, which both variants share."""
        self.decisions[:] = other.decisions[:count]
        self.ways = math.prod(len(each.probabilities) for each in self.decisions)

    @property
    def probability(self) -> float:
        product = 1.0
        for decision in self.decisions:
            product *= decision.probabilities[decision.taken]
        return product

    @property
    def gene_options(self) -> tuple[tuple[int, int], ...]:
        return tuple((d.gene, d.taken) for d in self.decisions if d.gene is not None)

    def successor(self) -> tuple[int, ...] | None:
        """The script of the next variant, depth first; None after the last."""
        script = [decision.taken for decision in self.decisions]
        while script:
            last = script.pop() + 1
            if last < len(self.decisions[len(script)].probabilities):
                return (*script, last)
        return None


@dataclass
class Decisions:
    """Every choice and draw that a variant has met so far."""

    oracle: Oracle
    choices: list[ir.Choice] = field(default_factory=list)
    draw_sites: list[ir.DrawSite] = field(default_factory=list)
    draw_count: int = 0
    finite_draws: dict[int, Span] = field(default_factory=dict)
    """Sites of the draws that select one of finitely many numbers."""
    visits: Counter[Span] = field(default_factory=Counter)
    """How often each `Fixed(...)` was evaluated."""


Result = TypeVar("Result")


def enumerate_variants(
    run: Callable[[Oracle], Result], lanes_limit: int = VARIANT_LIMIT
) -> Iterator[tuple[Oracle, Result]]:
    """Run once for every way of making the choices that `run` meets."""
    script: tuple[int, ...] | None = ()
    while script is not None:
        oracle = Oracle(script, lanes_limit)
        yield oracle, run(oracle)
        script = oracle.successor()


@dataclass
class Pool:
    """Numeric options of discrete choices, shared by all variants."""

    values: list[float] = field(default_factory=list)
    _offsets: dict[tuple[float, ...], int] = field(default_factory=dict)
    _bounds: dict[int, tuple[float, float]] = field(default_factory=dict)

    def offset(self, options: Sequence[float]) -> int:
        key = tuple(options)
        if key not in self._offsets:
            self._offsets[key] = len(self.values)
            self.values.extend(key)
            self._bounds[self._offsets[key]] = (min(key), max(key))
        return self._offsets[key]

    def bounds(self, offset: int) -> tuple[float, float]:
        """The least and the greatest of the options at an offset."""
        return self._bounds[offset]
