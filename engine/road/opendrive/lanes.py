"""The lanes of a file: a lane is a chain of links from section to section of one road, as in Scenic
(`scenic.formats.opendrive.xodr_parser`, version 3.1).
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from engine.frozen import frozen
from engine.opendrive.curves import Pose
from engine.opendrive.roads import OdrNetwork, OdrRoad, OdrSection

DRIVABLE = frozenset({"driving", "entry", "exit", "offRamp", "onRamp", "connectingRamp"})
"""Types of lanes that vehicles drive on, as Scenic has them."""
THROUGH = "-1"
"""Junction of a road outside all junctions."""
SHORTEST = 1e-6
"""Length below which a section is skipped [m]."""


NEAR, ALIKE = 0.5, 0.2
"""Largest distance [m] and angle [rad] between the end of a lane and the start of its successor."""
WITHIN = 1e-9
"""Least distance of a place in a section from the end of the section [m]."""


class End(NamedTuple):
    """One end of a road."""

    road: str
    at_start: bool


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
    """The parts of the lane, in the direction of the reference line."""
    forward: bool
    """True if traffic runs in that direction."""

    @property
    def last(self) -> Part:
        """Return the part at which traffic leaves it."""
        return self.parts[-1] if self.forward else self.parts[0]

    @property
    def first(self) -> Part:
        """Return the part at which traffic enters it."""
        return self.parts[0] if self.forward else self.parts[-1]


@frozen
class Sections:
    """The sections of a road that have a length."""

    road: OdrRoad

    @cached_property
    def rows(self) -> tuple[tuple[OdrSection, float], ...]:
        """Return each section with the place at which it ends [m]."""
        sections, length = self.road.sections, self.road.length
        ends = [*(each.start for each in sections[1:]), length]
        held = [(each, min(end, length)) for each, end in zip(sections, ends, strict=True)]
        return tuple((each, end) for each, end in held if end - each.start >= SHORTEST)

    def drivable(self, section: int) -> list[int]:
        """Return the drivable lanes: those right of the reference line first, from the middle outwards."""
        lanes = self.rows[section][0].lanes
        ids = [number for number, lane in lanes.items() if number and lane.type in DRIVABLE]
        return sorted(ids, key=lambda number: (number > 0, abs(number)))

    def goes_on(self, part: Part, step: int) -> int | None:
        """Return the lane's number in the next section (step 1) or the one before (-1), or beyond the road; None if it
        ends.
        """
        row = self.rows[part.section][0]
        lane = row.lanes[part.lane]
        number = lane.successor if step > 0 else lane.predecessor
        for passed in self._between(row, part.section + step, step):
            if number is None or number not in passed.lanes:
                return None
            number = passed.lanes[number].successor if step > 0 else passed.lanes[number].predecessor
        return number

    def _between(self, row: OdrSection, other: int, step: int) -> Sequence[OdrSection]:
        """Return the sections without a length between two sections, or up to the end of the road."""
        every, place = self.road.sections, self.road.sections.index(row)
        further = every[place + 1 :] if step > 0 else every[:place][::-1]
        if not 0 <= other < len(self.rows):
            return further
        return further[: further.index(self.rows[other][0])]

    def left(self, part: Part, *, at_start: bool) -> float:
        """Return the offset of a lane's middle to the left of the reference line at one end of a section [m]."""
        row, end = self.rows[part.section]
        s = row.start if at_start else end - WITHIN
        return self.road.center(0, s) + 0.5 * sum(row.edges(part.lane, s))

    def pose(self, part: Part, *, at_start: bool) -> Pose:
        """Return the pose of its traffic there."""
        row, end = self.rows[part.section]
        turn = math.pi if self.road.against(part.lane) else 0.0
        return self.road.reference(row.start if at_start else end).moved(0.0, self.left(part, at_start=at_start), turn)


