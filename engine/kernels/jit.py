"""The decorators of all compiled functions, and the cache of their machine code: `@kernel`, `@allocating`, `@inlined`,
`@shared` and `@deferred`.

A `@kernel` is compiled on Python's first call and kept on disk; another kernel contains it, so what many contain and
takes long is `@shared`: compiled once, called by all others. An `@inlined` function is always copied into its caller
and counts no references: numba passes each array as seven or more words and counts references to it with atomic
instructions, so a call that hands on a `RoadTables` costs tens of nanoseconds, and reading a field of a nested tuple of
arrays hundreds. Inner loops are therefore `@inlined` functions under one `@kernel` entry. A kernel counts none either
where another one contains it. Such functions may neither make arrays nor return them (numba refuses the former): they
read and write what their caller owns. What does make some is `@allocating`. Each says so itself, since numba would have
a callee do as the first caller does that has it compiled.

The cache is named by contents: one compilation for a user, however many clones and environments there are. Any edit of
a kernel, or of an enum value that is a constant in it, leads to another folder; folders long out of use are removed.

What inlines fast and caches by content touches private parts of numba and is in `numba_internals`. With a numba whose
parts are untested (not in `KNOWN`), functions are inlined and cached by numba's public means: that compiles for
longer, and once for each installation, with the same results.
"""

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import llvmlite  # pyright: ignore[reportMissingTypeStubs]  # only its version is asked for
import numba
import numpy as np

from engine.user_cache import cache_roots, is_writable, remove_old

if not cast("Any", numba).config.DISABLE_JIT:
    from engine.kernels import handle_types

    assert handle_types  # numba knows the type of `engine.handles` now

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": False, "no_cfunc_wrapper": True}
NJIT: Any = numba.njit
KNOWN = ("0.68",)
"""Versions of numba that `numba_internals` was tried with."""
KERNELS = Path(__file__).parent
BESIDE = ("handles.py", "named_results.py", "opcodes.py", "outcomes.py", "result_row.py", "tables.py", "vocabulary.py")
"""What kernels read beside one another: names, columns and enum values are constants of the machine code."""

Function = TypeVar("Function", bound=Callable[..., Any])


def is_known(version: str) -> bool:
    """Whether the private parts of this numba are as we take them to be."""
    return version.rpartition(".")[0] in KNOWN


def kernel(function: Function) -> Function:
    """Compile a function on its first call: without the GIL, without fastmath, x / 0 = inf, cached on disk.

    With NUMBA_DISABLE_JIT=1 in the environment it stays plain Python.
    """
    return _compiled(function, {}, {"_nrt": False})


def allocating(function: Function) -> Function:
    """Compile like `@kernel` what makes arrays or returns them: references are counted wherever it is contained."""
    return _compiled(function, {}, {"_nrt": True})


def inlined(function: Function) -> Function:
    """Compile like `@kernel`, but into the caller's machine code; cached as a part of the caller."""
    return _compiled(function, {"forceinline": True}, {"_nrt": False})


def shared(function: Function) -> Function:
    """Compile like `@kernel`, and have other kernels call that code where they would contain it: once for all callers.

    It makes no arrays and counts no references. Rarely executed code is better shared than contained: a small step
    stays in the caches of the processor.
    """
    return _shared(function, {"_nrt": False}, deferred=False)


def deferred(allocates: bool = False) -> Callable[[Function], Function]:
    """Compile like `@shared`, once a program needs it: `engine.host.plan` says so by `need`."""
    options = {} if allocates else {"_nrt": False}
    return lambda function: _shared(function, options, deferred=True)


def need(*functions: Callable[..., Any]) -> None:
    """Have deferred functions ready for the kernels that call them."""
    for function in functions:
        if not isinstance(function, FunctionType) and is_known(numba.__version__):
            cast("Any", function).need()


def _shared(function: Function, options: dict[str, Any], deferred: bool) -> Function:
    if not is_known(numba.__version__):
        return _finished(function)
    dispatcher = _finished(function, options)
    if dispatcher is function:
        return function
    from engine.kernels.shared import Shared

    return cast("Function", Shared(function, dispatcher, deferred))


def _compiled(function: Function, options: dict[str, Any], within: dict[str, Any]) -> Function:
    """A function compiled with further options, and with some more where it is part of other kernels."""
    if not is_known(numba.__version__):
        return NJIT(**OPTIONS | options)(function) if options else _finished(function)
    from engine.kernels.numba_internals import DRAFT_OPTIONS, Compiled

    draft: Any = NJIT(**OPTIONS | options | within | DRAFT_OPTIONS)(function)
    return function if draft is function else cast("Function", Compiled(function, draft, _finished))


def _finished(function: Function, options: dict[str, Any] | None = None) -> Function:
    """A function with machine code of its own, which is cached."""
    dispatcher: Any = NJIT(**OPTIONS | (options or {}))(function)
    if dispatcher is function:
        return function
    if is_known(numba.__version__):
        from engine.kernels.numba_internals import cache_by_content

        cache_by_content(dispatcher, function, cache_folder(), KERNELS)
    else:
        _cache_by_place(dispatcher)
    return cast("Function", dispatcher)


# -- where compiled kernels lie ----------------------------------------------------------------------------------------


def kernels_are_cached() -> bool:
    """Whether an earlier process compiled kernels of exactly this version: if not, the first calls take seconds."""
    return any(cache_folder().glob("*/*.nbc"))


@cache
def cache_folder() -> Path:
    """The folder for compiled kernels of this version: existing, writable, ours."""
    name = f"numba-{content_key()}"
    for root in (*cache_roots(), _temporary_root()):
        folder = root / name
        if is_writable(folder) and (root != _temporary_root() or _is_ours(root)):
            remove_old(root, "numba-*", folder)
            return folder
    return Path(tempfile.mkdtemp(prefix="cortexc-")) / name


@cache
def content_key() -> str:
    """Hash of all that machine code depends on, but for the processor: numba adds its name and features to each key."""
    versions = numba.__version__, llvmlite.__version__, np.__version__, str(sys.implementation.cache_tag), sys.version
    return hashlib.sha256("\0".join([source_hash(), *versions]).encode()).hexdigest()[:16]


@cache
def source_hash() -> str:
    """Hash of all sources that a compiled kernel may depend on."""
    digest = hashlib.sha256()
    for path in (*sorted(KERNELS.glob("*.py")), *(KERNELS.parent / name for name in BESIDE)):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _temporary_root() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"cortexc-{user}"


def _is_ours(folder: Path) -> bool:
    """Whether no other user made or may write this folder: compiled kernels in it are code that will be run."""
    status = folder.lstat()
    return not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o022)


def _cache_by_place(dispatcher: Any) -> None:
    """Numba's own cache, in our folder: an entry is of use to one installation only."""
    config = cast("Any", numba).config
    before, config.CACHE_DIR = config.CACHE_DIR, str(cache_folder())
    try:
        dispatcher.enable_caching()
    finally:
        config.CACHE_DIR = before
