"""The command that installs an extra can be typed as it stands, and what is missing is said with it."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from engine import extras
from engine.extras import MissingExtraError, installing, is_installed, needed


def test_a_checkout_installs_itself(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No index knows its name; the interpreter is the one that runs, both as they are called from here."""
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr(extras, "SOURCE", tmp_path)
    monkeypatch.setattr(extras, "sys", SimpleNamespace(executable=str(tmp_path / ".venv" / "bin" / "python")))
    monkeypatch.chdir(tmp_path)
    assert installing("report") == ".venv/bin/python -m pip install -e '.[report]'"
    (tmp_path / "deeper").mkdir()
    monkeypatch.chdir(tmp_path / "deeper")
    assert installing("report") == f"{tmp_path}/.venv/bin/python -m pip install -e '{tmp_path}[report]'"


def test_an_installed_package_goes_by_its_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """There is no folder to install from."""
    monkeypatch.setattr(extras, "SOURCE", tmp_path)
    assert installing("search").endswith(" -m pip install 'cortexc[search]'")


def test_what_is_there_is_loaded() -> None:
    """A module of a package."""
    assert needed("json.decoder", "this test needs", "search").JSONDecoder


@pytest.mark.parametrize(("package", "named"), [("", "no_such_package"), ("other", "other")])
def test_what_is_missing_is_said_with_its_cure(package: str, named: str) -> None:
    """Who needs it, the package by the name that one installs, and the command."""
    with pytest.raises(MissingExtraError) as caught:
        needed("no_such_package.part", "this test needs", "report", package)
    assert caught.value.message == f"this test needs the package `{named}`, which is not installed"
    assert caught.value.cure == installing("report")
    assert caught.value.package == named


def test_packages_are_found_without_an_import() -> None:
    """None is needed for an empty name."""
    assert is_installed("")
    assert is_installed("json")
    assert not is_installed("no_such_package")
