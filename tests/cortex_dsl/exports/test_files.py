"""Files are written whole and all, or not at all."""

import errno
import os
from pathlib import Path

import pytest

from cortex_dsl.exports.files import standing, write_all

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
    name = "x" * 255
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
