"""Networks that are kept: the same as those that are built, whatever lies in the cache."""

from copy import copy
from dataclasses import fields
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from engine.errors import InterchangeError
from engine.maps import MapFile
from engine.road import Network, build_network
from engine.road.arrays import road_tables
from engine.road.network import RoadSign, Surface, SurfaceKind
from engine.road.opendrive import making as maker
from engine.road.opendrive import network
from engine.road.opendrive.contents import SHAPED, from_bytes, packed, to_bytes, unpacked
from engine.road.opendrive.network import contents_of, map_file
from engine.road.opendrive.planning import plan_of
from engine.user_cache import ENVIRONMENT_VARIABLE

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, of which this process remembers nothing."""
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path / "cache"))
    contents_of.cache_clear()
    return tmp_path / "cache"


def told(network: Network) -> str:
    """All elements of a network, in words and numbers."""
    legs = [
        (leg.name, leg.heading, leg.length, leg.incoming_lanes, leg.outgoing_lanes, leg.neighbour, leg.phase)
        for site in network.intersections
        for leg in site.legs
    ]
    roads = [(road.name, road.lanes, road.groups) for road in (*network.roads, *network.connecting_roads)]
    parts = (network.lanes, network.maneuvers, network.intersections, legs, roads, vars(network.links))
    return repr((*parts, network.remarks, network.speed_limits, network.left_hand, network.arms, network.signs))


def assert_same(one: Network, other: Network) -> None:
    assert told(one) == told(other)
    first, second = road_tables(one), road_tables(other)
    for name, one_table, other_table in zip(first._fields, first, second, strict=True):
        assert np.array_equal(one_table, other_table), name
    assert one.bounds.keys() == other.bounds.keys()
    for lane, bounds in one.bounds.items():
        assert all(np.array_equal(a, b) for a, b in zip(bounds, other.bounds[lane], strict=True))
    assert repr(one.surfaces) == repr(other.surfaces)
    for surface, same in zip(one.surfaces, other.surfaces, strict=True):
        assert surface.line == same.line
        assert all(np.array_equal(getattr(surface.shape, name), getattr(same.shape, name)) for name, _ in SHAPED)
    assert one.drawn is not None
    assert other.drawn is not None
    for name in ("kerbs", "middle", "between"):
        drawn = zip(getattr(one.drawn, name), getattr(other.drawn, name), strict=True)
        assert all(np.array_equal(a, b) for a, b in drawn)


def built(spec: MapFile) -> Network:
    """Without any cache."""
    return maker._Builder(spec, plan_of(spec.path, spec.digest)).build()


def test_a_network_comes_back_from_its_contents_bit_for_bit(cache: Path) -> None:
    spec = map_file(VILLAGE, "village.xodr")
    fresh, contents = built(spec), packed(built(spec), maker.NEAR, maker.ALIKE)
    assert_same(unpacked(contents, spec), fresh)
    read = from_bytes(to_bytes(contents, "key"), "key")
    assert read is not None
    assert_same(unpacked(read, spec), fresh)
    assert from_bytes(to_bytes(contents, "key"), "another key") is None


ADDED = ("added_paths", "added_regions", "lay")
"""Fields that scenarios fill, and the one that makes `surfaces`."""


class Named(NamedTuple):
    name: str


def test_every_field_of_a_network_is_packed(cache: Path) -> None:
    """A field without its value makes other contents; those that no file fills are left out."""
    digest = map_file(VILLAGE, "village.xodr").digest
    full = built(MapFile("village.xodr", str(VILLAGE), digest, 1))
    assert not full.kerbs
    assert not len(full.buildings)
    full.remarks, full.levels, full.speed_limits = ("mended",), ("road 1 passes above road 2",), {0: 10.0}
    full.unread, full.heights = "not read: object (1, line 1)", np.ones((1, 6))
    full.signs = (RoadSign("9", "50", "de", "274", "50", 50.0, "road1", 1.0, 2.0, (0,)),)
    full.between_kerbs, full.heights = full.regions.shape(0), np.ones((1, 6))
    line, shape = full.paths.primitives(0), full.regions.shape(1)
    full.surfaces = (Surface(full, 0, SurfaceKind.CROSSING, "crossing", line, shape, 4.0, "road1", ends=(None, 1)),)
    whole = to_bytes(packed(full, maker.NEAR, maker.ALIKE), "key")
    empty = Network(full.spec, not full.left_hand)
    for field in (*fields(Network), Named("surfaces")):
        lacking = copy(full)
        setattr(lacking, field.name, getattr(empty, field.name))
        is_same = to_bytes(packed(lacking, maker.NEAR, maker.ALIKE), "key") == whole
        assert is_same == (field.name in {"spec", "kerbs", "buildings", "parked", *ADDED}), field.name


def test_paths_that_a_scenario_joins_stay_its_own(cache: Path) -> None:
    spec = map_file(VILLAGE, "village.xodr")
    one = build_network(spec)
    kept = len(one.paths)
    one.paths.reverse(0)
    other = build_network(spec)
    assert len(other.paths) == kept < len(one.paths)
    route = other.lanes[0].default_route
    assert other.paths.join(other.paths.parts(route)) == route


def test_another_process_reads_no_map_that_is_kept(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = map_file(VILLAGE, "village.xodr")
    fresh = build_network(spec)
    contents_of.cache_clear()
    monkeypatch.setattr(maker, "plan_of", lambda *_: pytest.fail("the file is read again"))
    assert_same(build_network(map_file(VILLAGE, "village.xodr")), fresh)


def turned(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: b"not one of ours",
        lambda content: content[:-1],
        lambda content: content + b"x",
        lambda content: turned(content, 0),
        lambda content: turned(content, 40),
        lambda content: turned(content, len(content) // 2),
    ],
)
def test_a_damaged_entry_is_as_none_and_is_written_anew(cache: Path, damage) -> None:
    spec = map_file(VILLAGE, "village.xodr")
    (entry,) = cache.glob(network.FAMILY)
    whole = entry.read_bytes()
    entry.write_bytes(damage(whole))
    contents_of.cache_clear()
    assert_same(build_network(spec), built(spec))
    assert entry.read_bytes() == whole


def test_a_folder_in_its_place_or_a_cache_that_is_none_costs_time_alone(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = map_file(VILLAGE, "village.xodr")
    (entry,) = cache.glob(network.FAMILY)
    entry.unlink()
    entry.mkdir()
    contents_of.cache_clear()
    assert_same(build_network(spec), built(spec))
    monkeypatch.setattr(network, "cached_file", lambda *_: None)
    contents_of.cache_clear()
    assert_same(build_network(spec), built(spec))


def test_a_file_that_changes_while_it_is_read_is_kept_nowhere(cache: Path) -> None:
    """What was read is of another digest than the one it would be found by."""
    with pytest.raises(InterchangeError, match="changed while it was read"):
        contents_of(str(VILLAGE), "0" * 32)
    assert not list(cache.glob("roads-*"))
