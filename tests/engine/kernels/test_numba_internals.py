"""Inlined functions: parts of kernels that exist nowhere else, and yet can be called from Python."""

from typing import Any, cast

import numpy as np
import pytest

from engine.kernels.jit import inlined, kernel
from engine.kernels.numba_internals import Inlined
from engine.tables import Floats


@inlined
def divided(x: float, y: float) -> float:
    return x / y


@inlined
def added(values: Floats, by: float) -> float:
    total = 0.0
    for value in values:
        total += divided(value, by)
    return total


@kernel
def halved(values: Floats) -> float:
    return added(values, 2.0) + divided(1.0, 0.0 * values[0] + 4.0)


def test_inlined_functions_work_in_one_another_in_kernels_and_from_python() -> None:
    """Under the kernels' rules: x / 0 is infinite."""
    values = np.array([1.0, 2.0, 6.0])
    assert halved(values) == 4.75
    assert added(values, 2.0) == 4.5
    if isinstance(divided, Inlined):
        assert divided(1.0, 0.0) == np.inf


def test_a_draft_has_no_machine_code_of_its_own() -> None:
    """Else it is made, and thrown away, for each of some hundred functions: half a minute instead of a quarter."""
    halved(np.ones(2))
    function = cast("Any", divided)
    if not isinstance(function, Inlined):
        pytest.skip("runs without the compiler")
    if not function.draft.overloads:  # the kernel came from the cache
        function.draft.compile("(float64, float64)")
    (result,) = function.draft.overloads.values()
    engine_of = result.target_context.codegen()._engine
    assert not engine_of.is_symbol_defined(result.fndesc.llvm_func_name)
