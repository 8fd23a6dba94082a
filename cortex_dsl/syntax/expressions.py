"""Tree to nodes: expressions, specifiers and `new`."""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from lark import Token, Tree

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import errors, nodes
from cortex_dsl.syntax.errors import MAX_DEPTH
from cortex_dsl.syntax.formatted import read_formatted, unescaped
from cortex_dsl.syntax.literals import SPOKEN_UNITS, UNIT_WORDS, unit_list
from engine.errors import Signal

Branch: TypeAlias = Tree[Token]
Child: TypeAlias = Tree[Token] | Token | None

_TEMPORAL = frozenset({"temporal", "until", "implies"})
_FOREIGN_CONSTANTS = {"true": "True", "false": "False", "null": "None", "nil": "None", "nullptr": "None"}


def span_of(child: Branch | Token) -> Span:
    """Return the span of a tree or token."""
    if isinstance(child, Token):
        return Span(child.start_pos or 0, child.end_pos or 0)
    return Span(child.meta.start_pos, child.meta.end_pos) if not child.meta.empty else Span(0, 0)


def branch(child: Child) -> Branch:
    assert isinstance(child, Tree), child
    return child


def token(child: Child) -> Token:
    assert isinstance(child, Token), child
    return child


def _holds_formulas(tree: Branch) -> bool:
    """Return whether temporal operators may be directly below this tree."""
    negation = tree.data == "unary" and tree.children[0] == "not"
    return negation or tree.data in _TEMPORAL or tree.data in ("and_", "or_")


def _words(child: Child) -> str:
    """The words of a token with one blank between them."""
    return " ".join(str(child).split())


class NestingError(Signal):
    """Nesting went over its limit; the diagnostic is already there."""


