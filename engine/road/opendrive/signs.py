"""The signals of a file as they stand beside its lanes."""

from collections.abc import Iterator

from engine.opendrive.signals import OdrSignal
from engine.road.opendrive.linking import Links, Part, Sections
from engine.road.signs import RoadSign


def signs_of(links: Links) -> Iterator[RoadSign]:
    """All of them, road by road."""
    for sections in links.sections.values():
        road = sections.road
        for each in road.signals:
            place = road.reference(each.s).moved(0.0, each.t)
            lanes = tuple(dict.fromkeys(_lanes(links, sections, each)))
            about = (each.id, each.name, each.country, each.type, each.subtype, each.value)
            yield RoadSign(*about, f"road{road.id}", place.x, place.y, lanes)


def _lanes(links: Links, sections: Sections, signal: OdrSignal) -> Iterator[int]:
    """Indices of the lanes whose traffic it tells."""
    number = next((i for i, (_, end) in enumerate(sections.rows) if signal.s <= end), len(sections.rows) - 1)
    for lane in sections.drivable(number) if sections.rows else ():
        # Where a file names lanes these decide: CARLA's towns have orientations that contradict them.
        meant = any(min(pair) <= lane <= max(pair) for pair in signal.lanes)
        if meant if signal.lanes else signal.along in (None, not sections.road.against(lane)):
            yield links.lane_of[sections.road.id, Part(number, lane)]
