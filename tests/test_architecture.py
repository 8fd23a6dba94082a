"""Who may import whom, and what ships: the rules of ARCHITECTURE.md as tests."""

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import grimp
import pytest
from importlinter.cli import EXIT_STATUS_SUCCESS, lint_imports

from cortex_dsl.version import VERSION

ROOT = Path(__file__).parent.parent
PACKAGES = {"cortex_dsl", "engine", "grammar"}


def test_import_contracts_hold(capsys: pytest.CaptureFixture[str]) -> None:
    """Every contract of `pyproject.toml` is kept."""
    status = lint_imports(config_filename=str(ROOT / "pyproject.toml"), no_cache=True)
    assert status == EXIT_STATUS_SUCCESS, capsys.readouterr().out


def test_kernels_import_nothing_but_numbers() -> None:
    """Kernels import numba, numpy, the standard library, themselves, the vocabulary, the tables, and where to cache."""
    graph = grimp.build_graph("engine", include_external_packages=True, cache_dir=None)
    kernels = {"engine.kernels", *graph.find_descendants("engine.kernels")}
    allowed = {
        "engine",
        "engine.vocabulary",
        "engine.tables",
        "engine.user_cache",
        "numba",
        "numpy",
        *sys.stdlib_module_names,
        *kernels,
    }
    used = {name for kernel in kernels for name in graph.find_modules_directly_imported_by(kernel)}
    assert used - allowed == set()


def test_version_is_stated_once() -> None:
    """The command's version is the distribution's."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == VERSION


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return zipfile.ZipFile(next(folder.glob("*.whl")))


def test_wheel_holds_our_packages_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    """Names as common as `engine` must at least be all that is installed."""
    tops = {name.split("/")[0] for name in wheel.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == PACKAGES
    assert len(tops) == len(PACKAGES) + 1


def test_wheel_holds_the_grammar_and_every_module(wheel: zipfile.ZipFile) -> None:
    """The grammar ships as data beside the code, and no module of the tree is left behind."""
    names = set(wheel.namelist())
    assert "grammar/cortex.lark" in names
    modules = {str(p.relative_to(ROOT)) for package in PACKAGES for p in (ROOT / package).rglob("*.py")}
    assert modules - names == set()


def test_wheel_installs_the_command(wheel: zipfile.ZipFile) -> None:
    """`cortexc` is the entry point, and the licence is inside."""
    entry_points = next(name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    assert "cortexc = cortex_dsl.cli:main" in wheel.read(entry_points).decode()
    assert any(re.search(r"\.dist-info/licenses/LICENSE$", name) for name in wheel.namelist())
