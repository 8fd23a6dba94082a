"""What the compiler found out about a text on its way, also where it found mistakes: the value of every expression."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.values import Value
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.errors import Signal

MOST_SIGHTINGS = 24
"""Values kept of one expression, which has one for every way of making the choices of the file."""


class Superseded(Signal):
    """Stops a compilation whose result nobody waits for any more."""


@dataclass(frozen=True)
class Sighting:
    """One value that an expression had, and where it had it."""

    evaluator: Evaluator
    value: Value


Sightings = Sequence[Sighting]


@dataclass
class Witness:
    """Collects values while a text is compiled; `superseded` is asked all the time."""

    superseded: Callable[[], bool] = lambda: False
    seen: dict[Span, list[Sighting]] = field(default_factory=dict)

    def __call__(self, evaluator: Evaluator, node: nodes.Expression, value: Value) -> None:
        if self.superseded():
            raise Superseded
        kept = self.seen.setdefault(node.span, [])
        if len(kept) < MOST_SIGHTINGS:
            kept.append(Sighting(evaluator, value))
