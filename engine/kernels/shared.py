"""Code that many kernels call and none contains: callers read its address from a cell.

A cell is a word of this process with its own symbol. The linker resolves the symbol in all machine code that names it,
so that a caller loaded from the cache works with a function that was compiled later, or elsewhere.
"""

# Internal parts of numba have no types.
# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

import hashlib
from collections.abc import Callable
from ctypes import addressof, c_void_p
from functools import partial, update_wrapper
from importlib import import_module
from typing import Any, NamedTuple, cast, get_type_hints

from llvmlite.binding import add_symbol  # pyright: ignore[reportMissingTypeStubs]
from llvmlite.ir import GlobalVariable  # pyright: ignore[reportMissingTypeStubs]
from numba.core import cgutils, types
from numba.core.imputils import lower_constant
from numba.core.typing.templates import signature
from numba.extending import lower_builtin, models, register_model, typeof_impl


class Shared:
    """A function that has machine code of its own wherever it is called: kernels call it through the address in a cell.

    The machine code of a caller names the cells, not their contents: caller and function are compiled in any order, and
    stored and replaced independently. The type of the result is that of the annotation. A `deferred` function is
    compiled for the first program that needs it; a call before that raises RuntimeError.
    """

    def __init__(self, function: Callable[..., Any], dispatcher: Any, deferred: bool) -> None:
        update_wrapper(self, function)
        self.name = function.__name__
        self.py_func = function
        self.dispatcher = dispatcher
        self.returns = _type_of_annotation(get_type_hints(function)["return"])
        self.is_always_needed = not deferred
        self._needed = not deferred
        self._cells: dict[tuple[Any, ...], c_void_p] = {}
        lower_builtin(self, types.VarArg(types.Any))(partial(_call_through_cell, self))

    def __call__(self, *arguments: Any) -> Any:
        return self.dispatcher(*arguments)

    def need(self) -> None:
        """Compile or load the function for all kernels that call it, now or later."""
        self._needed = True
        for arguments in list(self._cells):
            self._fill(arguments)

    def link(self, arguments: tuple[Any, ...]) -> str:
        """Return the symbol of the cell for arguments of these types; where the function is needed, it is filled."""
        if arguments not in self._cells:
            self._cells[arguments] = cell = c_void_p(0)
            add_symbol(self._symbol(arguments), addressof(cell))
        if self._needed:
            self._fill(arguments)
        return self._symbol(arguments)

    def _fill(self, arguments: tuple[Any, ...]) -> None:
        cell = self._cells[arguments]
        if not cell.value:
            self.dispatcher.compile(arguments)
            compiled = self.dispatcher.overloads[arguments]
            if compiled.signature.return_type != self.returns:
                raise TypeError(f"{self.name} returns {compiled.signature.return_type}, not {self.returns}")
            cell.value = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)

    def _symbol(self, arguments: tuple[Any, ...]) -> str:
        """Return the name of a cell: the same in every process."""
        text = f"{self.__module__}.{self.name}{arguments}"
        return f"cortexc.{self.name}.{hashlib.sha256(text.encode()).hexdigest()[:16]}"


class _SharedType(types.Callable):
    """The numba type of a shared function."""

    def __init__(self, function: Shared) -> None:
        self.function = function
        super().__init__(f"Shared({function.__module__}.{function.name})")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:  # noqa: ARG002
        """Return the signature without literal types, and with all integers as int64: one compilation serves every
        caller.
        """
        if kws:
            raise TypeError(f"{self.function.name}: arguments of shared functions have no names")
        plain = (types.unliteral(each) for each in args)
        return signature(
            self.function.returns, *(types.int64 if each in types.signed_domain else each for each in plain)
        )

    def get_call_signatures(self) -> tuple[list[Any], bool]:
        return [], True

    def get_impl_key(self, sig: Any) -> Shared:  # noqa: ARG002
        return self.function


register_model(_SharedType)(models.OpaqueModel)


@lower_constant(_SharedType)
def _nothing(context: Any, _builder: Any, _type: types.Type, _value: Shared) -> Any:
    """Return the value of a function by name, which has no content."""
    return context.get_dummy_value()


@typeof_impl.register(Shared)
def _type_of_shared(function: Shared, _context: object) -> types.Type:
    return _SharedType(function)


def _type_of_annotation(annotation: Any) -> types.Type:
    plain = {type(None): types.none, bool: types.boolean, int: types.int64, float: types.float64}
    if annotation in plain:
        return plain[annotation]
    hints = get_type_hints(annotation)
    fields = tuple(_type_of_annotation(hints.get(name, float)) for name in annotation._fields)
    return cast("types.Type", types.BaseTuple.from_types(fields, annotation))


def _call_through_cell(function: Shared, context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Call the function at the address in its cell; a cell that is empty raises a RuntimeError."""
    convention = context.call_conv
    pointer = convention.get_function_type(sig.return_type, sig.args).as_pointer()
    symbol = function.link(sig.args)
    cell = builder.module.globals.get(symbol) or GlobalVariable(builder.module, pointer, symbol)
    _uses_of(context.active_code_library).add(_Use(function.__module__, function.name, sig.args))
    code = builder.load(cell)
    with cgutils.if_unlikely(builder, cgutils.is_null(builder, code)):
        message = f"{function.name}: no program was prepared that needs it"
        convention.return_user_exc(builder, RuntimeError, (message,))
    status, result = convention.call_function(builder, code, sig.return_type, sig.args, args)
    with cgutils.if_unlikely(builder, status.is_error):
        convention.return_status_propagate(builder, status)
    return result


class _Use(NamedTuple):
    """A cell that machine code names."""

    module: str
    function: str
    arguments: tuple[Any, ...]
    """Their types."""

    def link(self) -> None:
        """Make the cell, and where the function is needed, compile or load it."""
        getattr(import_module(self.module), self.function).link(self.arguments)


def _uses_of(library: Any) -> set[_Use]:
    """Return the cells that the code of a library itself names."""
    return vars(library).setdefault("uses", set())


def all_uses(library: Any) -> set[_Use]:
    """Return the cells that the code of a library names, with those of all code that it contains."""
    uses: set[_Use] = set()
    libraries, seen = [library], {id(library)}
    while libraries:
        uses |= _uses_of(each := libraries.pop())
        new = [linked for linked in each._linking_libraries if id(linked) not in seen]
        seen |= {id(linked) for linked in new}
        libraries += new
    return uses
