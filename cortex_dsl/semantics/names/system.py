"""`simulation(system=[EGO_BRAKE, SAFETY_DIST])`: the params that belong to the system under test.

A search that may choose them can win by switching the brakes off; `--freeze` holds them fixed. The list holds names and
nothing else, wherever in the file their params stand, so it is read from the tree and never evaluated.
"""

from collections.abc import Iterator, Mapping

from cortex_dsl.semantics import errors
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

SYSTEM = "system"


def system_params(module: nodes.Module, params: Mapping[str, nodes.ParamEntry], findings: Findings) -> tuple[str, ...]:
    """The names that the file lists, each once, in the order of the list; what is no param is reported."""
    names: list[str] = []
    for node in _listed(module):
        if not isinstance(node, nodes.Name) or node.id not in params:
            actual = node.id if isinstance(node, nodes.Name) else "this"
            suggestion = did_you_mean(actual, params) or "list names of params, as in `system=[EGO_BRAKE]`"
            findings.add(errors.NO_SYSTEM_PARAM.at(node.span, actual=actual, suggestion=suggestion))
        elif node.id not in names:
            names.append(node.id)
    return tuple(names)


def lists_names(statement: nodes.Statement, part: nodes.Node) -> bool:
    """Whether a part of a statement is such a list."""
    return isinstance(statement, nodes.Simulation) and isinstance(part, nodes.Argument) and part.name == SYSTEM


def _listed(module: nodes.Module) -> Iterator[nodes.Expression]:
    """What stands in the lists."""
    for statement in module.statements:
        if isinstance(statement, nodes.Simulation):
            for argument in statement.arguments:
                if lists_names(statement, argument):
                    value = argument.value
                    listed = isinstance(value, nodes.ListDisplay | nodes.TupleDisplay)
                    yield from value.items if listed else (value,)
