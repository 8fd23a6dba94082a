"""A function that chooses one of many inlined functions by instruction, as one switch in machine code.

A chain of comparisons becomes the same machine code, but numba types and lowers each of its lines: a chain of closures
takes a second longer to compile.
"""

# Private parts of numba have no types.
# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

import math
from collections.abc import Callable, Mapping
from typing import Any, cast

import numba
from llvmlite.ir import Constant  # pyright: ignore[reportMissingTypeStubs]
from numba import types
from numba.extending import intrinsic

from engine.opcodes import Op

Scalar = Callable[..., float]


def switch(functions: Mapping[Op, Scalar], arities: Mapping[Op, int]) -> Scalar:
    """Return the function (op, x, y, z) that calls the function of an instruction; NaN for any other number.

    `arities` are the numbers of arguments of the functions: 1 to 3 floats.
    """
    if cast("Any", numba).config.DISABLE_JIT:

        def called(op: int, *operands: float) -> float:
            return functions[Op(op)](*operands[: arities[Op(op)]])

        return called

    def choose(typing: Any, op: Any, _x: Any, _y: Any, _z: Any) -> Any:
        kinds = {each: typing.resolve_value_type(function) for each, function in functions.items()}
        calls = {each: kind.get_call_type(typing, (types.float64,) * arities[each], {}) for each, kind in kinds.items()}

        def lower(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            start, end = builder.block, builder.append_basic_block("end")
            cases, values = builder.switch(arguments[0], end), [(Constant(arguments[1].type, math.nan), start)]
            for each, call in calls.items():
                block = builder.append_basic_block(f"case.{each}")
                cases.add_case(Constant(arguments[0].type, each), block)
                builder.position_at_end(block)
                value = context.get_function(kinds[each], call)(builder, arguments[1 : 1 + arities[each]])
                values.append((value, builder.block))
                builder.branch(end)
            builder.position_at_end(end)
            result = builder.phi(arguments[1].type)
            for value, block in values:
                result.add_incoming(value, block)
            return result

        return types.float64(op, types.float64, types.float64, types.float64), lower

    return cast("Scalar", intrinsic(choose))
