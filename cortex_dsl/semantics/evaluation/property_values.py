"""Values of properties as objects store them: of the right kind, and inside their legal range."""

from cortex_dsl.semantics.errors.names import UNKNOWN_PROPERTY
from cortex_dsl.semantics.errors.runs import OBSTACLE_BEHAVIOUR
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.functions import known_truth
from cortex_dsl.semantics.evaluation.ranges import within
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import FLAGS, IGNORED, PROPERTIES, SCENIC_ONLY
from cortex_dsl.source import Span


def refuse_scenic_only(name: str, span: Span, kind: str) -> None:
    """Refuse a property that means something to Scenic and nothing here, where any other name may be the file's own."""
    if name in SCENIC_ONLY:
        raise UNKNOWN_PROPERTY.mistake(span, kind=kind, name=name, suggestion=SCENIC_ONLY[name])


def checked(ev: Evaluator, name: str, value: Value, span: Span, *, may_act: bool) -> Value:
    """A value of a property, as it is stored."""
    if name in IGNORED:
        return None
    if name in FLAGS:
        return _flag(ev, name, value, span, may_act=may_act)
    if name not in PROPERTIES:
        return value
    spec = PROPERTIES[name]
    if spec.truth:
        return numbers.truth(ev, value, span)
    expr = numbers.adopt(ev, value, spec.dimension, span, f"`{name}`")
    return within(ev, expr, spec, span, f"`{name}`")


def _flag(ev: Evaluator, name: str, value: Value, span: Span, *, may_act: bool) -> Value:
    if name == "behavior":
        return _behaviour(value, span, may_act=may_act)
    if name in ("allowCollisions", "requireVisible"):
        return known_truth(ev, value, span, f"`{name}`")
    if name == "name" and not isinstance(value, str):
        raise WRONG_KIND.mistake(span, what="`name`", expected="text", actual=kind_name(value), cure="")
    return value


def _behaviour(value: Value, span: Span, *, may_act: bool) -> Value:
    if value is None:
        return None
    behaviour = as_behaviour(value, span)
    if behaviour is None:
        raise WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=kind_name(value), cure="as in `FollowLaneBehavior()`"
        )
    if not may_act:
        raise OBSTACLE_BEHAVIOUR.mistake(span)
    return behaviour
