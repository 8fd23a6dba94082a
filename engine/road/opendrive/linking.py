"""Continuations of a file's lanes: by the links of its roads, sections and lanes, and the connections of its junctions.

The rules are Scenic's (`scenic.formats.opendrive.xodr_parser`, version 3.1): a way through a junction leads from a lane
by a lane of a connecting road into the next lane. A file states most links twice, and each may be missing or wrong on
one side. A link of one side holds for both; of two statements, the statement that fits the places of the lanes counts.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from engine.opendrive.links import OdrConnection, OdrEnd
from engine.road.opendrive.lanes import THROUGH, End, Lanes, Part, linked_part


class Way(NamedTuple):
    """Way from a lane by a connecting lane into a third; indices of `Links.lanes`."""

    junction: str
    start: int
    connecting: int
    end: int


class Links(Lanes):
    """The lanes of a file and their continuations."""

    # -- from road to road

    def stated(self, end: End) -> OdrEnd | None:
        """Return the link that the file states at an end of a road; None without a link, or to an unknown road."""
        road = self.network.roads[end.road]
        beyond = road.predecessor if end.at_start else road.successor
        there = self.network.junctions if beyond and beyond.kind == "junction" else self.network.roads
        return beyond if beyond is not None and beyond.id in there else None

    @cached_property
    def _stating(self) -> Mapping[str, Sequence[End]]:
        """Return by road the ends of roads whose links name it."""
        found: dict[str, list[End]] = defaultdict(list)
        for road in self.sections:
            for end in (End(road, True), End(road, False)):
                if (beyond := self.stated(end)) is not None and beyond.kind == "road":
                    found[beyond.id].append(end)
        return found

    @cached_property
    def joints(self) -> Mapping[End, End]:
        """Return by end of a road the end of the road beyond it."""
        ends = (End(road, at_start) for road in self.sections for at_start in (True, False))
        return {end: joint for end in ends if (joint := self._joint(end)) is not None}

    def _joint(self, end: End) -> End | None:
        beyond = self.stated(end)
        if beyond is not None and beyond.kind == "junction":
            return None
        said = () if beyond is None else ends_of(beyond.id, beyond.at_start)
        claims = self._claims(end)
        exact = [each for each in claims if self.stated(each) == OdrEnd("road", end.road, end.at_start)]
        choices = [each for each in (*said, *claims) if each.road in self.sections]
        believed = [each for each in (*said[:1], *exact) if each.road in self.sections]
        return next((each for each in choices if self._coincide(end, each)), believed[0] if believed else None)

    def _claims(self, end: End) -> list[End]:
        """Return the ends whose links name this end's road, at either of its ends."""
        junctions = {road: each.junction for road, each in self.network.roads.items()}
        # a connecting road names the road before it, which continues by the junction
        return [each for each in self._stating[end.road] if junctions[each.road] in {junctions[end.road], THROUGH}]

    def _coincide(self, one: End, other: End) -> bool:
        """Return True if a lane of one end begins where a lane of the second end ends."""
        return self._leads(one, other) or self._leads(other, one)

    def _leads(self, before: End, after: End) -> bool:
        return any(
            self.follows(index, following)
            for index in self.leaving.get(before, {}).values()
            for following in self.entering.get(after, {}).values()
        )

    def says(self, end: End, number: int) -> int | None:
        """Return the number by which a lane at an end of its road continues beyond it, according to its link."""
        sections = self.sections[end.road]
        return sections.goes_on(Part(0 if end.at_start else len(sections.rows) - 1, number), -1 if end.at_start else 1)

    def _across(self, index: int, joint: End, said: int | None) -> int | None:
        """Return the lane beyond a joint into which a lane leads; `said` is its number according to the lane's link."""
        number, there = self.lanes[index].last.lane, self.entering.get(joint, {})
        back = [after for each, after in there.items() if self.says(joint, each) == number]
        choices = [after for after in (None if said is None else there.get(said), *back) if after is not None]
        return next((after for after in choices if self.follows(index, after)), choices[0] if choices else None)

    @cached_property
    def successors(self) -> Mapping[int, tuple[int, ...]]:
        """Return by index the lanes into which a lane continues without a connecting road."""
        onward: dict[int, dict[int, None]] = {index: {} for index in range(len(self.lanes))}
        for index, lane in enumerate(self.lanes):
            if (after := linked_part(self.sections[lane.road], lane.last, 1 if lane.forward else -1)) is not None:
                onward[index][self.lane_of[lane.road, after]] = None
        for end, joint in self.joints.items():
            for number, index in self.leaving.get(end, {}).items():
                if (following := self._across(index, joint, self.says(end, number))) is not None:
                    onward[index][following] = None
        for before, following in self._direct():
            onward[before][following] = None
        return {index: tuple(following) for index, following in onward.items() if following}

    @cached_property
    def contradicted(self) -> list[int]:
        """Return the lanes whose own link differs from their successor."""
        return [
            index
            for end, joint in self.joints.items()
            for number, index in self.leaving.get(end, {}).items()
            if (said := self.says(end, number)) is not None
            and (onward := self.successors.get(index))
            and self.entering.get(joint, {}).get(said) not in onward
        ]

    # -- through junctions

    def _direct(self) -> Iterator[tuple[int, int]]:
        """Yield the lanes that a direct junction joins, in both directions of travel."""
        for each in self.network.connections:
            if not each.direct or each.connecting not in self.sections:
                continue
            for end in self._incoming(each):
                beyond = self._entered(end, each)
                back: dict[int, list[int]] = defaultdict(list)
                for number, to in each.lanes.items():
                    back[to].append(number)
                ways = (
                    (end, beyond, {number: [to] for number, to in each.lanes.items()}),
                    (beyond, end, back),
                )
                for before, after, lanes in ways:
                    for number, index in self.leaving.get(before, {}).items():
                        own = self.says(before, number)
                        for said in lanes.get(number, ()) if lanes else (number if own is None else own,):
                            if (following := self._across(index, after, said)) is not None:
                                yield index, following

    @cached_property
    def ways(self) -> tuple[Way, ...]:
        """Return the ways in the order of the file's connections."""
        return tuple(dict.fromkeys(way for each in self.network.connections for way in self._ways(each)))

    def _ways(self, connection: OdrConnection) -> Iterator[Way]:
        if connection.direct or not {connection.incoming, connection.connecting} <= self.sections.keys():
            return
        roads = self.network.roads
        if roads[connection.incoming].junction != THROUGH or roads[connection.connecting].junction == THROUGH:
            return
        for end in self._incoming(connection):
            entered = self._entered(end, connection)
            for number, index in self.leaving.get(end, {}).items():
                said = connection.lanes.get(number) if connection.lanes else number
                through = self._across(index, entered, said)
                if through is not None:
                    for after in self.successors.get(through, ()):
                        yield Way(connection.junction, index, through, after)

    def _incoming(self, connection: OdrConnection) -> list[End]:
        """Return the ends by which a road leads into a junction: those with such a link, else an end at that place."""
        if connection.incoming not in self.sections:
            return []
        ends = ends_of(connection.incoming, None)
        stating = [end for end in ends if self.stated(end) in self._junction(connection)]
        beyond = ends_of(connection.connecting, None)
        free = (end for end in ends if self.stated(end) is None)
        return stating or [end for end in free if any(self._coincide(end, each) for each in beyond)]

    def _junction(self, connection: OdrConnection) -> tuple[OdrEnd]:
        return (OdrEnd("junction", connection.junction, None),)

    def _entered(self, end: End, connection: OdrConnection) -> End:
        """Return the end of a connecting road that is at an end of the incoming road."""
        choices = ends_of(connection.connecting, connection.at_start)
        meet = self._coincide if connection.direct else self._leads
        return next((each for each in choices if meet(end, each)), choices[0])


def ends_of(road: str, at_start: bool | None) -> tuple[End, End]:
    """Return both ends of a road, first the named end, or else its start."""
    first = at_start is not False
    return End(road, first), End(road, not first)
