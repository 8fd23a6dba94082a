"""The decorators of all compiled functions, and the cache of their machine code: `@kernel`, `@allocating`, `@inlined`,
`@shared` and `@deferred`.

A `@kernel` is compiled on the first call from Python and stored on disk; other kernels contain it. Code that many
kernels would contain and that takes long to compile is `@shared`: compiled once, called by all others; `@deferred` code
is compiled only for programs that need it. An `@inlined` function is always copied into its caller. None of these count
references inside other kernels, since numba counts with atomic instructions: they must neither create arrays nor return
them (numba refuses the former), and read and write arrays of their caller. A function that creates arrays is
`@allocating`. Each function is marked itself, since numba would compile a callee as its first caller is compiled.

The cache is named by contents: one compilation per user, for all clones and environments. Any edit of a kernel, or of
an enum value that is a constant in it, leads to another folder; folders long out of use are removed.

Private parts of numba are used in `numba_internals`, `shared`, `switch` and `handle_types`. With a numba whose parts
are untested (not in `KNOWN`), functions are inlined and cached by numba's public means: that compiles for longer, and
once for each installation, with the same results. Only the type of handles and the switch are needed with any version.
"""

import ast
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import llvmlite  # pyright: ignore[reportMissingTypeStubs]  # only its version is asked for
import numba

from engine.kernels.packaged import FOLDER, PackagedKernels, packaged_kernels, processor
from engine.user_cache import cache_roots, is_ours, is_writable, remove_old

# -- sources of a kernel -----------------------------------------------------------------------------------------------

KERNELS = Path(__file__).parent
KERNEL_INPUTS = (
    "handles.py",
    "judged.py",
    "opcodes.py",
    "operators/__init__.py",
    "outcomes.py",
    "tables.py",
    "vocabulary.py",
)
"""Modules of `engine` that kernels read: names, columns and enum values are constants of the machine code."""


def text_digest(kernels: Path = KERNELS) -> str:
    """Return the digest of all bytes of the sources; it costs 2 ms, `syntax_digest` 0.3 s."""
    return _digest((name, path.read_bytes()) for name, path in _sources(kernels))


def syntax_digest(kernels: Path = KERNELS) -> str:
    """Return the digest of the sources' meaning: no comment, docstring, line number or layout changes it."""
    trees = ((name, _described(ast.parse(path.read_bytes()))) for name, path in _sources(kernels))
    return _digest((name, repr(tree).encode()) for name, tree in trees)


def _sources(kernels: Path) -> Iterator[tuple[str, Path]]:
    for path in (*sorted(kernels.rglob("*.py")), *(kernels.parent / name for name in KERNEL_INPUTS)):
        yield path.relative_to(kernels.parent).as_posix(), path


def _digest(parts: Iterable[tuple[str, bytes]]) -> str:
    digest = hashlib.sha256()
    for name, content in parts:
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def _described(value: object) -> object:
    """Return a syntax tree as tuples. Empty fields are left out, so that all versions of Python give the same.

    A statement that consists of a string, such as a docstring, has no effect and is left out too.
    """
    match value:
        case ast.AST():
            fields = ((name, each) for name, each in ast.iter_fields(value) if each is not None and each != [])
            return (type(value).__name__, *((name, _described(each)) for name, each in fields))
        case list():
            return tuple(_described(each) for each in cast("list[object]", value) if not _is_note(each))
        case _:
            return value


def _is_note(value: object) -> bool:
    return isinstance(value, ast.Expr) and isinstance(value.value, ast.Constant) and isinstance(value.value.value, str)


if not cast("Any", numba).config.DISABLE_JIT:
    from engine.kernels import handle_types

    assert handle_types  # numba now has the type of `engine.handles`

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": False, "no_cfunc_wrapper": True}
NJIT: Any = numba.njit
KNOWN = ("0.68",)
"""Versions of numba that `numba_internals` was tried with."""

Function = TypeVar("Function", bound=Callable[..., Any])


def is_known(version: str) -> bool:
    """Return True if the private parts of this numba version were tested."""
    return version.rpartition(".")[0] in KNOWN


def kernel(function: Function) -> Function:
    """Compile a function on its first call: without the GIL, without fastmath, x / 0 = inf, cached on disk.

    With NUMBA_DISABLE_JIT=1 in the environment it stays plain Python.
    """
    return _compiled(function, {}, {"_nrt": False})


