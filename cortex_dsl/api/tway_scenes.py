"""Scenes of a covering array over the cells of the domains at the start: every combination of cells of `ways` domains
that is neither impossible nor excluded is in some scene.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cortex_dsl.api.domain_cells import DomainPrograms, StartCells
from engine.errors import ArgumentError
from engine.gates.coverage import cells_in, count_cells
from engine.gates.covering import ANY, covering_array
from engine.tables import Floats, Ints

OnStep = Callable[[str, int, int], None]
"""Callback with the work that is done, its finished parts, and their number."""


@dataclass(frozen=True)
class TwayScenes:
    """Scenes of a covering array, in the order of its rows."""

    genomes: Floats
    """(n, d) file units"""
    keys: Ints
    """(n, 6)"""
    rows: int
    """Rows of the array; a row that no scene fits as a whole has a scene for each of its combinations."""
    ways: int
    """Number of domains in a combination."""
    missing: int
    """Combinations without a scene, that no proof excludes."""
    cut: int
    """Combinations for which no scene was sought, as `most` scenes were chosen before."""


def tway_scenes(programs: DomainPrograms, ways: int, most: int, on_step: OnStep | None = None) -> TwayScenes:
    """Return at most `most` scenes.

    Raises:
        ArgumentError: no domain is at the start.
    """
    starts = programs.starts
    if not starts:
        raise ArgumentError(
            "--method tway needs a domain at the start: no scene can be drawn for a later instant",
            "add one, or leave --method out",
        )
    ways = min(ways, len(starts))
    return _Covering(programs, starts, ways, on_step or _silent).scenes(most)


def _silent(_what: str, _done: int, _all: int) -> None: ...


class _Covering:
    def __init__(self, programs: DomainPrograms, starts: Sequence[int], ways: int, on_step: OnStep) -> None:
        self.programs, self.starts, self.ways, self.on_step = programs, tuple(starts), ways, on_step
        self.sizes = [programs.sizes[domain] for domain in starts]
        self.genomes, self.keys = programs.pool.genomes, programs.pool.keys
        self.places = programs.pool.places[:, self.starts]
        """(n, starts) Cells of the pool, from whose scenes rows are taken first."""
        self.held: set[StartCells] = set()
        """Combinations that a chosen scene has."""

    def scenes(self, most: int) -> TwayScenes:
        forbidden = self._forbidden()
        rows = covering_array(self.sizes, self.ways, forbidden, self.programs.seed)
        chosen: list[tuple[Floats, Ints]] = []
        missing: set[StartCells] = set()
        cut: set[StartCells] = set()
        for number, row in enumerate(rows):
            self.on_step("scenes drawn for rows", number, len(rows))
            cells = tuple((self.starts[i], int(cell)) for i, cell in enumerate(row) if cell != ANY)
            left = [each for each in combinations(cells, self.ways) if each not in self.held]
            # The combinations one by one only where no scene fits the whole row.
            for wanted in dict.fromkeys((cells, *left)):
                if not set(left) - self.held:
                    break
                if len(chosen) >= most:
                    cut |= set(left)
                    break
                if wanted in self.held:
                    continue
                if (found := self._scene(wanted)) is not None:
                    chosen.append(found)
                elif len(wanted) == self.ways:
                    missing.add(wanted)
        genomes, keys = (np.concatenate(each) for each in zip(*chosen, strict=True)) if chosen else self._none()
        return TwayScenes(genomes, keys, len(rows), self.ways, len(missing - self.held), len(cut - self.held))

    def _none(self) -> tuple[Floats, Ints]:
        return self.genomes[:0], self.keys[:0]

    def _forbidden(self) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Return the combinations of up to `ways` domains that are proved to be impossible or excluded."""
        found: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
        total, done = sum(count_cells(self.sizes, ways) for ways in range(1, self.ways + 1)), 0
        for ways in range(1, self.ways + 1):
            for domains in combinations(range(len(self.starts)), ways):
                seen = self.programs.pool.cells([self.starts[i] for i in domains])
                for cells in cells_in(self.sizes, domains):
                    done += 1
                    if cells in seen:
                        continue
                    self.on_step("cells analysed", done, total)
                    places = zip(domains, cells, strict=True)
                    if self.programs.proofs.of(tuple((self.starts[i], cell) for i, cell in places)) is not None:
                        found.append((domains, cells))
        return found

    def _scene(self, cells: StartCells) -> tuple[Floats, Ints] | None:
        """Return genome (1, d) and key (1, 6) of a scene in the cells, and note its cells; None if there is none."""
        fits = [self.places[:, self.starts.index(domain)] == cell for domain, cell in cells]
        rows = np.flatnonzero(np.all(fits, axis=0))[:1]
        if len(rows):
            self._hold(self.places[rows[0]])
            return self.genomes[rows], self.keys[rows]
        found = self.programs.drawn_in(cells)
        if found is not None:
            self._hold(self.programs.start_places(self.programs.scenes(*found))[0, self.starts])
        return found

    def _hold(self, places: Ints) -> None:
        cells = tuple((self.starts[i], int(cell)) for i, cell in enumerate(places) if cell >= 0)
        self.held |= set(combinations(cells, self.ways))
