"""The evaluator's table: which function gives the value of which kind of expression."""

from collections.abc import Mapping

from cortex_dsl.semantics.context import Evaluator, Handler
from cortex_dsl.semantics.evaluation import calls, geometry, operators
from cortex_dsl.semantics.running import temporal
from cortex_dsl.semantics.state import Variant
from cortex_dsl.semantics.things import objects
from cortex_dsl.syntax import nodes

HANDLERS: Mapping[type, Handler] = {
    nodes.Number: operators.number,
    nodes.WithUnit: operators.with_unit,
    nodes.Degrees: operators.degrees,
    nodes.String: operators.string,
    nodes.Constant: operators.constant,
    nodes.Name: operators.name,
    nodes.Attribute: operators.attribute,
    nodes.Index: operators.index,
    nodes.Call: calls.call,
    nodes.Starred: operators.starred,
    nodes.ListDisplay: operators.display,
    nodes.TupleDisplay: operators.display,
    nodes.DictDisplay: operators.dictionary,
    nodes.Comprehension: operators.comprehension,
    nodes.Lambda: operators.lambda_,
    nodes.Unary: operators.unary,
    nodes.Binary: operators.binary,
    nodes.BoolOp: operators.boolean,
    nodes.Compare: operators.compare,
    nodes.Conditional: operators.conditional,
    nodes.Distance: geometry.distance,
    nodes.RelativeHeading: geometry.relative_heading,
    nodes.CanSee: geometry.can_see,
    nodes.Intersects: geometry.intersects,
    nodes.OffsetBy: geometry.offset_by,
    nodes.OffsetAlong: geometry.offset_along,
    nodes.New: objects.new,
    nodes.Temporal: temporal.implication,
}  # type: ignore[dict-item]


def evaluator(run: Variant) -> Evaluator:
    """An evaluator at the file's top level."""
    return Evaluator(run, HANDLERS)
