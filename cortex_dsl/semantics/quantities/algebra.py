"""Expressions of the IR: interned, written as formulas, and folded where folding gives the very bits of the kernel.

Terms have the form of their calculation: `a + b * c`, `a < b`, `where(c, a, b)`, `minimum(a, b)`; a number as an
operand becomes a literal. `~`, `&` and `|` are the logic of truths. `==` stays identity, since passes key on it: see
`equal`.

Transcendental operations on constants stay operations: a concrete copy of a case must compute the values of the
original.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from cortex_dsl import ir
from cortex_dsl.semantics.errors.values import TOO_DEEP
from cortex_dsl.source import Span
from engine.opcodes import Op
from engine.operators import OPERATORS
from engine.vocabulary import State

NOWHERE = Span(0, 0)
DEPTH_LIMIT = 150
"""Longest chain of operations, each on the result of the one before."""

# -- terms -------------------------------------------------------------------------------------------------------------


class Term(ir.Expr):
    """An expression with the algebra that made it."""

    algebra: "Algebra"
    depth: int
    """Number of nested operations below it."""

    def __add__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.ADD, self, other)

    def __radd__(self, other: float) -> "Term":
        return self.algebra.apply(Op.ADD, other, self)

    def __sub__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.SUB, self, other)

    def __rsub__(self, other: float) -> "Term":
        return self.algebra.apply(Op.SUB, other, self)

    def __mul__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.MUL, self, other)

    def __rmul__(self, other: float) -> "Term":
        return self.algebra.apply(Op.MUL, other, self)

    def __truediv__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.DIV, self, other)

    def __floordiv__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.FLOORDIV, self, other)

    def __mod__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.MOD, self, other)

    def __pow__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.POW, self, other)

    def __neg__(self) -> "Term":
        return self.algebra.apply(Op.NEG, self)

    def __abs__(self) -> "Term":
        return self.algebra.apply(Op.ABS, self)

    def __lt__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.LT, self, other)

    def __le__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.LE, self, other)

    def __gt__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.LT, other, self)

    def __ge__(self, other: "Operand") -> "Term":
        return self.algebra.apply(Op.LE, other, self)

    def __and__(self, other: "Term") -> "Term":
        return self.algebra.apply(Op.AND, self, other)

    def __or__(self, other: "Term") -> "Term":
        return self.algebra.apply(Op.OR, self, other)

    def __invert__(self) -> "Term":
        return self.algebra.apply(Op.NOT, self)

    def __bool__(self) -> bool:
        raise TypeError("the run decides what a term is worth: use `&`, `|`, `~` and `where`")


Operand = Term | float
Made = TypeVar("Made", bound=Term)


class Constant(Term, ir.Literal):
    """A number that is known."""


class Numbered(Protocol):
    index: int


class _Number(Term, ir.Literal):
    """The number of an object, whatever it is in the end."""

    def __init__(self, span: Span, of: Numbered) -> None:
        self.__dict__.update(span=span, of=of)

    @property
    def value(self) -> float:  # pyright: ignore[reportIncompatibleVariableOverride]
        return float(self.__dict__["of"].index)


class Operation(Term, ir.Apply):
    arguments: tuple[Term, ...]


class _Gene(Term, ir.Gene): ...


class _Draw(Term, ir.Draw): ...


class _Local(Term, ir.Local): ...


class _Running(Term, ir.Running): ...


class _Pack(Term, ir.Pack): ...


class _Item(Term, ir.Item): ...


# -- the algebra of a variant ------------------------------------------------------------------------------------------


@dataclass
class Algebra:
    """Makes terms; equal terms are the same object. `span` is the place of the present term."""

    span: Span = NOWHERE
    known: dict[tuple[object, ...], Any] = field(default_factory=dict)
    closed: dict[ir.Expr, float | None] = field(default_factory=dict)
    """Values of terms without unknowns, None of others, as far as `bounds.closed_value` has computed them."""
    intervals: dict[ir.Expr, tuple[float, float]] = field(default_factory=dict)
    """Intervals of terms, as far as `Evaluator.interval` has computed them."""
    undefined: dict[ir.Expr, bool] = field(default_factory=dict)
    """Whether a term may have no value, as far as `Evaluator.may_be_undefined` has tested it."""

    @property
    def _tables(self) -> tuple[dict[Any, Any], ...]:
        return self.known, self.closed, self.intervals, self.undefined

    def sizes(self) -> tuple[int, ...]:
        """Return the numbers of terms that are known, for `forget_since`."""
        return tuple(map(len, self._tables))

    def forget_since(self, sizes: Sequence[int]) -> None:
        """Forget all terms that became known after `sizes` were read."""
        for terms, size in zip(self._tables, sizes, strict=True):
            while len(terms) > size:
                terms.popitem()

    def close(self) -> None:
        """Forget all terms, which refer to their algebra."""
        for terms in self._tables:
            terms.clear()

    def literal(self, value: float) -> Constant:
        return self._interned(("literal", value.hex()), Constant, value)

    def truth(self, value: bool) -> Constant:
        return self.literal(1.0 if value else 0.0)

    def gene(self, index: int) -> Term:
        return self._interned(("gene", index), _Gene, index)

    def draw(self, index: int) -> Term:
        return self._interned(("draw", index), _Draw, index)

    def local(self, index: int) -> Term:
        return self._interned(("local", index), _Local, index)

    def running(self, monitor: int) -> Term:
        return self._interned(("running", monitor), _Running, monitor)

    def number_of(self, of: Numbered) -> Term:
        """The number of an object, which may be unknown until all are made."""
        return self._interned(("number", of), _Number, of)

    def random(self) -> Term:
        """Return a new number of the behaviour stream, which no other term shares."""
        return self._own(Operation(self.span, Op.RANDOM, ()))

    def time(self) -> Term:
        """Return the time of the run [s]."""
        return self.apply(Op.TIME)

    def state(self, actor: int, column: State) -> Term:
        """Return a state value of an object at the present sample."""
        return self.apply(Op.STATE, immediates=(actor, int(column)))

    def time_to_contact(self, actor: int, other: int = -1, reach: "Term | None" = None) -> Term:
        """Return the time until two outlines touch at their velocities [s], or the least over all (-1).

        With a reach, only noticed actors within it count.
        """
        noticed = () if reach is None else (reach,)
        return self.apply(Op.TTC, *noticed, immediates=(actor, other) + (1,) * len(noticed))

    def crossing(self, me: int, other: int, look: "Term", width: int) -> tuple["Term", ...]:
        """Return the items of `engine.kernels.crossing.Crossing` for two actors, under the foresight `look`."""
        return self.items(self.apply(Op.CROSSING, look, immediates=(me, other), width=width), width)

    def decided_outside(self, number: int) -> Term:
        return self.apply(Op.ACTION, immediates=(number,))

    def velocity(self, actor: int) -> tuple[Term, ...]:
        """Return the velocity (x, y) of an object's rear axle [m/s], sliding included, and its yaw rate [rad/s]."""
        return self.items(self.apply(Op.VELOCITY, immediates=(actor,), width=3), 3)

    def sees(self, viewer: int, other: int, view: Term, outline: Term) -> Term:
        """Return whether one actor sees another now; the index is -1 for a packed view or outline."""
        return self.apply(Op.SEES, view, outline, immediates=(viewer, other))

    def notices(self, viewer: int, other: int, reach: Term) -> Term:
        """Return whether one actor is within a reach [m] of another and not hidden from it."""
        return self.apply(Op.NOTICES, reach, immediates=(viewer, other))

    def touches(self, actor: int = -1) -> Term:
        """Return whether the ego has touched an actor, or any actor (-1)."""
        return self.apply(Op.TOUCHES, immediates=(actor,))

    def pack(self, *items: Term) -> Term:
        return self._interned(("pack", *items), _Pack, items)

    def items(self, bundle: Term, count: int) -> tuple[Term, ...]:
        return tuple(self._interned(("item", bundle, i), _Item, bundle, i) for i in range(count))

    def look(self, view: Term, outline: Term, actors: int) -> Term:
        """Return whether an outline is in a packed view at the start, where the first `actors` actors may hide it."""
        return self.apply(Op.CAN_SEE, view, outline, immediates=(actors,))

    def apply(self, op: Op, *operands: Operand, immediates: tuple[int, ...] = (), width: int = 1) -> Term:
        arguments = tuple(each if isinstance(each, Term) else self.literal(each) for each in operands)
        if op in OPERATORS and OPERATORS[op].is_exact and all(isinstance(a, Constant) for a in arguments):
            return self.literal(OPERATORS[op].value(*(a.value for a in arguments if isinstance(a, Constant))))
        if (simpler := _simplified(op, arguments)) is not None:
            return simpler
        # Later passes walk expressions recursively, so their depth must have a limit.
        depth = 1 + max((argument.depth for argument in arguments), default=0)
        if depth > DEPTH_LIMIT:
            raise TOO_DEEP.mistake(self.span, limit=DEPTH_LIMIT)
        key = (op, immediates, width, *arguments)
        return self._interned(key, Operation, op, arguments, immediates, width, depth=depth)

    # -- several terms -----------------------------------------------------------------------------------------------

    def gathered(self, op: Op, items: Sequence[Term], empty: float) -> Term:
        """All items joined by an associative operation, as a tree: long chains of operations are refused."""
        if len(items) < 2:
            return items[0] if items else self.literal(empty)
        half = len(items) // 2
        return self.apply(op, self.gathered(op, items[:half], empty), self.gathered(op, items[half:], empty))

    def any_of(self, items: Sequence[Term]) -> Term:
        return self.gathered(Op.OR, items, 0.0)

    def all_of(self, items: Sequence[Term]) -> Term:
        return self.gathered(Op.AND, items, 1.0)

    def least(self, items: Sequence[Term]) -> Term:
        return self.gathered(Op.MIN, items, math.inf)

    def chosen(self, index: Term, items: Sequence[Term], first: int = 0) -> Term:
        """The item of a number that only the run knows, found by halving."""
        if len(items) == 1:
            return items[0]
        half = len(items) // 2
        lower, upper = self.chosen(index, items[:half], first), self.chosen(index, items[half:], first + half)
        return where(index < float(first + half), lower, upper)

    def _interned(self, key: tuple[object, ...], kind: Callable[..., Made], *fields: object, depth: int = 0) -> Made:
        if (known := self.known.get(key)) is None:
            known = self.known[key] = self._own(kind(self.span, *fields), depth)
        return known

    def _own(self, term: Made, depth: int = 0) -> Made:
        term.__dict__.update(algebra=self, depth=depth)
        return term


