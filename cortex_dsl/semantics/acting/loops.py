"""`while` and `for` in behaviours: loops that the run goes through, and rounds that are written out before it."""

from collections.abc import Iterator, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.acting.bodies import Body, Variable
from cortex_dsl.semantics.acting.yielding import check_loop
from cortex_dsl.semantics.errors.runs import LEAVES_WRITTEN_OUT
from cortex_dsl.semantics.evaluation.arguments import items_of
from cortex_dsl.semantics.evaluation.lists import unpack
from cortex_dsl.semantics.model.values import Quantity, Value
from cortex_dsl.semantics.names.tree import parts
from cortex_dsl.semantics.quantities.algebra import table as table_entry
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.syntax import nodes


def while_(body: Body, node: nodes.While) -> ir.Block:
    condition = body.condition(node.condition, repeated=True)
    if isinstance(condition, ir.Literal) and not condition.value:
        return ()
    acts = body.nested(node.body, repeated=True, looping=True)
    check_loop(body.ev, condition, acts, node.condition.span)
    return (ir.Loop(node.span, condition, acts),)


def for_(body: Body, node: nodes.For) -> ir.Block:
    """Compile `for`: numbers are counted at run time, other items are unrolled."""
    ev, span = body.ev, node.iterable.span
    items = items_of(ev.evaluate(node.iterable), span, "what `for` runs over")
    table = _numbers(items)
    if not items:
        return ()
    if table is not None and len(node.targets) == 1:
        return _counted(body, node, items, table)
    if any(isinstance(each, nodes.Break | nodes.Continue) for each in _own_statements(node.body)):
        raise LEAVES_WRITTEN_OUT.mistake(node.span)
    acts: list[ir.Act] = []
    for item in items:
        ev.file.budget.spend(span)
        body.names.update(unpack(node.targets, item, span))
        body.variables.update({name: Variable(None, body.depth + 1) for name in node.targets})
        acts += body.nested(node.body, repeated=True)
    return tuple(acts)


def _numbers(items: Sequence[Value]) -> list[float] | None:
    """Known numbers of one dimension; None for anything else."""
    if not all(isinstance(item, Quantity) for item in items):
        return None
    found = [closed_value(item.expr) for item in items if isinstance(item, Quantity)]
    alike = len({item.dimension for item in items if isinstance(item, Quantity)}) == 1
    known = [number for number in found if number is not None]
    return known if alike and len(known) == len(items) else None


def _counted(body: Body, node: nodes.For, items: Sequence[Value], numbers_: Sequence[float]) -> ir.Block:
    """A loop with a counter, which goes up before the body, so that `continue` does not repeat a round."""
    ev, span = body.ev, node.span
    (name,), first = node.targets, items[0]
    assert isinstance(first, Quantity)
    counter = ev.algebra.local(index := ev.run.new_local())
    offset = ev.file.pool.offset(tuple(numbers_))
    value = table_entry(counter - 1.0, offset)
    body.variables.pop(name, None)
    bound = body.assign(name, Quantity(value, first.dimension), node.span, local=True)
    acts = body.nested(node.body, repeated=True, looping=True)
    ahead = ir.SetLocal(span, index, counter + 1.0)
    goes_on = counter < float(len(items))
    return (ir.SetLocal(span, index, ev.algebra.literal(0.0)), ir.Loop(span, goes_on, (ahead, *bound, *acts)))


def _own_statements(statements: Sequence[nodes.Statement]) -> Iterator[nodes.Statement]:
    """The statements of a loop, without those of loops in it."""
    for statement in statements:
        yield statement
        if not isinstance(statement, nodes.For | nodes.While):
            yield from _own_statements([part for part in parts(statement) if isinstance(part, nodes.Statement)])
            for part in parts(statement):
                if isinstance(part, nodes.Handler):
                    yield from _own_statements(part.body)
