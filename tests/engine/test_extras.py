"""The command that installs an extra can be typed as it stands."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from engine import extras
from engine.extras import installing


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
