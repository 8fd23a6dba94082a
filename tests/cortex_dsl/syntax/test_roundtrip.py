"""Laws of the syntax tree: text and tree say the same, and a part lies inside its whole."""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes, parse, unparse
from cortex_dsl.syntax.later import STATEMENTS, TEMPORAL
from cortex_dsl.syntax.units import UNIT_WORDS
from cortex_dsl.syntax.words import RESERVED

NOWHERE = Span(0, 0)
# Words that are keywords in some place and names in all others, beside plain names.
SOFT = [
    "m", "s", "g", "t", "min", "deg", "take", "wait", "abort", "terminate", "param", "map", "model", "behavior",
    "simulation", "distance", "minimum", "relative", "offset", "ahead", "behind", "left", "following", "facing",
    "before", "along", "can", "see", "intersects", "seconds", "steps", "interrupt", "when", "after", "self",
    "ego",
]  # fmt: skip

UNUSABLE = RESERVED | TEMPORAL | set(STATEMENTS) | {"true", "false", "null", "nil", "nullptr"}

names = st.one_of(
    st.sampled_from(SOFT),
    st.from_regex(r"[a-zA-Z_][a-zA-Z_0-9]{0,6}", fullmatch=True),
    st.sampled_from(["größe", "x1", "Δt"]),
).filter(lambda word: word not in UNUSABLE)
units = st.sampled_from(UNIT_WORDS)
floats = st.one_of(
    st.integers(0, 10**6).map(float),
    st.floats(min_value=0, allow_nan=False, allow_infinity=False),
)
texts = st.text(max_size=8)


def node(kind: Callable[..., Any], *values: Any, **named: Any) -> st.SearchStrategy[Any]:
    """Nodes of one kind, with empty spans for everything that wants one."""
    spans = {field.name: NOWHERE for field in dataclasses.fields(kind) if field.name.endswith("span")}
    return st.builds(kind, *values, **named, **{name: st.just(span) for name, span in spans.items()})


def several(strategy: st.SearchStrategy[Any], least: int = 0, most: int = 3) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(strategy, min_size=least, max_size=most).map(tuple)


