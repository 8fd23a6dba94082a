"""Rows of a table gathered by actor: one track each, in the order of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType

import numpy as np

from engine.interchange.errors import InterchangeError, quoted
from engine.interchange.osi import UNSET, Code, kind_of
from engine.interchange.tables.cells import Cells
from engine.interchange.tables.motion import across, along, headings_of, rates
from engine.tables import Floats, Ints
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind

MOST_ACTORS = 1000
TURNING = 1e-3
"""A slower turn does not show about which point it is [rad/s]."""
SAME_PLACE = 1e-3
"""How well samples must agree on how far the centre lies ahead of the rear axle [m]."""
DEGREES = 7.0
"""No heading in radians is larger, unless it runs on."""
KINDS: Mapping[str, ActorKind] = MappingProxyType(
    {
        **dict.fromkeys(("car", "vehicle", "van", "taxi", "passenger", "passenger_car"), ActorKind.CAR),
        **dict.fromkeys(("truck", "truck_bus", "lorry", "trailer", "heavy_truck"), ActorKind.TRUCK),
        **dict.fromkeys(("bus", "coach", "tram"), ActorKind.BUS),
        **dict.fromkeys(("motorcycle", "motorbike", "motorcyclist"), ActorKind.MOTORCYCLE),
        **dict.fromkeys(("bicycle", "bike", "cyclist", "pedestrian/bicycle"), ActorKind.BICYCLE),
        **dict.fromkeys(("pedestrian", "person", "walker", "human"), ActorKind.PEDESTRIAN),
        **dict.fromkeys(("obstacle", "static", "object", "prop", "miscellaneous"), ActorKind.OBSTACLE),
    }
)
"""What tables call kinds, in small letters."""


@dataclass(frozen=True)
class TableTrack:
    """One actor as a table tells it; SI units, headings not wrapped, positions of centres."""

    name: str
    kind: ActorKind
    is_ego: bool
    """The table says so."""
    time: Floats
    """(samples,) ascending; as the table counts [s]."""
    positions: Floats
    """(samples, 2)"""
    heading: Floats
    speed: Floats
    """Of the rear axle, along the heading."""
    length: float
    width: float
    rear_to_center: float


@dataclass(frozen=True)
class Tracks:
    """All actors of a table, in the order in which it names them."""

    tracks: tuple[TableTrack, ...]
    remarks: tuple[str, ...]


def tracks_of(cells: Cells) -> Tracks:
    """Raises InterchangeError: too many actors, two rows of one actor at one time, a size that is none."""
    gathered = _Gathered(cells, [])
    actors = _rows_by_actor(cells)
    if len(actors) > MOST_ACTORS:
        raise InterchangeError(f"there are {len(actors):,} actors", f"leave at most {MOST_ACTORS:,} in it", cells.file)
    time = _times(cells)
    tracks = [gathered.track(name, rows[np.argsort(time[rows], kind="stable")], time) for name, rows in actors.items()]
    return Tracks(tuple(tracks), tuple(dict.fromkeys(gathered.remarks)))


def _times(cells: Cells) -> Floats:
    """Seconds; whole nanoseconds from the first one, which keeps their digits."""
    if not cells.omega_prime:
        return cells.numbers["time"]
    nanos = cells.whole["total_nanos"]
    return (nanos - nanos.min()) / 1e9


def _rows_by_actor(cells: Cells) -> Mapping[str, Ints]:
    """Rows of each actor, in the order of the file."""
    if cells.omega_prime:
        labels = [f"{index}" for index in cells.whole["idx"].tolist()]
    else:
        labels = [str(label) for label in cells.texts["actor"]]
    names, first, numbers = np.unique(np.array(labels), return_index=True, return_inverse=True)
    order = np.argsort(numbers, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1)
    return {str(names[i]): groups[i] for i in np.argsort(first).tolist()}


@dataclass(frozen=True)
class _Gathered:
    """The cells, and what was taken for granted on the way."""

    cells: Cells
    remarks: list[str]

    def track(self, label: str, rows: Ints, time: Floats) -> TableTrack:
        """`rows` of one actor, in the order of time."""
        cells, own = self.cells, time[rows]
        if len(same := np.flatnonzero(np.diff(own) <= 0.0)):
            one, two = sorted((int(rows[same[0]]), int(rows[same[0] + 1])))
            message = f"`{quoted(label)[1:-1]}` has two rows at one time, the other on line {cells.lines[one]}"
            raise InterchangeError(message, "leave one of them out", cells.place(two))
        name, kind = self._name(label), self._kind(label, rows)
        length, width = (self._size(quantity, kind, rows, name) for quantity in ("length", "width"))
        positions = np.column_stack([cells.numbers["x"][rows], cells.numbers["y"][rows]])
        heading = self._heading(positions, rows)
        behind = MODELS[kind].rear_to_center * length / MODELS[kind].length
        speed, behind = self._speed(own, positions, heading, rows, behind)
        is_ego = name.casefold() == "ego" or self._text("role", rows).casefold() in ("ego", "host", "hero")
        return TableTrack(name, kind, is_ego, own, positions, heading, speed, length, width, behind)

    def _text(self, column: str, rows: Ints) -> str:
        return self.cells.texts[column][int(rows[0])] if column in self.cells.texts else ""

    def _name(self, label: str) -> str:
        known = self.cells.known_names
        return known[int(label)] if self.cells.omega_prime and int(label) in range(len(known)) else label

    def _kind(self, label: str, rows: Ints) -> ActorKind:
        if self.cells.omega_prime:
            code = Code(*(self._code(column, rows) for column in ("type", "role", "subtype")))
            found, said = kind_of(code), f"type {code.type}, subtype {code.subtype}"
        else:
            word = self._text("type", rows).casefold()
            near = get_close_matches(word, KINDS, n=1) if word else []
            found, said = (KINDS[near[0]] if near else None), f"type {quoted(word)}" if word else "no type"
        if "type" not in self.cells.names:
            self.remarks.append("the table has no types: everybody is taken for a car")
        elif found is None:
            self.remarks.append(f"`{quoted(label)[1:-1]}` has {said}: taken for a car")
        return ActorKind.CAR if found is None else found

    def _code(self, column: str, rows: Ints) -> int:
        return int(self.cells.whole[column][rows[0]]) if column in self.cells.whole else UNSET

    def _size(self, quantity: str, kind: ActorKind, rows: Ints, name: str) -> float:
        if quantity not in self.cells.numbers:
            self.remarks.append(f"the table has no {quantity}: each has that of its kind in cortexc")
            return float(getattr(MODELS[kind], quantity))
        sizes = self.cells.numbers[quantity][rows]
        if not (sizes > 0.0).all():
            row = int(rows[np.flatnonzero(~(sizes > 0.0))[0]])
            raise InterchangeError(f"a {quantity} of {sizes.min():g} m", "sizes are above 0", self.cells.place(row))
        if np.ptp(sizes) > SAME_PLACE:
            self.remarks.append(f"the {quantity} of `{quoted(name)[1:-1]}` changes; its median is taken")
        return float(np.median(sizes))

    def _heading(self, positions: Floats, rows: Ints) -> Floats:
        column = "yaw" if self.cells.omega_prime else "heading"
        if column not in self.cells.numbers:
            self.remarks.append("the table has no headings: they are taken from motion")
            return headings_of(positions)
        heading = self.cells.numbers[column][rows]
        jumps = len(heading) > 1 and np.abs(np.diff(heading)).max() > DEGREES
        if jumps or (len(heading) == 1 and abs(heading[0]) > DEGREES):
            row = int(rows[int(np.abs(heading).argmax())])
            written = self.cells.names[column]
            cure = f"if they are degrees, call the column `{written}_deg`"
            message = f"headings up to {np.abs(heading).max():g} that jump are not in radians"
            raise InterchangeError(message, cure, self.cells.place(row, column))
        return np.unwrap(heading)

    def _speed(
        self, time: Floats, positions: Floats, heading: Floats, rows: Ints, behind: float
    ) -> tuple[Floats, float]:
        """The rear axle's speed [m/s], and how far ahead of it the centre lies [m]."""
        if self.cells.omega_prime:
            velocity = np.column_stack([self.cells.numbers["vel_x"][rows], self.cells.numbers["vel_y"][rows]])
            return (velocity * along(heading)).sum(axis=1), _turning_point(time, velocity, heading, behind)
        if "speed" in self.cells.numbers:
            return self.cells.numbers["speed"][rows], behind
        self.remarks.append("the table has no speeds: they are taken from motion")
        rear = positions - behind * along(heading)
        return (rates(time, rear) * along(heading)).sum(axis=1), behind


