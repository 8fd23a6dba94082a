"""A driver by the name that the command line has for it: `python:package.module:function` or `process:COMMAND`.

Code is named on the command line or in Python and nowhere else. No file of a scenario, no manifest and no journal makes
anything run: what they keep is a name and a digest, to be compared with what is named again.
"""

import importlib
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from hashlib import sha256
from inspect import getsourcefile, unwrap
from pathlib import Path
from typing import Any, cast

from engine.config import Drives
from engine.driving.blocks import BLOCK, Driven, Driver
from engine.driving.controllers import controllers_of
from engine.driving.decisions import KeptActions, Recorder
from engine.driving.names import FORMS, joined, parted
from engine.driving.stacks import file_of, stack_of
from engine.errors import ControllerError, nearest
from engine.program import Program
from engine.vocabulary import RECORDS


@dataclass(frozen=True, eq=False)
class NamedDriver(Driver):
    """One that can be loaded again, in another process too."""

    def drive(self, *given: Any, **named: Any) -> Driven:
        """Drive all valid scenes (`Driver.drive`). What a function prints is no output of the command: it goes to
        stderr.
        """
        with redirect_stdout(sys.stderr):
            return super().drive(*given, **named)

    def __reduce__(self) -> tuple[Any, ...]:
        return driver_of, (parted(self.name), self.block, self.observe)


def named_driver(name: str, block: int = BLOCK, observe: str = RECORDS) -> NamedDriver:
    """Load what a name stands for.

    Raises:
        ControllerError: it is no name of a driver, there is no such module or function, or it cannot be loaded.
    """
    kind, _, place = name.partition(":")
    if kind == "process":
        stack = stack_of(place)
        return NamedDriver(stack, block, observe, name, _digest_of(file_of(stack)))
    module, _, function = place.rpartition(":")
    if kind != "python" or not module or not function:
        raise ControllerError(f"`{name}` names no driver", f"write {FORMS}")
    given = _made(_found(_module(module), module, function), name)
    return NamedDriver(given, block, observe, name, _digest(module))


def _module(name: str) -> Any:
    """Import a module; the folder in which the command runs counts, as for `python -m`."""
    if name.endswith(".py") or "/" in name:
        dotted = ".".join(part for part in Path(name).with_suffix("").parts if part.isidentifier())
        raise ControllerError(f"`{name}` is a file and no module", f"write `python:{dotted or 'module'}:function`")
    here = str(Path.cwd())
    if here not in sys.path and "" not in sys.path:
        sys.path.insert(0, here)
    try:
        with redirect_stdout(sys.stderr):
            return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(f"{error.name}.")):
            raise ControllerError(
                f"there is no module `{name}` here", f"name one that `python -c 'import {name}'` finds"
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
    """A class stands for an object of it."""
    if not isinstance(thing, type):
        return thing
    try:
        return thing()
    except Exception as error:
        raise ControllerError(
            f"`{name}` is a class that cannot be made: {type(error).__name__}: {error}",
            "let it be made without arguments, or name a function",
        ) from error


def _digest(module: str) -> str:
    """SHA-256 of the file of a module; "" where it has none."""
    place = getattr(sys.modules[module], "__file__", None)
    return _digest_of(place)


def _digest_of(place: str | None) -> str:
    return "" if place is None or not Path(place).is_file() else sha256(Path(place).read_bytes()).hexdigest()


# -- several, and from Python -----------------------------------------------------------------------------------------


def driver_for(program: Program, given: object, block: int = BLOCK, observe: str = RECORDS) -> Drives | None:
    """Return who is named (`driver_of`), or what is kept of one; all controllers of the program have theirs.

    Raises:
        ControllerError: they have not.
    """
    if isinstance(given, KeptActions | Recorder):
        return given
    driver = driver_of(given, block, observe)
    if driver is not None:
        controllers_of(program, driver.given)
    return driver


def driver_of(given: object, block: int = BLOCK, observe: str = RECORDS) -> Driver | None:
    """Return who is named: a driver, its name, a controller, or a mapping from names of controllers to these."""
    if given is None or isinstance(given, Driver):
        return given
    if isinstance(given, str):
        return named_driver(given, block, observe)
    if isinstance(given, Mapping):
        return _several(cast("Mapping[str, object]", given), block, observe)
    source = unwrap(given) if callable(given) else type(given)
    name = f"{getattr(source, '__module__', '')}:{getattr(source, '__qualname__', type(given).__name__)}"
    try:
        place = getsourcefile(source)
    except TypeError:
        place = None
    return Driver(given, block, observe, name, _digest_of(place))


def _several(given: Mapping[str, object], block: int, observe: str) -> Driver:
    parts = {name: part for name, each in given.items() if (part := driver_of(each, block, observe)) is not None}
    kind = NamedDriver if all(isinstance(part, NamedDriver) for part in parts.values()) else Driver
    names = joined({name: part.name for name, part in parts.items()})
    digest = sha256("".join(part.digest for part in parts.values()).encode()).hexdigest()
    return kind({name: part.given for name, part in parts.items()}, block, observe, names, digest)
