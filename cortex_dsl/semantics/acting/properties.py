"""Properties of the file's own, such as `with laps 0`, that behaviours and monitors set: `self.laps += 1`."""

from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.acting.bodies import Body, of_same_dimension
from cortex_dsl.semantics.errors.runs import CANNOT_SET, OBJECT_CHANGES
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.operators import combine
from cortex_dsl.semantics.model.values import Actor, Quantity, Truth
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import all_properties
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

SIMULATED: Mapping[str, str] = {
    **dict.fromkeys(("position", "heading", "x", "y"), "the run moves objects: `take` an action, or `do` a behavior"),
    "speed": "it follows from what the object does: `take SetSpeedAction(...)`",
    **dict.fromkeys(("steer", "throttle", "brake"), "an action sets it: `take SetSteerAction(...)` and the like"),
    "behavior": "a scenario changes it: `override x with behavior B()`",
}
"""Properties that the run sets, and the statement by which a file influences each."""


def set_attribute(body: Body, node: nodes.SetAttribute) -> ir.Block:
    """Set a property of the file's own; every later read sees the new value."""
    ev, target, name = body.ev, node.target, node.target.name
    actor = ev.evaluate(target.value)
    if not isinstance(actor, Actor):
        raise WRONG_KIND.mistake(
            target.value.span,
            what="what is assigned",
            expected="a property of an object",
            actual=kind_name(actor),
            cure="",
        )
    before = _may_change(actor, name, target.name_span)
    value = ev.evaluate(node.value)
    if node.operator:
        operation = nodes.Binary(span=node.span, operator=node.operator, left=target, right=node.value)
        value = combine(ev, node.operator, ev.evaluate(target), value, operation)
    cell = actor.cells[name]
    settled = of_same_dimension(name, before, value, node.value.span)
    return (
        ir.SetLocal(node.span, cell.value, settled.expr),
        ir.SetLocal(node.span, cell.assigned, ev.algebra.truth(True)),
    )


def _may_change(actor: Actor, name: str, span: Span) -> Quantity | Truth:
    """Return the first value of a property that may change.

    Raises:
        Mistake: the run sets the property, it is settled with the scene, or the object has none.
    """
    if name in SIMULATED:
        raise CANNOT_SET.mistake(span, name=name, reason=SIMULATED[name])
    if name in all_properties():
        raise CANNOT_SET.mistake(span, name=name, reason="it is the same from the first sample to the last")
    if name not in actor.properties:
        raise CANNOT_SET.mistake(span, name=name, reason=f"`{actor.name}` is not made with it: `with {name} 0`")
    first = actor.properties[name]
    if not isinstance(first, Quantity | Truth):
        raise OBJECT_CHANGES.mistake(span, name=name, kind=kind_name(first).split(" ", 1)[-1])
    return first
