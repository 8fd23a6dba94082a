"""What no file may exceed: how much the compiler works out for it, and how deep the place lies that is worked out."""

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
"""Items or characters that are copied for what evaluating an expression costs."""
MUCH = 20
"""A place that takes less than this part of all work is not what is too much."""


@dataclass
class Budget:
    """What a file has cost so far, and at which place of the file most of it did.

    It is counted in expressions and never in seconds, so that a file compiles everywhere or nowhere.
    """

    evaluations: int = 0
    repetitions: int = 0
    """Those that loops, lists and calls of this variant evaluated, without copies of items, which are fast."""
    _reported: bool = False
    """Whether it was said that it has become too much."""
    _under_way: dict[Span, int] = field(default_factory=dict)
    """What repeats other work and is being worked out, from the outside in, with the count at which it began."""
    _most: dict[Span, int] = field(default_factory=dict)
    """The most that one such place took at once."""

    def begin_variant(self) -> None:
        """Count the loops, lists and calls of the next variant."""
        self.repetitions = 0

    def spend(self, span: Span, evaluations: int = 1) -> None:
        """Count work. More than one evaluation at once is the work of a loop.

        Raises:
            Mistake: it has become too much, which is said once.
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
        """While a loop, a list or a call is worked out, which is what the place stands for."""
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
        """The place that took most at once: of those that took half as much or more the one that took least, which the
        others do nothing but repeat a few times. The place given where none took much.
        """
        took = self._most | {place: self.evaluations - before for place, before in self._under_way.items()}
        most = max(took.values(), default=0)
        if most * MUCH < self.evaluations:
            return span
        heavy = (place for place, work in took.items() if 2 * work >= most)
        return min(heavy, key=lambda place: (took[place], place.end - place.start))


# -- how deep ----------------------------------------------------------------------------------------------------------

CALL_LIMIT = 30
"""How many calls of functions may lie in one another."""
NESTING_LIMIT = 60
"""How deep blocks may lie in one another, with those of the behaviours that they run."""


@dataclass
class Depth:
    """How deep the place that is being worked out lies: in calls of functions, and in blocks of behaviours."""

    calls: int = 0
    """How many functions are being called, one inside the other."""
    given_up: bool = False
    """Whether one of these calls lay too deep: those around it call nothing more, else each would find that again."""
    blocks: int = 0
    """How many blocks of behaviours are being written out, one inside the other."""
    branches: int = 0
    """How many of them are what a branch leaves to the next `elif`."""

    @contextmanager
    def call(self, span: Span) -> Iterator[None]:
        """Around what a function does, which stands at a place.

        Raises:
            Mistake: it lies too deep, which is said once.
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
        """Around a block that is written out; `otherwise`: around the branches below one.

        Raises:
            Mistake: it lies too deep.
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
