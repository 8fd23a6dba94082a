"""Expressions of the IR: interned, and folded where folding gives the very bits that the kernel would.

Transcendental operations on constants stay operations: a concrete copy of a case must compute what the original did.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from cortex_dsl import ir
from cortex_dsl.semantics.errors.values import TOO_DEEP
from cortex_dsl.source import Span
from engine.vocabulary import Op

NOWHERE = Span(0, 0)
DEPTH_LIMIT = 150
"""Longest chain of operations, each on the result of the one before."""
_DYNAMIC = frozenset({Op.STATE, Op.TIME, Op.RANDOM, Op.WITHIN, Op.LEAD, Op.TTC, Op.IS_RUNNING})


def safe_quotient(a: float, b: float) -> float:
    if b == 0.0:
        return math.nan if a == 0.0 or math.isnan(a) else math.copysign(math.inf, a) * math.copysign(1.0, b)
    return a / b


def _power(a: float, b: float) -> float:
    """As the kernels have it: infinite where it overflows, NaN where it is no real number."""
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.inf
    except ValueError:
        return math.inf if a == 0.0 else math.nan


EXACT: Mapping[Op, Callable[..., float]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: safe_quotient,
    Op.NEG: lambda a: -a,
    Op.ABS: lambda a: abs(a),  # noqa: PLW0108 - the builtin's own type is too wide
    Op.MIN: lambda a, b: b if b < a else a,
    Op.MAX: lambda a, b: b if b > a else a,
    Op.FLOOR: lambda a: float(math.floor(a)),
    Op.CEIL: lambda a: float(math.ceil(a)),
    Op.LT: lambda a, b: float(a < b),
    Op.LE: lambda a, b: float(a <= b),
    Op.EQ: lambda a, b: float(a == b),
    Op.NE: lambda a, b: float(a != b),
    Op.AND: lambda a, b: float(bool(a) and bool(b)),
    Op.OR: lambda a, b: float(bool(a) or bool(b)),
    Op.NOT: lambda a: float(not a),
    Op.SELECT: lambda a, b, c: b if a else c,
}
"""Operations whose results are exactly defined, so that folding them changes no bit."""

CLOSED: Mapping[Op, Callable[..., float]] = {
    **EXACT,
    Op.MOD: lambda a, b: a % b,
    Op.FLOORDIV: lambda a, b: a // b,
    Op.POW: _power,
    Op.SQRT: math.sqrt,
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.TAN: math.tan,
    Op.ASIN: math.asin,
    Op.ACOS: math.acos,
    Op.ATAN: math.atan,
    Op.ATAN2: math.atan2,
    Op.EXP: math.exp,
    Op.LOG: math.log,
    Op.ROUND: lambda a: float(round(a)),
    Op.HYPOT: math.hypot,
    Op.WRAP: lambda a: a - math.tau * math.floor((a + math.pi) / math.tau),
}
"""What a constant expression is worth, for checks and indices; never written into the program."""


@dataclass
class Algebra:
    """Makes expressions; equal ones are the same object. `span` is the place of what is being made."""

    span: Span = NOWHERE
    _known: dict[tuple[object, ...], ir.Expr] = field(default_factory=dict)
    _depths: dict[int, int] = field(default_factory=dict)

    def literal(self, value: float) -> ir.Literal:
        key = ("literal", value.hex())
        return self._interned(key, lambda: ir.Literal(self.span, value))  # type: ignore[return-value]

    def truth(self, value: bool) -> ir.Literal:
        return self.literal(1.0 if value else 0.0)

    def gene(self, index: int) -> ir.Expr:
        return self._interned(("gene", index), lambda: ir.Gene(self.span, index))

    def draw(self, index: int) -> ir.Expr:
        return self._interned(("draw", index), lambda: ir.Draw(self.span, index))

    def local(self, index: int) -> ir.Expr:
        return self._interned(("local", index), lambda: ir.Local(self.span, index))

    def running(self, monitor: int) -> ir.Expr:
        return self._interned(("running", monitor), lambda: ir.Running(self.span, monitor))

    def random(self) -> ir.Expr:
        """A fresh number of the behaviour stream: never shared with another."""
        return ir.Apply(self.span, Op.RANDOM, ())

    def pack(self, *items: ir.Expr) -> ir.Expr:
        return self._interned(("pack", *map(id, items)), lambda: ir.Pack(self.span, items))

    def item(self, bundle: ir.Expr, index: int) -> ir.Expr:
        return self._interned(("item", id(bundle), index), lambda: ir.Item(self.span, bundle, index))

    def items(self, bundle: ir.Expr, count: int) -> tuple[ir.Expr, ...]:
        return tuple(self.item(bundle, i) for i in range(count))

    def apply(self, op: Op, *arguments: ir.Expr, immediates: tuple[int, ...] = (), width: int = 1) -> ir.Expr:
        if op in EXACT and all(isinstance(a, ir.Literal) for a in arguments):
            return self.literal(EXACT[op](*(a.value for a in arguments if isinstance(a, ir.Literal))))
        if (simpler := _simplified(op, arguments)) is not None:
            return simpler
        key = (op, immediates, width, *map(id, arguments))
        result = self._interned(key, lambda: ir.Apply(self.span, op, arguments, immediates, width))
        self._note_depth(result, arguments)
        return result

    def _note_depth(self, expression: ir.Expr, arguments: tuple[ir.Expr, ...]) -> None:
        """Later passes walk expressions recursively, so their depth must have a limit."""
        depth = 1 + max((self._depths.get(id(argument), 0) for argument in arguments), default=0)
        self._depths[id(expression)] = depth
        if depth > DEPTH_LIMIT:
            raise TOO_DEEP.mistake(self.span, limit=DEPTH_LIMIT)

    def add(self, a: ir.Expr, b: ir.Expr) -> ir.Expr:
        return self.apply(Op.ADD, a, b)

    def sub(self, a: ir.Expr, b: ir.Expr) -> ir.Expr:
        return self.apply(Op.SUB, a, b)

    def mul(self, a: ir.Expr, b: ir.Expr) -> ir.Expr:
        return self.apply(Op.MUL, a, b)

    def gathered(self, op: Op, items: Sequence[ir.Expr], empty: float) -> ir.Expr:
        """All items joined by an associative operation, as a tree: long chains of operations are refused."""
        if len(items) < 2:
            return items[0] if items else self.literal(empty)
        half = len(items) // 2
        return self.apply(op, self.gathered(op, items[:half], empty), self.gathered(op, items[half:], empty))

    def any_of(self, items: Sequence[ir.Expr]) -> ir.Expr:
        return self.gathered(Op.OR, items, 0.0)

    def all_of(self, items: Sequence[ir.Expr]) -> ir.Expr:
        return self.gathered(Op.AND, items, 1.0)

    def chosen(self, index: ir.Expr, items: Sequence[ir.Expr], first: int = 0) -> ir.Expr:
        """The item of a number that only the run knows, found by halving."""
        if len(items) == 1:
            return items[0]
        half = len(items) // 2
        below = self.apply(Op.LT, index, self.literal(float(first + half)))
        lower, upper = self.chosen(index, items[:half], first), self.chosen(index, items[half:], first + half)
        return self.apply(Op.SELECT, below, lower, upper)

    def _interned(self, key: tuple[object, ...], make: Callable[[], ir.Expr]) -> ir.Expr:
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]


def _simplified(op: Op, arguments: tuple[ir.Expr, ...]) -> ir.Expr | None:
    """Logic and selection with a known operand; truths are 1.0 or 0.0, so no bit changes."""
    if op == Op.SELECT and isinstance(arguments[0], ir.Literal):
        return arguments[1] if arguments[0].value else arguments[2]
    if op in (Op.AND, Op.OR):
        for one, other in (arguments, arguments[::-1]):
            if isinstance(one, ir.Literal):
                decides = bool(one.value) == (op == Op.OR)
                return one if decides else other
    return None


def operands(expression: ir.Expr) -> tuple[ir.Expr, ...]:
    """What an expression is made of."""
    match expression:
        case ir.Apply(arguments=arguments):
            return arguments
        case ir.Pack(items=items):
            return items
        case ir.Item(bundle=bundle):
            return (bundle,)
    return ()


def parts(expression: ir.Expr) -> list[ir.Expr]:
    """All distinct expressions that this one is made of, operands before what uses them, itself last."""
    ordered: dict[int, ir.Expr] = {}
    stack = [(expression, False)]
    while stack:
        part, complete = stack.pop()
        if id(part) in ordered:
            continue
        if complete:
            ordered[id(part)] = part
        else:
            stack.append((part, True))
            stack.extend((operand, False) for operand in operands(part))
    return list(ordered.values())


def leaves(expression: ir.Expr) -> list[ir.Expr]:
    """All distinct parts without operands of their own."""
    return [part for part in parts(expression) if not operands(part)]


def is_dynamic(expression: ir.Expr) -> bool:
    """Whether the value may change during a run."""
    return any(map(changes, parts(expression)))


def changes(part: ir.Expr) -> bool:
    """Whether an operation of its own reads the running simulation, whatever its operands do."""
    return isinstance(part, ir.Local | ir.Running) or (isinstance(part, ir.Apply) and part.op in _DYNAMIC)


Result = TypeVar("Result")


def folded(expression: ir.Expr, worth: Callable[[ir.Expr, list[Result]], Result]) -> Result:
    """What an expression is worth, from what its operands are worth; shared parts are asked once."""
    known: dict[int, Result] = {}
    for part in parts(expression):
        known[id(part)] = worth(part, [known[id(operand)] for operand in operands(part)])
    return known[id(expression)]


Numbers = Mapping[int, float]
NOTHING: Numbers = {}


def closed_value(
    expression: ir.Expr,
    operations: Mapping[Op, Callable[..., float]] = CLOSED,
    genes: Numbers = NOTHING,
    draws: Numbers = NOTHING,
) -> float | None:
    """Value of an expression without anything unknown in it; None for any other, NaN where it has none.

    `genes` (SI) and `draws` are known ones, by index.
    """

    def worth(part: ir.Expr, values: list[float | None]) -> float | None:
        known = [value for value in values if value is not None]
        match part:
            case ir.Literal(value=value):
                return value
            case ir.Gene(index=index):
                return genes.get(index)
            case ir.Draw(index=index):
                return draws.get(index)
            case ir.Apply(op=op) if op in operations and len(known) == len(values):
                try:
                    return operations[op](*known)
                except (ValueError, ArithmeticError, TypeError):
                    return math.nan
        return None

    return expression.value if isinstance(expression, ir.Literal) else folded(expression, worth)
