"""One row for each scalar instruction: its spelling, meaning, intervals, domain and texts. All passes read these rows.

Compiler, proofs, kernels, listing and exports loop over `OPERATORS` or look up a row. A new operator is a value of
`engine.opcodes.Op`, a function in `engine.kernels.scalars` and a row (`tests/test_new_operator.py` adds one). Loads no
numba.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum, auto

import numpy as np

from engine.frozen import frozen
from engine.kernels import scalars
from engine.opcodes import INSTRUCTIONS, Instruction, Op
from engine.operators import bounds, intervals, narrowing
from engine.operators.bounds import DIVISIONS, POWERS, Bounds, Domain, within
from engine.operators.intervals import Forward, Interval
from engine.operators.narrowing import Backward, Ends


class Rule(Enum):
    """Dimensions of operands and result; `cortex_dsl.semantics.evaluation` has the function of each."""

    ANGLE_TO_PURE = auto()
    PURE_TO_ANGLE = auto()
    PURE = auto()
    ANY = auto()
    """One operand of any dimension, which is that of the result."""
    ROOT = auto()
    ALIKE = auto()
    """Two operands of one dimension, which is that of the result."""
    ALIKE_TO_ANGLE = auto()
    ALIKE_TO_PURE = auto()
    EXTREMUM = auto()
    """Several operands of one dimension, or a list of them."""
    PRODUCT = auto()
    QUOTIENT = auto()
    POWER = auto()


@frozen
class Function:
    """A function of the language."""

    name: str
    doc: str
    rule: Rule
    parameters: tuple[str, ...] = ("x",)
    """Names of the parameters; empty if it takes any number of arguments."""


@frozen
class Infix:
    """A sign between two operands."""

    sign: str
    rule: Rule | None = None
    """None for comparisons and logic, whose result is a truth."""
    joined: str = ""
    """Participle for operands of different dimensions, as in "a length and a time cannot be added"."""


@frozen
class Operator:
    """Meaning of one instruction `dst <- f(a, b, c)`."""

    scalar: Callable[..., float]
    """Function of numbers that kernels compile; in Python it may raise, see `value`."""
    forward: Forward
    """Interval of the result, over many boxes."""
    backward: Backward | None = None
    """Narrower ends for the operands; None if nothing follows from the result."""
    bounds: Bounds | None = None
    """Interval of the result as a pair of floats; None if the compiler takes it from `forward`."""
    spelling: Function | Infix | None = None
    """None for an instruction that only the compiler writes."""
    domain: Domain | None = None
    """None if the result is a number for all operands."""
    reason: str = ""
    """Reason of a result that is not finite, with places for the operands."""
    formula: str = ""
    """Name of the function in expressions of OpenSCENARIO that means the same."""
    is_exact: bool = False
    """Whether the compiler folds it: Python and kernel give the same bits on every machine."""
    is_truth: bool = False
    """Whether the result is 1, 0 or NaN."""
    takes_conditions: bool = False
    """Whether the operands are conditions: any number but zero is true."""
    is_tabulated: bool = False
    """Whether proofs tabulate it over the range of one gene, which is tighter than `backward`."""

    @property
    def arity(self) -> int:
        """Number of operands."""
        return self.scalar.__code__.co_argcount

    def value(self, *operands: float) -> float:
        """Return the result of the kernel: infinities and NaN where Python raises."""
        try:
            return float(self.scalar(*operands))
        except (ArithmeticError, TypeError, ValueError):
            return self._value_of_floats(map(np.float64, operands))

    def _value_of_floats(self, operands: Iterable[np.float64]) -> float:
        """Return the value by the arithmetic of IEEE 754, which numpy has and Python has not."""
        try:
            with np.errstate(all="ignore"):
                return float(self.scalar(*operands))
        except OverflowError:
            return np.inf
        except ValueError:
            return np.nan

    def narrowed(self, result: Interval, operands: Sequence[Interval], truths: Sequence[bool]) -> Sequence[Ends | None]:
        """Return narrower ends for each operand; `truths` says which operands are 1, 0 or NaN."""
        if self.backward is None:
            return [None] * len(operands)
        ends = self.backward(result, *operands)
        if not self.takes_conditions:
            return ends
        return [
            each if each is None or is_truth else (np.where(each[0] > 0.0, -np.inf, each[0]), each[1])
            for each, is_truth in zip(ends, truths, strict=True)
        ]


def _wave(name: str, doc: str, scalar: Callable[[float], float], of_array: np.ufunc) -> Operator:
    function = Function(name, doc, Rule.ANGLE_TO_PURE, ("angle",))
    return Operator(scalar, intervals.wave(of_array), bounds=bounds.wave, spelling=function)


OPERATORS: Mapping[Op, Operator] = {
    Op.MOVE: Operator(scalars.move, intervals.unchanged, narrowing.shifted(0.0, 0.0)),
    Op.ADD: Operator(
        scalars.add, intervals.add, narrowing.add, bounds.add, Infix("+", Rule.ALIKE, "added"), is_exact=True
    ),
    Op.SUB: Operator(
        scalars.subtract, intervals.sub, narrowing.subtract, bounds.subtract, Infix("-", Rule.ALIKE, "subtracted"),
        is_exact=True,
    ),
    Op.MUL: Operator(
        scalars.multiply, intervals.mul, narrowing.multiply, bounds.multiply, Infix("*", Rule.PRODUCT), is_exact=True
    ),
    Op.DIV: Operator(
        scalars.divide, intervals.div, narrowing.divide, bounds.divide, Infix("/", Rule.QUOTIENT),
        DIVISIONS, "it divides by {1:.6g}", is_exact=True,
    ),
    Op.MOD: Operator(
        scalars.modulo, intervals.mod, spelling=Infix("%", Rule.ALIKE, "divided with remainder"),
        domain=DIVISIONS, reason="it divides by {1:.6g}",
    ),
    Op.FLOORDIV: Operator(
        scalars.floor_divide, intervals.floordiv, spelling=Infix("//", Rule.ALIKE_TO_PURE, "divided into whole parts"),
        domain=DIVISIONS, reason="it divides by {1:.6g}",
    ),
    Op.POW: Operator(
        scalars.power, intervals.power, spelling=Infix("**", Rule.POWER),
        domain=POWERS, reason="it is {0:.6g} to the power of {1:.6g}",
    ),
    Op.NEG: Operator(scalars.negate, intervals.neg, narrowing.negate, bounds.negate, is_exact=True),
    Op.ABS: Operator(
        scalars.magnitude, intervals.magnitude, narrowing.magnitude, bounds.magnitude,
        Function("abs", "Absolute value.", Rule.ANY), is_exact=True,
    ),
    Op.MIN: Operator(
        scalars.minimum, intervals.least, narrowing.minimum, bounds.minimum,
        Function("min", "Least of several numbers, or of a list.", Rule.EXTREMUM, ()), is_exact=True,
    ),
    Op.MAX: Operator(
        scalars.maximum, intervals.greatest, narrowing.maximum, bounds.maximum,
        Function("max", "Greatest of several numbers, or of a list.", Rule.EXTREMUM, ()), is_exact=True,
    ),
    Op.SQRT: Operator(
        scalars.sqrt, intervals.root, narrowing.sqrt, bounds.sqrt, Function("sqrt", "Square root.", Rule.ROOT),
        within(0.0, np.inf), "it is the square root of {0:.6g}", formula="sqrt",
    ),
    Op.HYPOT: Operator(
        scalars.hypot, intervals.length, narrowing.hypot, bounds.hypot,
        Function("hypot", "Square root of the sum of two squares.", Rule.ALIKE, ("x", "y")), is_tabulated=True,
    ),
    Op.SIN: _wave("sin", "Sine of an angle.", scalars.sin, np.sin),
    Op.COS: _wave("cos", "Cosine of an angle.", scalars.cos, np.cos),
    Op.TAN: Operator(
        scalars.tan, intervals.tangent, spelling=Function("tan", "Tangent of an angle.", Rule.ANGLE_TO_PURE, ("angle",))
    ),
    Op.ASIN: Operator(
        scalars.asin, intervals.arcsine, spelling=Function("asin", "Angle of a sine.", Rule.PURE_TO_ANGLE),
        domain=within(-1.0, 1.0), reason="it is the arc sine of {0:.6g}",
    ),
    Op.ACOS: Operator(
        scalars.acos, intervals.arccosine, spelling=Function("acos", "Angle of a cosine.", Rule.PURE_TO_ANGLE),
        domain=within(-1.0, 1.0), reason="it is the arc cosine of {0:.6g}",
    ),
    Op.ATAN: Operator(
        scalars.atan, intervals.arctangent, spelling=Function("atan", "Angle of a tangent.", Rule.PURE_TO_ANGLE)
    ),
    Op.ATAN2: Operator(
        scalars.atan2, intervals.direction,
        spelling=Function(
            "atan2", "Angle of the direction (x, y), as `atan2(y, x)`.", Rule.ALIKE_TO_ANGLE, ("y", "x")
        ),
    ),
    Op.EXP: Operator(
        scalars.exp, intervals.exponential, narrowing.exp,
        spelling=Function("exp", "Exponential of a pure number.", Rule.PURE),
        reason="it is e to the power of {0:.6g}", is_tabulated=True,
    ),
    Op.LOG: Operator(
        scalars.log, intervals.logarithm, narrowing.log,
        spelling=Function("log", "Natural logarithm of a pure number.", Rule.PURE),
        domain=within(np.nextafter(0.0, 1.0), np.inf), reason="it is the logarithm of {0:.6g}", is_tabulated=True,
    ),
    Op.FLOOR: Operator(
        scalars.floor, intervals.exactly_rising(np.floor), narrowing.shifted(0.0, 1.0), bounds.floor,
        Function("floor", "Greatest whole number not above x.", Rule.PURE), formula="floor", is_exact=True,
        is_tabulated=True,
    ),
    Op.CEIL: Operator(
        scalars.ceil, intervals.exactly_rising(np.ceil), narrowing.shifted(1.0, 0.0),
        spelling=Function("ceil", "Least whole number not below x.", Rule.PURE), formula="ceil", is_exact=True,
        is_tabulated=True,
    ),
    Op.ROUND: Operator(
        scalars.rounded, intervals.exactly_rising(np.rint), narrowing.shifted(0.5, 0.5),
        spelling=Function("round", "Nearest whole number, halves to even.", Rule.PURE), is_tabulated=True,
    ),
    Op.WRAP: Operator(scalars.wrap_angle, intervals.wrapped),
    Op.LT: Operator(
        scalars.less, intervals.below, narrowing.order, bounds.less, Infix("<"), is_exact=True, is_truth=True
    ),
    Op.LE: Operator(
        scalars.at_most, intervals.at_most, narrowing.order, bounds.at_most, Infix("<="), is_exact=True, is_truth=True
    ),
    Op.EQ: Operator(
        scalars.equal, intervals.equal, narrowing.equal, bounds.equal, Infix("=="), is_exact=True, is_truth=True
    ),
    Op.NE: Operator(
        scalars.unequal, intervals.unequal, narrowing.unequal, bounds.unequal, Infix("!="), is_exact=True, is_truth=True
    ),
    Op.AND: Operator(
        scalars.both, intervals.both, narrowing.both, bounds.both, Infix("and"),
        is_exact=True, is_truth=True, takes_conditions=True,
    ),
    Op.OR: Operator(
        scalars.either, intervals.one_of, narrowing.either, bounds.either, Infix("or"),
        is_exact=True, is_truth=True, takes_conditions=True,
    ),
    Op.NOT: Operator(
        scalars.negation, intervals.negation, narrowing.negation, bounds.negation,
        is_exact=True, is_truth=True, takes_conditions=True,
    ),
    Op.SELECT: Operator(scalars.select, intervals.select, narrowing.select, bounds.select, is_exact=True),
    Op.NORMAL_QUANTILE: Operator(scalars.normal_quantile, intervals.normal_quantile),
    Op.NORMAL_CDF: Operator(scalars.normal_cdf, intervals.normal_cdf),
}  # fmt: skip
"""Every scalar instruction but `Op.TABLE`, which reads the program's pool."""


def signature(op: Op) -> Instruction:
    """Return the operands and results of any instruction."""
    return INSTRUCTIONS[op] if op in INSTRUCTIONS else Instruction((1,) * OPERATORS[op].arity)
