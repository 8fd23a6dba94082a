"""Programs of every construct, for the laws of the syntax."""

import dataclasses
from typing import Any

import pytest
from hypothesis import strategies as st

from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import LATER_STATEMENTS, RESERVED

NOWHERE = Span(0, 0)
# Words that are keywords in some place and names in all others, beside plain names.
SOFT = [
    "m", "s", "g", "t", "min", "deg", "take", "wait", "abort", "terminate", "param", "map", "model", "behavior",
    "simulation", "distance", "minimum", "relative", "offset", "ahead", "behind", "left", "following", "facing",
    "before", "along", "can", "see", "intersects", "seconds", "steps", "interrupt", "when", "after", "self",
    "ego", "always", "eventually", "next", "implies", "choose", "shuffle", "monitor", "scenario", "setup", "compose",
    "precondition", "invariant", "record", "initial", "final", "mutate", "override", "signals",
]  # fmt: skip
LONELY = ("behavior", "map", "model", "monitor", "override", "param", "scenario", "signals", "simulation")

UNUSABLE = RESERVED | set(LATER_STATEMENTS) | {"true", "false", "null", "nil", "nullptr"}

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


def node(kind: type[Any], *values: Any, **named: Any) -> st.SearchStrategy[Any]:
    """Nodes of one kind, with empty spans for everything that wants one."""
    spans = {field.name: NOWHERE for field in dataclasses.fields(kind) if field.name.endswith("span")}
    return st.builds(kind, *values, **named, **{name: st.just(span) for name, span in spans.items()})


