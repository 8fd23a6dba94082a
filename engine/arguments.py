"""Checks of arguments of Python calls: messages contain name, expectation and value."""

from operator import index

from engine.errors import ArgumentError, ArgumentKindError

LEFT_OUT = "leave it out for the default"


def whole(name: str, value: object, least: int) -> int:
    """Return the value if it is a whole number (Python or numpy) of at least `least`.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: it is below `least`.
    """
    try:
        number = None if isinstance(value, bool) else index(value)  # type: ignore[arg-type]
    except TypeError:  # an array of several has the method, too
        number = None
    if number is None:
        raise ArgumentKindError(f"{name}: expected a whole number, got {value!r}", LEFT_OUT)
    if number < least:
        raise ArgumentError(f"{name}: expected {least} or more, got {number}", LEFT_OUT)
    return number
