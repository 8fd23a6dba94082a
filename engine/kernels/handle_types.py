"""The numba type of a handle (`engine.handles`): one word, whose fields are read when code names them.

A header does not change while a kernel runs, so its words are loaded with `!invariant.load`: LLVM reads each once, and
not again after every write to an array.
"""

# Internal parts of numba have no types.
# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

import hashlib
import operator
from typing import Any, cast

import numpy as np
from llvmlite import ir  # pyright: ignore[reportMissingTypeStubs]
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import (
    NativeValue,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)
from numba.np.numpy_support import from_dtype

from engine.handles import WORD, Field, Handle, Layout

WORDS = ir.IntType(64)
register_typing = cast("Any", infer_global)
NUMBERS = {"int": types.int64, "float": types.float64}


class HandleType(types.Type):
    """Type of the handles of a layout. Its name, a part of compiled symbols, has a digest of the layout."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.fields = {field.name: field for field in layout.fields}
        super().__init__(f"{layout.name}_{_digest(layout)}")

    def type_of(self, field: Field) -> types.Type:
        """Return the type of a field's value in compiled code."""
        if field.kind == "slots":
            return SlotsType(self)
        if field.layout is not None:
            return handle_type(field.layout)
        if field.kind in NUMBERS:
            return NUMBERS[field.kind]
        return types.Array(from_dtype(np.dtype(field.kind)), field.dimensions, "C")


class SlotsType(types.Type):
    """The slots of a handle."""

    def __init__(self, element: HandleType) -> None:
        self.element = element
        super().__init__(f"slots_{element.name}")


def handle_type(layout: Layout) -> HandleType:
    """Return the only type of a layout."""
    if layout.numba_type is None:
        layout.numba_type = HandleType(layout)
    return cast("HandleType", layout.numba_type)


def _digest(layout: Layout) -> str:
    fields = [(*field[:4], field.layout and _digest(field.layout), field.own) for field in layout.fields]
    return hashlib.sha256(repr(fields).encode()).hexdigest()[:12]


@register_model(HandleType)
class _HandleModel(models.OpaqueModel):
    """The address of a header."""


@register_model(SlotsType)
class _SlotsModel(models.OpaqueModel):
    """The address of the header of the handle with the slots, which holds their number and place."""


@typeof_impl.register(Handle)
def _type_of_handle(value: Handle, _context: object) -> types.Type:
    return handle_type(value.handle_layout)


@unbox(HandleType)
def _unbox(_type: HandleType, value: Any, c: Any) -> NativeValue:
    """Read the address; where a signal handler raises meanwhile, the call fails with its exception."""
    address = c.pyapi.object_getattr_string(value, "handle_address")
    failed = cgutils.is_null(c.builder, address)
    number = cgutils.alloca_once_value(c.builder, c.context.get_constant_null(types.voidptr))
    with cgutils.if_likely(c.builder, c.builder.not_(failed)):
        c.builder.store(c.pyapi.long_as_voidptr(address), number)
        c.pyapi.decref(address)
    return NativeValue(c.builder.load(number), is_error=failed)


@infer_getattr
class _Fields(AttributeTemplate):
    key = HandleType

    def generic_resolve(self, of: HandleType, attribute: str) -> types.Type | None:
        field = of.fields.get(attribute)
        return None if field is None else of.type_of(field)


@lower_getattr_generic(HandleType)
def _read_field(context: Any, builder: Any, of: HandleType, value: Any, attribute: str) -> Any:
    field = of.fields[attribute]
    kind = cast("Any", of.type_of(field))
    if field.kind == "slots":
        return value
    header = _header(builder, of, value)
    first = _word(builder, value, field.own) if field.own else _word(builder, header, field.word)
    if field.layout is not None:
        return builder.inttoptr(first, value.type)
    if field.kind == "int":
        return first
    if field.kind == "float":
        return builder.bitcast(first, ir.DoubleType())
    array = context.make_array(kind)(context, builder)
    size = np.dtype(field.kind).itemsize
    shape = [_word(builder, header, field.word + 1 + axis) for axis in range(field.dimensions)]
    strides = [WORDS(size)]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    data = builder.inttoptr(first, array.data.type)
    context.populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return impl_ret_borrowed(context, builder, kind, array._getvalue())


def _header(builder: Any, of: HandleType, value: Any) -> Any:
    """Return the address of the header, which slots share."""
    return builder.inttoptr(_word(builder, value, 0), value.type) if of.layout.own_words else value


def _word(builder: Any, header: Any, number: int) -> Any:
    """Load a word of a header, or of those before it."""
    words = builder.bitcast(header, WORDS.as_pointer())
    loaded = builder.load(builder.gep(words, [WORDS(number)]), align=WORD)
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


def _slots_field(of: SlotsType) -> Field:
    return next(field for field in of.element.layout.fields if field.kind == "slots")


@register_typing(operator.getitem)
class _SlotOf(AbstractTemplate):
    def generic(self, args: tuple[types.Type, ...], kws: dict[str, Any]) -> Any:
        if not kws and isinstance(args[0], SlotsType) and isinstance(args[1], types.Integer):
            return signature(args[0].element, args[0], types.int64)
        return None


@lower_builtin(operator.getitem, SlotsType, types.int64)
def _slot_of(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
    element = sig.args[0].element
    size = WORDS(WORD * element.layout.own_words)
    first = _word(builder, _header(builder, element, args[0]), _slots_field(sig.args[0]).word)
    return builder.inttoptr(builder.add(first, builder.mul(args[1], size)), args[0].type)


@register_typing(len)
class _NumberOfSlots(AbstractTemplate):
    def generic(self, args: tuple[types.Type, ...], kws: dict[str, Any]) -> Any:
        return signature(types.int64, args[0]) if not kws and isinstance(args[0], SlotsType) else None


@lower_builtin(len, SlotsType)
def _number_of_slots(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
    header = _header(builder, sig.args[0].element, args[0])
    return _word(builder, header, _slots_field(sig.args[0]).word + 1)
