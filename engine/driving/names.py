"""Names of one or several drivers, as on the command line: `--ego python:mine:drive`, `--ego other=process:./s`.

A run stores several names as `ego=python:mine:drive, other=process:./s`, in the order of their controllers' names, and
a single name without its controller. A function, class or object that is given in Python has its name in its module.
"""

import re
import shlex
from collections.abc import Mapping

FORMS = "`python:package.module:function` or `process:COMMAND`"
KINDS = ("python:", "process:")
_OF_CONTROLLER = re.compile(r"(.+?)=((?:python|process):.*)", re.DOTALL)
_BETWEEN = re.compile(r", (?=[^=,]+=(?:python|process):)")

Egos = str | dict[str, str]
"""Driver of the only controller, or of the ego; or a mapping from controllers to drivers."""


def joined(names: Mapping[str, str]) -> str:
    """Return the common name of the drivers of some controllers."""
    if len(names) == 1:
        return next(iter(names.values()))
    return ", ".join(f"{controller}={names[controller]}" for controller in sorted(names))


def parted(name: str) -> Egos:
    """Return the drivers of a name that `joined` returned; the name of a single driver unchanged."""
    parts = [_split(part) for part in _BETWEEN.split(name)]
    several = {controller: driver for controller, driver in parts if controller}
    return several if len(several) == len(parts) else name


def _split(word: str) -> tuple[str, str]:
    """Return the controller, "" if none is named, and its driver."""
    found = None if word.startswith(KINDS) else _OF_CONTROLLER.fullmatch(word)
    return (found[1], found[2]) if found else ("", word)


def words_of(egos: Egos) -> list[str]:
    """Return the command-line words that name these drivers."""
    each = [egos] if isinstance(egos, str) else [f"{controller}={name}" for controller, name in egos.items()]
    return [word for name in each for word in ("--ego", name)]


def as_options(name: str) -> str:
    """Return the command-line options that name these drivers; "" if the command line cannot name them, as objects."""
    egos = parted(name)
    every = (egos,) if isinstance(egos, str) else egos.values()
    return shlex.join(words_of(egos)) if all(each.startswith(KINDS) for each in every) else ""


def driver_hint(name: str) -> str:
    """Return the hint for a driver that has to be named again."""
    options = as_options(name)
    return f"name it again: `{options}`, or `ego` in Python" if options else "name it again in Python, as `ego`"


def added(egos: Egos | None, word: str) -> Egos:
    """Return drivers with one more that is named.

    Raises:
        ValueError: the controller has a driver already, or is not named; with the message as text.
    """
    controller, name = _split(word)
    if egos is None:
        return {controller: name} if controller else name
    if isinstance(egos, str) or not controller:
        bare = egos if isinstance(egos, str) else name
        raise ValueError(f"`{bare}` is for no controller by name; of several write --ego CONTROLLER=NAME for each")
    if controller in egos:
        raise ValueError(f"`{controller}` has a driver already, `{egos[controller]}`")
    return {**egos, controller: name}
