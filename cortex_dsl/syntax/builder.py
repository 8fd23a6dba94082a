"""Tree to nodes: statements and the module."""

from collections.abc import Callable, Sequence

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import definitions, errors, nodes, words
from cortex_dsl.syntax.explain.context import Word
from cortex_dsl.syntax.explain.joints import missing_guard_colon
from cortex_dsl.syntax.expressions import Branch, Child, ExpressionBuilder, NestingError, branch, span_of, token
from cortex_dsl.syntax.words import GUARDS

Statements = tuple[nodes.Statement, ...]
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

    def statements(self, children: Sequence[Child]) -> Statements:
        return tuple(self.statement(branch(child)) for child in children)

    def block(self, child: Child) -> Statements:
        return self.statements(branch(child).children)

    def statement(self, tree: Branch) -> nodes.Statement:
        return _BUILDERS[tree.data](self, tree.children, span_of(tree))

    # -- statements about the world -----------------------------------------------------------------------------------

    def map(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Map(str(parts[0]), self.expressions.arguments(parts[1]), span=span)

    def simulation(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Simulation(self.expressions.arguments(parts[0]), span=span)

    def model(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Model(".".join(str(word) for word in parts), span=span)

    def param(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Param(tuple(self.param_entry(branch(entry)) for entry in parts), span=span)

    def param_entry(self, tree: Branch) -> nodes.ParamEntry:
        word, value = token(tree.children[0]), tree.children[1]
        name = self.expressions.text(word) if word.type == "STRING" else str(word)
        return nodes.ParamEntry(name, self.expression(value), span=span_of(tree), name_span=span_of(word))

    def signals(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Signals(self.expressions.arguments(parts[0]), span=span)

    def environment(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Environment(self.expressions.arguments(parts[0]), span=span)

    def mutate(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        targets = () if parts[0] is None else branch(parts[0]).children
        return nodes.Mutate(tuple(str(word) for word in targets), self.optional(parts[1]), span=span)

    def override(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        specifiers = tuple(self.expressions.specifier(branch(each)) for each in branch(parts[1]).children)
        return nodes.Override(self.expression(parts[0]), specifiers, span=span)

    # -- other files -------------------------------------------------------------------------------------------------

    def import_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        path, quoted, place = self.path(branch(parts[0]))
        alias = None if parts[1] is None else str(parts[1])
        return nodes.Import(path, alias, quoted, span=span, path_span=place)

    def import_from(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        path, quoted, place = self.path(branch(parts[0]))
        names = tuple(_imported(branch(each)) for each in parts[1:])
        return nodes.ImportFrom(path, names, quoted, span=span, path_span=place)

    def import_all(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
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

    def assign(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        target = branch(parts[0])
        if target.data == "attribute":
            return self.set_attribute(target, "", parts[1], span)
        return nodes.Assign(self.targets(target), self.expression(parts[1]), span=span)

    def set_attribute(self, target: Branch, operator: str, value: Child, span: Span) -> nodes.Statement:
        attribute = self.expression(target)
        assert isinstance(attribute, nodes.Attribute)
        return nodes.SetAttribute(attribute, operator, self.expression(value), span=span)

    def augmented_assign(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
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

    def expression_statement(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
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

    def require(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Require(self.expressions.condition(parts[0]), None, self.label(parts[1]), span=span)

    def require_probably(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        probability = self.expression(parts[0])
        return nodes.Require(self.expressions.condition(parts[1]), probability, self.label(parts[2]), span=span)

    def require_monitor(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.RequireMonitor(self.expression(parts[0]), self.label(parts[1]), span=span)

    def expect(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Expect(self.expressions.condition(parts[0]), self.label(parts[1]), span=span)

    def optimize(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Optimize(str(parts[0]), self.expression(parts[1]), self.label(parts[2]), span=span)

    def record(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        when, value, label = parts
        return nodes.Record(self.expression(value), str(when or ""), self.label(label), span=span)

    def label(self, child: Child) -> str | None:
        if child is None:
            return None
        word = token(branch(child).children[0])
        return self.expressions.text(word) if word.type == "STRING" else str(word)

    def terminate_when(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        word, condition, label = parts
        simulation = "simulation" in str(word)
        return nodes.TerminateWhen(self.expression(condition), self.label(label), simulation, span=span)

    def terminate_after(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.TerminateAfter(self.expression(parts[0]), parts[1] == "steps", span=span)

    def terminate(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Terminate("simulation" in str(parts[0]), span=span)

    # -- acts of actors -----------------------------------------------------------------------------------------------

    def do(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Do(self.invocations(parts), mode=_mode(parts), span=span)

    def do_until(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Do(self.invocations(parts), until=self.expression(parts[2]), mode=_mode(parts), span=span)

    def do_for(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        duration, in_steps = self.expression(parts[2]), parts[3] == "steps"
        return nodes.Do(self.invocations(parts), duration=duration, in_steps=in_steps, mode=_mode(parts), span=span)

    def invocations(self, parts: Sequence[Child]) -> tuple[nodes.Expression, ...]:
        return self.expressions.expressions(branch(parts[1]).children)

    def take(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Take(self.expressions.expressions(parts), span=span)

    def wait_until(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Wait(until=self.expression(parts[0]), span=span)

    def wait_for(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Wait(duration=self.expression(parts[0]), in_steps=parts[1] == "steps", span=span)

    def assert_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Assert(self.expression(parts[0]), self.optional(parts[1]), span=span)

    def return_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.Return(self.optional(parts[0]) if parts else None, span=span)

    def try_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
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

    def if_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        condition, block, *elifs, otherwise = parts
        branches = [(self.expression(condition), self.block(block))]
        for each in elifs:
            condition, block = branch(each).children
            branches.append((self.expression(condition), self.block(block)))
        return nodes.If(tuple(branches), () if otherwise is None else self.block(otherwise), span=span)

    def while_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        return nodes.While(self.expression(parts[0]), self.block(parts[1]), span=span)

    def for_(self, parts: Sequence[Child], span: Span) -> nodes.Statement:
        targets, _, iterable, block = parts
        names = tuple(str(target) for target in branch(targets).children)
        return nodes.For(names, self.expression(iterable), self.block(block), span=span)


def _mode(parts: Sequence[Child]) -> str:
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


def _plain(kind: type[nodes.Statement]) -> "Builder":
    return lambda _builder, _parts, span: kind(span=span)


Builder = Callable[[StatementBuilder, Sequence[Child], Span], nodes.Statement]
_B = StatementBuilder
_BUILDERS: dict[str, Builder] = {
    "wait": _plain(nodes.Wait),
    "abort": _plain(nodes.Abort),
    "break_": _plain(nodes.Break),
    "continue_": _plain(nodes.Continue),
    "pass_": _plain(nodes.Pass),
} | {
    method.__name__: method
    for method in (
        _B.map, _B.simulation, _B.model, _B.param, _B.assign, _B.augmented_assign, _B.expression_statement,
        _B.require, _B.require_probably, _B.require_monitor, _B.expect, _B.optimize, _B.record, _B.terminate_when,
        _B.terminate_after, _B.terminate, _B.signals, _B.environment, _B.mutate, _B.override, _B.import_,
        _B.import_from, _B.import_all,
        _B.do, _B.do_until, _B.do_for, _B.take, _B.try_, _B.if_, _B.while_, _B.for_,
        _B.wait_until, _B.wait_for, _B.assert_, _B.return_,
    )
} | definitions.BUILDERS  # fmt: skip
"""Builder of each rule of the grammar; a method has the name of its rule."""
