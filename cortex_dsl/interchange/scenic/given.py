"""What is given to a call, as Scenic takes it: names of parameters are ours, their order is shared."""

from dataclasses import replace

from cortex_dsl.interchange.scenic.scenic_names import Unsaid
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.syntax import nodes


def by_position(node: nodes.Call, name: str) -> tuple[nodes.Argument, ...]:
    """The arguments without names, which Scenic does not share, each in its place."""
    parameters = BUILTINS[name].parameters
    places = {each: place for place, row in enumerate(parameters) for each in (row.name, *row.aliases)}
    plain = [each for each in node.arguments if each.name is None]
    named = sorted((each for each in node.arguments if each.name), key=lambda each: places[each.name or ""])
    if [places[each.name or ""] for each in named] != list(range(len(plain), len(node.arguments))):
        raise Unsaid(f"an argument of `{name}` behind one that is left out", node.span)
    return (*plain, *(replace(each, name=None) for each in named))


def the_one(node: nodes.Call) -> nodes.Argument:
    """The argument of an action that has one."""
    (argument,) = node.arguments
    if isinstance(argument.value, nodes.Starred):
        raise Unsaid("arguments of an action in a list", node.span)
    return argument


def left_out(argument: nodes.Argument, number: int, name: str) -> str:
    parameters = BUILTINS[name].parameters
    return f"`{argument.name or parameters[number].name}`, which Scenic's has not"
