"""What ships: the wheel, what it holds, and that it, an editable install and a bare clone all find what they read."""

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

ROOT = Path(__file__).parent.parent
PACKAGES = {"cortex_dsl", "engine"}


def test_version_is_stated_once() -> None:
    """The command's version is the distribution's."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == VERSION


def build(kind: str, folder: Path) -> Path:
    """A wheel, or a wheel that stands for an editable install."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
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


def test_wheel_holds_the_grammar_the_examples_and_every_module(wheel: zipfile.ZipFile) -> None:
    """What the command reads ships as data of its package, and no module of the tree is left behind."""
    names = set(wheel.namelist())
    held = (path for folder in FOLDERS for path in (ROOT / folder).iterdir() if path.is_file() and path.suffix != ".md")
    examples = {f"cortex_dsl/data/{path.relative_to(ROOT).as_posix()}" for path in held}
    data = {name for name in names if name.startswith("cortex_dsl/data/")}
    assert data == {"cortex_dsl/data/grammar/cortex.lark", *examples}
    modules = {str(p.relative_to(ROOT)) for package in PACKAGES for p in (ROOT / package).rglob("*.py")}
    assert modules - names == set()


def test_wheel_installs_the_command(wheel: zipfile.ZipFile) -> None:
    """`cortexc` is the entry point, and the licence is inside."""
    entry_points = next(name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    assert "cortexc = cortex_dsl.__main__:process" in wheel.read(entry_points).decode()
    assert any(re.search(r"\.dist-info/licenses/LICENSE$", name) for name in wheel.namelist())


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
