"""Legal ranges of numbers: checked at once for constants and bounded random values, else in each scene.

A concrete copy contains the values of a scene as constants, whose range is checked again. So no random value may lie
outside: a value whose bounds leave the range is an error; a value without bounds, or within rounding of the end, is a
requirement on the scene.
"""

import math

from cortex_dsl import ir
from cortex_dsl.semantics.errors.values import MAY_LEAVE_RANGE, NOT_FINITE, OUT_OF_RANGE
from cortex_dsl.semantics.evaluation.numbers import ROUNDING
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.wording import range_text, shown
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.bounds import closed_value, is_dynamic, range_labels
from cortex_dsl.semantics.quantities.units import SPEED
from cortex_dsl.source import Span


def in_range(ev: Evaluator, expr: Term, domain: Domain, span: Span) -> Term:
    """Return the expression if it is in its legal range; for a random value, add the requirement that it stays there.

    Raises:
        Mistake: it is, or may become, illegal.
    """
    if not isinstance(within(ev, expr, domain, span, domain.name), ir.Literal) and not is_dynamic(expr):
        require(ev, inside(ev, expr, domain), f"{domain.name.replace('`', '')} within its domain", span)
    return expr


def within(ev: Evaluator, expr: Term, domain: Domain, span: Span, what: str) -> Term:
    """The expression, if its legal range allows, as far as its bounds are known.

    Raises:
        Mistake: when it is, or may become, something illegal.
    """
    least, greatest = ev.interval(expr)
    value = closed_value(expr)
    if value is not None and math.isnan(value):
        raise NOT_FINITE.mistake(span, reason=f"{what} is not a number")
    if value is not None:
        least = greatest = value
    elif math.inf in (abs(least), abs(greatest)):
        return expr
    slack = ROUNDING * max(1.0, abs(least), abs(greatest)) if value is None else 0.0
    # An excluded end is met exactly by a whole number, a gene at its end, or one of several options.
    too_low = least <= domain.low if domain.above else least + slack < domain.low
    if not too_low and greatest - slack <= domain.high:
        return expr
    problem = MAY_LEAVE_RANGE if value is None else OUT_OF_RANGE
    raise problem.mistake(
        span,
        what=what,
        actual=shown(least if too_low else greatest, domain.dimension),
        expected=range_text(domain.low, domain.high, domain.dimension, domain.above),
        secondary=range_labels(expr, ev.file.genes.infos) if value is None else (),
        cure=(
            "turn the object with `facing` to have it drive the other way"
            if too_low and domain.dimension == SPEED
            else "write a number in that range"
        ),
    )


def inside(ev: Evaluator, value: Term, domain: Domain) -> Term | None:
    """Return the condition that a value lies in its legal range; None if it certainly does.

    NaN and infinite values pass: they are an error of their own, at their place in the file.
    """
    low, high = ev.interval(value)
    parts = []
    if low < domain.low or (domain.above and low == domain.low):
        parts.append(~((value <= domain.low if domain.above else value < domain.low) & (-math.inf < value)))
    if domain.high < high and domain.high < math.inf:
        parts.append(at_most(value, domain.high))
    return ev.algebra.all_of(parts) if parts else None


def at_most(value: Term, limit: Term | float) -> Term:
    """The condition that a value does not exceed a limit; infinity passes."""
    return ~((limit < value) & (value < math.inf))


def require(ev: Evaluator, condition: Term | None, name: str, span: Span) -> None:
    """Require a condition of the scene, once."""
    if condition is None:
        return
    found, known = ir.Requirement(condition, 1.0, name, ev.facts.line(span)), ev.run.built.requirements
    if found not in known:
        known.append(found)
