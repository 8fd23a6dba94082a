"""What searchers found, as tables in Markdown: of each scenario by method, and of each method over scenarios."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from statistics import median

from benchmarks.suite.comparison import Found
from benchmarks.suite.scenarios import DRIVEN, HALVES, JUDGE, TUNE
from benchmarks.suite.truth import Truth
from engine.search.statistics import clopper_pearson, holm

SIMULATIONS, SECONDS = (100, 300, 1000, 3000), (1.0, 3.0, 10.0, 30.0)
"""Points of the curves."""
LEVEL = 0.05
"""Error rate of a ranking."""
BASELINE = "random"
"""The method whose time is the equal time of all."""


@dataclass(frozen=True)
class Cell:
    """Runs of one method on one scenario."""

    truth: Truth
    rows: tuple[Found, ...]

    def of(self, value: Callable[[Found], float]) -> float:
        """The median over the runs."""
        return median(value(row) for row in self.rows)

    @property
    def found(self) -> int:
        """Runs that found a failure."""
        return sum(row.failures > 0 for row in self.rows)

    @property
    def first(self) -> float:
        """Valid simulations until the first failure; more than the budget where most runs found none."""
        return self.of(first_of)

    @property
    def mechanisms(self) -> float:
        """Of those that are known, on average."""
        return sum(len(row.first.keys() & set(self.truth.known)) for row in self.rows) / len(self.rows)

    def within(self, seconds: float) -> float:
        """The same, of those that were reached in so much processor time."""
        reached = (
            sum(row.reached.get(each, seconds + 1.0) <= seconds for each in self.truth.known) for row in self.rows
        )
        return sum(reached) / len(self.rows)


def first_of(row: Found) -> int:
    """Valid simulations until the first failure of a run, one more than its budget if there was none."""
    return min(row.first.values(), default=row.budget + 1)


Cells = dict[str, dict[str, Cell]]
"""By scenario, then by method; in both orders as they are told of."""


def cells_of(found: Sequence[Found], truths: dict[str, Truth]) -> Cells:
    """Runs of the programs as they are."""
    cells: Cells = {}
    methods = list(dict.fromkeys(each.method for each in found))
    for name in [name for name in HALVES if name in truths]:
        rows = [each for each in found if each.scenario == name and each.digest == truths[name].digest]
        of_each = {m: tuple(r for r in rows if r.method == m) for m in methods}
        cells[name] = {method: Cell(truths[name], its) for method, its in of_each.items() if its}
    return {name: row for name, row in cells.items() if row}


def timed_cells(found: Sequence[Found], truths: dict[str, Truth]) -> Cells:
    """The same, of runs whose processor time is known."""
    return cells_of([each for each in found if each.processor is not None], truths)


def methods_of(cells: Cells) -> list[str]:
    """Methods with runs, in the order of the cells."""
    return list(dict.fromkeys(method for row in cells.values() for method in row))


# -- of each scenario --------------------------------------------------------------------------------------------------


def table(found: Sequence[Found], truths: dict[str, Truth]) -> str:
    """A line for each scenario and method: everything."""
    columns = "scenario, method, runs, found, mechanisms, first failure, cells, failures, processor seconds"
    lines = [f"| {columns.replace(', ', ' | ')} |", f"|{'---|' * len(columns.split(', '))}"]
    for name, row in cells_of(found, truths).items():
        lines += [_line(name, method, cell) for method, cell in row.items()]
    return "\n".join(lines)


def _line(name: str, method: str, cell: Cell) -> str:
    return (
        f"| {name} | {method} | {len(cell.rows)} | {cell.found} "
        f"| {cell.mechanisms:.1f} of {len(cell.truth.known)} | {_simulations(cell)} | {cell.of(lambda r: r.cells):g} "
        f"| {cell.of(lambda r: r.failures):g} | {_time(cell):.1f} |"
    )


def compact(found: Sequence[Found], truths: dict[str, Truth]) -> str:
    """A line for each scenario and a column for each method: runs that found a failure, of how many, and the median of
    the simulations until the first.
    """
    cells = cells_of(found, truths)
    methods = methods_of(cells)
    lines = [f"| scenario | {' | '.join(methods)} |", f"|---|{'---|' * len(methods)}"]
    for name, row in cells.items():
        told = [f"{row[m].found}/{len(row[m].rows)}, {_simulations(row[m])}" if m in row else "" for m in methods]
        lines.append(f"| {name} | {' | '.join(told)} |")
    return "\n".join(lines)


def _simulations(cell: Cell) -> str:
    return "–" if cell.first > cell.rows[0].budget else f"{cell.first:,.0f}"


# -- of each method ----------------------------------------------------------------------------------------------------


def summaries(found: Sequence[Found], truths: dict[str, Truth]) -> str:
    """Two panels for each half, for the driver from outside, and for all files: all scenarios by the methods that have
    runs on each, and, where there are methods that have runs on some, these by all methods.
    """
    cells = timed_cells(found, truths)
    methods = methods_of(cells)
    some = [name for name, row in cells.items() if set(row) == set(methods)]
    panels = [list(cells), some] if some and some != list(cells) else [list(cells)]
    return "\n\n".join(_panel(cells, names) for names in panels)


def _panel(cells: Cells, names: Sequence[str]) -> str:
    """As many runs of each method: on each scenario as many as all of them have."""
    columns = "method, for, scenarios, runs, found a failure, 95 % interval, mechanisms, at equal time, cells, seconds"
    lines = [f"| {columns.replace(', ', ' | ')} |", f"|{'---|' * len(columns.split(', '))}"]
    methods = [m for m in cells[names[0]] if all(m in cells[name] for name in names)]
    runs = {name: min(len(cells[name][method].rows) for method in methods) for name in names}
    equal = {
        name: {m: Cell(cells[name][m].truth, cells[name][m].rows[: runs[name]]) for m in methods} for name in names
    }
    for half in (TUNE, JUDGE, DRIVEN, "both"):
        chosen = {name: row for name, row in equal.items() if half in (HALVES[name], "both")}
        lines += list(_of_methods(chosen, methods, half)) if chosen else []
    return "\n".join(lines)


def _of_methods(cells: Cells, methods: Sequence[str], half: str) -> Iterator[str]:
    known = sum(len(row[methods[0]].truth.known) for row in cells.values())
    for method in methods:
        of_each = [row[method] for row in cells.values()]
        found, runs = sum(cell.found for cell in of_each), sum(len(cell.rows) for cell in of_each)
        low, high = clopper_pearson(found, runs)
        mechanisms = sum(cell.mechanisms for cell in of_each)
        in_time = sum(row[method].within(_time(row.get(BASELINE, row[method]))) for row in cells.values())
        covered = sum(cell.of(lambda row: row.cells) for cell in of_each)
        seconds = sum(_time(cell) for cell in of_each) / len(of_each)
        yield (
            f"| {method} | {half} | {len(of_each)} | {runs} | {found} ({(found + 1) / (runs + 2):.0%}) "
            f"| {low:.0%} .. {high:.0%} | {mechanisms:.1f} of {known} | {in_time:.1f} | {covered:g} | {seconds:.1f} |"
        )


# -- how soon, and who is better ---------------------------------------------------------------------------------------


def curves(found: Sequence[Found], truths: dict[str, Truth]) -> str:
    """Share of targets that a run has reached after so many valid simulations, and after so many seconds of a
    processor: the empirical distribution of the effort until a target is found, over files, runs and known mechanisms.
    """
    cells = timed_cells(found, truths)
    methods = methods_of(cells)
    heads = [*(f"{each:,}" for each in SIMULATIONS), *(f"{each:g} s" for each in SECONDS)]
    lines = [f"| method | files | targets | {' | '.join(heads)} |", f"|{'---|' * (3 + len(heads))}"]
    for method in methods:
        of_each = [row[method] for row in cells.values() if method in row]
        targets = [(row, each) for cell in of_each for row in cell.rows for each in cell.truth.known]
        shares = [
            *(sum(row.first.get(each, limit + 1) <= limit for row, each in targets) for limit in SIMULATIONS),
            *(sum(row.reached.get(each, limit + 1.0) <= limit for row, each in targets) for limit in SECONDS),
        ]
        told = " | ".join(f"{share / len(targets):.0%}" for share in shares)
        lines.append(f"| {method} | {len(of_each)} | {len(targets)} | {told} |")
    return "\n".join(lines)


def ranking(found: Sequence[Found], truths: dict[str, Truth]) -> str:
    """Each pair of methods over the files that both have runs on: mechanisms found, by the test of Wilcoxon (1945) on
    the differences of the means of each file, corrected by Holm (1979).
    """
    from scipy.stats import wilcoxon

    cells = timed_cells(found, truths)
    methods = methods_of(cells)
    rows = []
    for one, other in combinations(methods, 2):
        pairs = [row[one].mechanisms - row[other].mechanisms for row in cells.values() if one in row and other in row]
        p = float(wilcoxon(pairs).pvalue) if any(pairs) else 1.0
        rows.append((one, other, len(pairs), sum(each > 0 for each in pairs), sum(each < 0 for each in pairs), p))
    lines = ["| method | against | files | more in | fewer in | p, Holm | |", "|---|---|---|---|---|---|---|"]
    for row, p in zip(rows, holm([row[-1] for row in rows]), strict=True):
        verdict = ("better" if row[3] > row[4] else "worse") if p < LEVEL else "undecided"
        lines.append(f"| {row[0]} | {row[1]} | {row[2]} | {row[3]} | {row[4]} | {p:.3f} | {verdict} |")
    return "\n".join(lines)


def _time(cell: Cell) -> float:
    """Median processor time of the runs of which it is known [s]."""
    return median(row.processor for row in cell.rows if row.processor is not None)