def brief(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """The same strategy, of which a report says no more than this name: written out, the grammar fills the memory."""

    @st.composite
    def part_of_the_grammar(draw: st.DrawFn) -> Any:
        return draw(strategy)

    return part_of_the_grammar()


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
        node(nodes.After, expressions, expressions, maybe),
        node(nodes.Facing, expressions, st.sampled_from(["", "toward", "away"])),
        node(nodes.Facing, expressions, st.just("apparent"), maybe),
        node(nodes.Beyond, expressions, expressions, maybe),
        node(nodes.InSight, maybe, st.booleans()),
        node(nodes.ContainedIn, expressions),
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
        node(
            nodes.SeenFrom,
            st.sampled_from(["apparent heading of", "relative position of", "distance past"]),
            inner,
            st.none() | inner,
        ),
        node(nodes.Angle, inner, inner) | node(nodes.Angle, st.none(), inner) | node(nodes.Angle, inner, st.none()),
        node(nodes.Follow, inner, st.none() | inner, inner),
        node(nodes.SideOf, st.sampled_from(["front", "back left", "right"]), inner),
        node(nodes.VisiblePart, inner, st.booleans(), st.none() | inner),
        node(nodes.RelativeTo, inner, inner),
        node(nodes.FieldAt, inner, inner),
        node(nodes.Index, inner, node(nodes.Slice, *[st.none() | inner] * 3)),
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
leaves |= node(
    nodes.Formatted,
    st.lists(st.tuples(texts, node(nodes.Placeholder, leaves, st.sampled_from(["", ".1f", ">8"]))), max_size=3).map(
        lambda pairs: tuple(part for pair in pairs for part in pair if part != "")
    ),
)
expressions = brief(st.recursive(leaves, grow, max_leaves=8))
# A string as the first statement would be the docstring.
said = expressions.filter(lambda value: not isinstance(value, nodes.String))
said = said.filter(lambda value: not (isinstance(value, nodes.Name) and value.id in LONELY))


def joined(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(
        node(nodes.Temporal, st.sampled_from(["always", "eventually", "next"]), several(inner, 1, 1)),
        node(nodes.Temporal, st.sampled_from(["until", "implies"]), several(inner, 2, 2)),
        node(nodes.BoolOp, st.sampled_from(["and", "or"]), several(inner, 2, 3)),
        node(nodes.Unary, st.just("not"), inner),
    )


formulas = brief(st.recursive(expressions, joined, max_leaves=4))
# Behind `require monitor` the temporal words are operators, so no monitor of such a name can be called.
named = node(nodes.Name, names.filter(lambda word: word not in ("always", "eventually", "next")))
monitors = node(nodes.Call, named, arguments(expressions))

labels = st.none() | texts
instants = st.sampled_from(["start", "contact", "end"])
modes = st.sampled_from(["", "choose", "shuffle"])
invocations = several(expressions, 1, 3)
paths = several(names, 1, 3).map(".".join)
imported = several(node(nodes.ImportedName, names, st.none() | names))
simple_statements = st.one_of(
    node(nodes.Map, names, arguments(expressions)),
    node(nodes.Simulation, arguments(expressions)),
    node(nodes.Model, several(names, 1, 3).map(".".join)),
    node(nodes.Param, several(node(nodes.ParamEntry, names | texts, expressions), 1, 2)),
    node(nodes.Assign, several(names, 1, 2), expressions),
    node(nodes.AugmentedAssign, names, st.sampled_from(["+", "-", "*", "/", "//", "%", "**"]), expressions),
    node(nodes.ExpressionStatement, said),
    node(nodes.Require, formulas, st.none() | expressions, labels),
    node(nodes.RequireMonitor, monitors, labels),
    node(nodes.Record, expressions, st.sampled_from(["", "initial", "final"]), labels),
    node(nodes.Domain, texts, expressions, instants, expressions),
    node(nodes.Domain, texts, expressions, instants, expressions, expressions, expressions),
    node(nodes.Mutate, several(names), st.none() | expressions),
    node(nodes.Override, named | node(nodes.Attribute, named, names), several(specifiers(expressions), 1, 2)),
    node(nodes.Signals, arguments(expressions)),
    node(nodes.Import, paths, st.none() | names, st.just(value=False)),
    node(nodes.Import, texts, st.none() | names, st.just(value=True)),
    node(nodes.ImportFrom, paths, imported, st.just(value=False)),
    node(nodes.ImportFrom, texts, imported, st.just(value=True)),
    node(nodes.TerminateWhen, expressions, labels, st.booleans()),
    node(nodes.Terminate, st.booleans()),
    node(nodes.TerminateAfter, expressions, st.booleans()),
    node(nodes.Do, invocations, mode=modes),
    node(nodes.Do, invocations, until=expressions, mode=modes),
    node(nodes.Do, invocations, duration=expressions, in_steps=st.booleans(), mode=modes),
    node(nodes.Take, several(expressions, 1, 2)),
    node(nodes.Wait, until=expressions),
    node(nodes.Wait, duration=expressions, in_steps=st.booleans()),
    node(nodes.Assert, expressions, st.none() | expressions),
    node(nodes.Return, expressions),
    *(
        node(kind)
        for kind in (
            nodes.Wait, nodes.Abort, nodes.Break, nodes.Continue, nodes.Return, nodes.Pass,
        )
    ),
)  # fmt: skip


def compound(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    body = several(inner, 1, 2)
    parameters = several(node(nodes.Parameter, names, st.none() | expressions))
    guards = several(node(nodes.Guard, expressions), 0, 2)
    properties = several(node(nodes.PropertyDefault, names, expressions))
    docstrings = st.none() | texts
    return st.one_of(
        node(nodes.BehaviorDefinition, names, parameters, body, docstrings, guards, guards),
        node(nodes.MonitorDefinition, names, parameters, body, docstrings),
        node(nodes.ScenarioDefinition, names, parameters, body, several(inner, 0, 2), docstrings, guards, guards),
        node(nodes.ScenarioDefinition, names, parameters, st.just(()), body, docstrings, guards, guards),
        node(nodes.ClassDefinition, names, st.none() | names, properties, docstrings),
        node(nodes.Try, body, several(node(nodes.Handler, expressions, body), 1, 2)),
        node(nodes.If, several(st.tuples(expressions, body), 1, 2), several(inner, 0, 2)),
        node(nodes.While, expressions, body),
        node(nodes.For, several(names, 1, 2), expressions, body),
        node(nodes.FunctionDefinition, names, parameters, body, docstrings),
    )


statements = brief(st.recursive(brief(simple_statements), compound, max_leaves=4))
modules = brief(node(nodes.Module, several(statements, 1, 3), st.none() | texts))


@pytest.fixture(scope="session")
def programs() -> st.SearchStrategy[nodes.Module]:
    """Syntax trees, whatever they mean."""
    return modules
