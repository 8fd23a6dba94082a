"""The folder for what can be made again."""

import os
from pathlib import Path

import pytest

from engine.user_cache import ENVIRONMENT_VARIABLE, KEPT, cache_roots, cached_file, fingerprint


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


def test_files_of_a_kind_that_are_long_unused_are_removed(root: Path) -> None:
    """The most recent ones of other versions stay, and everything of another kind, when a new one is to be written."""
    root.mkdir()
    for age in range(KEPT + 4):
        for family in ("grammar", "other"):
            old = root / f"{family}-{age:02}.lark"
            old.write_text("")
            os.utime(old, (1e9 - age, 1e9 - age))
    cached_file("grammar-00.lark", "grammar-*.lark")
    assert len(list(root.glob("grammar-*"))) == KEPT + 4
    cached_file("grammar-new.lark", "grammar-*.lark")
    assert sorted(p.name for p in root.glob("grammar-*")) == [f"grammar-{age:02}.lark" for age in range(KEPT)]
    assert len(list(root.glob("other-*"))) == KEPT + 4


def test_code_as_long_and_as_old_is_other_code(tmp_path: Path) -> None:
    """Packages are built with the times of files set to one moment."""
    (code := tmp_path / "code").mkdir()
    seen = set[str]()
    for text in ("GAP = 1", "GAP = 2"):
        (code / "one.py").write_text(text)
        os.utime(code / "one.py", (0, 0))
        seen |= {fingerprint([code]), fingerprint([code / "one.py"])}
    assert len(seen) == 2
