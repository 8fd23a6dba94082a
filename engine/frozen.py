"""`frozen`: dataclasses whose fields are set once, in a third of the time that `dataclass(frozen=True)` takes.

A short command such as `--check` creates hundreds of small classes. `dataclass(frozen=True)` writes and compiles six
functions for each of them: 1.3 times the CPU time of `--check`. Here it writes `__init__` alone, and all classes share
the other functions. Modules that no short command imports may use dataclasses.
"""

from collections.abc import Callable
from dataclasses import FrozenInstanceError, dataclass, field, fields
from operator import attrgetter
from typing import Any, NoReturn, TypeVar, dataclass_transform

Class = TypeVar("Class")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: type[Class]) -> type[Class]:
    """Return a dataclass, equal and hashed by its fields, which are set once: by `__init__` or `__post_init__`."""
    cls.__doc__ = cls.__doc__ or cls.__name__  # else `dataclass` computes a signature for it
    made = dataclass(repr=False, eq=False)(cls)
    shared: dict[str, Any] = {
        "__repr__": _repr,
        "__setattr__": _set_once,
        "__delattr__": _refuse,
        **_comparing(tuple(each.name for each in fields(made) if each.compare)),  # type: ignore[arg-type]
    }
    for name, function in shared.items():
        if name not in made.__dict__:
            setattr(made, name, function)
    return made


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def frozen_identity(cls: type[Class]) -> type[Class]:
    """Return a frozen dataclass whose objects are equal only to themselves."""
    made = frozen(cls)
    made.__eq__ = object.__eq__  # type: ignore[method-assign]
    made.__hash__ = object.__hash__  # type: ignore[method-assign]
    return made


def _comparing(names: tuple[str, ...]) -> dict[str, Callable[..., Any]]:
    key = attrgetter(*names) if names else type

    def __eq__(self: object, other: object) -> bool:  # noqa: N807 - becomes the method
        return key(self) == key(other) if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self: object) -> int:  # noqa: N807 - becomes the method
        return hash(key(self))

    return {"__eq__": __eq__, "__hash__": __hash__}


def _repr(self: Any) -> str:
    shown = ", ".join(f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
    return f"{type(self).__qualname__}({shown})"


def _set_once(self: Any, name: str, value: object) -> None:
    if name in self.__dict__ or name not in self.__dataclass_fields__:
        _refuse(self, name)
    self.__dict__[name] = value


def _refuse(self: object, name: str) -> NoReturn:
    raise FrozenInstanceError(f"cannot change field {name!r} of {type(self).__name__}")
