"""Conversion of sections for one side of a road (`singleSide`) to sections of the whole road.

Source: ASAM OpenDRIVE 1.7.0, section 11.4 (lane sections): a section with `singleSide="true"` applies to one side of
the road only, up to the next section that applies to that side.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from engine.opendrive.roads import OdrLane, OdrSection

LEFT, RIGHT = 1, -1


def whole_sections(sections: Sequence[OdrSection], single: Sequence[OdrSection]) -> list[OdrSection]:
    """Return sections, cut at each beginning of either side; `single` are those that apply to one side only."""
    ordered = sorted([*sections, *single], key=lambda each: each.start)
    if not single:
        return ordered
    starts = list(dict.fromkeys(each.start for each in ordered))
    of_side = {
        side: [each for each in ordered if each in sections or any(side * lane > 0 for lane in each.lanes)]
        for side in (LEFT, RIGHT)
    }
    center = dict((0, each.lanes[0]) for each in ordered if 0 in each.lanes)  # noqa: C402 - the last one
    return [
        OdrSection(start, center | {k: v for side in of_side for k, v in _cut(of_side[side], side, start, end)})
        for start, end in pairwise([*starts, None])
        if start is not None
    ]


def _cut(sections: Sequence[OdrSection], side: int, start: float, end: float | None) -> Iterator[tuple[int, OdrLane]]:
    """Yield the lanes of one side between two cuts; lanes that continue across a cut keep their numbers."""
    begun = [each for each in sections if each.start <= start]
    if not begun:
        return
    here = begun[-1]
    is_last = end is None or any(each.start == end for each in sections)
    lanes: Mapping[int, OdrLane] = here.lanes
    for number, lane in lanes.items():
        if side * number > 0:
            before = lane.predecessor if here.start == start else number
            yield number, replace(lane, predecessor=before, successor=lane.successor if is_last else number)
