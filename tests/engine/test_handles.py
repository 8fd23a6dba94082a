"""Named tuples that kernels take as one address."""

import copy
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.handles import Handle, Slots, handle, slotted
from engine.kernels.jit import kernel
from engine.tables import Floats, Ints
from tests.laws import examples


@handle
class Settings(NamedTuple):
    factor: float
    offset: int


@handle
class Tables(NamedTuple):
    values: Floats
    indices: Ints
    settings: Settings


@slotted("own")
class Walker(NamedTuple):
    shared: Floats
    own: Floats
    slots: "Slots[Walker]" = Slots()


@kernel
def weighted_sum(tables: Tables) -> float:
    total = 0.0
    for row in range(tables.values.shape[0]):
        for column in range(tables.values.shape[1]):
            total += tables.values[row, column] * tables.indices[column]
    return tables.settings.factor * total + tables.settings.offset


@kernel
def write_into(tables: Tables, row: int, value: float) -> None:
    tables.values[row, -1] = value


@kernel
def walk(walker: Walker, distance: float) -> float:
    for slot in range(len(walker.slots)):
        one = walker.slots[slot]
        one.own[0] += distance * one.shared[0]
    it = walker
    if len(walker.slots) > 0:
        it = walker.slots[len(walker.slots) - 1]
    return it.own[0]


def tables(rows: int = 2, columns: int = 3, factor: float = 0.5, count: int = 7) -> Tables:
    values = np.arange(float(rows * columns)).reshape(rows, columns) - 2.5
    return Tables(values, np.arange(columns, dtype=np.int32), Settings(factor, count))


@given(st.integers(0, 5), st.integers(1, 5), st.floats(-1e9, 1e9, width=32), st.integers(-(2**62), 2**62))
@examples(50)
def test_a_kernel_reads_what_python_reads(rows: int, columns: int, factor: float, count: int) -> None:
    """Whatever the shapes of the arrays and the numbers are, empty arrays included."""
    given_tables = tables(rows, columns, factor, count)
    expected = factor * float(sum((given_tables.values * given_tables.indices).ravel().tolist())) + count
    assert weighted_sum(given_tables) == expected


def test_a_kernel_writes_into_the_arrays_of_the_tuple() -> None:
    """An index from the end counts from the end."""
    written = tables()
    write_into(written, 1, 9.0)
    assert written.values[1].tolist() == [0.5, 1.5, 9.0]


def test_it_is_a_named_tuple() -> None:
    """With the class and the fields that are written, and the methods of any other."""
    one = tables()
    other = one._replace(settings=Settings(2.0, 0))
    assert isinstance(one, tuple)
    assert type(other) is Tables
    assert Tables._fields == ("values", "indices", "settings")
    assert weighted_sum(other) != weighted_sum(one)
    assert Tables.__doc__


def test_a_replaced_array_is_read_in_its_new_place() -> None:
    """A header belongs to one tuple: the new tuple has another."""
    one = tables()
    weighted_sum(one)
    other = one._replace(values=one.values * 2.0)
    assert weighted_sum(other) - 7 == 2.0 * (weighted_sum(one) - 7)
    assert handle_of(one).handle_address != handle_of(other).handle_address


def test_a_copy_and_a_pickle_are_made_anew() -> None:
    """Addresses mean nothing elsewhere: another process gets the values, and makes its own header."""
    one = tables()
    expected = weighted_sum(one)
    again = pickle.loads(pickle.dumps(one))
    assert handle_of(again).handle_address != handle_of(one).handle_address
    assert handle_of(again).handle_layout is handle_of(one).handle_layout
    for other in (again, copy.copy(one), copy.deepcopy(one)):
        assert weighted_sum(other) == expected


def test_another_process_computes_the_same() -> None:
    """One that is given the pickled tuple and shares no memory."""
    script = "import pickle, sys; from tests.engine.test_handles import weighted_sum; "
    script += "print(weighted_sum(pickle.load(sys.stdin.buffer)))"
    one = tables()
    expected = weighted_sum(one)
    text = pickle.dumps(one).replace(Tables.__module__.encode(), b"tests.engine.test_handles")
    done = subprocess.run([sys.executable, "-c", script], input=text, capture_output=True, check=True)
    assert float(done.stdout) == expected


