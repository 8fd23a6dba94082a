"""Drivers by their command-line name: `python:package.module:function` or `process:COMMAND`.

Code is named only on the command line or in Python. No file of a scenario, no manifest and no journal makes anything
run: they store a name and a digest, which are compared with the driver that is named again. The digest covers the file
that defines a function or class, or the files that a command names; it covers neither their imports nor weights that
they load.
"""

import ctypes
import importlib
import os
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager, redirect_stdout, suppress
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from inspect import getsourcefile, isclass, isroutine, unwrap
from pathlib import Path
from typing import Any, cast

from engine.config import ActorDriver
from engine.driving.blocks import BLOCK, Driven, Driver
from engine.driving.controllers import controllers_of
from engine.driving.decisions import RecordedActions, Recorder
from engine.driving.names import FORMS, Egos, joined
from engine.driving.stacks import files_of, stack_of
from engine.errors import ControllerError, nearest
from engine.program import Program
from engine.vocabulary import RECORDS


@dataclass(frozen=True, eq=False)
class NamedDriver(Driver):
    """A driver that can be loaded again, in another process too."""

    words: Egos = ""
    """Names by which it is loaded."""

    def drive(self, *given: Any, **named: Any) -> Driven:
        """Drive all valid scenes (`Driver.drive`), with prints of a function redirected to stderr, away from the
        command's output.
        """
        with _no_output():
            return super().drive(*given, **named)

    def __reduce__(self) -> tuple[Any, ...]:
        return driver_of, (self.words, self.block, self.observe)


@contextmanager
def _no_output() -> Generator[None]:
    """Redirect prints to stderr, also those of code that is not Python."""
    saved, out = None, sys.stdout
    _flush(out)
    with suppress(OSError):
        saved = os.dup(1)
        os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _flush(out)
        if saved is not None:
            os.dup2(saved, 1)
            os.close(saved)


def _flush(out: object) -> None:
    """Flush the buffers of Python and of C."""
    with suppress(OSError, ValueError, AttributeError):  # a process may have no streams
        cast("Any", out).flush()
    with suppress(OSError, TypeError, AttributeError):  # there may be no such library
        ctypes.CDLL(None).fflush(None)


def named_driver(name: str, block: int = BLOCK, observe: str = RECORDS) -> NamedDriver:
    """Load the driver of a name.

    Raises:
        ControllerError: it is no name of a driver, there is no such module or function, or it cannot be loaded.
    """
    kind, _, place = name.partition(":")
    if kind == "process":
        stack = stack_of(place)
        return NamedDriver(stack, block, observe, name, _digest_of(*files_of(stack)), words=name)
    module, _, function = place.rpartition(":")
    if kind != "python" or not module or not function or ":" in module:
        raise ControllerError(f"`{name}` names no driver", f"write {FORMS}")
    with _no_output():
        found = _found(_module(module), module, function)
        return NamedDriver(_made(found, name), block, observe, name, _digest_of(*_sources(found)), words=name)


@contextmanager
def _searched_first(folder: str) -> Generator[None]:
    """Let imports search a folder first; afterwards they search it last, so that its files hide no other modules, and
    a driver finds those that it imports later.
    """
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)
        if folder not in sys.path:
            sys.path.append(folder)


def _module(name: str) -> Any:
    """Import a module; the folder in which the command runs counts, as for `python -m`."""
    if name.endswith(".py") or "/" in name:
        dotted = ".".join(part for part in Path(name).with_suffix("").parts if part.isidentifier())
        raise ControllerError(f"`{name}` is a file and no module", f"write `python:{dotted or 'module'}:function`")
    try:
        with _searched_first(str(Path.cwd())):
            return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(f"{error.name}.")):
            raise ControllerError(
                f"there is no module `{name}` here",
                f"run the command in the folder of `{name.split('.')[0]}.py`, or put that folder into PYTHONPATH",
            ) from error
        raise _unloaded(name, error) from error
    except (Exception, SystemExit) as error:
        raise _unloaded(name, error) from error


def _unloaded(name: str, error: BaseException) -> ControllerError:
    return ControllerError(
        f"the module `{name}` cannot be imported: {type(error).__name__}: {error}",
        f"`python -c 'import {name}'` shows where",
    )


