"""`benchmarks.maps`: what it compares with, and what `--carla` ends with where nothing could be compared."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.maps import topology
from benchmarks.maps.__main__ import _turns_apart, jump, turn_of_chords
from benchmarks.maps.relations import Relations, relations
from benchmarks.maps.standard import ends
from engine.road import build_network
from engine.road.opendrive.network import map_file
from engine.vocabulary import ManeuverType

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


def test_maneuvers_of_another_type_are_told_with_both_turns() -> None:
    """A bend of 20.6 degrees whose chords turn by 19.5 is the case of CARLA's Town04."""
    network = build_network(map_file(VILLAGE, "village.xodr"))
    each = next(each for each in network.maneuvers if each.type is ManeuverType.LEFT_TURN)
    ways = [[each.start, each.connecting, each.end, kind] for kind in ("LEFT_TURN", "STRAIGHT")]
    line = np.array([(0.0, 0.0), (10.0, 0.0), (20.0, 1.0), (30.0, 3.0)])
    lines = [line] * len(network.lanes)
    ((ours, scenics),) = _turns_apart(network, range(len(network.lanes)), lines, ways)
    assert ours > 20.0
    assert scenics == pytest.approx(math.degrees(math.atan2(2.0, 10.0)))


def test_pairs_of_maneuvers_that_one_tool_alone_relates_are_named() -> None:
    """Scenic's answer is made up: as ours, then without a pair that crosses, then without one that merges."""
    network = build_network(map_file(VILLAGE, "village.xodr"))
    ways = network.maneuvers
    theirs = {
        "ways": [[each.start, each.connecting, each.end, each.type.name] for each in ways],
        "conflicts": [[other.id for other in each.conflicting_maneuvers] for each in ways],
        "reverse": [[other.id for other in each.reverse_maneuvers] for each in ways],
    }
    same = range(len(network.lanes))
    conflicting, reverse = relations(network, same, theirs)
    count = sum(map(len, theirs["conflicts"]))
    assert (conflicting, reverse) == (Relations(count), Relations(sum(map(len, theirs["reverse"]))))
    pairs = [(one, other) for one in ways for other in one.conflicting_maneuvers]
    crossing = next((one, other) for one, other in pairs if one.end != other.end)
    merging = next((one, other) for one, other in pairs if one.end == other.end)
    for one, other in (crossing, merging):
        theirs["conflicts"][one.id].remove(other.id)
    theirs["reverse"][0].append(0)
    conflicting, reverse = relations(network, same, theirs)
    assert conflicting == Relations(count - 2, only_here=(" / ".join(each.name for each in crossing),), merging=1)
    assert reverse.only_scenic == (f"{ways[0].name} / {ways[0].name}",)
    assert conflicting.differ
    assert reverse.differ


def test_how_far_a_way_jumps_is_that_of_its_worse_end() -> None:
    here, there, far = (np.array([(x, 0.0), (x + 10.0, 0.0)]) for x in (0.0, 10.5, 40.0))
    assert jump(here, there, far) == pytest.approx(19.5)
    assert jump(here, there, there[1:]) == pytest.approx(0.5)


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
