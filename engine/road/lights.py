"""Arms of intersections with traffic lights, and signs over them, by the file of a map."""

from collections.abc import Mapping

from engine.road.network import Lane, Network, RoadSign, once_per_network


@once_per_network
def lit_arms(network: Network) -> Mapping[tuple[int, int], RoadSign] | None:
    """Return the traffic light of each arm by the indices of intersection and arm: the first of the file.

    None without a file, or if no light applies to an arm: then every arm has a light, defined by the scenario.
    """
    light = {start: sign for sign in reversed(_lights(network)) for start in _lanes_of(network, sign)}
    found = {
        (intersection.id, arm): light[lane.id]
        for intersection in network.intersections
        for arm, leg in enumerate(intersection.legs)
        for lane in reversed(leg.incoming_lanes)
        if lane.id in light
    }
    return found or None


def lights_for_nobody(network: Network) -> int:
    """Return the number of lights of the file that apply to no lane into an intersection."""
    led = {lane.id for each in network.intersections for leg in each.legs for lane in leg.incoming_lanes}
    lights = _lights(network)
    reported = {sign.id for sign in lights if not led.isdisjoint(_lanes_of(network, sign))}
    return len({sign.id for sign in lights} - reported)


def _lights(network: Network) -> list[RoadSign]:
    return [sign for sign in network.signs if sign.is_traffic_light]


def _lanes_of(network: Network, light: RoadSign) -> list[int]:
    """Return the lanes at whose ends traffic waits for a light."""
    return [start for lane in light.lanes for start in _waiting_lanes(network.lanes[lane])]


def _waiting_lanes(lane: Lane) -> tuple[int, ...]:
    """Return the lane at whose end traffic waits for a light: itself, or the lanes before it if it is in a junction."""
    return tuple(before.id for before in lane.predecessors) if not lane.maneuvers and lane.intersection else (lane.id,)


def signs_at(network: Network, intersection: int) -> tuple[RoadSign, ...]:
    """Return the signs over the lanes through an intersection, each once, as in Scenic."""
    through = {each.connecting_lane.road for each in network.intersections[intersection].maneuvers}
    found = dict[str, RoadSign]()
    for sign in network.signs:
        if sign.road in through:
            found.setdefault(sign.id, sign)
    return tuple(found.values())
