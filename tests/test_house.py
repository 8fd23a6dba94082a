"""The floor plan: no circle of files, and no file so large that nobody finds a thing in it."""

from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("cortex_dsl", "engine")
LONGEST = 350
"""Lines of a file."""
LONGER = {
    "cortex_dsl/ir.py": 490,
    "cortex_dsl/syntax/nodes.py": 820,
    "cortex_dsl/syntax/expressions.py": 455,
}
"""Files that are one list each of small things of one kind, where a reader jumps to a name."""


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """What each module imports of ours, at the top, inside a function, or for its types alone."""
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def test_no_circle_of_files(imports: dict[str, set[str]]) -> None:
    """Every module can be read after all that it imports."""
    try:
        order = list(TopologicalSorter(imports).static_order())
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))
    assert len(order) == len(imports)


def test_files_can_be_read_in_one_go() -> None:
    """A file that grows beyond a few screens is parted, unless it is a list that nobody reads from end to end."""
    lengths = {str(path.relative_to(ROOT)): _lines(path) for path in _files()}
    assert {name: lines for name, lines in lengths.items() if lines > LONGER.get(name, LONGEST)} == {}


def _files() -> Iterator[Path]:
    for package in PACKAGES:
        yield from (ROOT / package).rglob("*.py")


def _lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())