def _simplified(op: Op, arguments: tuple[Term, ...]) -> Term | None:
    """Logic and selection with a known operand; truths are 1.0, 0.0 or NaN, so no bit changes."""
    if op == Op.SELECT and isinstance(arguments[0], Constant) and not math.isnan(arguments[0].value):
        return arguments[1] if arguments[0].value else arguments[2]
    for one, other in (arguments, arguments[::-1]) if op in (Op.AND, Op.OR) else ():
        if isinstance(one, Constant) and not math.isnan(one.value):
            return one if bool(one.value) == (op == Op.OR) else other
    return None


# -- functions of terms ------------------------------------------------------------------------------------------------


def function_of(op: Op) -> Callable[..., Term]:
    """Return the function of terms that an instruction computes; a number among its operands becomes a literal."""

    def function(*operands: Operand) -> Term:
        algebra = next(each.algebra for each in operands if isinstance(each, Term))
        return algebra.apply(op, *operands)

    return function


def _pose(op: Op) -> Callable[..., tuple[Term, Term, Term]]:
    """A function to x, y [m] and heading [rad]."""

    def function(first: Term, *others: Operand) -> tuple[Term, Term, Term]:
        x, y, heading = first.algebra.items(first.algebra.apply(op, first, *others, width=3), 3)
        return x, y, heading

    return function


