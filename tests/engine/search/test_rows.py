"""What grows with a search, against the plain way to do the same: rows of blocks, different genomes, numbers of codes,
members of a pool, the digest of the pace.
"""

import sqlite3
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from engine.assessment import Rows, concatenate, map_arrays, with_room
from engine.search import evaluations
from engine.search.chain import Pace, _digest  # pyright: ignore[reportPrivateUsage]
from engine.search.evaluations import first_alike
from engine.search.insight.diversity import _different  # pyright: ignore[reportPrivateUsage]
from engine.search.insight.kinds import numbered
from engine.search.methods.ga import _Pool  # pyright: ignore[reportPrivateUsage]
from engine.search.statistics import spread_evenly
from engine.tables import Floats, Ints

VALUES = st.sampled_from([0.0, -0.0, 1.0, -1.0, float("nan"), float("inf"), 5e-324])
GENOMES = arrays.arrays(np.float64, st.tuples(st.integers(0, 30), st.integers(0, 3)), elements=VALUES)


@dataclass(frozen=True)
class Inner:
    wide: Floats


@dataclass(frozen=True)
class Block:
    numbers: Ints
    inner: Inner


def block(first: int, count: int) -> Block:
    numbers = np.arange(first, first + count, dtype=np.int32)
    return Block(numbers, Inner(np.stack([numbers * 0.5, -numbers], axis=1).astype(np.float64)))


@given(st.lists(st.integers(0, 40), min_size=1, max_size=12))
def test_rows_of_blocks_are_those_of_one_table(sizes: list[int]) -> None:
    """After each block, the table is that of all blocks so far; earlier tables keep their rows."""
    rows, blocks, tables, end = Rows[Block](), list[Block](), list[Block](), 0
    for size in sizes:
        blocks.append(block(end, size))
        rows.put(blocks[-1], end)
        end += size
        tables.append(rows.table(end))
    for count, table in enumerate(tables, start=1):
        whole = concatenate(blocks[:count])
        assert (table.numbers.dtype, table.inner.wide.shape) == (whole.numbers.dtype, whole.inner.wide.shape)
        assert table.numbers.tolist() == whole.numbers.tolist()
        assert table.inner.wide.tolist() == whole.inner.wide.tolist()


@given(st.integers(1, 20), st.integers(0, 30), st.lists(st.integers(0, 9), max_size=6))
def test_rows_that_are_there_already_stay_where_they_are(there: int, room: int, sizes: list[int]) -> None:
    """With room behind them no row is copied as long as it suffices; the table is that of all blocks either way."""
    first = map_arrays(block(0, there), lambda each: each)
    wide = np.asarray(with_room(first.inner.wide, there + room))
    first = Block(with_room(first.numbers, there + room)[:there], Inner(wide[:there]))
    rows, end = Rows(first), there
    rows.put(first, 0)
    for size in sizes:
        rows.put(block(end, size), end)
        end += size
    whole, table = block(0, end), rows.table(end)
    assert (table.numbers.tolist(), table.inner.wide.tolist()) == (whole.numbers.tolist(), whole.inner.wide.tolist())
    assert (first.numbers.tolist(), len(first.numbers)) == (list(range(there)), there)
    assert np.shares_memory(table.inner.wide, wide) == (end <= there + room)


@pytest.mark.parametrize("mix", [evaluations.MIX, (0, 0)])
@given(genomes=GENOMES)
def test_rows_are_alike_that_have_the_same_bytes(mix: tuple[int, int], genomes: Floats) -> None:
    """Also where all genomes have one number, as those of one in 10^19 pairs have."""
    first: dict[bytes, int] = {}
    alike = [first.setdefault(bytes(genome), row) for row, genome in enumerate(genomes)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluations, "MIX", mix)
        assert first_alike(genomes).tolist() == alike


@given(GENOMES)
def test_different_points_are_those_of_numpy(places: Floats) -> None:
    places = np.nan_to_num(places, posinf=2.0)
    assert np.array_equal(_different(places), np.unique(places, axis=0))


@given(arrays.arrays(np.int64, st.tuples(st.integers(0, 30), st.integers(1, 4)), elements=st.integers(-3, 9)))
def test_numbers_have_the_order_of_their_rows(codes: Ints) -> None:
    numbers = numbered(codes)
    rows = codes.tolist()
    for a, one in zip(rows, numbers.tolist(), strict=True):
        for b, other in zip(rows, numbers.tolist(), strict=True):
            assert (a < b) == (one < other)


@given(st.lists(st.integers(0, 3), min_size=1, max_size=20))
def test_others_are_those_with_another_genome(genes: list[int]) -> None:
    genomes = tuple((float(gene),) for gene in genes)
    pool = _Pool(genomes=genomes, different=len(set(genomes)))
    for member, genome in enumerate(genomes):
        assert list(pool.others(member)) == [other for other, each in enumerate(genomes) if each != genome]


@given(st.integers(0, 50), st.integers(1, 60))
def test_numbers_are_spread_evenly(count: int, most: int) -> None:
    found = spread_evenly(count, most).tolist()
    assert len(found) == min(count, most)
    assert found == list(range(count)) or (found[0], found[-1]) == (0, count - 1 if most > 1 else 0)
    gaps = np.diff(found)
    assert not len(gaps) or gaps.max() - gaps.min() <= 1


@given(st.lists(st.booleans(), max_size=12))
def test_the_digest_of_the_pace_is_that_of_all_its_rows(committed: list[bool]) -> None:
    """Also after transactions that were rolled back, whose generation is written again with another time."""
    pace, seconds = Pace(), 0.0
    connection = sqlite3.connect(":memory:", isolation_level=None)
    connection.execute("CREATE TABLE pace (generation INTEGER PRIMARY KEY, seconds REAL NOT NULL)")
    for stays in committed:
        seconds += 0.1
        generation = connection.execute("SELECT count(*) FROM pace").fetchone()[0]
        connection.execute("BEGIN")
        connection.execute("INSERT INTO pace VALUES (?, ?)", (generation, seconds))
        rows = connection.execute("SELECT generation, seconds FROM pace ORDER BY generation").fetchall()
        assert pace.digest(connection) == _digest(rows)
        connection.execute("COMMIT" if stays else "ROLLBACK")
    rows = connection.execute("SELECT generation, seconds FROM pace ORDER BY generation").fetchall()
    assert pace.digest(connection) == _digest(rows)
