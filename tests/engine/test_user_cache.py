"""The folder for what can be made again."""

import os
import time
from pathlib import Path

import pytest

from engine.user_cache import (
    ENVIRONMENT_VARIABLE,
    MAX_OTHERS,
    cache_roots,
    cached_file,
    fingerprint,
    is_ours,
    is_writable,
)
from tests.folders import small_files


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_chosen_folder_comes_first_and_is_made(root: Path) -> None:
    """Whoever names a folder gets it."""
    assert next(cache_roots()) == root
    assert cached_file("grammar-1.lark", "grammar-*.lark") == root / "grammar-1.lark"
    assert root.is_dir()


def test_what_cannot_be_written_is_passed_over(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file in the place of the folder: the next one is taken, and without any there is none."""
    root.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    assert cached_file("a", "*") == tmp_path / "user" / "cortexc" / "a"
    monkeypatch.setenv("XDG_CACHE_HOME", str(root / "below"))
    monkeypatch.setenv("HOME", str(root / "home"))
    assert cached_file("a", "*") is None


def test_a_full_folder_is_passed_over(root: Path) -> None:
    """Files can be made in it, but hold nothing: a limit on the size of files stands for a full disk."""
    assert is_writable(root)
    with small_files(1000):
        assert not is_writable(root)
    assert is_writable(root)


@pytest.mark.parametrize("mode", [0o777, 0o720, 0o702])
def test_a_folder_that_others_may_write_is_not_ours(root: Path, mode: int) -> None:
    """What lies in it could be anybody's code."""
    root.mkdir(mode=0o700)
    assert is_ours(root)
    root.chmod(mode)
    assert not is_ours(root)


def test_a_folder_of_another_user_is_not_ours(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even if it may be written."""
    root.mkdir(mode=0o700)
    monkeypatch.setattr(os, "getuid", lambda: root.stat().st_uid + 1)
    assert not is_ours(root)


def test_a_clock_that_runs_backwards_removes_nothing_in_use(root: Path) -> None:
    """Entries from the future are the most recent ones."""
    root.mkdir()
    ahead = time.time() + 1e6
    for number in range(MAX_OTHERS + 4):
        (root / f"grammar-{number:02}.lark").write_text("")
        os.utime(root / f"grammar-{number:02}.lark", (ahead, ahead))
    cached_file("grammar-new.lark", "grammar-*.lark")
    assert len(list(root.glob("grammar-*"))) == MAX_OTHERS + 4


def test_files_of_a_kind_that_are_long_unused_are_removed(root: Path) -> None:
    """The most recent ones of other versions stay, and everything of another kind, when a new one is to be written."""
    root.mkdir()
    for age in range(MAX_OTHERS + 4):
        for family in ("grammar", "other"):
            old = root / f"{family}-{age:02}.lark"
            old.write_text("")
            os.utime(old, (1e9 - age, 1e9 - age))
    cached_file("grammar-00.lark", "grammar-*.lark")
    assert len(list(root.glob("grammar-*"))) == MAX_OTHERS + 4
    cached_file("grammar-new.lark", "grammar-*.lark")
    assert sorted(p.name for p in root.glob("grammar-*")) == [f"grammar-{age:02}.lark" for age in range(MAX_OTHERS)]
    assert len(list(root.glob("other-*"))) == MAX_OTHERS + 4


def test_code_as_long_and_as_old_is_other_code(tmp_path: Path) -> None:
    """Packages are built with the times of files set to one moment."""
    (code := tmp_path / "code").mkdir()
    seen = set[str]()
    for text in ("GAP = 1", "GAP = 2"):
        (code / "one.py").write_text(text)
        os.utime(code / "one.py", (0, 0))
        seen |= {fingerprint([code]), fingerprint([code / "one.py"])}
    assert len(seen) == 2
