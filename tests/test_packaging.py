"""What ships: the wheel, what it holds, and that it, an editable install and a bare clone all find what they read."""

import json
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

from cortex_dsl.shipped import FOLDERS
from cortex_dsl.version import VERSION
from engine.kernels import packaged
from engine.kernels.packaged import TARGET_FILE, Target

ROOT = Path(__file__).parent.parent
PACKAGES = {"cortex_dsl", "engine"}


def test_version_is_stated_once() -> None:
    """The command's version is the distribution's."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == VERSION


def build(kind: str, folder: Path, **environment: str) -> Path:
    """A wheel, or a wheel that stands for an editable install."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, **environment}, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    return zipfile.ZipFile(build("wheel", tmp_path_factory.mktemp("wheel")))


def test_wheel_holds_our_packages_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    """Names as common as `engine` must at least be all that is installed."""
    tops = {name.split("/")[0] for name in wheel.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == PACKAGES
    assert len(tops) == len(PACKAGES) + 1


def test_wheel_holds_the_grammar_the_examples_the_pages_and_every_module(wheel: zipfile.ZipFile) -> None:
    """What the command reads ships as data of its package, and no module of the tree is left behind."""
    names = set(wheel.namelist())
    held = (path for folder in FOLDERS for path in (ROOT / folder).iterdir() if path.is_file() and path.suffix != ".md")
    examples = {f"cortex_dsl/data/{path.relative_to(ROOT).as_posix()}" for path in held}
    data = {name for name in names if name.startswith("cortex_dsl/data/")}
    assert data == {"cortex_dsl/data/grammar/cortex.lark", *examples}
    modules = {str(p.relative_to(ROOT)) for package in PACKAGES for p in (ROOT / package).rglob("*.py")}
    assert modules - names == set()
    codes = {str(p.relative_to(ROOT)) for p in (ROOT / "cortex_dsl" / "codes").glob("SCN*/*")}
    assert codes
    assert codes - names == set()


def test_wheel_installs_the_command(wheel: zipfile.ZipFile) -> None:
    """`cortexc` is the entry point, and the licence is inside."""
    entry_points = next(name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    assert "cortexc = cortex_dsl.__main__:process" in wheel.read(entry_points).decode()
    assert any(re.search(r"\.dist-info/licenses/LICENSE$", name) for name in wheel.namelist())


# -- kernels in a wheel ------------------------------------------------------------------------------------------------

DRAWING = """
import numpy as np
from engine.compiling import before_compiling
from engine.streams import key_rows
from engine.kernels.random_numbers import GENE_CHANNEL, fill_uniform
out, compiled = np.zeros((3, 4)), []
with before_compiling(lambda: compiled.append(1)):
    fill_uniform(key_rows(1, 2, 0, 0, range(3)), 0, GENE_CHANNEL, out)
print(len(compiled), out.sum().hex())
"""
"""Calls one small kernel: the wheel of a test carries no other. `make wheel` has many, by `wheels.jobs`."""


@pytest.fixture(scope="module")
def carrying(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel with a compiled kernel."""
    folder = tmp_path_factory.mktemp("carrying")
    command = [sys.executable, "-m", "wheels.compile_kernels", str(folder / "kernels"), "-c", DRAWING]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return build("wheel", folder, CORTEXC_WHEEL_KERNELS=str(folder / "kernels"))


def drawn(site: Path, home: Path) -> tuple[int, str]:
    """How often numba compiled, and the numbers, in a process with an empty home that knows the unpacked wheel."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("CORTEXC_", "NUMBA_", "XDG_"))}
    environment = {**kept, "PYTHONPATH": os.pathsep.join([str(site), sysconfig.get_path("purelib")]), "HOME": str(home)}
    command = [sys.executable, "-S", "-c", DRAWING]
    done = subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    compiled, numbers = done.stdout.split()
    return int(compiled), numbers


def test_kernels_of_a_wheel_are_not_compiled(carrying: Path, tmp_path: Path) -> None:
    """With another key they are, as without a wheel, and give the same numbers."""
    site, home = tmp_path / "site", tmp_path / "home"
    home.mkdir()
    with zipfile.ZipFile(carrying) as archive:
        archive.extractall(site)
    if not packaged_here(site):
        pytest.skip("this processor is older than the target of a wheel")
    compiled, numbers = drawn(site, home)
    assert compiled == 0
    with (site / "engine" / "opcodes.py").open("a") as file:
        file.write("FURTHER = 1\n")
    again, same = drawn(site, home)
    assert again > 0
    assert same == numbers
    assert drawn(site, home) == (0, numbers)


def packaged_here(site: Path) -> bool:
    """Whether this processor has the features of the target that the wheel describes."""
    described = json.loads((site / "engine" / "kernels" / "compiled" / TARGET_FILE).read_text())
    return packaged._suits(Target(described["triple"], described["processor"], described["features"]))


def test_a_wheel_with_kernels_is_for_its_python_and_platform_alone(carrying: Path, wheel: zipfile.ZipFile) -> None:
    """And one without is for all."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    name, *tags = carrying.stem.split("-")
    assert name == "cortexc"
    assert tags[1:3] == [python, python]
    assert tags[3] != "any"
    assert Path(str(wheel.filename)).stem.endswith("py3-none-any")
    with zipfile.ZipFile(carrying) as archive:
        metadata = next(each for each in archive.namelist() if each.endswith("dist-info/WHEEL"))
        assert "Root-Is-Purelib: false" in archive.read(metadata).decode()


# -- one loader in three places ---------------------------------------------------------------------------------------

CHECK = """
import sys
from pathlib import Path
from cortex_dsl.cli import main
from cortex_dsl.installation import resource
print(resource("grammar/cortex.lark"))
sys.exit(main(["--no-colour", str(resource("examples/left_turn.scn")), "--check"]))
"""


def checked(prelude: str, at: Path, home: Path) -> str:
    """Check the example in a process that knows the installed dependencies and, of us, what the prelude adds."""
    environment = {**os.environ, "PYTHONPATH": sysconfig.get_path("purelib"), "CORTEXC_CACHE": str(home)}
    command = [sys.executable, "-S", "-c", prelude + CHECK]  # no .pth file of this environment is read
    done = subprocess.run(command, cwd=at, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_finds_its_grammar(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    """Unpacked into a folder, as an installer does."""
    site, elsewhere = tmp_path / "site", tmp_path / "elsewhere"
    elsewhere.mkdir()
    wheel.extractall(site)
    said = checked(f"import sys; sys.path.insert(0, {str(site)!r})", elsewhere, tmp_path / "cache")
    assert said.startswith(str(site / "cortex_dsl" / "data"))


def test_an_editable_install_finds_its_grammar(tmp_path: Path) -> None:
    """It is one line in a .pth file, a folder, and no hook that every import would go through."""
    site, elsewhere = tmp_path / "site", tmp_path / "elsewhere"
    elsewhere.mkdir()
    with zipfile.ZipFile(build("wheel:editable", tmp_path)) as editable:
        editable.extractall(site)
    files = [path for path in site.rglob("*") if path.is_file() and ".dist-info" not in str(path)]
    assert [path.suffix for path in files] == [".pth"]
    assert files[0].read_text().split() == [str(ROOT)]
    said = checked(f"import site; site.addsitedir({str(site)!r})", elsewhere, tmp_path / "cache")
    assert said.startswith(str(ROOT / "grammar"))


def test_a_clone_finds_its_grammar(tmp_path: Path) -> None:
    """`python -m cortex_dsl` in a checkout, where nothing of ours is installed."""
    assert checked("", ROOT, tmp_path).startswith(str(ROOT / "grammar"))
    command = [sys.executable, "-S", "-m", "cortex_dsl", "examples/left_turn.scn", "--check"]
    environment = {**os.environ, "PYTHONPATH": sysconfig.get_path("purelib"), "CORTEXC_CACHE": str(tmp_path)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
