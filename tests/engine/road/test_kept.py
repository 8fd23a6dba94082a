"""What is found out about a network: once, and no longer than the network is there."""

import gc
import weakref

from engine.maps import RoadSpec
from engine.road import build_network
from engine.road.lights import lit_arms
from engine.road.merging import all_left_by, ways_through
from engine.road.sections import all_intersections


def test_a_network_keeps_what_was_found_whatever_others_are_asked() -> None:
    """The region of all intersections is added to a network once."""
    spec = RoadSpec(rows=2, cols=1)
    first = build_network(spec)
    region, count = all_intersections(first), len(first.regions)
    for other in [build_network(spec) for _ in range(6)]:
        assert all_intersections(other) == region
    assert (all_intersections(first), len(first.regions)) == (region, count)


def test_a_network_that_nobody_needs_goes() -> None:
    network = build_network(RoadSpec())
    for find in (all_intersections, all_left_by, lit_arms, ways_through):
        find(network)
    seen = weakref.ref(network)
    del network
    gc.collect()
    assert seen() is None
