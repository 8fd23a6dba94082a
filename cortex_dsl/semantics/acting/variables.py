"""Names that a behaviour assigns: which ones need a local, and how a value is kept as it is now."""

from collections.abc import Iterator, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.quantities.algebra import is_dynamic
from cortex_dsl.semantics.values import Colour, LaneNow, Pose, Quantity, Truth, Value, Vector
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes


def snapshot(ev: Evaluator, value: Value, span: Span, acts: list[ir.Act]) -> Value:
    """The value with everything that changes during the run copied into fresh locals."""

    def kept(expr: ir.Expr) -> ir.Expr:
        if not is_dynamic(expr):
            return expr
        local = ev.run.new_local()
        acts.append(ir.SetLocal(span, local, expr))
        return ev.algebra.local(local)

    match value:
        case Quantity(expr, dimension):
            return Quantity(kept(expr), dimension)
        case Truth(expr):
            return Truth(kept(expr))
        case Vector(x, y):
            return Vector(kept(x), kept(y))
        case Pose(x, y, heading):
            return Pose(kept(x), kept(y), kept(heading))
        case LaneNow(id, section):
            return LaneNow(kept(id), section)
        case Colour(index):
            return Colour(kept(index))
        case tuple():
            return tuple(snapshot(ev, item, span, acts) for item in value)
    return value


def assigned_names(statements: Sequence[nodes.Statement], *, repeated: bool) -> Iterator[str]:
    """Every assignment's names; twice where it may run again."""
    for statement in statements:
        match statement:
            case nodes.Assign(targets=targets):
                yield from targets * (2 if repeated else 1)
            case nodes.AugmentedAssign(target=target):
                yield from (target, target)
            case nodes.If(branches=branches, otherwise=otherwise):
                for _, body in branches:
                    yield from assigned_names(body, repeated=True)
                yield from assigned_names(otherwise, repeated=True)
            case nodes.While(body=body):
                yield from assigned_names(body, repeated=True)
            case nodes.Try(body=body, handlers=handlers):
                yield from assigned_names(body, repeated=True)
                for handler in handlers:
                    yield from assigned_names(handler.body, repeated=True)
