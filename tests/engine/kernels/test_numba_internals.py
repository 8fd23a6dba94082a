"""Functions that are parts of kernels, and yet can be called from Python; code that kernels share."""

import ast
import importlib
import inspect
import itertools
import pkgutil
from pathlib import Path
from typing import Any, NamedTuple, cast

import numba
import numpy as np
import pytest

import engine.kernels
from engine import host
from engine.kernels import behaviour, evaluate, numba_internals, senses
from engine.kernels.jit import deferred, inlined, is_known, kernel, need, shared
from engine.kernels.numba_internals import Compiled
from engine.kernels.shared import Shared
from engine.opcodes import FUSIONS, Op
from engine.tables import Floats, Ints


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


@kernel
def doubled(x: float) -> float:
    return 2.0 * x


@shared
def tripled(x: float) -> float:
    return 3.0 * x


@kernel
def sixfold(x: float) -> float:
    return tripled(doubled(x))


class Parts(NamedTuple):
    whole: float
    half: float


@deferred()
def parted(x: float, count: int, at_all: bool) -> Parts:
    return Parts(x, 0.5 * x * count if at_all else 0.0)


@kernel
def half_of(x: float, rows: Ints) -> float:
    """Calls with a literal, and with an element of a narrow array: one compilation serves both."""
    return parted(x, 1, True).half + parted(x, rows[0], x > 0.0).half


@deferred()
def needed_later(x: float) -> float:
    return 2.0 * x


@kernel
def asks_later(x: float) -> float:
    return needed_later(x) if x > 0.0 else 0.0


@deferred()
def never_needed(x: float) -> float:
    return x


@kernel
def asks_for_it(x: float) -> float:
    return never_needed(x) if x > 0.0 else 0.0


def test_inlined_functions_work_in_one_another_in_kernels_and_from_python() -> None:
    """Under the kernels' rules: x / 0 is infinite."""
    values = np.array([1.0, 2.0, 6.0])
    assert halved(values) == 4.75
    assert added(values, 2.0) == 4.5
    if isinstance(divided, Compiled):
        assert divided(1.0, 0.0) == np.inf


def test_a_draft_has_no_machine_code_of_its_own() -> None:
    """Else it is made, and thrown away, for each of some hundred functions: half a minute instead of a quarter."""
    halved(np.ones(2))
    function = cast("Any", divided)
    if not isinstance(function, Compiled):
        pytest.skip("runs without the compiler")
    if not function.draft.overloads:  # the kernel came from the cache
        function.draft.compile("(float64, float64)")
    (result,) = function.draft.overloads.values()
    engine_of = result.target_context.codegen()._engine
    assert not engine_of.is_symbol_defined(result.fndesc.llvm_func_name)


def test_shared_code_is_made_once_and_callers_get_none_of_it() -> None:
    """What is contained is compiled with each of its callers, which for a whole run takes ten seconds each time."""
    assert sixfold(1.0) == 6.0
    if not isinstance(sixfold, Compiled):
        pytest.skip("runs without the compiler, or by numba's public parts alone")
    assert cast("Any", doubled)._finished is None
    (made,) = cast("Any", sixfold).finished.overloads.values()
    assert "tripled" not in {function.name for function in made.library._final_module.functions}


def test_a_deferred_function_is_compiled_once_and_only_for_whom_it_is_needed() -> None:
    """A program that does not need it runs without it; a call without need is an error and no wrong number."""
    if not isinstance(half_of, Compiled):
        pytest.skip("runs without the compiler, or by numba's public parts alone")
    assert asks_for_it(-1.0) == 0.0
    with pytest.raises(RuntimeError, match="never_needed"):
        asks_for_it(1.0)
    assert not cast("Any", never_needed).dispatcher.overloads
    need(parted)
    assert half_of(8.0, np.array([3], dtype=np.int32)) == 4.0 + 12.0
    assert len(cast("Any", parted).dispatcher.overloads) == 1
    assert parted(8.0, 1, True) == Parts(8.0, 4.0)


def test_need_may_come_after_a_caller_is_loaded() -> None:
    """A later program may be the first to need a function."""
    if not isinstance(asks_later, Compiled):
        pytest.skip("runs without the compiler, or by numba's public parts alone")
    assert asks_later(-1.0) == 0.0
    need(needed_later)
    assert asks_later(2.0) == 4.0


