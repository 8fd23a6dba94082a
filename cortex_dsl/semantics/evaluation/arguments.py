"""Arguments of calls: evaluated, unpacked and bound to the parameters of the callee."""

from collections.abc import Mapping, Sequence
from functools import cache

from cortex_dsl.semantics.errors.names import DUPLICATE, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import TOO_FEW_ARGUMENTS, TOO_MANY_ARGUMENTS, WRONG_KIND
from cortex_dsl.semantics.evaluation.numbers import adopt, unit_cure
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import POISON, Value
from cortex_dsl.semantics.model.wording import kind_name, range_text, shown
from cortex_dsl.semantics.names.builtins import BUILTINS, Builtin, Parameter
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.units import PURE, UNITS, example
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.frozen import frozen


@frozen
class Given:
    """One argument as it was written; `node` is None for an item of an unpacked list."""

    value: Value
    span: Span
    name: str | None = None
    node: nodes.Expression | None = None
    whole: Span | None = None
    """Span that includes the name in front of the value."""

    @property
    def place(self) -> Span:
        return self.whole or self.span


def evaluate_arguments(ev: Evaluator, arguments: Sequence[nodes.Argument]) -> list[Given]:
    """All arguments, lists behind `*` unpacked. Reports every mistake in them before giving up."""
    given, broken = evaluate_each(ev, arguments)
    if broken:
        raise Mistake
    return given


def evaluate_each(ev: Evaluator, arguments: Sequence[nodes.Argument]) -> tuple[list[Given], bool]:
    """Return the arguments that can be evaluated, and whether others failed; report the errors of those."""
    given: list[Given] = []
    broken = False
    for argument in arguments:
        starred = isinstance(argument.value, nodes.Starred)
        node = argument.value.value if isinstance(argument.value, nodes.Starred) else argument.value
        value = ev.tolerate(lambda node=node: ev.evaluate(node))
        if value is POISON:
            broken = True
        elif starred:
            items = items_of(value, node.span, "what `*` unpacks")
            ev.file.budget.spend(node.span, len(items))
            given += [Given(item, node.span) for item in items]
        else:
            given.append(Given(value, node.span, argument.name, node, argument.span))
    return given, broken


def items_of(value: Value, span: Span, what: str = "this") -> tuple[Value, ...]:
    if isinstance(value, tuple):
        return value
    raise WRONG_KIND.mistake(span, what=what, expected="a list", actual=kind_name(value), cure="")


@frozen
class Slot:
    """Properties of a parameter that binding reads."""

    name: str
    optional: bool = False
    aliases: tuple[str, ...] = ()


def bind(function: str, signature: str, slots: Sequence[Slot], given: Sequence[Given], span: Span) -> dict[str, Given]:
    """Arguments by the parameter they belong to.

    Raises:
        Mistake: for one too many, one too few, an unknown or a repeated name.
    """
    bound: dict[str, Given] = {}
    positional = [g for g in given if g.name is None]
    if len(positional) > len(slots):
        raise TOO_MANY_ARGUMENTS.mistake(
            positional[len(slots)].span,
            function=function,
            count=_count(len(slots)),
            given=len(positional),
            signature=signature,
        )
    bound.update({slot.name: g for slot, g in zip(slots, positional, strict=False)})
    named = [(g.name, g) for g in given if g.name is not None]
    by_name = {name: slot.name for slot in slots for name in (slot.name, *slot.aliases)} if named else {}
    for name, g in named:
        if name not in by_name:
            raise UNKNOWN_ARGUMENT.mistake(
                g.place, function=function, name=name, suggestion=did_you_mean(name, [slot.name for slot in slots])
            )
        if by_name[name] in bound:
            raise DUPLICATE.mistake(g.place, what="the argument", name=name)
        bound[by_name[name]] = g
    missing = [f"`{slot.name}`" for slot in slots if not slot.optional and slot.name not in bound]
    if missing:
        raise TOO_FEW_ARGUMENTS.mistake(span, function=function, missing=" and ".join(missing), signature=signature)
    return bound


def _count(number: int) -> str:
    return ("no arguments", "one argument")[number] if number < 2 else f"{number} arguments"


def bind_builtin(row: Builtin, given: Sequence[Given], span: Span) -> dict[str, Given]:
    signature, slots = _shape(row.name)
    return bind(row.name, signature, slots, given, span)


@cache
def _shape(builtin: str) -> tuple[str, tuple[Slot, ...]]:
    row = BUILTINS[builtin]
    return row.signature, tuple(Slot(p.name, p.default is not None, p.aliases) for p in row.parameters)


def number_for(ev: Evaluator, parameter: Parameter, argument: Given) -> Term:
    """The number that a parameter with a dimension takes, inside its legal range."""
    assert parameter.dimension is not None
    what = f"`{parameter.name}`"
    expr = adopt(ev, argument.value, parameter.dimension, argument.span, what, usage(parameter))
    return in_range(ev, expr, Domain(what, parameter.dimension, parameter.low, parameter.high), argument.span)


def usage(parameter: Parameter) -> str:
    """Return the form of a parameter with a dimension: its unit or its range, and an example."""
    dimension = parameter.dimension
    assert dimension is not None
    limits = range_text(parameter.low, parameter.high, dimension, above=False)
    form = parameter.meaning or (f"a number without a unit, {limits}" if dimension == PURE else unit_cure(dimension))
    usual, _, word = example(dimension).partition(" ")
    value = float(usual) * (UNITS[word].factor if word else 1.0)
    legal = min(max(value, parameter.low), parameter.high)
    number = example(dimension) if legal == value else shown(legal, dimension)
    return f"{form}; as in `{parameter.name}={number}`"


def no_names(function: str, given: Sequence[Given]) -> None:
    """Functions of any number of arguments take none by name."""
    for g in given:
        if g.name is not None:
            raise UNKNOWN_ARGUMENT.mistake(g.place, function=function, name=g.name, suggestion="")


Bound = Mapping[str, Given]