def _turning_point(time: Floats, velocity: Floats, heading: Floats, usual: float) -> float:
    """How far the centre lies ahead of the point that does not swing in a turn: the rear axle.

    Every driven sample of a turn says it, as the centre's velocity across the heading over the yaw rate. What follows
    contact does not: it begins, in a table of ours, with the one sample that is on no step. Where samples disagree, as
    measured ones do, it is the usual one of such a body.
    """
    driven = _driven(time)
    turning = rates(time[:driven], heading[:driven])
    swing = (velocity * across(heading)).sum(axis=1)[:driven]
    shown = np.abs(turning) > TURNING
    if not shown.any():
        return usual
    distances = swing[shown] / turning[shown]
    middle = float(np.median(distances))
    agreed = np.count_nonzero(np.abs(distances - middle) < SAME_PLACE)
    return middle if 2 * agreed > len(distances) else usual


def _driven(time: Floats) -> int:
    """Samples up to and with the first that is on no step."""
    steps = np.diff(time)
    if len(steps) == 0:
        return len(time)
    short = np.flatnonzero(steps < 0.999 * np.median(steps))
    return int(short[0]) + 2 if len(short) else len(time)


def spelt(names: Sequence[str], name: str) -> str:
    """The actor that was probably meant, or those that there are."""
    near = get_close_matches(name, names, n=1)
    return f"did you mean `{near[0]}`?" if near else "there are " + ", ".join(f"`{n}`" for n in names[:12])