class ExpressionBuilder:
    """Builds expressions and collects errors that only show once their shape is known."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.diagnostics: list[Diagnostic] = []
        self.depth = 0
        self.in_formula = False
        """Whether a temporal operator may stand where building has come to."""

    def report(self, diagnostic: Diagnostic) -> None:
        self.diagnostics.append(diagnostic)

    # -- dispatch ----------------------------------------------------------------------------------------------------

    def expression(self, child: Child) -> nodes.Expression:
        tree = branch(child)
        if self.depth >= MAX_DEPTH:
            self.report(
                errors.TOO_DEEP.at(
                    span_of(tree),
                    f"this expression is nested more than {MAX_DEPTH} deep",
                    reason=errors.TOO_DEEP.reason,
                    cure="give inner parts a name of their own",
                )
            )
            raise NestingError
        self.depth += 1
        around = self.in_formula
        self.in_formula = around and _holds_formulas(tree)
        if tree.data in _TEMPORAL and not around:
            self.misplaced(tree)
        try:
            return _BUILDERS[tree.data](self, tree, span_of(tree))
        finally:
            self.depth -= 1
            self.in_formula = around

    def condition(self, child: Child) -> nodes.Expression:
        """The condition of a `require`, which may be about time."""
        self.in_formula = True
        try:
            return self.expression(child)
        finally:
            self.in_formula = False

    def misplaced(self, tree: Branch) -> None:
        word = token(tree.children[0]) if tree.data == "temporal" else tree.data
        self.report(
            errors.MISPLACED_TEMPORAL.at(
                span_of(tree),
                f"`{word}` cannot be used here",
                "speaks of a whole run",
                reason=errors.MISPLACED_TEMPORAL.reason,
                cure=f"write `require {'… ' if tree.data != 'temporal' else ''}{word} …` on a line of its own",
            )
        )

    def expressions(self, children: Iterable[Child]) -> tuple[nodes.Expression, ...]:
        return tuple(self.expression(child) for child in children)

    def optional(self, child: Child) -> nodes.Expression | None:
        return None if child is None else self.expression(child)

    # -- literals ----------------------------------------------------------------------------------------------------

    def number(self, tree: Branch, span: Span) -> nodes.Expression:
        literal = token(tree.children[0])
        value = float(literal.replace("_", "").rstrip(".") or "0") if "e" not in literal.lower() else float(literal)
        if math.isinf(value):
            self.report(
                errors.WRONG_LITERAL.at(
                    span_of(literal),
                    "this number is too large",
                    "more than 1.8e308",
                    reason=errors.WRONG_LITERAL.reason,
                    cure="write a smaller one",
                )
            )
            value = 0.0
        return nodes.Number(value, self.unit(tree.children[1]), span=span)

    def unit(self, child: Child) -> str | None:
        if child is None:
            return None
        word = token(child)
        if word.type == "UNKNOWN_UNIT":
            meant = "m/s^2" if word == "m/s" else SPOKEN_UNITS.get(word.lower()) or nearest(word, UNIT_WORDS)
            self.report(
                errors.UNKNOWN_UNIT.at(
                    span_of(word),
                    f"`{word}` is divided only once" if word == "m/s" else f"unknown unit `{word}`",
                    f"did you mean `{meant}`?" if meant else "a word directly after a number or a call is its unit",
                    reason=f"the units are {unit_list()}",
                    cure=f"write `{meant}`" if meant else "write one of them, or an operator before the word",
                )
            )
        return str(word)

    def with_unit(self, tree: Branch, span: Span) -> nodes.Expression:
        value = self.expression(tree.children[0])
        return nodes.WithUnit(value, self.unit(tree.children[1]) or "", span=span)

    def string(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.String(self.text(token(tree.children[0])), span=span)

    def formatted(self, tree: Branch, span: Span) -> nodes.Expression:
        return read_formatted(token(tree.children[0]), self.source, self.expression, self.report, span)

    def text(self, literal: Token) -> str:
        return unescaped(literal, literal.start_pos or 0, self.report)

    def constant(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Constant({"True": True, "False": False, "None": None}[str(tree.children[0])], span=span)

    def initial_scenario(self, _tree: Branch, span: Span) -> nodes.Expression:
        return nodes.InitialScenario(span=span)

    def name(self, tree: Branch, span: Span) -> nodes.Expression:
        word = str(tree.children[0])
        if (ours := _FOREIGN_CONSTANTS.get(word)) is not None:
            cure = f"write `{ours}`"
            self.report(errors.FOREIGN_SPELLING.at(span, f"`{word}` is written `{ours}`", cure=cure))
        return nodes.Name(word, span=span)

    # -- access and calls --------------------------------------------------------------------------------------------

    def attribute(self, tree: Branch, span: Span) -> nodes.Expression:
        value, word = self.expression(tree.children[0]), token(tree.children[1])
        return nodes.Attribute(value, str(word), span=span, name_span=span_of(word))

    def index(self, tree: Branch, span: Span) -> nodes.Expression:
        value, index = self.expressions(tree.children)
        return nodes.Index(value, index, span=span)

    def call(self, tree: Branch, span: Span) -> nodes.Expression:
        function, rest = self.expression(tree.children[0]), tree.children[1]
        if rest is not None and branch(rest).data == "generator":
            value = self.expression(rest)
            return nodes.Call(function, (nodes.Argument(value, span=value.span),), span=span)
        return nodes.Call(function, self.arguments(rest), span=span)

    def arguments(self, child: Child) -> tuple[nodes.Argument, ...]:
        if child is None:
            return ()
        return tuple(self.argument(branch(each)) for each in branch(child).children)

    def argument(self, tree: Branch) -> nodes.Argument:
        if tree.data == "keyword_argument":
            return nodes.Argument(self.expression(tree.children[1]), str(tree.children[0]), span=span_of(tree))
        return nodes.Argument(self.expression(tree.children[0]), span=span_of(tree))

    def starred(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Starred(self.expression(tree.children[1]), span=span)

    # -- displays ----------------------------------------------------------------------------------------------------

    def list(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.ListDisplay(self.expressions(tree.children), span=span)

    def tuple(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.TupleDisplay(self.expressions(tree.children), span=span)

    def dict(self, tree: Branch, span: Span) -> nodes.Expression:
        entries = [self.expressions(branch(entry).children) for entry in tree.children]
        return nodes.DictDisplay(tuple((key, value) for key, value in entries), span=span)

    def generator(self, tree: Branch, span: Span) -> nodes.Expression:
        element, *clauses = tree.children
        return nodes.Comprehension(
            self.expression(element), tuple(self.for_clause(branch(clause)) for clause in clauses), span=span
        )

    def for_clause(self, tree: Branch) -> nodes.ForClause:
        targets, _, iterable, *conditions = tree.children
        return nodes.ForClause(
            tuple(str(target) for target in branch(targets).children),
            self.expression(iterable),
            self.expressions(conditions),
            span=span_of(tree),
        )

    # -- operators ---------------------------------------------------------------------------------------------------

    def conditional(self, tree: Branch, span: Span) -> nodes.Expression:
        then, condition, otherwise = self.expressions(tree.children)
        return nodes.Conditional(condition, then, otherwise, span=span)

    def lambda_(self, tree: Branch, span: Span) -> nodes.Expression:
        *parameters, body = tree.children
        return nodes.Lambda(tuple(str(name) for name in parameters), self.expression(body), span=span)

    def or_(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.BoolOp("or", self.expressions(tree.children), span=span)

    def and_(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.BoolOp("and", self.expressions(tree.children), span=span)

    def unary(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Unary(str(tree.children[0]), self.expression(tree.children[1]), span=span)

    def temporal(self, tree: Branch, span: Span) -> nodes.Expression:
        word, operand = tree.children
        return nodes.Temporal(str(word), (self.expression(operand),), span=span)

    def until(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Temporal("until", self.expressions(tree.children), span=span)

    def implies(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Temporal("implies", self.expressions(tree.children), span=span)

    def binary(self, tree: Branch, span: Span) -> nodes.Expression:
        left, operator, right = tree.children
        return nodes.Binary(str(operator), self.expression(left), self.expression(right), span=span)

    def compare(self, tree: Branch, span: Span) -> nodes.Expression:
        first, *rest = tree.children
        operators = [" ".join(str(word).split()) for word in rest[::2]]
        return nodes.Compare(
            self.expression(first), tuple(zip(operators, self.expressions(rest[1::2]), strict=True)), span=span
        )

    def can_see(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.CanSee(*self.expressions(tree.children), span=span)

    def intersects(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Intersects(*self.expressions(tree.children), span=span)

    def offset_along(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.OffsetAlong(*self.expressions(tree.children), span=span)

    def offset_by(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.OffsetBy(*self.expressions(tree.children), span=span)

    def degrees(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Degrees(self.expression(tree.children[0]), span=span)

    def distance(self, tree: Branch, span: Span) -> nodes.Expression:
        return self.measured(tree, None, tree.children[1], span)

    def distance_from_to(self, tree: Branch, span: Span) -> nodes.Expression:
        return self.measured(tree, tree.children[1], tree.children[2], span)

    def distance_to_from(self, tree: Branch, span: Span) -> nodes.Expression:
        return self.measured(tree, tree.children[2], tree.children[1], span)

    def measured(self, tree: Branch, origin: Child, target: Child, span: Span) -> nodes.Expression:
        outlines = str(tree.children[0]).startswith("minimum")
        return nodes.Distance(self.optional(origin), self.expression(target), outlines, span=span)

    def relative_heading(self, tree: Branch, span: Span) -> nodes.Expression:
        of, origin = tree.children
        return nodes.RelativeHeading(self.expression(of), self.optional(origin), span=span)

    def seen_from(self, tree: Branch, span: Span) -> nodes.Expression:
        words, of, origin = tree.children
        return nodes.SeenFrom(_words(words), self.expression(of), self.optional(origin), span=span)

    def angle_from(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Angle(self.expression(tree.children[1]), None, span=span)

    def angle_to(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Angle(None, self.expression(tree.children[1]), span=span)

    def angle_from_to(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.Angle(*self.expressions(tree.children[1:]), span=span)

    def angle_to_from(self, tree: Branch, span: Span) -> nodes.Expression:
        target, origin = self.expressions(tree.children[1:])
        return nodes.Angle(origin, target, span=span)

    def follow(self, tree: Branch, span: Span) -> nodes.Expression:
        field, origin, distance = tree.children
        return nodes.Follow(self.expression(field), self.optional(origin), self.expression(distance), span=span)

    def side_of(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.SideOf(_words(tree.children[0]).removesuffix(" of"), self.expression(tree.children[1]), span=span)

    def visible_part(self, tree: Branch, span: Span) -> nodes.Expression:
        seen = not _words(tree.children[0]).startswith("not")
        return nodes.VisiblePart(self.expression(tree.children[1]), seen, span=span)

    def visible_from(self, tree: Branch, span: Span) -> nodes.Expression:
        region, words, viewer = tree.children
        seen = not _words(words).startswith("not")
        return nodes.VisiblePart(self.expression(region), seen, self.expression(viewer), span=span)

    def relative_to(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.RelativeTo(*self.expressions(tree.children), span=span)

    def field_at(self, tree: Branch, span: Span) -> nodes.Expression:
        return nodes.FieldAt(*self.expressions(tree.children), span=span)

    def slice(self, tree: Branch, span: Span) -> nodes.Expression:
        start, stop, step = (*tree.children, None)[:3]
        return nodes.Slice(self.optional(start), self.optional(stop), self.optional(step), span=span)

    # -- making objects ----------------------------------------------------------------------------------------------

    def new(self, tree: Branch, span: Span) -> nodes.Expression:
        word, listed = token(tree.children[0]), tree.children[1]
        specifiers = () if listed is None else branch(listed).children
        return nodes.New(
            str(word),
            tuple(self.specifier(branch(each)) for each in specifiers),
            span=span,
            class_span=span_of(word),
        )

    def specifier(self, tree: Branch) -> nodes.Specifier:
        return _SPECIFIERS[tree.data](self, tree.children, span_of(tree))

    def at(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.At(self.expression(parts[0]), span=span)

    def in_region(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.InRegion(str(parts[0]), self.expression(parts[1]), span=span)

    def offset_by_specifier(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.OffsetBySpecifier(self.expression(parts[0]), span=span)

    def offset_along_specifier(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.OffsetAlongSpecifier(*self.expressions(parts), span=span)

    def beside(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        side = str(parts[0]).split()[0]
        return nodes.Beside(side, self.expression(parts[1]), self.optional(parts[2]), span=span)

    def following(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        field, origin, distance = parts
        return nodes.Following(self.expression(field), self.optional(origin), self.expression(distance), span=span)

    def before(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        region, distance, trajectory = parts
        return nodes.Before(self.expression(region), self.expression(distance), self.optional(trajectory), span=span)

    def after(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        region, distance, trajectory = parts
        return nodes.After(self.expression(region), self.expression(distance), self.optional(trajectory), span=span)

    def beyond(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        place, offset, viewer = parts
        return nodes.Beyond(self.expression(place), self.expression(offset), self.optional(viewer), span=span)

    def meeting(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        other, place, time, way = parts
        met, where, when = (self.expression(each) for each in (other, place, time))
        return nodes.Meeting(met, where, when, self.optional(way), span=span)

    def in_sight(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.InSight(self.optional(parts[1]), not _words(parts[0]).startswith("not"), span=span)

    def contained_in(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.ContainedIn(self.expression(parts[0]), span=span)

    def apparently_facing(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.Facing(self.expression(parts[0]), "apparent", self.optional(parts[1]), span=span)

    def facing(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.Facing(self.expression(parts[0]), span=span)

    def facing_toward(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.Facing(self.expression(parts[0]), "toward", span=span)

    def facing_away(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        return nodes.Facing(self.expression(parts[0]), "away", span=span)

    def with_(self, parts: Sequence[Child], span: Span) -> nodes.Specifier:
        word = token(parts[0])
        return nodes.With(str(word), self.expression(parts[1]), span=span, property_span=span_of(word))

    # -- several values ----------------------------------------------------------------------------------------------

    def bare_tuple(self, tree: Branch, span: Span) -> nodes.Expression:
        items = self.expressions(tree.children)
        if len(items) == 1 and isinstance(items[0], nodes.New):
            return items[0]  # Scenic allows a comma after the last specifier.
        return nodes.TupleDisplay(items, span=span)


_B = ExpressionBuilder
_BUILDERS: dict[str, Callable[[ExpressionBuilder, Branch, Span], nodes.Expression]] = {
    method.__name__: method
    for method in (
        _B.formatted, _B.number, _B.with_unit, _B.string, _B.constant, _B.initial_scenario,
        _B.name, _B.attribute, _B.index, _B.call,
        _B.starred, _B.list, _B.tuple, _B.dict, _B.generator, _B.conditional, _B.lambda_, _B.or_, _B.and_, _B.unary,
        _B.binary,
        _B.compare, _B.can_see, _B.intersects, _B.offset_along, _B.offset_by, _B.degrees, _B.distance,
        _B.distance_from_to, _B.distance_to_from, _B.relative_heading, _B.seen_from, _B.angle_from, _B.angle_to,
        _B.angle_from_to, _B.angle_to_from, _B.follow, _B.side_of, _B.visible_part, _B.visible_from, _B.relative_to,
        _B.field_at, _B.slice, _B.new, _B.bare_tuple, _B.temporal, _B.until, _B.implies,
    )
}  # fmt: skip
"""Builder of each rule of the grammar; a method has the name of its rule."""

_SPECIFIERS: dict[str, Callable[[ExpressionBuilder, Sequence[Child], Span], nodes.Specifier]] = {
    method.__name__: method
    for method in (
        _B.at, _B.in_region, _B.offset_by_specifier, _B.offset_along_specifier, _B.beside, _B.following, _B.before,
        _B.after, _B.beyond, _B.meeting, _B.in_sight, _B.contained_in, _B.apparently_facing,
        _B.facing, _B.facing_toward, _B.facing_away, _B.with_,
    )
}  # fmt: skip