def where(condition: Term, then: Operand, otherwise: Operand) -> Term:
    """`then` where the condition is true."""
    return condition.algebra.apply(Op.SELECT, condition, then, otherwise)


minimum, maximum, hypot, atan2, wrapped = map(function_of, (Op.MIN, Op.MAX, Op.HYPOT, Op.ATAN2, Op.WRAP))
"""`wrapped`: an angle brought into [-pi, pi)."""
sin, cos, tan, asin, acos, atan = map(function_of, (Op.SIN, Op.COS, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN))
exp, log, sqrt, floor, ceil, rounded = map(function_of, (Op.EXP, Op.LOG, Op.SQRT, Op.FLOOR, Op.CEIL, Op.ROUND))
equal, unequal, normal_cdf, normal_quantile = map(function_of, (Op.EQ, Op.NE, Op.NORMAL_CDF, Op.NORMAL_QUANTILE))

path_pose = _pose(Op.PATH_POSE)
"""`path_pose(path, s)` at arc length s."""
path_length, path_distance, path_project = map(function_of, (Op.PATH_LENGTH, Op.PATH_DISTANCE, Op.PATH_PROJECT))
"""`path_project(path, x, y)`: arc length of the foot of a point [m]."""
road_heading, lane_nearest = map(function_of, (Op.ROAD_HEADING, Op.LANE_NEAREST))
road_follow = _pose(Op.ROAD_FOLLOW)
"""`road_follow(x, y, by)`: where one gets by following the lane's direction."""
region_distance, region_contains = map(function_of, (Op.REGION_DISTANCE, Op.REGION_CONTAINS))
"""`(region, x, y)`."""
region_box_distance, region_contains_box = map(function_of, (Op.REGION_BOX_DISTANCE, Op.REGION_CONTAINS_BOX))
"""`(region, outline)`, an outline being packed x, y, heading, length, width."""
region_depth, region_box_depth, box_distance = map(function_of, (Op.REGION_DEPTH, Op.REGION_BOX_DEPTH, Op.BOX_DISTANCE))
"""`box_distance`: between two outlines [m]."""


def region_sample(region: Term, u: Term, v: Term) -> tuple[Term, Term]:
    """A point of a region, uniform by area, from two uniform numbers."""
    x, y = region.algebra.items(region.algebra.apply(Op.REGION_SAMPLE, region, u, v, width=2), 2)
    return x, y


def lead_on(path: Term, actor: int, reach: Term) -> tuple[Term, Term]:
    """Return gap [m] and speed along a path [m/s] of the actor ahead, among those noticed within `reach`."""
    gap, speed = path.algebra.items(path.algebra.apply(Op.LEAD, path, reach, immediates=(actor,), width=2), 2)
    return gap, speed


def sees_within(limit: Term, actor: int) -> Term:
    """Return whether an object sees another object whose centre is nearer than `limit` [m]."""
    return limit.algebra.apply(Op.WITHIN, limit, immediates=(actor,))


def table(index: Term, offset: int) -> Term:
    """The entry of the pool so far behind an offset."""
    return index.algebra.apply(Op.TABLE, index, immediates=(offset,))
