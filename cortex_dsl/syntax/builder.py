"""Tree to nodes: statements, definitions and the module."""

from collections.abc import Callable, Sequence

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import errors, nodes, words
from cortex_dsl.syntax.explain.context import Word
from cortex_dsl.syntax.explain.joints import missing_guard_colon
from cortex_dsl.syntax.expressions import Branch, Child, ExpressionBuilder, NestingError, branch, span_of, token
from cortex_dsl.syntax.words import GUARDS
from engine.frozen import frozen

Statements = tuple[nodes.Statement, ...]
Parts = Sequence[Child]
_NEVER_ALONE = frozenset({
    "behavior", "environment", "map", "model", "monitor", "override", "param", "scenario", "signals", "simulation",
})  # fmt: skip
"""Statement words that say nothing alone on a line."""


def build(tree: Branch, source: Source) -> tuple[nodes.Module | None, list[Diagnostic]]:
    """The module of a tree, and the errors that show only in its shape."""
    builder = StatementBuilder(source)
    try:
        module = builder.module(tree)
    except NestingError:
        module = None
    return module, builder.diagnostics


class StatementBuilder:
    """Builds statements; expressions are left to an `ExpressionBuilder`."""

    def __init__(self, source: Source) -> None:
        self.expressions = ExpressionBuilder(source)
        self.expression = self.expressions.expression
        self.optional = self.expressions.optional
        self.report = self.expressions.report

    @property
    def diagnostics(self) -> list[Diagnostic]:
        return self.expressions.diagnostics

    def module(self, tree: Branch) -> nodes.Module:
        statements, docstring = _with_docstring(self.statements(tree.children))
        end = len(self.expressions.source.text)
        return nodes.Module(statements, docstring, span=Span(0, end))

    def statements(self, children: Parts) -> Statements:
        return tuple(self.statement(branch(child)) for child in children)

    def block(self, child: Child) -> Statements:
        return self.statements(branch(child).children)

    def statement(self, tree: Branch) -> nodes.Statement:
        return _BUILDERS[tree.data](self, tree.children, span_of(tree))

    # -- statements about the world -----------------------------------------------------------------------------------

    def map(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Map(str(parts[0]), self.expressions.arguments(parts[1]), span=span)

    def simulation(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Simulation(self.expressions.arguments(parts[0]), span=span)

    def model(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Model(".".join(str(word) for word in parts), span=span)

    def param(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Param(tuple(self.param_entry(branch(entry)) for entry in parts), span=span)

    def param_entry(self, tree: Branch) -> nodes.ParamEntry:
        word, value = token(tree.children[0]), tree.children[1]
        name = self.expressions.text(word) if word.type == "STRING" else str(word)
        return nodes.ParamEntry(name, self.expression(value), span=span_of(tree), name_span=span_of(word))

    def signals(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Signals(self.expressions.arguments(parts[0]), span=span)

    def environment(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Environment(self.expressions.arguments(parts[0]), span=span)

    def mutate(self, parts: Parts, span: Span) -> nodes.Statement:
        targets = () if parts[0] is None else branch(parts[0]).children
        return nodes.Mutate(tuple(str(word) for word in targets), self.optional(parts[1]), span=span)

    def override(self, parts: Parts, span: Span) -> nodes.Statement:
        specifiers = tuple(self.expressions.specifier(branch(each)) for each in branch(parts[1]).children)
        return nodes.Override(self.expression(parts[0]), specifiers, span=span)

    # -- other files -------------------------------------------------------------------------------------------------

    def import_(self, parts: Parts, span: Span) -> nodes.Statement:
        path, quoted, place = self.path(branch(parts[0]))
        alias = None if parts[1] is None else str(parts[1])
        return nodes.Import(path, alias, quoted, span=span, path_span=place)

    def import_from(self, parts: Parts, span: Span) -> nodes.Statement:
        path, quoted, place = self.path(branch(parts[0]))
        names = tuple(_imported(branch(each)) for each in parts[1:])
        return nodes.ImportFrom(path, names, quoted, span=span, path_span=place)

    def import_all(self, parts: Parts, span: Span) -> nodes.Statement:
        path, quoted, place = self.path(branch(parts[0]))
        return nodes.ImportFrom(path, (), quoted, span=span, path_span=place)

    def path(self, tree: Branch) -> tuple[str, bool, Span]:
        """Return the imported path, whether it is quoted, and its place."""
        first = token(tree.children[0])
        quoted = first.type == "STRING"
        path = self.expressions.text(first) if quoted else ".".join(str(word) for word in tree.children)
        if not quoted and path.endswith(".scn"):
            self.report(
                errors.WRONG_IMPORT.at(
                    span_of(tree),
                    "a name is written without its extension",
                    reason=errors.WRONG_IMPORT.reason,
                    cure=f'write `{path.removesuffix(".scn")}` or `"{path}"`',
                )
            )
        return path, quoted, span_of(tree)

    # -- names and values --------------------------------------------------------------------------------------------

    def assign(self, parts: Parts, span: Span) -> nodes.Statement:
        target = branch(parts[0])
        if target.data == "attribute":
            return self.set_attribute(target, "", parts[1], span)
        return nodes.Assign(self.targets(target), self.expression(parts[1]), span=span)

    def set_attribute(self, target: Branch, operator: str, value: Child, span: Span) -> nodes.Statement:
        attribute = self.expression(target)
        assert isinstance(attribute, nodes.Attribute)
        return nodes.SetAttribute(attribute, operator, self.expression(value), span=span)

    def augmented_assign(self, parts: Parts, span: Span) -> nodes.Statement:
        tree, operator = branch(parts[0]), str(parts[1])[:-1]
        if tree.data == "attribute":
            return self.set_attribute(tree, operator, parts[2], span)
        return nodes.AugmentedAssign(self.target(tree), operator, self.expression(parts[2]), span=span)

    def targets(self, tree: Branch) -> tuple[str, ...]:
        several = tree.data in ("bare_tuple", "tuple") and tree.children
        return tuple(self.target(branch(child)) for child in tree.children) if several else (self.target(tree),)

    def target(self, tree: Branch) -> str:
        if tree.data == "name":
            return str(tree.children[0])
        self.report(errors.no_target(span_of(tree), errors.ATTRIBUTE_CURE if tree.data == "attribute" else ""))
        return "_"

    def expression_statement(self, parts: Parts, span: Span) -> nodes.Statement:
        value = self.expression(parts[0])
        match value:
            case nodes.Name(id=word) if word in _NEVER_ALONE:
                self.report(
                    errors.INCOMPLETE.at(span, f"nothing follows `{word}`", reason="a statement needs what it is about")
                )
            case nodes.Call(function=nodes.Name(id=word)) if word in GUARDS:
                self.report(missing_guard_colon(Word("name", word, value.function.span)))
            case nodes.Call(function=nodes.Name(id=word)) if word in words.LATER_STATEMENTS:
                self.report(
                    errors.NOT_SUPPORTED.at(
                        value.function.span,
                        f"not supported yet: {words.LATER_STATEMENTS[word]}",
                        reason=errors.NOT_SUPPORTED.reason,
                        cure=words.INSTEAD.get(word, ""),
                    )
                )
        return nodes.ExpressionStatement(value, span=span)

    # -- conditions on scenes and runs -------------------------------------------------------------------------------

    def require(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Require(self.expressions.condition(parts[0]), None, self.label(parts[1]), span=span)

    def require_probably(self, parts: Parts, span: Span) -> nodes.Statement:
        probability = self.expression(parts[0])
        return nodes.Require(self.expressions.condition(parts[1]), probability, self.label(parts[2]), span=span)

    def require_monitor(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.RequireMonitor(self.expression(parts[0]), self.label(parts[1]), span=span)

    def expect(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Expect(self.expressions.condition(parts[0]), self.label(parts[1]), span=span)

    def optimize(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Optimize(str(parts[0]), self.expression(parts[1]), self.label(parts[2]), span=span)

    def record(self, parts: Parts, span: Span) -> nodes.Statement:
        when, value, label = parts
        return nodes.Record(self.expression(value), str(when or ""), self.label(label), span=span)

    def domain(self, parts: Parts, span: Span) -> nodes.Statement:
        name, value, when, _, cells, *ends = parts
        return nodes.Domain(
            self.expressions.text(token(name)),
            self.expression(value),
            " ".join(str(when or "start").split()),
            self.expression(cells),
            *map(self.expression, ends),
            span=span,
        )

    def label(self, child: Child) -> str | None:
        if child is None:
            return None
        word = token(branch(child).children[0])
        return self.expressions.text(word) if word.type == "STRING" else str(word)

    def terminate_when(self, parts: Parts, span: Span) -> nodes.Statement:
        word, condition, label = parts
        simulation = "simulation" in str(word)
        return nodes.TerminateWhen(self.expression(condition), self.label(label), simulation, span=span)

    def terminate_after(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.TerminateAfter(self.expression(parts[0]), parts[1] == "steps", span=span)

    def terminate(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Terminate("simulation" in str(parts[0]), span=span)

    # -- acts of actors -----------------------------------------------------------------------------------------------

    def do(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Do(self.invocations(parts), mode=_mode(parts), span=span)

    def do_until(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Do(self.invocations(parts), until=self.expression(parts[2]), mode=_mode(parts), span=span)

    def do_for(self, parts: Parts, span: Span) -> nodes.Statement:
        duration, in_steps = self.expression(parts[2]), parts[3] == "steps"
        return nodes.Do(self.invocations(parts), duration=duration, in_steps=in_steps, mode=_mode(parts), span=span)

    def invocations(self, parts: Parts) -> tuple[nodes.Expression, ...]:
        return self.expressions.expressions(branch(parts[1]).children)

    def take(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Take(self.expressions.expressions(parts), span=span)

    def wait_until(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Wait(until=self.expression(parts[0]), span=span)

    def wait_for(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Wait(duration=self.expression(parts[0]), in_steps=parts[1] == "steps", span=span)

    def assert_(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Assert(self.expression(parts[0]), self.optional(parts[1]), span=span)

    def return_(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.Return(self.optional(parts[0]) if parts else None, span=span)

    def try_(self, parts: Parts, span: Span) -> nodes.Statement:
        body, *handlers = parts
        if not handlers:
            self.report(
                errors.INCOMPLETE.at(
                    Span(span.start, span.start + len("try")),
                    "this `try` has no `interrupt when`",
                    "nothing can interrupt it",
                    reason=errors.INCOMPLETE.reason,
                    cure="write `interrupt when CONDITION:` below it, or remove the `try`",
                )
            )
        return nodes.Try(self.block(body), tuple(self.handler(branch(each)) for each in handlers), span=span)

    def handler(self, tree: Branch) -> nodes.Handler:
        return nodes.Handler(self.expression(tree.children[0]), self.block(tree.children[1]), span=span_of(tree))

    def if_(self, parts: Parts, span: Span) -> nodes.Statement:
        condition, block, *elifs, otherwise = parts
        branches = [(self.expression(condition), self.block(block))]
        for each in elifs:
            condition, block = branch(each).children
            branches.append((self.expression(condition), self.block(block)))
        return nodes.If(tuple(branches), () if otherwise is None else self.block(otherwise), span=span)

    def while_(self, parts: Parts, span: Span) -> nodes.Statement:
        return nodes.While(self.expression(parts[0]), self.block(parts[1]), span=span)

    def for_(self, parts: Parts, span: Span) -> nodes.Statement:
        targets, _, iterable, block = parts
        names = tuple(str(target) for target in branch(targets).children)
        return nodes.For(names, self.expression(iterable), self.block(block), span=span)


def _mode(parts: Parts) -> str:
    return str(parts[0] or "")


def _imported(tree: Branch) -> nodes.ImportedName:
    word, alias = tree.children
    return nodes.ImportedName(str(word), None if alias is None else str(alias), span=span_of(tree))


def _with_docstring(statements: Statements) -> tuple[Statements, str | None]:
    """The statements without a leading string, and that string."""
    match statements:
        case (nodes.ExpressionStatement(value=nodes.String(value=text)), *rest):
            return tuple(rest), text
    return statements, None


# -- definitions -------------------------------------------------------------------------------------------------------


@frozen
class _Body:
    """The parts of a block: its docstring, its guards by their word, its sections by theirs, and the remainder."""

    docstring: str | None
    guards: dict[str, tuple[nodes.Guard, ...]]
    sections: dict[str, Branch]
    statements: list[Branch]


def behavior(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    word, *parameters, block = parts
    body = _body(builder, block)
    return nodes.BehaviorDefinition(
        str(word),
        _parameters(builder, parameters),
        builder.statements(body.statements),
        body.docstring,
        body.guards["precondition"],
        body.guards["invariant"],
        span=span,
        name_span=span_of(token(word)),
    )


def monitor(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    return _named_block(nodes.MonitorDefinition, builder, parts, span)


def def_(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    return _named_block(nodes.FunctionDefinition, builder, parts, span)


def _named_block(
    kind: type[nodes.MonitorDefinition | nodes.FunctionDefinition], builder: StatementBuilder, parts: Parts, span: Span
) -> nodes.Statement:
    word, *parameters, block = parts
    docstring, rest = _docstring(builder, block)
    return kind(
        str(word),
        _parameters(builder, parameters),
        builder.statements(rest),
        docstring,
        span=span,
        name_span=span_of(token(word)),
    )


def scenario(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    word, *parameters, block = parts
    body = _body(builder, block, sections=("setup", "compose"))
    setup, compose = (_section(builder, body.sections.get(name)) for name in ("setup", "compose"))
    if body.sections and body.statements:
        _stray_statement(builder, body.statements[0], next(iter(body.sections.values())))
    return nodes.ScenarioDefinition(
        str(word),
        _parameters(builder, parameters),
        setup or builder.statements(body.statements),
        compose,
        body.docstring,
        body.guards["precondition"],
        body.guards["invariant"],
        span=span,
        name_span=span_of(token(word)),
    )


def class_(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    word, base, block = parts
    docstrings, lines = [], []
    for line in map(branch, branch(block).children):
        if line.data == "docstring" and not lines and not docstrings:
            docstrings.append(builder.expressions.text(token(line.children[0])))
        elif line.data == "docstring":
            builder.report(_no_property(span_of(line)))
        else:
            lines.append(line)
    return nodes.ClassDefinition(
        str(word),
        None if base is None else str(base),
        tuple(_property(builder, line) for line in lines if line.data == "property"),
        docstrings[0] if docstrings else None,
        span=span,
        name_span=span_of(token(word)),
        base_span=None if base is None else span_of(token(base)),
    )


def _no_property(span: Span) -> Diagnostic:
    return errors.CLASS_BODY.at(
        span,
        "a string is not a property",
        reason=errors.CLASS_BODY.reason,
        cure="its docstring is the first line of a class",
    )


def _property(builder: StatementBuilder, line: Branch) -> nodes.PropertyDefault:
    word, value = line.children
    return nodes.PropertyDefault(
        str(word), builder.expressions.expression(value), span=span_of(line), name_span=span_of(token(word))
    )


def _parameters(builder: StatementBuilder, children: Parts) -> tuple[nodes.Parameter, ...]:
    return tuple(_parameter(builder, branch(child)) for child in children if child is not None)


def _parameter(builder: StatementBuilder, tree: Branch) -> nodes.Parameter:
    if tree.data == "rest_parameter":
        return nodes.Parameter(str(tree.children[1]), rest=True, span=span_of(tree))
    word, default = tree.children
    return nodes.Parameter(str(word), builder.expressions.optional(default), span=span_of(tree))


# -- contents of a block ----------------------------------------------------------------------------------------------


def _docstring(builder: StatementBuilder, block: Child) -> tuple[str | None, Parts]:
    """Return a leading string and the children after it."""
    children = branch(block).children
    if children and branch(children[0]).data == "expression_statement":
        value = branch(branch(children[0]).children[0])
        if value.data == "string":
            return builder.expressions.text(token(value.children[0])), children[1:]
    return None, children


def _body(builder: StatementBuilder, block: Child, sections: Sequence[str] = ()) -> _Body:
    docstring, rest = _docstring(builder, block)
    body = _Body(docstring, {"precondition": (), "invariant": ()}, {}, [])
    for child in map(branch, rest):
        if child.data == "guard" and not body.statements and not body.sections:
            body.guards[str(child.children[0])] += (_guard(builder, child),)
        elif child.data in sections and _in_order(builder, body, child):
            body.sections[child.data] = child
        elif child.data not in sections:
            body.statements.append(child)
    return body


def _guard(builder: StatementBuilder, tree: Branch) -> nodes.Guard:
    return nodes.Guard(builder.expressions.expression(tree.children[1]), span=span_of(tree))


def _in_order(builder: StatementBuilder, body: _Body, section: Branch) -> bool:
    """Return whether a section is the only one of its name, and no earlier one belongs below it."""
    name = section.data
    first = body.sections.get(name) or (body.sections.get("compose") if name == "setup" else None)
    if first is None:
        return True
    twice = first.data == name
    builder.report(
        errors.MISPLACED_PART.at(
            _head(section, name),
            f"a second `{name}:` in one scenario" if twice else "`setup:` goes before `compose:`",
            secondary=[Label(_head(first, first.data), "first here" if twice else "this comes second")],
            reason=errors.MISPLACED_PART.reason,
            cure="put both into one block" if twice else "move this block above it",
        )
    )
    return False


def _section(builder: StatementBuilder, tree: Branch | None) -> Statements:
    return () if tree is None else builder.statements(branch(tree.children[0]).children)


def _stray_statement(builder: StatementBuilder, statement: Branch, section: Branch) -> None:
    span = span_of(statement)
    builder.report(
        errors.MISPLACED_PART.at(
            Span(span.start, _line_end(builder, span)),
            f"this is beside `{section.data}:`",
            secondary=[Label(_head(section, section.data), "a block of the same scenario")],
            reason=errors.MISPLACED_PART.reason,
            cure="move it into `setup:`",
        )
    )


def _line_end(builder: StatementBuilder, span: Span) -> int:
    end = builder.expressions.source.text.find("\n", span.start)
    return span.end if end < 0 else min(span.end, end)


def _head(tree: Branch, word: str) -> Span:
    start = span_of(tree).start
    return Span(start, start + len(word))


# -- in the wrong place ----------------------------------------------------------------------------------------------


def stray_section(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    """`setup:` or `compose:` that no scenario holds directly."""
    word = builder.expressions.source.text[span.start : span.end].split(":")[0].strip()
    builder.statements(branch(parts[0]).children)
    builder.report(
        errors.MISPLACED_PART.at(
            Span(span.start, span.start + len(word)),
            f"`{word}:` outside a scenario",
            reason=errors.MISPLACED_PART.reason,
            cure=f"write `scenario Main():` above it and indent the `{word}:` block",
        )
    )
    return nodes.Pass(span=span)


def stray_guard(builder: StatementBuilder, parts: Parts, span: Span) -> nodes.Statement:
    """A guard anywhere else than at the top of a behaviour or scenario."""
    word = token(parts[0])
    builder.expressions.expression(parts[1])
    builder.report(
        errors.MISPLACED_PART.at(
            span_of(word),
            f"`{word}` belongs at the top of a behavior or scenario",
            "too late, or in another place",
            reason=errors.MISPLACED_PART.reason,
            cure="move it above the statements, below the docstring",
        )
    )
    return nodes.Pass(span=span)


# -- the table ---------------------------------------------------------------------------------------------------------


def _plain(kind: type[nodes.Statement]) -> "Builder":
    return lambda _builder, _parts, span: kind(span=span)


Builder = Callable[[StatementBuilder, Parts, Span], nodes.Statement]
_B = StatementBuilder
_BUILDERS: dict[str, Builder] = {
    "wait": _plain(nodes.Wait),
    "abort": _plain(nodes.Abort),
    "break_": _plain(nodes.Break),
    "continue_": _plain(nodes.Continue),
    "pass_": _plain(nodes.Pass),
    "class_": class_,
    "behavior": behavior,
    "monitor": monitor,
    "def_": def_,
    "scenario": scenario,
    "setup": stray_section,
    "compose": stray_section,
    "guard": stray_guard,
} | {
    method.__name__: method
    for method in (
        _B.map, _B.simulation, _B.model, _B.param, _B.assign, _B.augmented_assign, _B.expression_statement,
        _B.require, _B.require_probably, _B.require_monitor, _B.expect, _B.optimize, _B.record, _B.domain,
        _B.terminate_when, _B.terminate_after, _B.terminate, _B.signals, _B.environment, _B.mutate, _B.override,
        _B.import_, _B.import_from, _B.import_all,
        _B.do, _B.do_until, _B.do_for, _B.take, _B.try_, _B.if_, _B.while_, _B.for_,
        _B.wait_until, _B.wait_for, _B.assert_, _B.return_,
    )
}  # fmt: skip
"""Builder of each rule of the grammar; a method has the name of its rule."""
