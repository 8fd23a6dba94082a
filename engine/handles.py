"""Named tuples of arrays that compiled code takes as one address.

A function of many arrays is expensive to compile: numba passes each array as five to eight words through every call,
and types and lowers all of them wherever the tuple is passed on. A `@handle` tuple is one word in a kernel: the address
of a header that holds the address and the shape of each array, and the numbers. Python code sees an ordinary tuple.

`engine.kernels.handle_types` teaches numba to read the fields.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from numbers import Integral, Real
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Tuple = TypeVar("Tuple", bound=tuple[Any, ...])
WORD = 8
"""Size of an entry of a header [bytes]."""


class Field(NamedTuple):
    """Position and type of a field in a header."""

    name: str
    kind: str
    """numpy's name of an array's type, such as `<f8`; `int` or `float` for a number; `handle` or `slots`."""
    dimensions: int
    """Number of dimensions of an array; 0 for all other kinds."""
    word: int
    """Number of its first word: an address, followed by the shape of an array or the number of slots; or the number."""
    layout: "Layout | None"
    """Layout of a handle within a handle."""
    own: int = 0
    """Number of the word before the header with the address of the slot's own array; else 0."""


class Layout:
    """The fields of a header: equal layouts are one object, so that the type of a handle is found without a search."""

    numba_type: Any = None
    """Filled by `engine.kernels.handle_types`."""

    def __init__(self, name: str, fields: tuple[Field, ...]) -> None:
        self.name = name
        self.fields = fields
        own = sum(field.own > 0 for field in fields)
        self.own_words = own + 1 if own else 0
        """Words before the header: its address, then the addresses of the arrays that each slot has to itself."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _interned, (self.name, self.fields)


_layouts: dict[tuple[str, tuple[Field, ...]], Layout] = {}


def _interned(name: str, fields: tuple[Field, ...]) -> Layout:
    return _layouts.setdefault((name, fields), Layout(name, fields))


class Handle:
    """The header of a named tuple; made when a kernel first receives the tuple, and never changed."""

    own_fields: tuple[str, ...] = ()
    """Arrays that each slot has separately (`slotted`)."""

    @property
    def handle_header(self) -> NDArray[np.int64]:
        """Return (words,) the addresses and shapes of arrays, and numbers, floats bit by bit; before them
        `Layout.own_words`.
        """
        return self._made[1]

    @property
    def handle_layout(self) -> Layout:
        """Return the fields of the header."""
        return self._made[0]

    @property
    def handle_address(self) -> int:
        """Return the address of the first word, which is valid as long as the tuple exists."""
        return self._made[2]

    @property
    def _made(self) -> tuple[Layout, NDArray[np.int64], int]:
        try:
            return cast("tuple[Layout, NDArray[np.int64], int]", vars(self)["_handle"])
        except KeyError:
            # Two threads may both make a header: both use the header that is stored first.
            return vars(self).setdefault("_handle", self._make_header())

    def _make_header(self) -> tuple[Layout, NDArray[np.int64], int]:
        values = cast("tuple[Any, ...]", self)
        fields: list[Field] = []
        words: list[int] = []
        for name, value in zip(cast("Any", self)._fields, values, strict=True):
            kind, dimensions, inner, content = _words_of(value)
            if not content:
                raise TypeError(f"{type(self).__name__}.{name}: the array is not contiguous and aligned")
            own = self.own_fields.index(name) + 1 if name in self.own_fields else 0
            fields.append(Field(name, kind, dimensions, len(words), inner, own))
            words += content
        layout = _interned(type(self).__name__, tuple(fields))
        header = np.array([0] * layout.own_words + words, dtype=np.int64)
        address = int(header.ctypes.data)
        if layout.own_words:
            header[0] = address + WORD * layout.own_words
            for field in fields:
                if field.own:
                    header[field.own] = words[field.word]
        return layout, header, address

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the values alone: addresses have no meaning in another process."""
        return type(self), tuple(cast("tuple[Any, ...]", self))


