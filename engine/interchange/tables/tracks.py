"""Rows of a table gathered by actor: one track each, in the order of time."""

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from types import MappingProxyType

import numpy as np

from engine.errors import InterchangeError, cited, quoted
from engine.interchange.kinds import UNSET, Code, kind_of
from engine.interchange.motion import (
    Motion,
    across,
    along,
    jump_remark,
    pieces_of,
    rates,
    without_jumps,
)
from engine.interchange.motion_headings import motion_headings
from engine.interchange.tables.columns import FRAMES, NAME, VELOCITY, Cells, unread_remark
from engine.interchange.tables.conventions import ahead
from engine.interchange.tables.headings import Headings, slides
from engine.interchange.tables.plausible import AssumedColumn, along_heading, driven, held_speeds, scale_remarks
from engine.interchange.tables.track import TableTrack, Tracks
from engine.tables import Bools, Floats, Ints
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind

TURNING = 1e-3
"""Yaw rate below which the turning point cannot be determined [rad/s]."""
SAME_PLACE = 1e-3
"""Largest difference of samples in the distance of the centre ahead of the rear axle [m]."""
LONGEST = 100.0
"""Maximum length of an outline [m], as in cortexc."""
MOST_TRACKS = 50_000
"""Maximum number of tracks in a table."""
MOST_REMARKS = 200
LONGEST_SPAN = 24 * 3600
"""Maximum time from a table's first row to its last [s]."""
SI_UNITS: Mapping[str, str] = MappingProxyType(
    {
        "time": "s",
        "heading": "rad",
        "speed": "m/s",
        **dict.fromkeys(VELOCITY, "m/s"),
        **dict.fromkeys(("x", "y", "z", "length", "width"), "m"),
    }
)
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
"""Names of kinds in tables, in small letters."""


def tracks_of(cells: Cells) -> Tracks:
    """Return the tracks of a table.

    Raises:
        InterchangeError: too many actors, two rows of one actor at one time, an invalid size.
    """
    remarks = [*_read_as(cells), *_assumed_units(cells)]
    gathered = _Gathered(cells, remarks, Headings(cells, remarks))
    actors = _rows_by_actor(cells)
    if len(actors) > MOST_TRACKS:
        raise InterchangeError(f"there are {len(actors):,} actors", f"leave at most {MOST_TRACKS:,} in it", cells.file)
    time = _times(cells)
    actors = {name: rows[np.argsort(time[rows], kind="stable")] for name, rows in actors.items()}
    gathered.refuse_twice(actors, time)
    gathered.headings.judge(actors.values(), time)
    found = [gathered.track(name, rows, time) for name, rows in actors.items()]
    tracks = [track for track in found if track is not None]
    if not tracks:
        raise InterchangeError(
            "every actor in it jumps at every row", "correct its units, or the names of its actors", cells.file
        )
    if len({track.name for track in tracks}) < len(tracks):
        raise InterchangeError("two actors have the same name", "rename one of them", cells.file)
    odd = scale_remarks([track.name for track in tracks], [(track.time, track.positions) for track in tracks])
    said = tuple(dict.fromkeys([*odd, *remarks]))[:MOST_REMARKS]
    return Tracks(tuple(tracks), said, cells.file, cells.begin, cells.omega_prime)


def _read_as(cells: Cells) -> Iterator[str]:
    """Yield remarks on the recognized layout, and on columns that are not read."""
    if cells.layout is not None:
        yield f"read as a table of {cells.layout.name}: {cells.layout.said}"
    yield from cells.remarks
    time = cells.columns.get("time")
    if time is not None and time.unit == FRAMES:
        yield f"{cited(time.name)} counts {1.0 / time.factor:g} frames a second"
    if remark := unread_remark(cells.unread):
        yield remark
    if "width" in cells.columns and "length" not in cells.columns and "height" in map(str.casefold, cells.unread):
        yield "`width` and `height` are those of a box in an image? its position is a corner: add half of both"


def _times(cells: Cells) -> Floats:
    """Return seconds; whole nanoseconds count from the first, which preserves their digits."""
    if not cells.omega_prime:
        return cells.numbers["time"]
    nanos = cells.whole["total_nanos"]
    first, last = int(nanos.min()), int(nanos.max())
    if last - first > LONGEST_SPAN * 10**9:
        row = int(np.flatnonzero(nanos == last)[0])
        message = f"this is {(last - first) / 1e9:,.0f} s after the first time"
        raise InterchangeError(message, "correct it or leave out the row", cells.place(row, "total_nanos"))
    return (nanos - first) / 1e9


def _assumed_units(cells: Cells) -> Iterator[str]:
    """Yield a remark on columns without a unit."""
    silent = [(key, column) for key, column in cells.columns.items() if key in SI_UNITS and not column.unit]
    if silent:
        columns = ", ".join(f"{cited(column.name)} [{SI_UNITS[key]}]" for key, column in silent)
        yield f"no unit is said: {columns} are taken for granted; another stands in a name, as in `speed [km/h]`"


