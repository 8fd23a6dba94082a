"""`@inlined`: a compiled function that is always copied into its caller, and counts no references.

numba passes each array as seven or more words and counts references to it with atomic instructions, so a call that
hands on a `RoadTables` costs tens of nanoseconds, and reading a field of a nested tuple of arrays hundreds. Inner
loops are therefore written as `@inlined` functions under one `@kernel` entry. Such a function may neither make arrays
nor return them (numba refuses the former): it reads and writes what its caller owns.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": False, "forceinline": True, "_nrt": False}
PART_OPTIONS: dict[str, Any] = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def inlined(function: Function) -> Function:
    """Compile like `@kernel`, into the caller's machine code; cached as a part of the caller."""
    return cast("Function", numba.njit(**OPTIONS)(function))


def inlined_part(function: Function) -> Function:
    """Like `@inlined`, but out of Python's reach: the bridge that unpacks many tables is a third of the compilation."""
    return cast("Function", numba.njit(**PART_OPTIONS)(function))