def allocating(function: Function) -> Function:
    """Compile a function that creates or returns arrays, like `@kernel`; references are counted in every caller."""
    return _compiled(function, {}, {"_nrt": True})


def inlined(function: Function) -> Function:
    """Compile like `@kernel`, but into the caller's machine code; cached as a part of the caller."""
    return _compiled(function, {"forceinline": True}, {"_nrt": False})


def shared(function: Function) -> Function:
    """Compile like `@kernel`, and have other kernels call that code instead of containing it: once for all callers.

    It creates no arrays and counts no references. Rarely executed code is better shared than contained: a small step
    stays in the caches of the processor.
    """
    return _shared(function, {"_nrt": False}, deferred=False)


def deferred(allocates: bool = False) -> Callable[[Function], Function]:
    """Compile like `@shared`, once a program needs it: `engine.host.plan` calls `need`."""
    # An option that is left out is that of the function whose compilation compiles this one.
    return lambda function: _shared(function, {"_nrt": allocates}, deferred=True)


def need(*functions: Callable[..., Any]) -> None:
    """Prepare deferred functions for the kernels that call them."""
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
    """Return a function compiled with further options, and with those in `within` inside other kernels."""
    if not is_known(numba.__version__):
        return NJIT(**OPTIONS | options)(function) if options else _finished(function)
    from engine.kernels.numba_internals import DRAFT_OPTIONS, Compiled

    draft: Any = NJIT(**OPTIONS | options | within | DRAFT_OPTIONS)(function)
    return function if draft is function else cast("Function", Compiled(function, draft, _finished))


def _finished(function: Function, options: dict[str, Any] | None = None) -> Function:
    """Return a function with its own machine code, which is cached."""
    dispatcher: Any = NJIT(**OPTIONS | (options or {}))(function)
    if dispatcher is function:
        return function
    if is_known(numba.__version__):
        from engine.kernels.numba_internals import cache_by_content

        cache_by_content(dispatcher, function, cache_folder(), KERNELS, packaged())
    else:
        _cache_by_place(dispatcher)
    return cast("Function", dispatcher)


# -- where compiled kernels lie ----------------------------------------------------------------------------------------


@cache
def packaged() -> PackagedKernels | None:
    """Return the kernels that came with the installation, if they are those of this version and run on this machine."""
    return packaged_kernels(content_key()) if is_known(numba.__version__) else None


@cache
def cache_folder() -> Path:
    """Return the folder for compiled kernels of this version and processor: existing, writable, ours."""
    name = f"numba-{content_key()}-{hashlib.sha256(repr(processor()).encode()).hexdigest()[:8]}"
    for root in _roots():
        folder = root / name
        if is_writable(folder) and is_ours(folder) and (root != _temporary_root() or is_ours(root)):
            remove_old(root, "numba-*", folder)
            with suppress(OSError):
                (folder / f"{text_digest()}-{source_hash()}.sources").touch()
            return folder
    return Path(tempfile.mkdtemp(prefix="cortexc-")) / name


@cache
def content_key() -> str:
    """Return the hash of all that machine code depends on, but for the processor."""
    python = f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"
    versions = numba.__version__, llvmlite.__version__, python
    return hashlib.sha256("\0".join([source_hash(), *versions]).encode()).hexdigest()[:16]


@cache
def source_hash() -> str:
    """Return the hash of all sources that a compiled kernel may depend on: of their syntax trees, without docstrings.

    An empty file in each folder of compiled kernels is named by the hashes of text and syntax, so that few starts parse
    the sources.
    """
    text = text_digest()
    folders = (FOLDER, *(folder for root in _roots() for folder in _kernel_folders(root)))
    known = (marker.stem.partition("-")[2] for folder in folders for marker in folder.glob(f"{text}-*.sources"))
    return next(known, None) or syntax_digest()


def _roots() -> tuple[Path, ...]:
    return (*cache_roots(), _temporary_root())


def _kernel_folders(root: Path) -> list[Path]:
    with suppress(OSError):
        return [folder for folder in root.glob("numba-*") if is_ours(folder)]
    return []


def _temporary_root() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"cortexc-{user}"


def _cache_by_place(dispatcher: Any) -> None:
    """Store the machine code with numba's own cache, in our folder: an entry serves a single installation."""
    config = cast("Any", numba).config
    before, config.CACHE_DIR = config.CACHE_DIR, str(cache_folder())
    try:
        dispatcher.enable_caching()
    finally:
        config.CACHE_DIR = before
