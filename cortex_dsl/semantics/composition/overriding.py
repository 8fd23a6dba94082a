"""`override x with property value`: in a scenario, for as long as it runs."""

from cortex_dsl.semantics.acting.bodies import of_same_dimension
from cortex_dsl.semantics.errors.names import UNKNOWN_PROPERTY
from cortex_dsl.semantics.errors.runs import CANNOT_OVERRIDE
from cortex_dsl.semantics.errors.values import OVERRIDDEN_AND_SET, WRONG_KIND
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.property_values import checked
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Instance
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import FLAGS, IGNORED, PROPERTIES, all_properties
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vocabulary import ActorKind

SETTLED = ("name", "allowCollisions", "regionContainedIn", "requireVisible")
"""Properties that are used before the run only."""


def override(ev: Evaluator, node: nodes.Override, instance: Instance) -> None:
    """Override properties of an object.

    Raises:
        Mistake: it is no object, or the property cannot change.
    """
    target = ev.evaluate(node.target)
    if not isinstance(target, Actor):
        raise WRONG_KIND.mistake(
            node.target.span, what="what is overridden", expected="an object", actual=kind_name(target), cure=""
        )
    for specifier in node.specifiers:
        if not isinstance(specifier, nodes.With):
            raise CANNOT_OVERRIDE.mistake(
                specifier.span,
                name="the place of an object",
                here="",
                reason="its place follows from its motion",
                cure="override its behavior, as in `override x with behavior B()`",
            )
        _property(ev, target, specifier, instance)


def _property(ev: Evaluator, target: Actor, node: nodes.With, instance: Instance) -> None:
    name = node.property
    if name not in (*PROPERTIES, *FLAGS, *IGNORED) and name not in target.properties:
        suggestion = did_you_mean(name, {*all_properties(), *target.properties})
        raise UNKNOWN_PROPERTY.mistake(node.property_span, kind=f"`{target.name}`", name=name, suggestion=suggestion)
    own = name not in all_properties() and instance is not ev.run.root
    if own:
        _override_own(ev, target, node, instance)
        return
    _check_can_change(ev, node, instance)
    may_act = target.plain or target.kind is not ActorKind.OBSTACLE
    value = checked(ev, name, ev.evaluate(node.value), node.value.span, may_act=may_act)
    if name == "behavior" and instance is not ev.run.root:
        call = None if value is None else as_behaviour(value, node.value.span)
        target.overrides.append((instance.monitor, call))
    else:
        target.properties[name] = value


def _override_own(ev: Evaluator, target: Actor, node: nodes.With, instance: Instance) -> None:
    """Override a property of the file's own: reads during the run see the value of the running scenario."""
    name = node.property
    if name in ev.facts.attributes_set:
        raise OVERRIDDEN_AND_SET.mistake(node.property_span, name=name)
    value = of_same_dimension(name, target.properties[name], ev.evaluate(node.value), node.value.span)
    target.overridden.setdefault(name, []).append((instance.monitor, value))


def _check_can_change(ev: Evaluator, node: nodes.With, instance: Instance) -> None:
    name = node.property
    if name == "speed":
        reason, cure = "how fast it is follows from what it does", "override its behavior"
        raise CANNOT_OVERRIDE.mistake(node.property_span, name=name, here="", reason=reason, cure=cure)
    if name in SETTLED:
        reason, cure = "it is used only before the run", "set it where the object is made"
        raise CANNOT_OVERRIDE.mistake(node.property_span, name=name, here="", reason=reason, cure=cure)
    if name not in ("behavior", *IGNORED) and instance is not ev.run.root:
        raise CANNOT_OVERRIDE.mistake(
            node.property_span,
            name=name,
            here="by a scenario that another one starts",
            reason="it is the same from the first sample to the last",
            cure="set it where the object is made; only `behavior` can change during the run",
        )
