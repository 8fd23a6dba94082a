"""`frozen`: the classes of `dataclass(frozen=True)`, in a third of the time.

A short command such as `--check` creates hundreds of small classes. `dataclass` writes and compiles six functions for
each of them, which takes longer than reading a scenario; here each class has one function of its own, `__init__`, and
shares the other functions. Modules that no short command imports may use dataclasses.
"""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields
from operator import attrgetter
from typing import Any, NoReturn, TypeVar, dataclass_transform

Class = TypeVar("Class")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: type[Class]) -> type[Class]:
    """Return a frozen dataclass, equal and hashed by its fields. No `__post_init__`, no `init=False`."""
    cls.__doc__ = cls.__doc__ or cls.__name__  # else `dataclass` computes a signature for it
    made = dataclass(init=False, repr=False, eq=False)(cls)
    if hasattr(made, "__post_init__") or not all(each.init for each in fields(made)):  # type: ignore[arg-type]
        raise TypeError(f"{cls.__name__} needs a real dataclass")
    own: dict[str, Any] = {
        "__init__": _init(made),
        "__repr__": _repr,
        "__setattr__": _refuse,
        "__delattr__": _refuse,
        **_comparing(tuple(each.name for each in fields(made) if each.compare)),  # type: ignore[arg-type]
    }
    for name, function in own.items():
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


def _init(cls: Any) -> Callable[..., None]:
    """Return an `__init__` that fills the instance's dictionary without `__setattr__`."""
    every = fields(cls)
    space: dict[str, Any] = {f"_default_{each.name}": _default(each) for each in every if _has_default(each)}
    plain = [_parameter(each) for each in every if not each.kw_only]
    named = [_parameter(each) for each in every if each.kw_only]
    parameters = ", ".join(["self", *plain, *(["*", *named] if named else [])])
    body = "; ".join(f"d[{each.name!r}] = {_value(each)}" for each in every) or "pass"
    exec(f"def __init__({parameters}):\n d = self.__dict__; {body}", space)  # noqa: S102 - names of our own
    return space["__init__"]


def _has_default(each: "Field[Any]") -> bool:
    return each.default is not MISSING or each.default_factory is not MISSING


def _default(each: "Field[Any]") -> Any:
    """Return the default, or its factory, which also marks a value that was not given."""
    return each.default if each.default_factory is MISSING else each.default_factory


def _parameter(each: "Field[Any]") -> str:
    return f"{each.name}=_default_{each.name}" if _has_default(each) else each.name


def _value(each: "Field[Any]") -> str:
    if each.default_factory is MISSING:
        return each.name
    return f"_default_{each.name}() if {each.name} is _default_{each.name} else {each.name}"


def _comparing(names: tuple[str, ...]) -> dict[str, Callable[..., Any]]:
    key = attrgetter(*names) if names else type

    def __eq__(self: object, other: object) -> bool:  # noqa: N807 - becomes the method
        return key(self) == key(other) if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self: object) -> int:  # noqa: N807 - becomes the method
        return hash(key(self))

    return {"__eq__": __eq__, "__hash__": __hash__}


def _repr(self: object) -> str:
    shown = ", ".join(f"{name}={value!r}" for name, value in _shown(self))
    return f"{type(self).__qualname__}({shown})"


def _shown(self: Any) -> Iterator[tuple[str, Any]]:
    for each in fields(self):
        if each.repr:
            yield each.name, getattr(self, each.name)


def _refuse(self: object, name: str, *_value: object) -> NoReturn:
    raise FrozenInstanceError(f"cannot change field {name!r} of {type(self).__name__}")
