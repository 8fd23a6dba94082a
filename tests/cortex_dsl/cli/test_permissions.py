"""Files and folders that the user may not read or write: reported by name, and left as they were."""

import os
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cortex_dsl.console.user_files import write_bytes

from .conftest import obey_modes

ROOT = Path(__file__).parents[3]
EGO = "ego = new Car on road\n"
UGLY = "x=1 m\n"
Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def humble(tmp_path: Path) -> Run:
    """`cortexc ARGUMENTS` as somebody for whom modes count."""

    def run(*arguments: object, script: str = "") -> "subprocess.CompletedProcess[str]":
        result = subprocess.run(
            [sys.executable, "-m", "cortex_dsl", *map(str, arguments)],
            input=script,
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "120"},
            preexec_fn=obey_modes,
            timeout=300,
            check=False,
        )
        assert "Traceback" not in result.stderr
        assert "bug in cortexc" not in result.stderr
        return result

    return run


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A file that cannot be read, one that cannot be written, a folder that can only be read, and a closed one."""
    for name in ("unreadable.scn", "readonly.scn", "still/a.scn", "closed/b.scn"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(UGLY)
    modes = {"unreadable.scn": 0o000, "readonly.scn": 0o444, "still": 0o555, "closed": 0o000}
    for name, mode in modes.items():
        (tmp_path / name).chmod(mode)
    yield tmp_path
    for name in ("still", "closed"):
        (tmp_path / name).chmod(0o755)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("unreadable.scn", "--check"), "cannot read `unreadable.scn`: permission denied"),
        (("closed/b.scn", "--check"), "cannot read `closed/b.scn`: permission denied"),
        (("fmt", "unreadable.scn"), "cannot read `unreadable.scn`: permission denied"),
        (("fmt", "readonly.scn"), "cannot write `readonly.scn`: permission denied"),
        (("fmt", "still"), "cannot write `still/a.scn`: permission denied"),
        (("fmt", "closed"), "cannot read the folder `closed`: permission denied"),
        (("fmt", "closed/b.scn"), "cannot read `closed/b.scn`: permission denied"),
    ],
)
def test_commands(folder: Path, humble: Run, arguments: tuple[str, ...], said: str) -> None:
    """Exit code 2, one line that names the file, and its content as it was."""
    result = humble(*arguments)
    assert result.returncode == 2
    assert said in result.stderr
    assert (folder / "readonly.scn").read_text() == UGLY


def test_a_search(folder: Path, humble: Run) -> None:
    """Without a place for its results it is not begun."""
    example = ROOT / "examples" / "left_turn.scn"
    result = humble(example, "--ga", "--generations", "1", "--out", "still/run")
    assert result.returncode == 2
    assert "cannot write" in result.stderr
    assert [path.name for path in (folder / "still").iterdir()] == ["a.scn"]


@pytest.mark.parametrize("name", ["unreadable.scn", "closed/b.scn"])
def test_imports(folder: Path, humble: Run, name: str) -> None:
    """A file that may not be looked at is not called missing."""
    (folder / "main.scn").write_text(f'import "{name}"\n{EGO}')
    result = humble("main.scn", "--check")
    assert result.returncode == 1
    assert f"error[SCN233]: cannot read `{name}`: permission denied" in result.stderr


def test_a_session(folder: Path, humble: Run) -> None:
    """Loading and saving are refused one by one, whatever is asked for, and the session goes on."""
    orders = [
        ":load unreadable.scn",
        ":load closed/b.scn",
        "x = 2 m",
        ":save still/new.scn",
        ":save! still/a.scn",
        ":save! readonly.scn",
        ":save! closed/b.scn",
        ":save mine.scn",
    ]
    result = humble("repl", script="\n".join(orders) + "\n")
    assert result.returncode == 1
    assert result.stderr.count("permission denied") == 6
    assert (folder / "readonly.scn").read_text() == UGLY
    assert (folder / "mine.scn").read_text() == "x = 2 m\n"
    assert stat.S_IMODE((folder / "readonly.scn").stat().st_mode) == 0o444


DYING = """
import os, signal, sys
from cortex_dsl.cli import main
os.fsync = lambda number: os.kill(os.getpid(), signal.SIGKILL)
sys.exit(main(["fmt", "a.scn"]))
"""


def test_the_formatter_is_killed_while_it_writes(tmp_path: Path) -> None:
    """The file is as it was, to the last byte: what had been written lies beside it, under a hidden name."""
    (tmp_path / "a.scn").write_text(UGLY)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    killed = subprocess.run([sys.executable, "-c", DYING], cwd=tmp_path, env=environment, timeout=300, check=False)
    assert killed.returncode == -9
    assert (tmp_path / "a.scn").read_text() == UGLY
    assert [path.name for path in tmp_path.glob("[!.]*")] == ["a.scn"]


def test_the_formatter_is_interrupted_while_it_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is left behind."""

    def interrupt(_number: int) -> None:
        raise KeyboardInterrupt

    path = tmp_path / "a.scn"
    path.write_text(UGLY)
    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_bytes(path, b"x = 1 m\n")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.scn", UGLY)]