def arguments(expressions: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    plain = node(nodes.Argument, expressions)
    starred = node(nodes.Argument, node(nodes.Starred, expressions))
    return several(st.one_of(plain, starred, node(nodes.Argument, expressions, names)))


def specifiers(expressions: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    maybe = st.none() | expressions
    return st.one_of(
        node(nodes.At, expressions),
        node(nodes.InRegion, st.sampled_from(["in", "on"]), expressions),
        node(nodes.OffsetBySpecifier, expressions),
        node(nodes.OffsetAlongSpecifier, expressions, expressions),
        node(nodes.Beside, st.sampled_from(["ahead", "behind", "left", "right"]), expressions, maybe),
        node(nodes.Following, expressions, maybe, expressions),
        node(nodes.Before, expressions, expressions, maybe),
        node(nodes.Facing, expressions, st.sampled_from(["", "toward", "away"])),
        node(nodes.With, names, expressions),
    )


def grow(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    calls = node(nodes.Call, inner, arguments(inner))
    items = several(st.one_of(inner, node(nodes.Starred, inner)))
    clause = node(nodes.ForClause, several(names, 1, 2), inner, several(inner, 0, 2))
    comparators = st.sampled_from(["<", "<=", ">", ">=", "==", "!=", "in", "not in", "is", "is not"])
    return st.one_of(
        calls,
        node(nodes.WithUnit, calls, units),
        node(nodes.Attribute, inner, names),
        node(nodes.Index, inner, inner),
        node(nodes.ListDisplay, items),
        node(nodes.TupleDisplay, items),
        node(nodes.DictDisplay, several(st.tuples(inner, inner))),
        node(nodes.Comprehension, inner, several(clause, 1, 2)),
        node(nodes.Lambda, several(names), inner),
        node(nodes.Unary, st.sampled_from(["-", "+", "not"]), inner),
        node(nodes.Binary, st.sampled_from(["+", "-", "*", "/", "//", "%", "**", "@"]), inner, inner),
        node(nodes.BoolOp, st.sampled_from(["and", "or"]), several(inner, 2, 3)),
        node(nodes.Compare, inner, several(st.tuples(comparators, inner), 1, 2)),
        node(nodes.Conditional, inner, inner, inner),
        node(nodes.Distance, st.none() | inner, inner, st.booleans()),
        node(nodes.RelativeHeading, inner, st.none() | inner),
        node(nodes.CanSee, inner, inner),
        node(nodes.Intersects, inner, inner),
        node(nodes.Degrees, inner),
        node(nodes.OffsetBy, inner, inner),
        node(nodes.OffsetAlong, inner, inner, inner),
        node(nodes.New, names, several(specifiers(inner))),
    )


leaves = st.one_of(
    node(nodes.Number, floats, st.none() | units),
    node(nodes.Name, names),
    node(nodes.Constant, st.sampled_from([True, False, None])),
    node(nodes.String, texts),
)
expressions = st.recursive(leaves, grow, max_leaves=8)
# A string as the first statement would be the docstring.
said = expressions.filter(lambda value: not isinstance(value, nodes.String))
said = said.filter(
    lambda value: (
        not (isinstance(value, nodes.Name) and value.id in ("behavior", "map", "model", "param", "simulation"))
    )
)

labels = st.none() | texts
simple_statements = st.one_of(
    node(nodes.Map, names, arguments(expressions)),
    node(nodes.Simulation, arguments(expressions)),
    node(nodes.Model, several(names, 1, 3).map(".".join)),
    node(nodes.Param, several(node(nodes.ParamEntry, names | texts, expressions), 1, 2)),
    node(nodes.Assign, several(names, 1, 2), expressions),
    node(nodes.AugmentedAssign, names, st.sampled_from(["+", "-", "*", "/", "//", "%", "**"]), expressions),
    node(nodes.ExpressionStatement, said),
    node(nodes.Require, expressions, st.none() | expressions, labels),
    node(nodes.TerminateWhen, expressions, labels),
    node(nodes.TerminateAfter, expressions, st.booleans()),
    node(nodes.Do, expressions),
    node(nodes.Do, expressions, until=expressions),
    node(nodes.Do, expressions, duration=expressions, in_steps=st.booleans()),
    node(nodes.Take, several(expressions, 1, 2)),
    *(
        node(kind)
        for kind in (
            nodes.Wait, nodes.Abort, nodes.Terminate, nodes.Break, nodes.Continue, nodes.Return, nodes.Pass,
        )
    ),
)  # fmt: skip


def compound(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    body = several(inner, 1, 2)
    parameters = several(node(nodes.Parameter, names, st.none() | expressions))
    return st.one_of(
        node(nodes.BehaviorDefinition, names, parameters, body, st.none() | texts),
        node(nodes.Try, body, several(node(nodes.Handler, expressions, body), 1, 2)),
        node(nodes.If, several(st.tuples(expressions, body), 1, 2), several(inner, 0, 2)),
        node(nodes.While, expressions, body),
    )


statements = st.recursive(simple_statements, compound, max_leaves=4)
modules = node(nodes.Module, several(statements, 1, 3), st.none() | texts)


def children(value: Any) -> Iterator[nodes.Node]:
    """The nodes directly below a node."""
    if isinstance(value, nodes.Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from children(item)


def spans_nest(parent: nodes.Node) -> None:
    for field in dataclasses.fields(parent):
        for child in children(getattr(parent, field.name)):
            assert parent.span.start <= child.span.start <= child.span.end <= parent.span.end, (parent, child)
            spans_nest(child)


@settings(max_examples=120, deadline=None, suppress_health_check=list(HealthCheck))
@given(modules)
def test_print_then_parse_gives_the_same_tree(module: nodes.Module) -> None:
    """What is written for a tree reads as that tree, and spans nest in what was read."""
    text = unparse(module)
    read = parse(Source("generated", text))
    assert read == module, text
    assert unparse(read) == text
    spans_nest(read)
