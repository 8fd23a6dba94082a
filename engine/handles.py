"""Named tuples of arrays that compiled code takes as one address.

A function of many arrays is expensive to compile: numba passes each array as five to eight words through every call,
and types and lowers all of them wherever the tuple is handed on. A `@handle` tuple is one word in a kernel: the address
of a header that holds the address and the shape of each array, and the numbers. Python code sees an ordinary tuple.

`engine.kernels.handle_types` teaches numba to read the fields.
"""

import struct
from collections.abc import Iterator, Sequence
from numbers import Integral, Real
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Tuple = TypeVar("Tuple", bound=tuple[Any, ...])
WORD = 8
"""Bytes of an entry of a header."""


class Field(NamedTuple):
    """Where a field is in a header, and what it holds."""

    name: str
    kind: str
    """numpy's name of an array's type, such as `<f8`; `int` or `float` of a number; `handle` or `slots`."""
    dimensions: int
    """Of an array; 0 of everything else."""
    word: int
    """Number of its first word: an address, followed by the shape of an array or the number of slots; or the number."""
    layout: "Layout | None"
    """Of a handle in a handle."""


class Layout:
    """The fields of a header: equal layouts are one object, so that the type of a handle is found without a search."""

    numba_type: Any = None
    """Filled by `engine.kernels.handle_types`."""

    def __init__(self, name: str, fields: tuple[Field, ...], words: int) -> None:
        self.name = name
        self.fields = fields
        self.words = words

    def __reduce__(self) -> tuple[Any, ...]:
        return _interned, (self.name, self.fields, self.words)


_layouts: dict[tuple[str, tuple[Field, ...]], Layout] = {}


def _interned(name: str, fields: tuple[Field, ...], words: int) -> Layout:
    return _layouts.setdefault((name, fields), Layout(name, fields, words))


class Handle:
    """The header of a named tuple; made when a kernel first receives the tuple, and never changed."""

    @property
    def handle_header(self) -> NDArray[np.int64]:
        """(words,) addresses and shapes of arrays, and numbers; floats bit by bit.

        Raises TypeError for an array that is not contiguous in memory: kernels are compiled for one layout.
        """
        return self._made[1]

    @property
    def handle_layout(self) -> Layout:
        """The fields of the header."""
        return self._made[0]

    @property
    def handle_address(self) -> int:
        """The address of the header, which lives as long as the tuple."""
        return self._made[2]

    @property
    def _made(self) -> tuple[Layout, NDArray[np.int64], int]:
        try:
            return cast("tuple[Layout, NDArray[np.int64], int]", vars(self)["_handle"])
        except KeyError:
            # Two threads may both make a header: the first one that is stored is that of both.
            return vars(self).setdefault("_handle", self._make_header())

    def _make_header(self) -> tuple[Layout, NDArray[np.int64], int]:
        values = cast("tuple[Any, ...]", self)
        fields: list[Field] = []
        words: list[int] = []
        for name, value in zip(cast("Any", self)._fields, values, strict=True):
            kind, dimensions, inner, content = _words_of(value)
            if not content:
                raise TypeError(f"{type(self).__name__}.{name}: the array is not contiguous and aligned")
            fields.append(Field(name, kind, dimensions, len(words), inner))
            words += content
        header = np.array(words, dtype=np.int64)
        return _interned(type(self).__name__, tuple(fields), len(words)), header, int(header.ctypes.data)

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


def _slots_of(shared: Any, own: dict[str, NDArray[Any]]) -> "Slots[Any]":
    return Slots(shared, **own)


class Slots(Sequence[Tuple]):
    """Handles of one type that share most of their fields: a header each, written for all of them at once."""

    def __init__(self, shared: Tuple | None = None, **own: NDArray[Any]) -> None:
        """`shared` has the fields that all have in common; `own` the others, (slots, ...) of each a row for a slot."""
        self._shared = shared
        self._own = own
        self.headers = np.zeros((0, 0), dtype=np.int64)
        """(slots, words)"""
        if shared is not None:
            common = cast("Handle", shared)
            count = len(next(iter(own.values())))
            self.headers = np.repeat(common.handle_header[np.newaxis], count, axis=0)
            places = {field.name: field for field in common.handle_layout.fields}
            for name, array in own.items():
                word, dimensions = places[name].word, places[name].dimensions
                self.headers[:, word] = array.ctypes.data + array.strides[0] * np.arange(count)
                self.headers[:, word + 1 : word + 1 + dimensions] = array.shape[1:]

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle what the headers are made of: they are written anew."""
        return _slots_of, (self._shared, self._own)

    @property
    def nbytes(self) -> int:
        """Memory of the headers."""
        return self.headers.nbytes

    def __len__(self) -> int:
        return len(self.headers)

    def __getitem__(self, slot: int) -> Tuple:  # type: ignore[override]
        """The tuple of a slot: views of its rows."""
        rows = {name: array[slot] for name, array in self._own.items()}
        return cast("Tuple", cast("Any", self._shared)._replace(**rows))

    def __iter__(self) -> Iterator[Tuple]:
        return (self[slot] for slot in range(len(self)))
