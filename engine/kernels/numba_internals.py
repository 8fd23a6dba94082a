"""Private parts of numba: functions without machine code of their own, and a cache by content.

`Compiled`: numba would optimise and finish each function alone, and again in each function that contains it. A `_Draft`
prevents that, which saves two thirds of the time of a first compilation.

`cache_by_content`: numba's own cache is named by path and time of the source, and stores an index apart from the code:
two files, which are inconsistent if the process dies between their writes. Here each compiled signature is one file
that is written atomically, named by its purpose, and checked when it is read. A broken file is compiled again.

The file of a caller lists the cells of shared functions that it names (`engine.kernels.shared`).

`tests/engine/kernels/test_numba_internals.py` tests the parts that are used.
"""

# Internal parts of numba have no types.
# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

import hashlib
import os
import pickle
import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import cache, update_wrapper
from pathlib import Path
from threading import Lock
from typing import Any, cast

from llvmlite.binding import parse_assembly  # pyright: ignore[reportMissingTypeStubs]
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.extending import typeof_impl

from engine.kernels.packaged import PackagedKernels
from engine.kernels.shared import all_uses

# -- inlined functions -------------------------------------------------------------------------------------------------


class _Draft(JITCodeLibrary):
    """The code of a function that exists only inside its callers, which make machine code of it."""

    def _optimize_final_module(self) -> None:
        """Do nothing: the callers' modules are optimised."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return the null pointer, numba's sign for a function that Python cannot call."""
        del name
        return 0

    @property
    def codegen(self) -> Any:
        """Return this object, which sets the address of an environment: part of the bridge from Python."""
        return self

    def set_env(self, env_name: str, env: object) -> None:
        """Do nothing: there is no environment."""