def test_an_array_that_is_not_contiguous_is_refused_by_name() -> None:
    """Kernels are compiled for one layout; numba would compile them again for any other."""
    values = np.zeros((4, 6))[:, ::2]
    with pytest.raises(TypeError, match=r"Tables\.values: .*contiguous"):
        weighted_sum(tables()._replace(values=values))


def test_threads_share_one_header(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two that ask at the same time get the same: the other one would be lost while a kernel reads it.

    Each thread waits with its header until both have made one.
    """
    make_header, both = Handle._make_header, Barrier(2, timeout=60.0)

    def make_and_wait(self: Handle) -> Any:
        made = make_header(self)
        both.wait()
        return made

    monkeypatch.setattr(Handle, "_make_header", make_and_wait)
    one = tables()
    with ThreadPoolExecutor(2) as pool:
        addresses = list(pool.map(lambda each: handle_of(each).handle_address, [one] * 2))
    assert addresses == [handle_of(one).handle_address] * 2


def test_slots_share_fields_and_have_rows_of_their_own() -> None:
    """A kernel and Python see the same rows."""
    own = np.arange(6.0).reshape(3, 2)
    base = Walker(np.array([10.0]), np.zeros(2))
    walker = base._replace(slots=Slots(base, own=own))
    assert walk(base, 1.0) == 0.0
    assert walk(walker, 1.0) == 14.0
    assert own.tolist() == [[10.0, 1.0], [12.0, 3.0], [14.0, 5.0]]
    assert [slot.own.tolist() for slot in walker.slots] == own.tolist()
    assert len(walker.slots) == 3


def test_a_field_has_one_type_in_all_tuples_that_share_compiled_code() -> None:
    """Arrays of another type or dimension make another type of handle, and code of its own."""
    narrow = tables()._replace(indices=np.arange(3, dtype=np.int64))
    assert weighted_sum(narrow) == weighted_sum(tables())
    assert handle_of(narrow).handle_layout is not handle_of(tables()).handle_layout


def test_a_copy_of_slots_has_rows_of_its_own() -> None:
    """What is done in the copy leaves the original as it is, and the other way round."""
    own = np.arange(6.0).reshape(3, 2)
    base = Walker(np.array([10.0]), np.zeros(2))
    walker = base._replace(slots=Slots(base, own=own))
    for other in (copy.deepcopy(walker), pickle.loads(pickle.dumps(walker))):
        walk(other, 1.0)
        assert own.tolist() == [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]
        assert [slot.own[0] for slot in other.slots] == [10.0, 12.0, 14.0]


def test_an_address_that_cannot_be_read_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal handler may raise while Python computes it: the call raises, and the process goes on."""

    def raising(self: Handle) -> int:
        raise KeyboardInterrupt

    one = tables()
    weighted_sum(one)
    monkeypatch.setattr(Handle, "handle_address", property(raising))
    with pytest.raises(KeyboardInterrupt):
        weighted_sum(one)


@pytest.mark.parametrize("value", ["7", None, 1j])
def test_what_is_no_number_is_refused(value: object) -> None:
    """It would be taken for another number, or for none."""
    with pytest.raises(TypeError, match=type(value).__name__):
        weighted_sum(tables()._replace(settings=Settings(value, 0)))  # type: ignore[arg-type]


def test_python_alone_reads_the_same() -> None:
    """Without the compiler."""
    script = "from tests.engine.test_handles import tables, weighted_sum; print(weighted_sum(tables()))"
    environment: dict[str, Any] = {"NUMBA_DISABLE_JIT": "1", "PATH": ""}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    assert float(done.stdout) == weighted_sum(tables())


def handle_of(value: object) -> Handle:
    assert isinstance(value, Handle)
    return value
