"""Which lanes a file has, and how they go on: by the links of its roads, sections, lanes and junctions.

The rules are Scenic's (`scenic.formats.opendrive.xodr_parser`, version 3.1): a lane is what is linked from section to
section of one road; a way through a junction leads from a lane by a lane of a connecting road into the one after that.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from engine.frozen import frozen
from engine.opendrive.links import OdrConnection, OdrEnd
from engine.opendrive.read import OdrNetwork, OdrRoad, OdrSection

DRIVABLE = frozenset({"driving", "entry", "exit", "offRamp", "onRamp", "connectingRamp"})
"""Types of lanes that vehicles drive on, as Scenic has them."""
THROUGH = "-1"
"""The junction of a road that is none's."""
SHORTEST = 1e-6
"""A section shorter than this is passed over [m]."""


class Part(NamedTuple):
    """A lane in one section of its road."""

    section: int
    """Index in `Sections.rows`."""
    lane: int


@frozen
class FileLane:
    """A lane of one road, through all the sections in which it is linked."""

    road: str
    parts: tuple[Part, ...]
    """In the direction of the reference line."""
    forward: bool
    """Whether traffic runs that way."""

    @property
    def last(self) -> Part:
        """Where traffic leaves it."""
        return self.parts[-1] if self.forward else self.parts[0]

    @property
    def first(self) -> Part:
        """Where traffic enters it."""
        return self.parts[0] if self.forward else self.parts[-1]


class Way(NamedTuple):
    """From a lane by a connecting one into a third; indices of `Links.lanes`."""

    junction: str
    start: int
    connecting: int
    end: int


@frozen
class Sections:
    """The sections of a road that have a length."""

    road: OdrRoad

    @cached_property
    def rows(self) -> tuple[tuple[OdrSection, float], ...]:
        """Each with the place at which it ends [m]."""
        sections, length = self.road.sections, self.road.length
        ends = [*(each.start for each in sections[1:]), length]
        held = [(each, min(end, length)) for each, end in zip(sections, ends, strict=True)]
        return tuple((each, end) for each, end in held if end - each.start >= SHORTEST)

    def drivable(self, section: int) -> list[int]:
        """Lanes right of the reference line first, from the middle outwards."""
        lanes = self.rows[section][0].lanes
        ids = [number for number, lane in lanes.items() if number and lane.type in DRIVABLE]
        return sorted(ids, key=lambda number: (number > 0, abs(number)))

    def goes_on(self, part: Part, step: int) -> int | None:
        """The number by which a lane goes on in the section after it (step 1) or before it (-1), or beyond the road."""
        row = self.rows[part.section][0]
        lane = row.lanes[part.lane]
        number = lane.successor if step > 0 else lane.predecessor
        for passed in self._between(row, part.section + step, step):
            if number is None or number not in passed.lanes:
                return None
            number = passed.lanes[number].successor if step > 0 else passed.lanes[number].predecessor
        return number

    def _between(self, row: OdrSection, other: int, step: int) -> Sequence[OdrSection]:
        """The sections without a length from one to the next one, or to the end of the road."""
        every, place = self.road.sections, self.road.sections.index(row)
        further = every[place + 1 :] if step > 0 else every[:place][::-1]
        if not 0 <= other < len(self.rows):
            return further
        return further[: further.index(self.rows[other][0])]


