"""How deep the place that is being worked out lies: in calls of functions, and in blocks of behaviours."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from cortex_dsl.semantics.errors.behaviours import DEEP_BY_BRANCHES, DEEP_BY_RUNNING, TOO_DEEP_BODIES
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import ENDLESS_LAMBDA
from cortex_dsl.source import Span

CALL_LIMIT = 30
"""How many calls of functions may lie in one another."""
NESTING_LIMIT = 60
"""How deep blocks may lie in one another, with those of the behaviours that they run."""


@dataclass
class Depth:
    """Of the place that is being worked out."""

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