class _DraftCompiler(Compiler):
    """numba's own passes, which end in a draft."""

    def define_pipelines(self) -> Any:
        state = cast("Any", self).state
        state.library = _Draft(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


FINISHING = Lock()
"""Lock for the first call of a function from two threads: compiling twice would take twice as long."""
DRAFT_OPTIONS: dict[str, Any] = {"no_cpython_wrapper": True, "pipeline_class": _DraftCompiler}


class Compiled:
    """A function that kernels contain, as Python sees it; numba sees its draft. Python's first call finishes it."""

    def __init__(
        self, function: Callable[..., Any], draft: Any, finish: Callable[[Callable[..., Any]], Callable[..., Any]]
    ) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.draft = draft
        self._finish = finish
        self._finished: Any = None

    def __call__(self, *arguments: Any) -> Any:
        return (self._finished or self.finished)(*arguments)

    @property
    def finished(self) -> Any:
        """Return the function with its own machine code."""
        with FINISHING:
            if self._finished is None:
                self._finished = self._finish(self.py_func)
        return self._finished


@typeof_impl.register(Compiled)
def _type_of_draft(function: Compiled, _context: object) -> types.Type:
    return types.Dispatcher(function.draft)


# -- the cache ---------------------------------------------------------------------------------------------------------


class _Reduced(CompileResultCacheImpl):
    """Serialization of compiled code: the cells that it names, and numba's own reduction."""

    def reduce(self, cres: Any) -> Any:
        library = cres.library
        library._shared_module = _names_only(library)
        return all_uses(library), super().reduce(cres)

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        uses, reduced = payload
        for use in uses:
            use.link()
        return super().rebuild(target_context, reduced)


def _names_only(library: Any) -> Any:
    """Return a module that defines the functions of a library without their code.

    No other code links a finished kernel, and numba needs only the names of what it may call: an entry is half as long,
    and loaded sooner.
    """
    names = [function.name for function in library._final_module.functions if not function.is_declaration]
    stubs = "".join(f'\ndefine void @"{name}"() {{ ret void }}' for name in names)
    return parse_assembly(f"{library.codegen._create_empty_module(library.name)}{stubs}")


def cache_by_content(
    dispatcher: Any,
    function: Callable[..., Any],
    folder: Path,
    sources: Path,
    packaged: PackagedKernels | None = None,
) -> None:
    """Store compiled code of a function in a folder whose name identifies its `sources`.

    Code in the folder of the package is not compiled.
    """
    if Path(function.__code__.co_filename).is_file():
        dispatcher._cache = _cache_class(folder, sources, packaged)(function)


@cache
def _cache_class(folder: Path, sources: Path, packaged: PackagedKernels | None) -> type[Any]:
    class Implementation(_Reduced):
        _locator_classes = [_locator_class(folder, sources)]  # noqa: RUF012 (numba's own attribute)

        def get_filename_base(self, fullname: str, abiflags: str) -> str:
            """Return the begin of the names of a function's files: with its line for code outside our kernels."""
            if cast("Any", self).locator.kernel is None:
                return str(super().get_filename_base(fullname, abiflags))
            return fullname.replace("<", "").replace(">", "")

    return type("KernelCache", (_KernelCache,), {"_impl_class": Implementation, "packaged": packaged})


def _locator_class(folder: Path, sources: Path) -> type[UserProvidedCacheLocator]:
    class Locator(UserProvidedCacheLocator):
        """Location of a function's files: for our kernels by module name, for others by path."""

        def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
            source = Path(py_file)
            self.kernel = source.relative_to(sources).with_suffix("") if source.is_relative_to(sources) else None
            self._py_file = py_file
            self._lineno = py_func.__code__.co_firstlineno
            self._cache_path = str(folder / (self.kernel or self.get_suitable_cache_subpath(py_file)))
            self._stamp = b"" if self.kernel else hashlib.sha256(source.read_bytes()).digest()

        @classmethod
        def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "Locator":
            return cls(py_func, py_file)

        def get_source_stamp(self) -> bytes:
            """Return nothing for our kernels, whose folder identifies their contents; a hash for other files."""
            return self._stamp

    return Locator


class _KernelCache(FunctionCache):
    """numba's cache, for which a full disk, a vanished folder or a broken file is a miss and not an error."""

    packaged: PackagedKernels | None = None

    def __init__(self, py_func: Callable[..., Any]) -> None:
        super().__init__(py_func)
        implementation = cast("Any", self)._impl
        locator, name = implementation.locator, implementation.filename_base
        self._kernel: Path | None = locator.kernel
        self._function = f"{self._kernel}.{name}"
        self._cache_file = _Files(Path(self.cache_path), name, locator.get_source_stamp())
        if self.packaged and self._kernel:
            self._packaged_file = _Files(self.packaged.folder / self._kernel, name, b"")

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Return a key without the bytes of a kernel's code, which vary with docstrings: the folder identifies them."""
        signature, target, (code, closure) = super()._index_key(sig, codegen)
        return signature, target, (self._function if self._kernel else code, closure)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the result of `_load_overload`.

        numba would first import the declarations of everything it can compile, including scipy.linalg: a compiled
        kernel needs none of them, and a compilation imports them itself.
        """
        rtsys.initialize(target_context)
        with cast("Any", self)._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code of the package, else that of the user's cache, else None."""
        signature, target, contents = self._index_key(sig, target_context.codegen())
        places = [(self._cache_file, target)]
        if self.packaged and self._kernel:
            places.insert(0, (self._packaged_file, tuple(self.packaged.target)))
        for files, compiled_for in places:
            # An entry of another kind raises nearly any exception; it costs a compilation, never a wrong kernel.
            try:
                code = files.load((signature, compiled_for, contents))
                compiled = None if code is None else cast("Any", self)._impl.rebuild(target_context, code)
            except Exception as error:
                _log(f"kernel cache not read: {error!r}")
                continue
            if compiled is not None:
                return compiled
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _log(f"kernel cache not written: {error!r}")


class _Files:
    """One file for each compiled signature of a function: the hash of what follows, then the key and the code."""

    def __init__(self, folder: Path, name: str, stamp: bytes) -> None:
        self._folder, self._name, self._stamp = folder, name, stamp

    def load(self, key: Any) -> Any:
        """Return the code for this key; None if there is no complete file."""
        path = self._path(key)
        try:
            content = path.read_bytes()
        except OSError:
            return None
        digest, payload = content[:32], content[32:]
        if hashlib.sha256(payload).digest() != digest:
            _log(f"kernel cache: {path} is damaged")
            return None
        stamp, kept, code = pickle.loads(payload)  # noqa: S301 - our own folder; `user_cache.is_ours` sees to it
        return code if (stamp, kept) == (self._stamp, key) else None

    def save(self, key: Any, code: Any) -> None:
        """Write the file completely or not at all, even if another process writes the same, or this one is killed."""
        payload = dumps((self._stamp, key, code))
        path = self._path(key)
        unborn = path.with_name(f"{path.name}.{os.getpid()}.{uuid.uuid4().hex[:12]}")
        try:
            unborn.write_bytes(hashlib.sha256(payload).digest() + payload)
            unborn.replace(path)
        except BaseException:  # Ctrl-C too leaves no part of a file
            with suppress(OSError):
                unborn.unlink()
            raise

    def flush(self) -> None:
        """Do nothing: no data is held in memory."""

    def _path(self, key: Any) -> Path:
        return self._folder / f"{self._name}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"


def _log(message: str) -> None:
    if os.environ.get("NUMBA_DEBUG_CACHE"):
        print(message, file=sys.stderr)  # noqa: T201
