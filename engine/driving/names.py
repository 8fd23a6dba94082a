"""Names of drivers as the command line has them, one or several: `--ego python:mine:drive`, `--ego other=process:./s`.

A run keeps the name of several as `ego=python:mine:drive, other=process:./s`.
"""

import re
import shlex
from collections.abc import Mapping

FORMS = "`python:package.module:function` or `process:COMMAND`"
_ONE = re.compile(r"(?:(\w+)=)?((?:python|process):.*)", re.DOTALL)
_BETWEEN = re.compile(r", (?=\w+=(?:python|process):)")

Egos = str | dict[str, str]
"""The driver of the only controller, or of the ego; or those of several controllers by these."""


def joined(egos: Mapping[str, str]) -> str:
    """The name of several drivers, each with that of its controller."""
    return ", ".join(f"{controller}={name}" for controller, name in egos.items())


def parted(name: str) -> Egos:
    """Inverse of `joined`; a name that is of one driver as it is."""
    parts = [_ONE.fullmatch(part) for part in _BETWEEN.split(name)]
    several = {part[1]: part[2] for part in parts if part and part[1]}
    return several if len(several) == len(parts) else name


def words_of(egos: Egos) -> list[str]:
    """The words of a command line that name these drivers."""
    each = [egos] if isinstance(egos, str) else [f"{controller}={name}" for controller, name in egos.items()]
    return [word for name in each for word in ("--ego", name)]


def as_options(name: str) -> str:
    """The options of a command line for who has this name."""
    return shlex.join(words_of(parted(name)))


def added(egos: Egos | None, word: str) -> Egos | None:
    """Return drivers with one more that is named; None where that is one too many: two, of which one has no name of a
    controller, or the same, or two of one controller.
    """
    found = _ONE.fullmatch(word)
    controller, name = (found[1], found[2]) if found else (None, word)
    if controller is None:
        return name if egos is None else None
    before = {} if egos is None else egos
    return None if isinstance(before, str) or controller in before else {**before, controller: name}
