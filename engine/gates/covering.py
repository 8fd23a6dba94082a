"""Covering arrays: few rows of cells that hold every combination of the cells of any `ways` domains. Plain numpy.

Rows are made one after the other. Each begins with a combination that no row holds yet; the other domains follow one by
one, with the cell that completes the most new combinations. Several candidates are made side by side, and the best one
becomes a row. Source: Cohen, Dalal, Fredman and Patton (1997), "The AETG system: an approach to testing based on
combinatorial design", IEEE Transactions on Software Engineering 23(7).
"""

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import prod

import numpy as np
from numpy.random import Generator, default_rng

from engine.frozen import frozen
from engine.tables import Bools, Ints

ANY = -1
"""Place of a domain in which a row may have any value."""
CANDIDATES = 32
"""Candidates for a row."""
WORK = 3_000_000
"""Look-ups that may be spent on further arrays, of which the smallest is taken."""
MOST_ARRAYS = 40

Combination = tuple[tuple[int, ...], tuple[int, ...]]
"""Domains in ascending order, and a cell of each."""


def covering_array(sizes: Sequence[int], ways: int, forbidden: Iterable[Combination] = (), seed: int = 0) -> Ints:
    """Return (rows, domains) cells, or `ANY`, such that each combination of cells of `ways` domains is in some row.

    No row holds a forbidden combination of at most `ways` domains, and combinations with a forbidden part are left out.
    A combination that no cells of another domain fit has `ANY` there.

    Args:
        sizes: (domains,) number of cells of each domain.
        ways: number of domains of a combination, at most all of them.
        forbidden: combinations that cannot be.
        seed: seed of the candidates.
    """
    space = _Space(tuple(sizes), ways, _tables(sizes, ways, forbidden))
    best = _array(space, None)
    least = max((int(open_.sum()) for open_ in space.open().values()), default=0)
    effort = len(best) * prod(range(len(sizes) - ways + 1, len(sizes) + 1)) * CANDIDATES
    for number in range(min(MOST_ARRAYS, WORK // max(1, effort) + 1)):
        if len(best) <= least:
            break
        other = _array(space, default_rng([seed, number]))
        best = other if len(other) < len(best) else best
    return best


@frozen
class _Space:
    """Domains, and what they may not hold together."""

    sizes: tuple[int, ...]
    ways: int
    forbidden: dict[tuple[int, ...], Bools]
    """Tables of combinations by their domains; domains without one are not listed."""

    def open(self) -> dict[tuple[int, ...], Bools]:
        """Return the combinations that rows must hold, by their domains."""
        found: dict[tuple[int, ...], Bools] = {}
        for domains in combinations(range(len(self.sizes)), self.ways):
            table = np.ones([self.sizes[domain] for domain in domains], dtype=bool)
            for part, never in self.forbidden.items():
                if set(part) <= set(domains):
                    shape = [self.sizes[domain] if domain in part else 1 for domain in domains]
                    table &= ~never.reshape(shape)
            found[domains] = table
        return found


def _tables(sizes: Sequence[int], ways: int, forbidden: Iterable[Combination]) -> dict[tuple[int, ...], Bools]:
    tables: dict[tuple[int, ...], Bools] = {}
    for domains, cells in forbidden:
        if len(domains) > ways:
            raise ValueError(f"a forbidden combination has {len(domains)} domains, more than {ways}")
        table = tables.setdefault(domains, np.zeros([sizes[domain] for domain in domains], dtype=bool))
        table[cells] = True
    return tables


def _array(space: _Space, draws: Generator | None) -> Ints:
    """Return one array; without `draws` equal choices are made in order, which suits equal sizes of a prime power."""
    open_ = space.open()
    left = {domains: int(table.sum()) for domains, table in open_.items()}
    rows: list[Ints] = []
    while any(left.values()):
        most = max(left.values())
        fullest = [domains for domains, count in left.items() if count == most]
        domains = fullest[0 if draws is None else int(draws.integers(len(fullest)))]
        row = _row(space, open_, domains, draws)
        rows.append(row)
        for each, table in open_.items():
            cells = tuple(row[list(each)].tolist())
            if min(cells) >= 0 and table[cells]:
                table[cells] = False
                left[each] -= 1
    return _without_spare(space, np.array(rows, dtype=np.int64).reshape(-1, len(space.sizes)))


def _row(space: _Space, open_: dict[tuple[int, ...], Bools], domains: tuple[int, ...], draws: Generator | None) -> Ints:
    """Return the best candidate that begins with an open combination of these domains."""
    begins = np.argwhere(open_[domains])
    count = min(CANDIDATES, len(begins)) if draws is None else CANDIDATES
    chosen = begins[:1] if draws is None else begins[draws.integers(len(begins), size=count)]
    rows = np.full((len(chosen), len(space.sizes)), ANY, dtype=np.int64)
    rows[:, domains] = chosen
    others = [domain for domain in range(len(space.sizes)) if domain not in domains]
    if draws is not None:
        draws.shuffle(others)
    gained, known = np.ones(len(rows), dtype=np.int64), list(domains)
    for domain in others:
        gains = np.zeros((len(rows), space.sizes[domain]), dtype=np.int64)
        for part in combinations(sorted(known), space.ways - 1):
            gains += _looked_up(open_[tuple(sorted((*part, domain)))], part, domain, rows)
        gains = np.where(_fitting(space, known, domain, rows), gains, -1)
        ties = gains if draws is None else gains + draws.random(gains.shape) * 0.5
        cells = ties.argmax(axis=1)
        gain = gains[np.arange(len(rows)), cells]
        rows[:, domain] = np.where(gain < 0, ANY, cells)
        gained += np.maximum(gain, 0)
        known.append(domain)
    return rows[int(gained.argmax())]


def _looked_up(table: Bools, part: Sequence[int], domain: int, rows: Ints) -> Bools:
    """Return (n, cells) the entries of a table at the cells of each row, for all cells of `domain`; `ANY` has none."""
    axis = sum(each < domain for each in part)
    if not part:
        return np.tile(table, (len(rows), 1))
    cells = tuple(rows[:, each] for each in part)
    found = np.moveaxis(table, axis, -1)[cells]
    free = np.logical_or.reduce([each < 0 for each in cells])
    return found & ~free[:, np.newaxis] if free.any() else found


def _fitting(space: _Space, known: Sequence[int], domain: int, rows: Ints) -> Bools:
    """Return (n, cells) the cells of `domain` that are not forbidden beside those of each row."""
    fits = np.ones((len(rows), space.sizes[domain]), dtype=bool)
    for domains, never in space.forbidden.items():
        if domain in domains:
            part = [each for each in domains if each != domain]
            if set(part) <= set(known):
                fits &= ~_looked_up(never, part, domain, rows)
    return fits


def _without_spare(space: _Space, rows: Ints) -> Ints:
    """Return the rows without those whose combinations are all in other rows; the last ones go first."""
    counts = {domains: np.zeros(table.shape, dtype=np.int64) for domains, table in space.open().items()}
    for domains, table in counts.items():
        cells = rows[:, list(domains)]
        np.add.at(table, tuple(cells[(cells >= 0).all(axis=1)].T), 1)
    kept = np.ones(len(rows), dtype=bool)
    for number in range(len(rows) - 1, -1, -1):
        held = [
            (table, cells)
            for domains, table in counts.items()
            if min(cells := tuple(rows[number, list(domains)].tolist())) >= 0
        ]
        if all(table[cells] > 1 for table, cells in held):
            kept[number] = False
            for table, cells in held:
                table[cells] -= 1
    return rows[kept]
