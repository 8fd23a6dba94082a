"""The floor plan: no circle of files, none so large that nobody finds a thing in it, and few with one reader alone."""

import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from statistics import quantiles

import grimp
import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("cortex_dsl", "engine")
USUAL, LONGEST = 450, 900
"""Lines that nine of ten files do not exceed, and that no file exceeds."""
MOST_ALONE = 0.15
"""Of all modules, those that a single other one imports."""
ROWS = 4
"""So many modules of its own folder, which nobody else imports, make a table of the one that imports them."""


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """What each module imports of ours, at the top, inside a function, or for its types alone."""
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def test_no_circle_of_files(imports: dict[str, set[str]]) -> None:
    """Every module can be read after all that it imports, and after their folders, whose `__init__` runs first."""
    needed = {name: {*found, *_folders_entered(name, found)} for name, found in imports.items()}
    try:
        order = list(TopologicalSorter(needed).static_order())
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))
    assert len(order) == len(imports)


def _folders_entered(module: str, imported: set[str]) -> set[str]:
    """Folders of imported modules in which the importing module is not itself."""
    parts = (each.split(".") for each in imported)
    folders = {".".join(names[:count]) for names in parts for count in range(1, len(names))}
    return {folder for folder in folders if not f"{module}.".startswith(f"{folder}.")}


def test_files_are_not_too_long() -> None:
    """A file is one thing that one sentence names; its length follows from that, within two bounds."""
    lengths = {str(path.relative_to(ROOT)): _lines(path) for path in _files()}
    assert {name: lines for name, lines in lengths.items() if lines > LONGEST} == {}
    assert quantiles(lengths.values(), n=10)[-1] <= USUAL


def test_few_modules_serve_one_other_alone() -> None:
    """What a single neighbour asks for lives in the neighbour's file, unless it is a room of its own.

    A module has one importer where a single other module of the product imports it: at the top, in a function, for its
    types, or by a text that names it (`"engine.road.build"`, or `"engine.road.build:load"`). Two sorts are set aside:

    - lazy: its importer loads it within a function, or names it in a text, so that only those pay for it who need it;
    - of a table: its importer takes, at the top, at least four such modules from its own folder, one for each row.

    A folder's `__init__` counts as a module and as an importer, but itself never as alone.
    """
    importers = _importers()
    alone = _alone(importers)
    assert len(alone) < MOST_ALONE * len(importers), "\n".join(
        f"{one} <- {importer}" for one, importer in alone.items()
    )


@pytest.mark.parametrize(
    ("readers", "alone"),
    [
        ({"a.one": ({"a.main"}, set())}, True),
        ({"a.one": ({"a.main", "a.other"}, set())}, False),
        ({"a.one": ({"a.main"}, {"a.other"})}, False),
        ({"a.one": (set(), {"a.main"})}, False),
        ({"a.one": ({"a.main"}, {"a.main"})}, True),
        ({f"a.{name}": ({"a.main"}, set()) for name in ("one", "two", "three")}, True),
        ({f"a.{name}": ({"a.main"}, set()) for name in ("one", "two", "three", "four")}, False),
        ({f"a.{name}.it": ({"a.main"}, set()) for name in ("one", "two", "three", "four")}, True),
    ],
)
def test_who_is_alone(readers: "Importers", alone: bool) -> None:
    """One importer, at the top, that is no table: each of these conditions decides."""
    assert ("a.one" in _alone(readers) or "a.one.it" in _alone(readers)) is alone


Importers = Mapping[str, tuple[set[str], set[str]]]
"""Of each module, who imports it at the top, and who within a function or by a text."""


def _alone(importers: Importers) -> dict[str, str]:
    """Modules with one importer, which is no table and takes them at the top; and that importer."""
    single = {
        one: next(iter(at_top))
        for one, (at_top, lazily) in importers.items()
        if len(at_top | lazily) == 1 and at_top and not (ROOT / one.replace(".", "/")).is_dir()
    }
    rows = Counter(importer for one, importer in single.items() if _folder(one) == _folder(importer))
    return {one: importer for one, importer in single.items() if rows[importer] < ROWS}


def _importers() -> Importers:
    names = {_module(path): path for path in _files()}
    found: dict[str, tuple[set[str], set[str]]] = {name: (set(), set()) for name in names}
    for name, path in names.items():
        for imported, lazily in _imported(ast.parse(path.read_text(encoding="utf-8")), names):
            if imported != name:
                found[imported][lazily].add(name)
    return found


def _imported(tree: ast.AST, names: Mapping[str, Path], lazily: bool = False) -> Iterator[tuple[str, bool]]:
    """Modules that a tree names; whether it does so within a function or by a text."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import):
            yield from ((each.name, lazily) for each in node.names if each.name in names)
        elif isinstance(node, ast.ImportFrom) and (source := node.module or "") in names:
            inner = [f"{source}.{each.name}" for each in node.names]
            yield from ((each if each in names else source, lazily) for each in inner)
        elif (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and (named := node.value.partition(":")[0]) in names
        ):
            yield named, True
        yield from _imported(
            node, names, lazily or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        )


def _folder(module: str) -> str:
    """Of the file; of a folder's `__init__` the folder itself."""
    return module if (ROOT / module.replace(".", "/")).is_dir() else module.rpartition(".")[0]


def _module(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def _files() -> Iterator[Path]:
    for package in PACKAGES:
        yield from (ROOT / package).rglob("*.py")


def _lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())
