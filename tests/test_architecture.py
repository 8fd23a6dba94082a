"""Who may import whom: the rules of ARCHITECTURE.md as tests."""

import subprocess
import sys
from pathlib import Path

import grimp

ROOT = Path(__file__).parent.parent


def test_import_contracts_hold() -> None:
    """Every contract of `pyproject.toml` is kept. A process of its own, as its logging silences that of all others."""
    linter = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([linter, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_kernels_import_nothing_but_numbers() -> None:
    """Kernels import numba, numpy, the standard library, themselves, words, tables and results, and where to cache."""
    graph = grimp.build_graph("engine", include_external_packages=True, cache_dir=None)
    kernels = {"engine.kernels", *graph.find_descendants("engine.kernels")}
    allowed = {
        "engine",
        "engine.handles",
        "engine.judged",
        "engine.opcodes",
        "engine.operators",
        "engine.outcomes",
        "engine.tables",
        "engine.user_cache",
        "engine.vocabulary",
        "llvmlite",
        "numba",
        "numpy",
        *sys.stdlib_module_names,
        *kernels,
    }
    used = {name for kernel in kernels for name in graph.find_modules_directly_imported_by(kernel)}
    assert used - allowed == set()
