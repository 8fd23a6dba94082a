"""Construction of a network from a specification: one row for each kind of road.

A further kind is a type in `engine.maps`, checks of its numbers (alone, and together), a function that fills a
`Network`, and a row here.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any

from engine.frozen import frozen
from engine.maps import LaneletFile, LoneRoad, MapFile, MapSpec, RoadSpec, Roundabout
from engine.road.grid import grid_network
from engine.road.lanelet2.network import lanelet_network
from engine.road.lone_road import lone_road, wrong_lone_road, wrong_lone_road_numbers
from engine.road.network import Network
from engine.road.opendrive.network import file_network
from engine.road.roundabout import roundabout, wrong_roundabout, wrong_roundabout_numbers
from engine.road.specification import SPEED_LIMITS, RoadError, wrong_alone, wrong_length, wrong_together


@frozen
class Maker:
    """Functions that make one kind of road."""

    make: Callable[[Any], Network]
    """Function from a valid specification to its network."""
    wrong_numbers: Callable[[Any], Iterator[RoadError]]
    """Errors of single numbers that no road allows."""
    wrong: Callable[[Any], Iterator[RoadError]]
    """Errors of numbers that are valid alone but not together."""


def _nothing(_: MapSpec) -> Iterator[RoadError]:
    """Return no error: a file is checked when it is named."""
    return iter(())


MAKERS: Mapping[type[MapSpec], Maker] = {
    RoadSpec: Maker(grid_network, wrong_alone, wrong_together),
    LoneRoad: Maker(lone_road, wrong_lone_road_numbers, wrong_lone_road),
    Roundabout: Maker(roundabout, wrong_roundabout_numbers, wrong_roundabout),
    MapFile: Maker(file_network, _nothing, _nothing),
    LaneletFile: Maker(lanelet_network, _nothing, _nothing),
}


def wrong_numbers(spec: MapSpec) -> Iterator[RoadError]:
    """Yield the errors of single numbers that no road of its kind allows."""
    yield from MAKERS[type(spec)].wrong_numbers(spec)
    if spec.speed_limit is not None:
        yield from wrong_length("speed_limit", spec.speed_limit, *SPEED_LIMITS, unit="m/s")


def build_network(spec: MapSpec) -> Network:
    """Return the network of a specification.

    Raises:
        RoadError: no road fits the specification.
    """
    maker = MAKERS[type(spec)]
    error = next(chain(wrong_numbers(spec), maker.wrong(spec)), None)
    if error is not None:
        raise error
    network = maker.make(spec)
    if spec.speed_limit is not None:
        network.speed_limits = {lane.id: spec.speed_limit for lane in network.lanes}
    return network