class Links:
    """The lanes of a file and what leads into what."""

    def __init__(self, network: OdrNetwork) -> None:
        self.network = network
        self.sections = {road.id: Sections(road) for road in network.roads.values() if road.length > SHORTEST}
        self.lanes: list[FileLane] = []
        self.lane_of: dict[tuple[str, Part], int] = {}
        """By road and part, the index of the lane."""
        self.merges: dict[int, int] = {}
        """Lanes that run into another one of their road."""
        for road in [*self._roads(through=True), *self._roads(through=False)]:
            self._gather(road)

    def _roads(self, *, through: bool) -> Iterator[Sections]:
        return (each for each in self.sections.values() if (each.road.junction == THROUGH) is through)

    def _gather(self, sections: Sections) -> None:
        """All lanes of a road: forward ones first."""
        road = sections.road
        found: list[FileLane] = []
        seen: dict[Part, int] = {}
        merged: dict[int, Part] = {}
        for section in range(len(sections.rows)):
            for number in sections.drivable(section):
                part: Part | None = Part(section, number)
                if part in seen:
                    continue
                parts: list[Part] = []
                while part is not None and part not in seen:
                    parts.append(part)
                    seen[part] = len(found)
                    part = self._next_part(sections, part)
                if part is not None:
                    merged[len(found)] = part
                found.append(FileLane(road.id, tuple(parts), not road.against(number)))
        order = sorted(range(len(found)), key=lambda i: not found[i].forward)
        place = {old: len(self.lanes) + new for new, old in enumerate(order)}
        self.lanes += [found[i] for i in order]
        self.lane_of |= {(road.id, part): place[index] for part, index in seen.items()}
        self.merges |= {place[index]: place[seen[part]] for index, part in merged.items()}

    def _next_part(self, sections: Sections, part: Part) -> Part | None:
        """The same lane in the next section, on the same side of the road."""
        number = sections.goes_on(part, 1)
        if number is None or part.section + 1 >= len(sections.rows):
            return None
        following = Part(part.section + 1, number)
        same_side = number * part.lane > 0
        return following if same_side and number in sections.drivable(part.section + 1) else None

    # -- from road to road

    @cached_property
    def successors(self) -> Mapping[int, int]:
        """By index, the lane that another goes on to without a junction in between."""
        onward = {index: self._beyond(lane) for index, lane in enumerate(self.lanes)}
        linked = {index: other for index, other in onward.items() if other is not None}
        return {**linked, **{i: other for i, other in self.merges.items() if self.lanes[i].forward}}

    def _beyond(self, lane: FileLane) -> int | None:
        sections = self.sections[lane.road]
        step = 1 if lane.forward else -1
        if lane.last.section != (len(sections.rows) - 1 if lane.forward else 0):
            return None  # it ends within its road
        end = sections.road.successor if lane.forward else sections.road.predecessor
        number = sections.goes_on(lane.last, step)
        return None if end is None or number is None or end.kind != "road" else self._entered(end, number)

    def _entered(self, end: OdrEnd, number: int) -> int | None:
        """The lane of that number that begins at an end of a road."""
        other = self.sections.get(end.id)
        if other is None or not other.rows:
            return None
        index = self.lane_of.get((end.id, Part(0 if end.at_start else len(other.rows) - 1, number)))
        return index if index is not None and self.lanes[index].forward is end.at_start else None

    # -- through junctions

    @cached_property
    def ways(self) -> tuple[Way, ...]:
        """In the order of the file's connections."""
        return tuple(dict.fromkeys(way for each in self.network.connections for way in self._ways(each)))

    def _ways(self, connection: OdrConnection) -> Iterator[Way]:
        incoming, connecting = self.sections.get(connection.incoming), self.sections.get(connection.connecting)
        if incoming is None or connecting is None or not incoming.rows or not connecting.rows:
            return
        if incoming.road.junction != THROUGH or connecting.road.junction == THROUGH:
            return
        entered = OdrEnd("road", connection.connecting, connection.at_start)
        for index in self._ending_at(incoming, connection.junction):
            number = self.lanes[index].last.lane
            to = connection.lanes.get(number) if connection.lanes else number
            through = None if to is None else self._entered(entered, to)
            end = None if through is None else self.successors.get(through)
            if through is not None and end is not None:
                yield Way(connection.junction, index, through, end)

    def _ending_at(self, sections: Sections, junction: str) -> Iterator[int]:
        """Lanes of a road whose traffic runs into a junction."""
        road, last = sections.road, len(sections.rows) - 1
        for end, section, forward in ((road.successor, last, True), (road.predecessor, 0, False)):
            if end is not None and end.kind == "junction" and end.id == junction:
                for number in sections.drivable(section):
                    index = self.lane_of[road.id, Part(section, number)]
                    if self.lanes[index].forward is forward:
                        yield index
