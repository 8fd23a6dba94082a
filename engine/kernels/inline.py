"""`@inlined`: a compiled function that is always copied into its caller, and counts no references.

numba passes each array as seven or more words and counts references to it with atomic instructions, so a call that
hands on a `RoadTables` costs tens of nanoseconds, and reading a field of a nested tuple of arrays hundreds. Inner
loops are therefore written as `@inlined` functions under one `@kernel` entry. Such a function may neither make arrays
nor return them (numba refuses the former): it reads and writes what its caller owns.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar, cast

import numba
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import typeof_impl

from engine.kernels.jit import OPTIONS, kernel

Function = TypeVar("Function", bound=Callable[..., Any])


class _Draft(JITCodeLibrary):
    """The code of a function that exists only inside its callers, which make machine code of it.

    numba would optimise and finish the function alone as well, and again with each function that it is copied into on
    the way to a kernel: that was a good half of the time which a first compilation took.
    """

    def _optimize_final_module(self) -> None:
        """Its callers do."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """The null pointer, numba's sign for a function that Python cannot call."""
        del name
        return 0

    @property
    def codegen(self) -> Any:
        """Who sets the address of the function's environment, which belongs to the bridge from Python."""
        return self

    def set_env(self, env_name: str, env: object) -> None:
        """Nothing to set."""


class _DraftCompiler(Compiler):
    """numba's own passes, which end in a draft."""

    def define_pipelines(self) -> Any:
        state = cast("Any", self).state
        state.library = _Draft(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


DRAFT_OPTIONS: dict[str, Any] = OPTIONS | {
    "forceinline": True,
    "_nrt": False,
    "no_cpython_wrapper": True,
    "pipeline_class": _DraftCompiler,
}


class Inlined:
    """What Python sees of an `@inlined` function; numba sees the draft. Called from Python, it becomes a kernel."""

    def __init__(self, function: Callable[..., Any], draft: Any) -> None:
        self.py_func = function
        self.draft = draft

    def __call__(self, *arguments: Any) -> Any:
        return self._alone(*arguments)

    @cached_property
    def _alone(self) -> Callable[..., Any]:
        return kernel(self.py_func)


@typeof_impl.register(Inlined)
def _type_of_draft(function: Inlined, _context: object) -> types.Type:
    return types.Dispatcher(function.draft)


def inlined(function: Function) -> Function:
    """Compile like `@kernel`, but into the caller's machine code; cached as a part of the caller."""
    draft = numba.njit(**DRAFT_OPTIONS)(function)
    return function if draft is function else cast("Function", Inlined(function, draft))
