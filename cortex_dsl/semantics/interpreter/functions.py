"""Functions that a file defines by `def`: the compiler calls them, and their results are ordinary values.

A function sees the names of the place of its definition and has variables of its own. A call from a behavior is
evaluated at the moment of that call.
"""

from collections.abc import Mapping

from cortex_dsl.semantics.interpreter.control import Leaving, Run, block
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import Function, Value
from cortex_dsl.syntax import nodes


class Returned(Leaving):
    """`return`, on its way to the call."""

    def __init__(self, value: Value) -> None:
        super().__init__()
        self.value = value


def return_(ev: Evaluator, node: nodes.Return) -> None:
    raise Returned(None if node.value is None else ev.evaluate(node.value))


def function(ev: Evaluator, node: nodes.FunctionDefinition, run: Run) -> Function:
    """The value of a definition."""

    def apply(moment: Moment, arguments: Mapping[str, Value]) -> Value:
        with ev.run.depth.call(node.name_span):
            here = ev.framed(dict(arguments)).at_moment(moment)
            for parameter in node.parameters:
                if parameter.name not in here.scope and parameter.default is not None:
                    here.scope[parameter.name] = ev.evaluate(parameter.default)
            try:
                block(here, node.body, run)
            except Leaving as leaving:
                return leaving.value if isinstance(leaving, Returned) else None
            return None

    return Function(node.name, node.parameters, apply)