def test_every_deferred_kernel_is_needed_by_some_program() -> None:
    """The tables and the rule of `engine.host` name them all: a kernel that is not named could never be called."""
    named = {*evaluate.DEFERRED.values(), *itertools.chain(*senses.DEFERRED.values())}
    rule = set(inspect.getclosurevars(host.deferred_kernels).globals)
    kernels = {
        function
        for module in pkgutil.iter_modules(engine.kernels.__path__, "engine.kernels.")
        for function in vars(importlib.import_module(module.name)).values()
        if isinstance(function, Shared) and not function.is_always_needed
    }
    assert kernels
    assert {each.name for each in kernels - named} <= rule


def test_every_shared_kernel_states_whether_it_counts_references() -> None:
    """An option that is left out is that of the caller under compilation, which then refuses new arrays."""
    kernels = {
        function
        for module in pkgutil.iter_modules(engine.kernels.__path__, "engine.kernels.")
        for function in vars(importlib.import_module(module.name)).values()
        if isinstance(function, Shared)
    }
    assert kernels
    assert [each.name for each in kernels if "_nrt" not in each.dispatcher.targetoptions] == []


def test_the_tables_name_every_instruction_that_calls_a_deferred_kernel() -> None:
    """A row that is missing would let a program without the others of its family fail."""
    geometry = {op for op in Op if Op.PATH_POSE <= op < Op.STATE} - {Op.PATH_POSE, Op.REGION_DISTANCE}
    assert set(evaluate.DEFERRED) == geometry
    kernels = {kernel.name for row in senses.DEFERRED.values() for kernel in cast("Any", row)} | {"foresee"}
    called: set[str] = set()
    for node in ast.walk(ast.parse(inspect.getsource(cast("Any", behaviour.interpret).py_func))):
        if isinstance(node, ast.If) and isinstance(node.test, ast.Compare):
            calls = {name for line in node.body for name in _names_called(line)}
            if calls & kernels:
                called.add(ast.unparse(node.test.comparators[0]))
    fused = {f"Fused.{number.name}" for number, ops in FUSIONS.items() if set(ops) & senses.DEFERRED.keys()}
    assert called == {f"Op.{op.name}" for op in senses.DEFERRED} | fused


def _names_called(line: ast.AST) -> set[str]:
    calls = (node.func for node in ast.walk(line) if isinstance(node, ast.Call))
    return {function.id for function in calls if isinstance(function, ast.Name)}


def test_numba_has_the_parts_that_are_used() -> None:
    """What `numba_internals` overrides or sets; where one is gone or renamed, its place is taken by what is public."""
    if not is_known(numba.__version__):
        pytest.skip("this numba is used by its public parts alone")
    library, cache = numba_internals.JITCodeLibrary, numba_internals.FunctionCache
    for name in (
        "_optimize_final_module",
        "_finalize_final_module",
        "_finalize_dynamic_globals",
    ):
        assert callable(getattr(library, name))
    assert {"get_pointer_to_function", "codegen", "enable_object_caching"} <= set(dir(library))
    assert {"load_overload", "save_overload", "cache_path"} <= set(dir(cache))
    kept = cast("Any", cache(_plain))
    assert {"load", "save", "flush"} <= set(dir(kept._cache_file))
    assert {"locator", "filename_base", "reduce", "rebuild"} <= set(dir(kept._impl))
    assert "_linking_libraries" in vars(_compiled_library())
    assert hasattr(numba.njit(_plain), "_cache")


def test_unknown_versions_are_not_taken_for_known_ones() -> None:
    """A minor version is known as a whole."""
    assert is_known("0.68.1")
    assert not any(map(is_known, ("0.69.0", "0.6.8", "1.0.0", "0.680.0")))


def test_private_parts_are_touched_in_few_files() -> None:
    """All else imports `numba` itself; `compiling` its events, which numba documents."""
    product = Path(numba_internals.__file__).parents[2]
    sources = [path for folder in ("engine", "cortex_dsl") for path in (product / folder).rglob("*.py")]
    inside = {path.stem for path in sources if "numba.core" in path.read_text(encoding="utf-8")}
    assert inside == {"compiling", "handle_types", "numba_internals", "shared"}


def _plain(x: float) -> float:
    return x


def _compiled_library() -> Any:
    plain: Any = numba.njit(_plain)
    plain(1.0)
    (made,) = plain.overloads.values()
    return made.library
