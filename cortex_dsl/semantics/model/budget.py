"""How much the compiler works out for a file, and at which place of the file most of it is.

It is counted in expressions and never in seconds, so that a file compiles everywhere or nowhere.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import TOO_MUCH_WORK
from cortex_dsl.source import Span

EVALUATION_LIMIT = 1_000_000
"""How many expressions a file may evaluate, all variants together."""
COPIES = 64
"""Items or characters that are copied for what evaluating an expression costs."""
MUCH = 20
"""A place that takes less than this part of all work is not what is too much."""


@dataclass
class Budget:
    """What a file has cost so far."""

    evaluations: int = 0
    _under_way: dict[Span, int] = field(default_factory=dict)
    """What repeats other work and is being worked out, from the outside in, with the count at which it began."""
    _most: dict[Span, int] = field(default_factory=dict)
    """The most that one such place took at once."""

    def spend(self, span: Span, evaluations: int = 1) -> None:
        """Count work.

        Raises:
            Mistake: it has become too much, which is said once.
        """
        reported = self.evaluations >= EVALUATION_LIMIT
        self.evaluations += evaluations
        if reported:
            raise Mistake
        if self.evaluations >= EVALUATION_LIMIT:
            raise TOO_MUCH_WORK.mistake(self._heaviest(span), limit=EVALUATION_LIMIT)

    def copy(self, span: Span, count: int) -> None:
        """`spend` for so many items or characters that are copied, before they are."""
        self.spend(span, count // COPIES)

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
