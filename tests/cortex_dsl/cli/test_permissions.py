"""Files and folders that the user may not read or write: reported by name, and left as they were."""

import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cortex_dsl.console.user_files import write_bytes
from tests.fork_server import RUN, Ended, ForkServer

ROOT = Path(__file__).parents[3]
EGO = "ego = new Car on road\n"
UGLY = "x=1 m\n"
Run = Callable[..., Ended]


@pytest.fixture
def humble(command_server: ForkServer, tmp_path: Path) -> Run:
    """`cortexc ARGUMENTS` as somebody for whom modes count."""

    def run(*arguments: object, script: str = "") -> Ended:
        result = command_server.run(f"obey_modes(); {RUN}", *arguments, at=tmp_path, given=script, COLUMNS="120")
        assert "Traceback" not in result.err
        assert "bug in cortexc" not in result.err
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
    assert result.status == 2
    assert said in result.err
    assert (folder / "readonly.scn").read_text() == UGLY


def test_a_search(folder: Path, humble: Run) -> None:
    """Without a place for its results it is not begun."""
    example = ROOT / "examples" / "left_turn.scn"
    result = humble(example, "--ga", "--generations", "1", "--out", "still/run")
    assert result.status == 2
    assert "cannot write" in result.err
    assert [path.name for path in (folder / "still").iterdir()] == ["a.scn"]


@pytest.mark.parametrize("name", ["unreadable.scn", "closed/b.scn"])
def test_imports(folder: Path, humble: Run, name: str) -> None:
    """A file that may not be looked at is not called missing."""
    (folder / "main.scn").write_text(f'import "{name}"\n{EGO}')
    result = humble("main.scn", "--check")
    assert result.status == 1
    assert f"error[SCN233]: cannot read `{name}`: permission denied" in result.err


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
    assert result.status == 1
    assert result.err.count("permission denied") == 6
    assert (folder / "readonly.scn").read_text() == UGLY
    assert (folder / "mine.scn").read_text() == "x = 2 m\n"
    assert stat.S_IMODE((folder / "readonly.scn").stat().st_mode) == 0o444


DYING = """
import signal
os.fsync = lambda number: os.kill(os.getpid(), signal.SIGKILL)
sys.exit(main(["fmt", "a.scn"]))
"""


def test_the_formatter_is_killed_while_it_writes(command_server: ForkServer, tmp_path: Path) -> None:
    """The file is as it was, to the last byte: what had been written lies beside it, under a hidden name."""
    (tmp_path / "a.scn").write_text(UGLY)
    assert command_server.run(DYING, at=tmp_path).status == -9
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