def _found(module: Any, name: str, function: str) -> Any:
    there = module
    for part in function.split("."):
        if not hasattr(there, part):
            names = [each for each in dir(there) if not each.startswith("_") and callable(getattr(there, each))]
            near = nearest(part, names)
            cure = f"did you mean `{near}`?" if near else "name a function, an object or a class of it"
            raise ControllerError(f"the module `{name}` has no `{function}`", cure)
        there = getattr(there, part)
    return there


def _made(thing: Any, name: str) -> Any:
    """Return an object of a class; any other thing unchanged."""
    if not isclass(thing):
        return thing
    try:
        return thing()
    except (Exception, SystemExit) as error:
        raise ControllerError(
            f"`{name}` is a class that cannot be made: {type(error).__name__}: {error}",
            "let it be made without arguments, or name a function",
        ) from error


def _definition(thing: Any) -> Any:
    """Return the function or class that defines a thing's behaviour."""
    while isinstance(thing, partial):
        thing = cast("partial[Any]", thing).func
    if callable(thing):
        thing = unwrap(thing)
    return thing if any(is_one(thing) for is_one in (isclass, isroutine)) else cast("Any", type(thing))


def _sources(thing: Any) -> tuple[str, ...]:
    """Return the file that defines a thing; () if there is no such file."""
    try:
        place = getsourcefile(_definition(thing))
    except (TypeError, OSError):
        return ()
    return () if place is None else (place,)


def _digest_of(*places: str) -> str:
    """Return the SHA-256 of the concatenated files; "" if there are none."""
    texts = [Path(place).read_bytes() for place in places if Path(place).is_file()]
    return sha256(b"".join(texts)).hexdigest() if texts else ""


# -- several, and from Python -----------------------------------------------------------------------------------------


def driver_for(program: Program, given: object, block: int = BLOCK, observe: str = RECORDS) -> ActorDriver | None:
    """Return the driver that is given (`driver_of`); every controller of the program has to have one.

    Raises:
        ControllerError: a controller has no driver, or one that cannot be asked.
    """
    if isinstance(given, RecordedActions | Recorder):
        return given
    driver = driver_of(given, block, observe)
    if driver is not None:
        controllers_of(program, driver.given)
    return driver


def driver_of(given: object, block: int = BLOCK, observe: str = RECORDS) -> Driver | None:
    """Return the driver that is given by its name, as a controller or a class of one, or as a mapping from controller
    names to these.
    """
    if given is None or isinstance(given, Driver):
        return given
    if isinstance(given, str):
        return named_driver(given, block, observe)
    if isinstance(given, Mapping):
        return _several(cast("Mapping[str, object]", given), block, observe)
    name = _name(given)
    return Driver(_made(given, name), block, observe, name, _digest_of(*_sources(given)))


def _name(given: object) -> str:
    """Return `python:module:function` if the command line finds this very object by it; else `module:Class`."""
    source = _definition(given)
    module, path = getattr(source, "__module__", ""), getattr(source, "__qualname__", type(given).__name__)
    there = home = sys.modules.get(module)
    for part in path.split("."):
        there: Any = getattr(there, part, None)
    if there is not given:
        path = next((name for name, each in vars(home).items() if each is given), "") if home is not None else ""
    named = path and module != "__main__"
    return f"python:{module}:{path}" if named else f"{module}:{getattr(source, '__qualname__', '')}"


def _several(given: Mapping[str, object], block: int, observe: str) -> Driver:
    parts = {name: part for name, each in given.items() if (part := driver_of(each, block, observe)) is not None}
    name = joined({name: part.name for name, part in parts.items()})
    digests = [parts[each].digest for each in sorted(parts)]
    digest = digests[0] if len(digests) == 1 else sha256("".join(digests).encode()).hexdigest()
    drivers = {name: part.given for name, part in parts.items()}
    if not all(isinstance(part, NamedDriver) for part in parts.values()):
        return Driver(drivers, block, observe, name, digest)
    return NamedDriver(drivers, block, observe, name, digest, words={name: part.name for name, part in parts.items()})
