"""Limits of every file: the work of the compiler, and the nesting depth."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import DEEP_BY_BRANCHES, DEEP_BY_RUNNING, TOO_DEEP_BODIES
from cortex_dsl.semantics.errors.values import ENDLESS_LAMBDA, TOO_MUCH_WORK
from cortex_dsl.source import Span

# -- how much ----------------------------------------------------------------------------------------------------------

EVALUATION_LIMIT = 1_000_000
"""How many expressions a file may evaluate, all variants together."""
REPETITION_LIMIT = 100_000
"""How many of them in the loops, lists and calls of one variant, where a short text may demand any number: a second at
most, since editors compile a file at every key. The largest file of the tests takes 11,000, in all of its variants.
"""
COPIES = 64
"""Number of copied items or characters that costs as much as one evaluation of an expression."""
MUCH = 20
"""Inverse share of all work below which a place is not the cause of an excess."""


@dataclass
class Budget:
    """Cost of a file so far, and the place with the largest cost.

    It is counted in expressions and never in seconds, so that a file compiles everywhere or nowhere.
    """

    evaluations: int = 0
    repetitions: int = 0
    """Evaluations in loops, lists and calls of this variant, without copies of items, which are fast."""
    _reported: bool = False
    """Whether the excess has been reported."""
    _under_way: dict[Span, int] = field(default_factory=dict)
    """Present repetitions, from the outside in, with the count at their start."""
    _most: dict[Span, int] = field(default_factory=dict)
    """Largest cost of one execution of each such place."""

    def begin_variant(self) -> None:
        """Count the loops, lists and calls of the next variant."""
        self.repetitions = 0

    def spend(self, span: Span, evaluations: int = 1) -> None:
        """Count work. More than one evaluation at once is the work of a loop.

        Raises:
            Mistake: the limit is exceeded, which is reported once.
        """
        self.repetitions += evaluations if self._under_way or evaluations > 1 else 0
        self._count(span, evaluations)

    def copy(self, span: Span, count: int) -> None:
        """`spend` for so many items or characters that are copied, before they are."""
        self._count(span, count // COPIES)

    def _count(self, span: Span, evaluations: int) -> None:
        self.evaluations += evaluations
        if self._reported:
            raise Mistake
        if (limit := self._exceeded) is not None:
            self._reported = True
            raise TOO_MUCH_WORK.mistake(self._heaviest(span), limit=f"{limit:,}")

    @property
    def _exceeded(self) -> int | None:
        if self.repetitions >= REPETITION_LIMIT:
            return REPETITION_LIMIT
        return EVALUATION_LIMIT if self.evaluations >= EVALUATION_LIMIT else None

    @contextmanager
    def repeating(self, span: Span) -> Iterator[None]:
        """Count the work of a loop, a list or a call at this place."""
        if span in self._under_way:  # a function that calls itself
            yield
            return
        before = self._under_way[span] = self.evaluations
        try:
            yield
        finally:
            del self._under_way[span]
            self._most[span] = max(self.evaluations - before, self._most.get(span, 0))

    def _heaviest(self, span: Span) -> Span:
        """Return the place with the largest cost of one execution; the given place if no cost is large.

        Among the places with at least half the largest cost, it is the cheapest: the others only repeat it a few times.
        """
        took = self._most | {place: self.evaluations - before for place, before in self._under_way.items()}
        most = max(took.values(), default=0)
        if most * MUCH < self.evaluations:
            return span
        heavy = (place for place, work in took.items() if 2 * work >= most)
        return min(heavy, key=lambda place: (took[place], place.end - place.start))


# -- how deep ----------------------------------------------------------------------------------------------------------

CALL_LIMIT = 30
"""Maximum nesting depth of function calls."""
NESTING_LIMIT = 60
"""Maximum nesting depth of blocks, including those of the behaviours that they run."""


@dataclass
class Depth:
    """Nesting depth of the present place: in calls of functions, and in blocks of behaviours."""

    calls: int = 0
    """Number of nested function calls."""
    given_up: bool = False
    """Whether a call exceeded the limit; the surrounding calls then stop, since each would repeat the error."""
    blocks: int = 0
    """Number of nested blocks of behaviours."""
    branches: int = 0
    """Number of these blocks that are the `elif` remainder of a branch."""

    @contextmanager
    def call(self, span: Span) -> Iterator[None]:
        """Count one level of function calls.

        Raises:
            Mistake: the limit is exceeded, which is reported once.
        """
        if self.given_up:
            raise Mistake
        if self.calls == CALL_LIMIT:
            raise self._given_up(span)
        self.calls += 1
        try:
            yield
        except RecursionError:
            raise self._given_up(span) from None
        finally:
            self.calls -= 1
            self.given_up = self.given_up and self.calls > 0

    def _given_up(self, span: Span) -> Mistake:
        self.given_up = True
        return ENDLESS_LAMBDA.mistake(span)

    @contextmanager
    def nested(self, span: Span, *, otherwise: bool = False) -> Iterator[None]:
        """Count one level of blocks; `otherwise`: the branches after a branch.

        Raises:
            Mistake: the limit is exceeded.
        """
        if self.blocks == NESTING_LIMIT:
            raise self._too_deep(span)
        self.blocks += 1
        self.branches += otherwise
        try:
            yield
        finally:
            self.blocks -= 1
            self.branches -= otherwise

    def _too_deep(self, span: Span) -> Mistake:
        mostly_branches = 2 * self.branches > NESTING_LIMIT
        counted, reason, cure = DEEP_BY_BRANCHES if mostly_branches else DEEP_BY_RUNNING
        return TOO_DEEP_BODIES.mistake(span, limit=NESTING_LIMIT, counted=counted, reason=reason, cure=cure)
