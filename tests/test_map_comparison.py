"""`benchmarks.maps --carla`: what it ends with where nothing could be compared."""

import sys
from pathlib import Path

import pytest

from benchmarks.maps import topology

VILLAGE = Path(__file__).parents[1] / "examples" / "roads" / "village.xodr"


def test_a_folder_without_files_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    assert topology.compare_with_carla([], sys.executable) == 2
    assert "no file was compared" in capsys.readouterr().out


def test_a_python_without_carla_is_told_apart(capsys: pytest.CaptureFixture[str]) -> None:
    assert topology.compare_with_carla([VILLAGE], sys.executable) == 2
    assert "has no package `carla`" in capsys.readouterr().out


def test_a_reader_that_crashes_is_a_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One file is read, as we do it, and one is not."""
    ways = [(int(a), one, int(b), other) for a, one, b, other in topology.ways(VILLAGE)]
    reader = tmp_path / "reader.py"
    reader.write_text(
        f"import sys\nif 'village' not in sys.argv[1]:\n    sys.exit('gone')\nprint({list(map(list, ways))})\n"
    )
    monkeypatch.setattr(topology, "ASK", reader)
    assert topology.compare_with_carla([VILLAGE], sys.executable) == 0
    assert topology.compare_with_carla([VILLAGE, tmp_path / "other.xodr"], sys.executable) == 1
    assert "CARLA does not read it: gone" in capsys.readouterr().out