class Lanes:
    """The lanes of a file, each through all sections of its road in which it is linked."""

    def __init__(self, network: OdrNetwork) -> None:
        self.network = network
        self.sections = {
            road.id: sections
            for road in network.roads.values()
            if road.length > SHORTEST and (sections := Sections(road)).rows
        }
        self.lanes: list[FileLane] = []
        self.lane_of: dict[tuple[str, Part], int] = {}
        """Index of the lane by road and part."""
        for road in [*self._roads(through=True), *self._roads(through=False)]:
            self._gather(road)

    def _roads(self, *, through: bool) -> Iterator[Sections]:
        return (each for each in self.sections.values() if (each.road.junction == THROUGH) is through)

    def _gather(self, sections: Sections) -> None:
        """Add all lanes of a road, forward lanes first."""
        road = sections.road
        found: list[FileLane] = []
        seen: dict[Part, int] = {}
        for section in range(len(sections.rows)):
            for number in sections.drivable(section):
                part: Part | None = Part(section, number)
                if part in seen:
                    continue
                parts: list[Part] = []
                while part is not None and part not in seen:
                    parts.append(part)
                    seen[part] = len(found)
                    part = linked_part(sections, part, 1)
                found.append(FileLane(road.id, tuple(parts), not road.against(number)))
        order = sorted(range(len(found)), key=lambda i: not found[i].forward)
        place = {old: len(self.lanes) + new for new, old in enumerate(order)}
        self.lanes += [found[i] for i in order]
        self.lane_of |= {(road.id, part): place[index] for part, index in seen.items()}

    @cached_property
    def leaving(self) -> Mapping[End, Mapping[int, int]]:
        """Return, by end of a road and number there, the lanes whose traffic leaves the road."""
        return self._at_ends(leaving=True)

    @cached_property
    def entering(self) -> Mapping[End, Mapping[int, int]]:
        """Return, by end of a road and number there, the lanes whose traffic enters the road."""
        return self._at_ends(leaving=False)

    def _at_ends(self, *, leaving: bool) -> Mapping[End, Mapping[int, int]]:
        found: dict[End, dict[int, int]] = defaultdict(dict)
        for index, lane in enumerate(self.lanes):
            part, at_start = (lane.last if leaving else lane.first), lane.forward is not leaving
            if part.section == (0 if at_start else len(self.sections[lane.road].rows) - 1):
                found[End(lane.road, at_start)][part.lane] = index
        return found

    @cached_property
    def poses(self) -> Sequence[tuple[Pose, Pose]]:
        """Return by lane the poses at which its traffic enters and leaves it."""
        return [
            (
                self.sections[lane.road].pose(lane.first, at_start=lane.forward),
                self.sections[lane.road].pose(lane.last, at_start=not lane.forward),
            )
            for lane in self.lanes
        ]

    def follows(self, before: int, after: int, near: float = NEAR, alike: float = ALIKE) -> bool:
        """Return True if lane `after` begins at the end of lane `before`, in the same direction."""
        end, start = self.poses[before][1], self.poses[after][0]
        turn = math.remainder(end.heading - start.heading, math.tau)
        return math.hypot(end.x - start.x, end.y - start.y) <= near and abs(turn) <= alike


def linked_part(sections: Sections, part: Part, step: int) -> Part | None:
    """Return the same lane in the next section (step 1) or the one before (-1); None without a link.

    A link of either lane holds for both. In a contradiction, the lane at the end of this lane counts.
    """
    beyond = part.section + step
    if not 0 <= beyond < len(sections.rows):
        return None
    here = [number for number in sections.drivable(beyond) if number * part.lane > 0]
    said = sections.goes_on(part, step)
    back = [number for number in here if sections.goes_on(Part(beyond, number), -step) == part.lane]
    choices = [number for number in (said, *back) if number is not None and number in here]
    at_start = step < 0
    left = sections.left(part, at_start=at_start) if len(set(choices)) > 1 else 0.0
    fitting = (
        number
        for number in choices
        if len(set(choices)) == 1 or abs(sections.left(Part(beyond, number), at_start=not at_start) - left) <= NEAR
    )
    number = next(fitting, choices[0] if choices else None)
    return None if number is None else Part(beyond, number)
