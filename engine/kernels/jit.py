"""`@kernel`: the one decorator of all compiled functions, and the cache that makes them start at once.

numba's own cache notices an edit only in the file of the function itself. A kernel that calls, or takes an enum value
from, another file would go on with old physics. So the cache folder is named by a hash of every source that a kernel
may depend on: any edit leads to another folder, and folders long out of use are removed.
"""

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator

from engine.user_cache import cache_roots, is_writable, remove_old

try:
    import fcntl
except ImportError:  # Windows has no advisory locks of this kind
    fcntl = None

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": False, "no_cfunc_wrapper": True}

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile a function on its first call: without the GIL, without fastmath, x / 0 = inf, cached on disk.

    With NUMBA_DISABLE_JIT=1 in the environment it stays plain Python.
    """
    dispatcher = cast("Any", numba.njit(**OPTIONS)(function))
    if hasattr(dispatcher, "enable_caching"):
        dispatcher._cache = _KernelCache(function)
    return cast("Function", dispatcher)


def kernels_are_cached() -> bool:
    """Whether an earlier process compiled kernels of exactly this version: if not, the first calls take seconds."""
    return any(cache_folder().glob("*/*.nbi"))


@cache
def cache_folder() -> Path:
    """The folder for compiled kernels of this version: existing, writable, ours."""
    name = f"numba-{source_hash()}"
    for root in (*cache_roots(), _temporary_root()):
        folder = root / name
        if is_writable(folder) and (root != _temporary_root() or _is_ours(root)):
            remove_old(root, "numba-*", folder)
            return folder
    return Path(tempfile.mkdtemp(prefix="cortexc-")) / name


@cache
def source_hash() -> str:
    """Hash of all sources that a compiled kernel may depend on."""
    here = Path(__file__).parent
    digest = hashlib.sha256()
    for path in (
        *sorted(here.glob("*.py")),
        *(here.parent / f"{name}.py" for name in ("outcomes", "tables", "vocabulary")),
    ):
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


@contextlib.contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    """Let one process at a time write: numba's index and data files are two files and not written as one."""
    if fcntl is None:
        yield
        return
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


class _Locator(UserProvidedCacheLocator):
    """Places a kernel's files in `cache_folder()`, one subfolder per source folder (checkouts of equal text differ)."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._py_file = py_file
        self._lineno = py_func.__code__.co_firstlineno
        self._cache_path = str(cache_folder() / self.get_suitable_cache_subpath(py_file))

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator":
        return cls(py_func, py_file)


class _CacheImplementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 (numba's own attribute)


class _KernelCache(FunctionCache):
    """numba's cache, for which a full disk, a vanished folder or a broken file is a miss and not an error."""

    _impl_class = _CacheImplementation

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        # A truncated pickle raises nearly any exception; what it costs is one compilation, never a wrong kernel.
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:
            _log(f"kernel cache not read: {error!r}")
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            Path(self.cache_path).mkdir(parents=True, exist_ok=True)
            with _exclusive(Path(self.cache_path)):
                super().save_overload(sig, data)
        except OSError as error:
            _log(f"kernel cache not written: {error!r}")


def _log(message: str) -> None:
    if os.environ.get("NUMBA_DEBUG_CACHE"):
        print(message, file=sys.stderr)  # noqa: T201
