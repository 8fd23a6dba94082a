"""Requirements that keep random values within their domain: no negative length, no speed below 0.

A number with bounds is checked where it is given (`ranges.within`). A number without bounds, such as the value of a
`Normal`, is checked in every sampled scene.
"""

from collections.abc import Iterable, Iterator

from cortex_dsl.semantics.evaluation.numbers import ROUNDING
from cortex_dsl.semantics.evaluation.ranges import at_most, inside, require
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.names.properties import ENVIRONMENT, PROPERTIES
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.source import Span


def require_domains(ev: Evaluator, actors: Iterable[Actor]) -> None:
    """Require of the scene that unbounded values lie in their domain."""
    found = [*_of_environment(ev)]
    for actor in actors:
        found.extend(_of_actor(ev, actor))
    for condition, what, span in found:
        require(ev, condition, f"{what} within its domain", span)


_Found = tuple[Term, str, Span]


def _of_environment(ev: Evaluator) -> Iterator[_Found]:
    if (environment := ev.run.built.environment) is not None:
        for name, value in environment.values.items():
            if (condition := inside(ev, value, ENVIRONMENT[name])) is not None:
                yield condition, f"{name} of the environment", environment.span


def _of_actor(ev: Evaluator, actor: Actor) -> Iterator[_Found]:
    for name, spec in PROPERTIES.items():
        value = actor.properties[name]
        assert isinstance(value, Term)
        condition = inside(ev, value, spec)
        if name == "speed":
            condition = _below_top(ev, actor, value, condition)
        if condition is not None:
            yield condition, f"{name} of {actor.name}", actor.span


def _below_top(ev: Evaluator, actor: Actor, speed: Term, condition: Term | None) -> Term | None:
    """Add the top speed to a condition if it may be less: it is random, or another scenario overrides it."""
    top = actor.properties["topSpeed"]
    assert isinstance(top, Term)
    if ev.interval(speed)[1] <= ev.interval(top)[0] * (1.0 + ROUNDING):
        return condition
    return at_most(speed, top) if condition is None else condition & at_most(speed, top)
