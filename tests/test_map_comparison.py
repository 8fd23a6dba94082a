"""`benchmarks.maps`: what it compares with, and what `--carla` ends with where nothing could be compared."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.maps import topology
from benchmarks.maps.__main__ import turn_of_chords
from benchmarks.maps.standard import ends

ROADS = Path(__file__).parents[1] / "examples" / "roads"
VILLAGE = ROADS / "village.xodr"


@pytest.mark.parametrize("file", ["village.xodr", "on_ramp.xodr"])
def test_lanes_end_where_the_standard_puts_them(file: str) -> None:
    apart = [each for each, _ in ends(ROADS / file) if not math.isnan(each)]
    assert len(apart) > 15
    assert max(apart) < 1e-3


def test_what_chords_turn_is_that_of_the_nearest_vertices() -> None:
    """Straight on, then a bend of 45 degrees, which is far from the first vertices."""
    line = np.array([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0), (30.0, 0.0), (40.0, 0.0), (50.0, 10.0)])
    assert turn_of_chords(line, 9.0, 1.0) == 0.0
    assert turn_of_chords(line, 41.0, 1.0) == pytest.approx(math.pi / 4.0)
    assert turn_of_chords(line[:2], 5.0, 0.0) == 0.0


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
