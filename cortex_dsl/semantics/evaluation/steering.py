"""Steering as Scenic's scripts give it: a share of the full angle, positive to the right."""

from cortex_dsl import ir
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.motion import size
from cortex_dsl.semantics.quantities import numbers
from cortex_dsl.semantics.quantities.units import ANGLE, PURE
from engine.vocabulary import Op


def of_scenic(ev: Evaluator, steer: Given) -> ir.Expr:
    """The steering angle, positive to the left [rad]; what has a unit of angle is one already."""
    given = numbers.quantity(steer.value, steer.span, "`steer`")
    if given.dimension == ANGLE or ev.moment.actor is None:
        return numbers.adopt(ev, given, ANGLE, steer.span, "`steer`")
    share = numbers.adopt(ev, given, PURE, steer.span, "`steer`")
    share = numbers.in_range(ev, share, -1.0, 1.0, PURE, steer.span, "`steer`")
    return ev.algebra.apply(Op.NEG, ev.algebra.mul(share, size(ev.moment.actor, "maxSteer")))
