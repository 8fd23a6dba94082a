"""Files are written whole and all, or not at all."""

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from engine import atomic
from engine.atomic import standing, write_all, write_one

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


def test_of_two_writers_of_the_same_names_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is told which name, and takes back what it had placed: the folder holds the files of the other alone."""
    name = list(FILES)[-1]
    place = atomic._place

    def meanwhile(waiting: Path, to: Path, over: bool) -> None:
        if to.name == name:
            to.write_bytes(b"of the other")
        place(waiting, to, over)

    monkeypatch.setattr(atomic, "_place", meanwhile)
    with pytest.raises(atomic.TakenError) as caught:
        write_all(tmp_path, FILES, over=False)
    assert caught.value.filename == str(tmp_path / name)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [(name, b"of the other")]


def test_new_files_where_there_are_no_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system that knows no second name of a file takes them as well."""

    def link(*_: object) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "link", link)
    write_all(tmp_path, FILES, over=False)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == FILES


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


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGKILL"])
def test_who_is_killed_leaves_no_file(tmp_path: Path, name: str) -> None:
    """What waited for its place is hidden, and the next export takes it away. Signals are left to whoever runs us: a
    function that writes files changes nothing for the rest of its process.
    """
    folder = tmp_path / "new"
    process = subprocess.run([sys.executable, "-c", ENDED, str(folder), name], capture_output=True, check=False)
    assert process.returncode == -getattr(signal, name)
    assert process.stderr == b""
    assert [path.name[0] for path in folder.iterdir()] == [".", "."]
    write_all(folder, FILES)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == FILES


HELD = """
import os, sys
from pathlib import Path
from engine.atomic import write_all
def held(handle):
    print(flush=True)
    sys.stdin.readline()
os.fsync = held
write_all(Path(sys.argv[1]), {"four.txt": b"4"})
"""


def test_what_waits_for_somebody_who_lives_stays(tmp_path: Path) -> None:
    """Nor is anything taken away that is none of ours."""
    (tmp_path / ".one.txt.12345678.part").touch()
    (tmp_path / ".mine.cortexc-part").touch()
    command = [sys.executable, "-c", HELD, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        other.stdout.readline()
        (left,) = tmp_path.glob(".four.txt.*")
        write_all(tmp_path, FILES)
        assert left.exists()
        other.communicate("\n")
    assert other.returncode == 0
    hidden = {".one.txt.12345678.part", ".mine.cortexc-part"}
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, "four.txt", *hidden}


def test_signals_are_as_they_were(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While files are written, too."""
    numbers = (signal.SIGTERM, signal.SIGHUP)
    before, meanwhile = [signal.getsignal(number) for number in numbers], []
    monkeypatch.setattr(os, "fsync", lambda handle: meanwhile.append([signal.getsignal(number) for number in numbers]))
    write_all(tmp_path, FILES)
    assert meanwhile == [before] * len(FILES)


def test_a_folder_that_may_not_be_listed_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its lock nothing is taken away."""
    left = tmp_path / ".one.txt.12345678.cortexc-part"
    left.touch()
    monkeypatch.setattr(atomic, "_opened", lambda folder: None)
    write_all(tmp_path, FILES)
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, left.name}


# -- one file ----------------------------------------------------------------------------------------------------------


def test_one_file_keeps_its_mode(tmp_path: Path) -> None:
    """A new one has the usual mode; nothing else is left in the folder."""
    old, new = tmp_path / "old.txt", tmp_path / "new.txt"
    old.write_bytes(b"before")
    old.chmod(0o640)
    mask = os.umask(0o022)
    try:
        write_one(old, b"after")
        write_one(new, b"first")
    finally:
        os.umask(mask)
    assert (old.read_bytes(), stat.S_IMODE(old.stat().st_mode)) == (b"after", 0o640)
    assert (new.read_bytes(), stat.S_IMODE(new.stat().st_mode)) == (b"first", 0o644)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.txt", "old.txt"]


def test_one_file_is_written_where_its_link_leads(tmp_path: Path) -> None:
    (tmp_path / "real.txt").write_bytes(b"before")
    (tmp_path / "link.txt").symlink_to("real.txt")
    write_one(tmp_path / "link.txt", b"after")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_bytes() == b"after"


def test_one_file_that_does_not_fit_stays_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(handle: int) -> None:
        raise OSError(errno.ENOSPC, "no space left")

    (tmp_path / "old.txt").write_bytes(b"before")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="no space left"):
        write_one(tmp_path / "old.txt", b"after")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"old.txt": b"before"}
