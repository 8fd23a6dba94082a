"""Files are written whole and all, or not at all."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from engine.atomic import standing, write_all

FILES = {"one.txt": b"1", "two.txt": b"22", "three.txt": b"333"}


def test_all_are_there(tmp_path: Path) -> None:
    write_all(tmp_path / "new" / "folder", FILES)
    assert {path.name: path.read_bytes() for path in (tmp_path / "new" / "folder").iterdir()} == FILES


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the files that fitted, nor half of one, nor folders that were made for them."""
    synced = []

    def full(handle: int) -> None:
        synced.append(handle)
        if len(synced) == 3:
            raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="no space left"):
        write_all(tmp_path / "new" / "folder", FILES)
    assert list(tmp_path.iterdir()) == []


def test_what_was_there_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupted export neither touches a file that is there nor takes the folder away."""
    (tmp_path / "one.txt").write_bytes(b"before")

    def interrupted(handle: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_all(tmp_path, FILES)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"one.txt": b"before"}


def test_names_as_long_as_may_be(tmp_path: Path) -> None:
    """The name under which a file waits is never too long, if its own is not."""
    for name in ("x" * 255, "\N{HEAVY BLACK HEART}" * 85):
        write_all(tmp_path, {name: b"1"})
        assert (tmp_path / name).read_bytes() == b"1"


def test_what_stands_there(tmp_path: Path) -> None:
    """The same contents, or something else."""
    (tmp_path / "one.txt").write_bytes(b"1")
    (tmp_path / "two.txt").write_bytes(b"2")
    found = standing(tmp_path, FILES)
    assert found.same == {"one.txt"}
    assert found.other == ("two.txt",)


def test_a_folder_in_a_files_place(tmp_path: Path) -> None:
    (tmp_path / "one.txt").mkdir()
    with pytest.raises(IsADirectoryError):
        standing(tmp_path, FILES)


def test_what_is_no_file_is_something_else(tmp_path: Path) -> None:
    """Nothing is read of a pipe, which waits for a writer, of a device, or of a file of another size."""
    os.mkfifo(tmp_path / "one.txt")
    (tmp_path / "two.txt").symlink_to("/dev/zero")
    with (tmp_path / "three.txt").open("wb") as file:
        file.truncate(10**13)
    assert standing(tmp_path, FILES).other == tuple(FILES)
    write_all(tmp_path, FILES)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == FILES


def test_a_link_that_leads_nowhere(tmp_path: Path) -> None:
    """It is something else, and is replaced; where it leads nothing is made. One to the same contents is the same."""
    (tmp_path / "one.txt").symlink_to(tmp_path / "gone" / "far.txt")
    (tmp_path / "real").write_bytes(FILES["two.txt"])
    (tmp_path / "two.txt").symlink_to("real")
    found = standing(tmp_path, FILES)
    assert (found.same, found.other) == ({"two.txt"}, ("one.txt",))
    write_all(tmp_path, FILES)
    assert (tmp_path / "one.txt").read_bytes() == b"1"
    assert not (tmp_path / "one.txt").is_symlink()
    assert not (tmp_path / "gone").exists()


ENDED = """
import os, signal, sys
from pathlib import Path
from engine.atomic import write_all
calls = []
def ended(handle):
    calls.append(handle)
    if len(calls) == 2:
        os.kill(os.getpid(), getattr(signal, sys.argv[2]))
os.fsync = ended
write_all(Path(sys.argv[1]), {"one.txt": b"1", "two.txt": b"22", "three.txt": b"333"})
"""


@pytest.mark.parametrize(("name", "left"), [("SIGTERM", 0), ("SIGHUP", 0), ("SIGKILL", 2)])
def test_who_is_ended_leaves_nothing(tmp_path: Path, name: str, left: int) -> None:
    """By a signal that can be heard; what is left after another one is taken away by the next export."""
    folder = tmp_path / "new"
    process = subprocess.run([sys.executable, "-c", ENDED, str(folder), name], capture_output=True, check=False)
    number = getattr(signal, name)
    assert process.returncode in (128 + number, -number)
    assert process.stderr == b""
    assert len(list(folder.iterdir()) if folder.exists() else []) == left
    write_all(folder, FILES)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == FILES


def test_what_waits_for_somebody_who_lives_stays(tmp_path: Path) -> None:
    """Nor is anything taken away that is none of ours."""
    names = [f".one.txt.{os.getppid()}.cortexc-part", ".one.txt.999999999.part", ".mine.cortexc-part"]
    for name in names:
        (tmp_path / name).write_bytes(b"")
    gone = tmp_path / ".one.txt.999999999.cortexc-part"
    gone.write_bytes(b"")
    write_all(tmp_path, FILES)
    assert not gone.exists()
    assert all((tmp_path / name).exists() for name in names)


def test_signals_are_as_they_were(tmp_path: Path) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)]
    write_all(tmp_path, FILES)
    assert [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)] == before