def _rows_by_actor(cells: Cells) -> Mapping[str, Ints]:
    """Return the rows of each actor, in the order of the file."""
    labels = map(str, cells.whole["idx"].tolist()) if cells.omega_prime else cells.texts["actor"]
    rows: dict[str, array[int]] = {}
    for row, label in enumerate(labels):
        rows.setdefault(label, array("q")).append(row)
    return {label: np.array(own) for label, own in rows.items()}


@dataclass(frozen=True)
class _Gathered:
    """The cells, and remarks on assumptions."""

    cells: Cells
    remarks: list[str]
    headings: Headings

    def refuse_twice(self, actors: Mapping[str, Ints], time: Floats) -> None:
        """Raise InterchangeError if an actor has two rows at one time; `actors`: rows of each, in the order of time."""
        for label, rows in actors.items():
            if len(same := np.flatnonzero(np.diff(time[rows]) <= 0.0)):
                one, two = sorted((int(rows[same[0]]), int(rows[same[0] + 1])))
                message = f"{cited(label)} has two rows at one time, the other on line {self.cells.lines[one]}"
                raise InterchangeError(message, "leave one of them out", self.cells.place(two))

    def track(self, label: str, rows: Ints, time: Floats) -> TableTrack | None:
        """Return the track of `rows` of one actor, in the order of time; None if it jumps at each of them."""
        cells, own = self.cells, time[rows]
        name, kind = self._name(label, rows), self._kind(label, rows)
        places = np.column_stack([cells.numbers["x"][rows], cells.numbers["y"][rows]])
        remaining, breaks, jumps = without_jumps(own, places)
        self._remark(jump_remark(name, own, places, jumps))
        if not remaining.any():
            return None
        rows, motion = (
            rows[remaining],
            Motion(own[remaining], places[remaining], pieces_of(own[remaining], breaks[remaining])),
        )
        length, width = (self._size(quantity, kind, rows, name) for quantity in ("length", "width"))
        velocity = self._velocity(name, motion, rows)
        behind = MODELS[kind].rear_to_center * length / MODELS[kind].length
        point = 0.0 if cells.layout is None else ahead(cells.layout.point, length, behind)
        lag, on_foot = behind and max(0.0, behind + point), kind == ActorKind.PEDESTRIAN
        shown = partial(motion_headings, motion, lag=lag, on_foot=on_foot)
        heading = self.headings.of(name, motion, velocity, rows, shown, on_foot=on_foot)
        speed, behind = self._speed(name, motion, velocity, heading, rows, behind)
        point = 0.0 if cells.layout is None else ahead(cells.layout.point, length, behind)
        known = ~np.isnan(heading)
        return TableTrack(
            label=label,
            name=name,
            kind=kind,
            is_ego=self._is_ego(label, rows),
            time=motion.time,
            positions=motion.positions - np.where(known[:, np.newaxis], point * along(heading), 0.0),
            heading=heading,
            speed=speed,
            length=length,
            width=width,
            rear_to_center=behind,
            slides=slides(cells, rows),
            breaks=breaks[remaining],
            ahead=point,
            height=cells.numbers["z"][rows] if "z" in cells.numbers else None,
        )

    def _is_ego(self, label: str, rows: Ints) -> bool:
        """Return True for the ego: by its key in omega-prime, where names have no meaning, else by its name."""
        if self.cells.omega_prime:
            return self.cells.host is not None and int(label) == self.cells.host
        if self.cells.layout is not None and self.cells.layout.ego:
            return label == self.cells.layout.ego
        return label.casefold() == "ego" or self._text("role", rows).casefold() in ("ego", "host", "hero")

    def _text(self, column: str, rows: Ints) -> str:
        return self.cells.texts[column][int(rows[0])] if column in self.cells.texts else ""

    def _name(self, label: str, rows: Ints) -> str:
        known = self.cells.known_names
        if text := self._text(NAME, rows):
            return text
        return (known[int(label)] if self.cells.omega_prime and int(label) in range(len(known)) else "") or label

    def _kind(self, label: str, rows: Ints) -> ActorKind:
        if self.cells.omega_prime:
            code = Code(*(self._code(column, rows) for column in ("type", "role", "subtype")))
            found, said = kind_of(code), f"type {code.type}, subtype {code.subtype}"
        else:
            word = self._text("type", rows).casefold()
            own = dict[str, ActorKind]() if self.cells.layout is None else self.cells.layout.kinds
            near = get_close_matches(word, KINDS, n=1) if word and word not in own else []
            found, said = own.get(word, KINDS[near[0]] if near else None), f"type {quoted(word)}" if word else "no type"
        if "type" not in self.cells.columns and "type" not in self.cells.texts:
            self.remarks.append("the table has no types: all actors are taken for cars")
        elif found is None:
            self.remarks.append(f"{cited(label)} has {said}: taken for a car")
        return ActorKind.CAR if found is None else found

    def _code(self, column: str, rows: Ints) -> int:
        return int(self.cells.whole[column][rows[0]]) if column in self.cells.whole else UNSET

    def _size(self, quantity: str, kind: ActorKind, rows: Ints, name: str) -> float:
        if quantity not in self.cells.numbers:
            return self._usual_size(quantity, kind, f"the table has no {quantity}")
        sizes = self.cells.numbers[quantity][rows]
        rows, sizes = rows[~np.isnan(sizes)], sizes[~np.isnan(sizes)]
        is_known = len(sizes) if self.cells.layout is None else (sizes > 0.0).any()  # 0 of a known tool: unknown
        if not is_known:
            return self._usual_size(quantity, kind, f"the table has no {quantity} of a {kind.name.casefold()}")
        if not (sizes > 0.0).all():
            row = int(rows[np.flatnonzero(~(sizes > 0.0))[0]])
            raise InterchangeError(f"a {quantity} of {sizes.min():g} m", "sizes are above 0", self.cells.place(row))
        if sizes.max() > LONGEST:
            place = self.cells.place(int(rows[int(sizes.argmax())]), quantity)
            cure = "write metres" if self.cells.omega_prime else f"if it is in mm, call the column `{quantity} [mm]`"
            raise InterchangeError(f"a {quantity} of {sizes.max():g} m is above {LONGEST:g} m", cure, place)
        if np.ptp(sizes) > SAME_PLACE:
            self.remarks.append(f"the {quantity} of {cited(name)} changes; its median is taken")
        return float(np.median(sizes))

    def _usual_size(self, quantity: str, kind: ActorKind, found: str) -> float:
        layout = self.cells.layout
        if layout is not None and kind in layout.sizes:
            return layout.sizes[kind][("length", "width").index(quantity)]
        self.remarks.append(f"{found}: each has that of its kind in cortexc")
        return float(getattr(MODELS[kind], quantity))

    def _velocity(self, name: str, motion: Motion, rows: Ints) -> AssumedColumn | None:
        """Return the velocities of the centre as they are believed; None without columns of them."""
        numbers, columns = self.cells.numbers, self.cells.columns
        if not all(each in numbers for each in VELOCITY):
            return None
        velocity = np.column_stack([numbers[each][rows] for each in VELOCITY])
        called = ", ".join(columns[each].name for each in VELOCITY)
        unit = columns[VELOCITY[0]].factor if columns[VELOCITY[0]].unit else 0.0
        held = held_speeds(name, called, motion, velocity, unit)
        self._remark(held.remark)
        return held

    def _remark(self, remark: str) -> None:
        if remark:
            self.remarks.append(remark)

    def _speed(
        self, name: str, motion: Motion, velocity: AssumedColumn | None, heading: Floats, rows: Ints, behind: float
    ) -> tuple[Floats, float]:
        """Return the rear axle's speed [m/s], and the distance of the centre ahead of it [m]."""
        numbers, columns = self.cells.numbers, self.cells.columns
        known, ahead = ~np.isnan(heading), np.nan_to_num(heading)  # noise without a heading is not a speed
        if velocity is not None:
            turning_point = _turning_point(motion, velocity.values, ahead, behind, slides(self.cells, rows))
            return along_heading(velocity.values, ahead) * known, turning_point
        if "speed" in numbers:
            speed, unit = numbers["speed"][rows], columns["speed"].factor if columns["speed"].unit else 0.0
            held = held_speeds(name, columns["speed"].name, motion, speed[:, np.newaxis] * along(ahead), unit)
            self._remark(held.remark)
            return (along_heading(held.values, ahead) * known if held.remark else speed), behind
        self.remarks.append("the table has no speeds: they are taken from motion")
        return along_heading(motion.rates(motion.positions - behind * along(ahead)), ahead) * known, behind


def _turning_point(motion: Motion, velocity: Floats, heading: Floats, usual: float, loose: Bools) -> float:
    """Return the distance of the centre ahead of the point without lateral velocity in a turn, the rear axle [m].

    Every driven sample of a turn gives it: the centre's velocity across the heading over the yaw rate. Samples after
    contact do not: in a table of cortexc they begin with the single sample off the steps. Samples at which the actor is
    `loose` do not either. If samples disagree, as measured ones do, it is the usual distance of such a body.
    """
    last = driven(motion.time)
    turning = rates(motion.time[:last], heading[:last], motion.pieces[:last])
    swing = (velocity * across(heading)).sum(axis=1)[:last]
    shown = (np.abs(turning) > TURNING) & ~loose[:last]
    if not shown.any():
        return usual
    distances = swing[shown] / turning[shown]
    middle = float(np.median(distances))
    agreed = np.count_nonzero(np.abs(distances - middle) < SAME_PLACE)
    return middle if 2 * agreed > len(distances) else usual
