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

from engine.driving.blocks import BLOCK, Driven, Driver
from engine.driving.stacks import file_of, stack_of
from engine.errors import ControllerError, nearest

FORMS = "`python:package.module:function` or `process:COMMAND`"


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
        return named_driver, (self.name, self.block)


def named_driver(name: str, block: int = BLOCK) -> NamedDriver:
    """Load what a name stands for.

    Raises:
        ControllerError: it is no name of a driver, there is no such module or function, or it cannot be loaded.
    """
    kind, _, place = name.partition(":")
    if kind == "process":
        stack = stack_of(place)
        return NamedDriver(stack, block, name, _digest_of(file_of(stack)))
    module, _, function = place.rpartition(":")
    if kind != "python" or not module or not function:
        raise ControllerError(f"`{name}` names no driver", f"write {FORMS}")
    return NamedDriver(_made(_found(_module(module), module, function), name), block, name, _digest(module))


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
            names: list[str] = [each for each in dir(there) if not each.startswith("_")]
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


# -- from Python -------------------------------------------------------------------------------------------------------


def driver_of(given: object, block: int = BLOCK) -> Driver | None:
    """Return who is named from Python: a driver, its name, a controller, or a mapping from names to controllers."""
    if given is None or isinstance(given, Driver):
        return given
    if isinstance(given, str):
        return named_driver(given, block)
    if isinstance(given, Mapping):
        several = cast("Mapping[str, object]", given)
        parts = {name: part for name, each in several.items() if (part := driver_of(each, block)) is not None}
        names = [f"{name}={part.name}" for name, part in parts.items()]
        controllers = {name: part.given for name, part in parts.items()}
        joined = sha256("".join(part.digest for part in parts.values()).encode()).hexdigest()
        return Driver(controllers, block, ", ".join(names), joined)
    source = unwrap(given) if callable(given) else type(given)
    name = f"{getattr(source, '__module__', '')}:{getattr(source, '__qualname__', type(given).__name__)}"
    try:
        place = getsourcefile(source)
    except TypeError:
        place = None
    return Driver(given, block, name, _digest_of(place))