def _words_of(value: Any) -> tuple[str, int, Layout | None, list[int]]:
    """Return kind, dimensions, layout and words of a field; no words for an array that kernels do not take."""
    if isinstance(value, np.ndarray):
        array = cast("NDArray[Any]", value)
        plain = array.flags.c_contiguous and array.flags.aligned
        address = array.__array_interface__["data"][0]
        return array.dtype.str, array.ndim, None, [address, *array.shape] if plain else []
    if isinstance(value, Handle):
        return "handle", 0, value.handle_layout, [value.handle_address]
    if isinstance(value, Slots):
        headers = cast("Slots[Any]", value).headers
        return "slots", 0, None, [headers.ctypes.data, len(headers)]
    if isinstance(value, Integral):
        return "int", 0, None, [int(value)]
    if isinstance(value, Real):
        return "float", 0, None, [struct.unpack("<q", struct.pack("<d", float(value)))[0]]
    raise TypeError(f"kernels take arrays, numbers and handles, and this is {type(value).__name__}")


def handle(tuple_class: type[Tuple]) -> type[Tuple]:
    """Let kernels take the instances of a named tuple as one address. Its fields are arrays, numbers and handles."""
    names = {
        "__doc__": tuple_class.__doc__,
        "__module__": tuple_class.__module__,
        "__qualname__": tuple_class.__qualname__,
    }
    return cast("type[Tuple]", type(tuple_class.__name__, (Handle, tuple_class), names))


def slotted(*own_fields: str) -> Callable[[type[Tuple]], type[Tuple]]:
    """Return `handle` for a named tuple whose `Slots` share all fields except the arrays named here."""

    def decorate(tuple_class: type[Tuple]) -> type[Tuple]:
        made = handle(tuple_class)
        cast("Any", made).own_fields = own_fields
        return made

    return decorate


def _slots_of(shared: Any, own: dict[str, NDArray[Any]]) -> "Slots[Any]":
    return Slots(shared, **own)


class Slots(Sequence[Tuple]):
    """Handles of one type that share a header: each has only the addresses of its own arrays."""

    def __init__(self, shared: Tuple | None = None, **own: NDArray[Any]) -> None:
        """Create handles; `shared` has the common fields and the shapes of the own arrays, `own` their rows (slots,
        ...).

        Raises TypeError for fields other than those that the class names (`slotted`), and for rows of another shape.
        """
        self._shared = shared
        self._own = own
        self.headers = np.zeros((0, 0), dtype=np.int64)
        """(slots, `Layout.own_words`)"""
        if shared is not None:
            common = cast("Handle", shared)
            if set(own) != set(common.own_fields):
                raise TypeError(f"slots of {type(shared).__name__} have {', '.join(common.own_fields)} of their own")
            count = len(next(iter(own.values())))
            self.headers = np.repeat(common.handle_header[np.newaxis, : common.handle_layout.own_words], count, axis=0)
            for word, name in enumerate(common.own_fields, start=1):
                rows, pattern = own[name], getattr(shared, name)
                if (rows.shape[1:], rows.dtype, len(rows)) != (pattern.shape, pattern.dtype, count):
                    raise TypeError(f"{name}: rows of {rows.shape[1:]} and {rows.dtype}, not {pattern.shape}")
                self.headers[:, word] = rows.ctypes.data + rows.strides[0] * np.arange(count)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the parts of the headers, which are written again in a copy."""
        return _slots_of, (self._shared, self._own)

    @property
    def nbytes(self) -> int:
        """Return the memory of the headers [bytes]."""
        return self.headers.nbytes

    def __len__(self) -> int:
        return len(self.headers)

    def __getitem__(self, slot: int) -> Tuple:  # type: ignore[override]
        """Return the tuple of a slot: views of its rows."""
        rows = {name: array[slot] for name, array in self._own.items()}
        return cast("Tuple", cast("Any", self._shared)._replace(**rows))

    def __iter__(self) -> Iterator[Tuple]:
        return (self[slot] for slot in range(len(self)))
