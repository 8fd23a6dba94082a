"""Which maneuvers conflict, and which run the other way, by Scenic and by us: pairs of maneuvers that both have."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from engine.road import Network

Pairs = frozenset[tuple[int, int]]
"""Of indices of our maneuvers."""


class Relations(NamedTuple):
    """How many pairs of maneuvers have a relation by both, and which have it by one alone, by their names."""

    both: int = 0
    only_scenic: tuple[str, ...] = ()
    only_here: tuple[str, ...] = ()
    merging: int = 0
    """Pairs that conflict by us alone and end on one lane. Scenic asks whether centre lines meet, and those that merge
    end up to some millimetres apart or do meet, as rounding has it; here all that merge conflict."""

    @property
    def differ(self) -> bool:
        return bool(self.only_scenic or self.only_here)

    def __str__(self) -> str:
        text = f"{self.both}" + (f", {self.merging} more that merge" if self.merging else "")
        for who, pairs in (("only Scenic", self.only_scenic), ("only here", self.only_here)):
            text += f", {len(pairs)} {who} ({', '.join(pairs[:2])})" if pairs else ""
        return text


def relations(network: Network, same: Sequence[int], theirs: Mapping[str, Any]) -> tuple[Relations, Relations]:
    """Of conflicting and of reverse maneuvers; `same` has for each lane of Scenic's the index of ours."""
    ours = {(each.start, each.connecting, each.end): each.id for each in network.maneuvers}
    number = [ours.get((same[a], same[b], same[c])) for a, b, c, _ in theirs["ways"]]
    ends = [each.end for each in network.maneuvers]
    conflicts = frozenset((each.id, other.id) for each in network.maneuvers for other in each.conflicting_maneuvers)
    merging = frozenset((one, other) for one, other in conflicts if ends[one] == ends[other])
    reverse = frozenset((each.id, other.id) for each in network.maneuvers for other in each.reverse_maneuvers)
    meeting, back = (frozenset(_pairs(number, theirs[name])) for name in ("conflicts", "reverse"))
    return _held(network, conflicts, meeting, merging), _held(network, reverse, back)


def _pairs(number: Sequence[int | None], others: Sequence[Sequence[int]]) -> Iterator[tuple[int, int]]:
    """Those of which we have both maneuvers."""
    for index, related in enumerate(others):
        for other in related:
            one, two = number[index], number[other]
            if one is not None and two is not None:
                yield one, two


def _held(network: Network, ours: Pairs, scenics: Pairs, merging: Pairs = frozenset()) -> Relations:
    def named(pairs: Pairs) -> tuple[str, ...]:
        names = [each.name for each in network.maneuvers]
        return tuple(f"{names[one]} / {names[other]}" for one, other in sorted(pairs))

    more = ours - scenics
    return Relations(len(ours & scenics), named(scenics - ours), named(more - merging), len(more & merging))
