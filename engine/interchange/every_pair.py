"""`cortexc measure --all`: every pair of a recording that comes near, assessed while it is near, worst first.

There is no ego: any two actors are a pair, from the first sample at which their centres are nearer than `NEAR` to the
last, while both are present. The result of a pair equals that of `measuring` for a recording of the two actors alone,
cut to that window. A pair that overlaps from its first sample (a trailer, a rider and a bicycle, sizes that are too
large) has no defined start: it is counted, but not ranked.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from engine.display import counted
from engine.errors import InterchangeError, cited
from engine.host import pair_arrays
from engine.interchange.measuring import outcomes_of
from engine.interchange.recording import SAME_INSTANT, Recording
from engine.interchange.tables.facing import decides, undecided
from engine.interchange.tables.heights import height_between, height_ranges, level_remarks
from engine.interchange.tables.read import absences, actor_of, mixed_rates, usual_step
from engine.interchange.tables.track import TableTrack, Tracks
from engine.kernels.every_pair import (
    CONTACT,
    FASTEST_AT,
    NEAREST_AT,
    OVERLAPPING,
    TOUCHED,
    TTC,
    TTC_TIME,
    RecordedActors,
    judge_windows,
    near_windows,
)
from engine.kernels.pair import PLACES, ROWS
from engine.outcomes import PAIRS, Outcomes, blank_outcomes
from engine.risk import PROFILES, assess
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import LEVEL, State, Verdict

NEAREST = PLACES.index(ROWS.index("min_distance"))
NEAR = 50.0
"""Distance between two centres above which they have no window [m]."""
MOST_WINDOWS = 1_000_000
MOST_JUDGED = 100_000_000
"""Maximum number of samples of all windows: more take minutes."""
MOST_ROWS = 8_000_000
"""Maximum number of samples of all actors; a kernel holds them in 0.6 GB."""


@dataclass(frozen=True)
class RankedWindows:
    """Windows of pairs, the worst first; arrays are row-aligned, times [s] are those of the recording."""

    names: Sequence[str]
    """Names of all actors."""
    kinds: Ints
    """(actors,)"""
    step: float
    """Time step of the measurement [s]."""
    actors: Ints
    """(windows, 2)"""
    begin: Floats
    end: Floats
    outcomes: Outcomes
    """One row per window: the pair's metrics, with the first actor as ego."""
    score: Ints
    ttc: Floats
    """Least time to collision [s], infinite if none is expected."""
    ttc_time: Floats
    after_contact: Bools
    """True if an actor of the pair had touched a third actor before the pair was nearest."""
    overlapping: Sequence[tuple[str, str]]
    """Pairs that overlap from the first sample of a window."""
    remarks: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.score)

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        worst = f", the worst of risk {self.score[0]}" if len(self) else ""
        return f"RankedWindows({counted(len(self.names), 'actor')}, {counted(len(self), 'window')}{worst})"


def rank_pairs(
    tracks: Tracks, *, near: float = NEAR, step: float | None = None, profile: str = "paper"
) -> RankedWindows:
    """Assess every pair while its centres are nearer than `near` [m], on steps of `step` [s] or those of the recording.

    Raises:
        InterchangeError: no motion on steps; too many samples or windows; no such profile.
    """
    if profile not in PROFILES:
        raise InterchangeError(f"there is no risk profile `{profile}`", f"name one of {', '.join(PROFILES)}")
    own = usual_step(np.unique(np.concatenate([track.time for track in tracks.tracks])))
    on = own if step is None else step
    crowd = _crowd(tracks, on)
    windows = near_windows(crowd, near, MOST_WINDOWS)
    if len(windows) >= MOST_WINDOWS:
        cure = "look nearer, as in --near 20, or at a part of it"
        raise InterchangeError(f"more than {MOST_WINDOWS:,} times two come near", cure, tracks.file)
    if (judged := int((windows[:, 3] - windows[:, 2] + 1).sum())) > MOST_JUDGED:
        cure = "look nearer, as in --near 20, or take a longer step"
        raise InterchangeError(f"pairs are near one another at {judged:,} samples", cure, tracks.file)
    rows = judge_windows(crowd, windows, on)
    _judge_between_steps(tracks, windows, rows, on)
    aside = _decided_by_assumption(tracks, windows, rows, on)
    levels = _on_other_levels(tracks, windows, on)
    pairs = dict.fromkeys((one, other, round(above, 1)) for one, other, above in levels.values())
    said = (*mixed_rates(tracks.tracks, own), *absences(tracks.tracks), *_between_steps(tracks, on))
    remarks = (*tracks.remarks, *said, *level_remarks(list(pairs)), *dict.fromkeys(aside.values()))
    remaining = np.setdiff1d(np.arange(len(windows)), [*aside, *levels])
    return _ranked(tracks, windows[remaining], rows[remaining], on, profile, remarks)


# -- from tracks to a crowd --------------------------------------------------------------------------------------------


def _crowd(tracks: Tracks, step: float) -> RecordedActors:
    spans = [_steps(track, step) for track in tracks.tracks]
    offset = np.concatenate([[0], np.cumsum([end - begin for begin, end in spans])]).astype(np.int64)
    if offset[-1] > MOST_ROWS:
        message = f"{offset[-1]:,} samples on steps of {step:g} s"
        raise InterchangeError(message, "take a longer step, as in --step 0.1", tracks.file)
    states = np.zeros((int(offset[-1]), len(State)))
    for (begin, end), row, track in zip(spans, offset.tolist(), tracks.tracks, strict=False):
        _fill(states[row : row + end - begin], track, np.arange(begin, end, dtype=np.float64) * step)
    return RecordedActors(
        states,
        offset,
        np.array([begin for begin, _ in spans], dtype=np.int64),
        np.array([(track.length, track.width, track.rear_to_center) for track in tracks.tracks]),
        np.array([_bounds(track) for track in tracks.tracks]),
        np.array([_fastest(states[a:b]) for a, b in zip(offset[:-1].tolist(), offset[1:].tolist(), strict=True)]),
    )


def _steps(track: TableTrack, step: float) -> tuple[int, int]:
    """Return the first step with an actor, and the step after the last; an empty range if it is between two steps."""
    first = math.ceil((track.time[0] - SAME_INSTANT) / step)
    return first, max(first, math.floor((track.time[-1] + SAME_INSTANT) / step) + 1)


def _fill(states: Floats, track: TableTrack, instants: Floats) -> None:
    """Fill an actor's states: linear between two of its rows, absent in a gap."""
    motion = zip(
        (State.X, State.Y, State.HEADING, State.SPEED), (*track.positions.T, track.heading, track.speed), strict=True
    )
    for column, values in motion:
        states[:, column] = np.interp(instants, track.time, values)
    states[:, State.PRESENT] = 1.0
    for gap in track.gaps.tolist():
        begin = int(np.searchsorted(instants, track.time[gap] + SAME_INSTANT, "right"))
        end = int(np.searchsorted(instants, track.time[gap + 1] - SAME_INSTANT))
        states[begin : max(end, begin + 1), State.PRESENT] = 0.0  # a gap without an instant: the instant after it


def _bounds(track: TableTrack) -> tuple[float, float, float, float]:
    x, y = track.positions.T
    return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def _fastest(states: Floats) -> float:
    """Return the longest displacement of a step [m]; infinite if no step may be skipped."""
    if not states[:, State.PRESENT].all():
        return math.inf
    ways = np.diff(states[:, [State.X, State.Y]], axis=0)
    return float(np.hypot(ways[:, 0], ways[:, 1]).max(initial=0.0))


# -- actors with rows between steps, as at contact in our recordings ---------------------------------------------------

CLOSE = 1.0
"""Distance at all steps above which a pair cannot touch between two of them [m]."""
ON_STEP = 1e-6
"""Largest distance of a row from a step on which it counts [s]."""


def _judge_between_steps(tracks: Tracks, windows: Ints, rows: Floats, step: float) -> None:
    """Assess the closest pairs again at every instant at which one of the actors has a row."""
    off = np.array(
        [bool((np.abs(t.time / step - np.round(t.time / step)) * step > ON_STEP).any()) for t in tracks.tracks]
    )
    close = (rows[:, CONTACT] != OVERLAPPING) & (rows[:, NEAREST] < CLOSE)
    for row in np.flatnonzero(close & (off[windows[:, 0]] | off[windows[:, 1]])).tolist():
        one, other, first, last = (int(value) for value in windows[row])
        outcomes = outcomes_of(_alone((tracks.tracks[one], tracks.tracks[other]), first * step, last * step, step))
        rows[row, : len(PLACES)] = [float(getattr(outcomes, ROWS[place])[0, 0]) for place in PLACES]
        rows[row, [NEAREST_AT, FASTEST_AT]] += first * step
        if outcomes.collided[0]:
            rows[row, [CONTACT, TTC, TTC_TIME]] = TOUCHED, 0.0, rows[row, NEAREST_AT]


def _decided_by_assumption(tracks: Tracks, windows: Ints, rows: Floats, step: float) -> dict[int, str]:
    """Return remarks, by row, on windows in which contact depends on an assumed heading."""
    assumed = np.array([t.assumed is not None and bool(t.assumed.any()) for t in tracks.tracks])
    touch = (rows[:, CONTACT] == TOUCHED) & assumed[windows[:, :2]].any(axis=1)
    found: dict[int, str] = {}
    for row in np.flatnonzero(touch).tolist():
        one, other, first, last = (int(value) for value in windows[row])
        pair = (tracks.tracks[one], tracks.tracks[other])
        if decides(pair, _alone(pair, first * step, last * step, step).states)[1]:
            found[row] = undecided(pair)
    return found


def _on_other_levels(tracks: Tracks, windows: Ints, step: float) -> dict[int, tuple[str, str, float]]:
    """Return the windows, by row, of two at different heights: both names, and the height of the second above [m]."""
    found: dict[int, tuple[str, str, float]] = {}
    low, high = (end[windows[:, :2]] for end in height_ranges(tracks.tracks).T)
    may_be_apart = (high - low[:, ::-1]).max(axis=1, initial=-np.inf) >= LEVEL
    for row in np.flatnonzero(may_be_apart).tolist():
        one, other, first, last = (int(value) for value in windows[row])
        pair = (tracks.tracks[one], tracks.tracks[other])
        above, throughout = height_between(*pair, (first - 1) * step, (last + 1) * step)
        if throughout:
            found[row] = (pair[0].name, pair[1].name, above)
    return found


def _between_steps(tracks: Tracks, step: float) -> Iterator[str]:
    """Yield the remark on actors whose rows all lie between two steps."""
    found = [track for track in tracks.tracks if np.diff(_steps(track, step))[0] < 1]
    if found:
        more = f" and {len(found) - 1:,} more actors" if len(found) > 1 else ""
        cure = "take a shorter step, as in --step 0.01, or measure it with --ego"
        when = f"at {found[0].time[0]:.6g} s"
        yield f"{cited(found[0].name)}{more}, {when}: between two steps of {step:g} s only, and not judged; {cure}"


def _alone(pair: tuple[TableTrack, TableTrack], begin: float, end: float, step: float) -> Recording:
    """Return a recording of two actors alone, while both are present."""
    times = [track.time[(track.time > begin + ON_STEP) & (track.time < end - ON_STEP)] for track in pair]
    instants = np.unique(np.concatenate([[begin, end], *times]))
    instants = instants[np.append(True, np.diff(instants) > SAME_INSTANT)]
    states = np.zeros((len(instants), 2, len(State)))
    for number, track in enumerate(pair):
        _fill(states[:, number], track, instants)
    return Recording("pair", tuple(map(actor_of, pair)), instants - begin, states, step, commands=False)


# -- from numbers to ranks ---------------------------------------------------------------------------------------------


def _ranked(
    tracks: Tracks, windows: Ints, rows: Floats, step: float, profile: str, remarks: tuple[str, ...]
) -> RankedWindows:
    names = [track.name for track in tracks.tracks]
    apart = rows[:, CONTACT] != OVERLAPPING
    overlapping = [(names[int(row[0])], names[int(row[1])]) for row in windows[~apart]]
    windows, rows = windows[apart], rows[apart]
    outcomes = _outcomes(rows)
    risk = assess(outcomes, PROFILES[profile])
    nearest = outcomes.min_distance_time[:, 0]
    order = np.lexsort((nearest, outcomes.min_distance[:, 0], -risk.continuous, -risk.score))
    ordered = type(outcomes)(**{name: array[order] for name, array in vars(outcomes).items()})
    return RankedWindows(
        names=names,
        kinds=np.array([int(track.kind) for track in tracks.tracks], dtype=np.int32),
        step=step,
        actors=windows[order, :2].astype(np.int32),
        begin=windows[order, 2].astype(np.float64) * step,
        end=windows[order, 3].astype(np.float64) * step,
        outcomes=ordered,
        score=risk.score[order],
        ttc=rows[order, TTC],
        ttc_time=rows[order, TTC_TIME],
        after_contact=_after_contact(windows, outcomes, len(names))[order],
        overlapping=tuple(dict.fromkeys(overlapping)),
        remarks=remarks,
    )


def _outcomes(rows: Floats) -> Outcomes:
    """Return outcomes with the first actor of each row as ego."""
    count = len(rows)
    pairs = np.tile(np.array([row.fill for row in PAIRS], dtype=np.float64), (count, 1, 1))
    pairs[:, 0, list(PLACES)] = rows[:, : len(PLACES)]
    touched = rows[:, CONTACT] == TOUCHED
    arrays = pair_arrays(pairs + 0.0)  # -0.0 becomes 0
    ones = np.zeros(count, dtype=np.int32)
    return blank_outcomes(
        count,
        2,
        verdict=np.full(count, int(Verdict.VALID), dtype=np.int32),
        collided=touched,
        contact_actors=np.column_stack([np.where(touched, ones, -1), np.where(touched, 1, -1)]).astype(np.int32),
        **arrays,
    )


def _after_contact(windows: Ints, outcomes: Outcomes, actors: int) -> Bools:
    """Return (windows,) True where an actor of the pair had touched a third actor before the pair was nearest."""
    when: Floats = outcomes.min_distance_time[:, 0]
    whom = np.full(actors, -1)
    first, second = np.full(actors, math.inf), np.full(actors, math.inf)  # `second`: contact with a different partner
    touched = np.flatnonzero(outcomes.collided)
    for row in touched[np.argsort(when[touched], kind="stable")].tolist():
        one, other = (int(actor) for actor in windows[row, :2])
        for actor, met in ((one, other), (other, one)):
            if whom[actor] < 0:
                whom[actor], first[actor] = met, when[row]
            elif whom[actor] != met:
                second[actor] = min(second[actor], when[row])
    found = np.zeros(len(windows), dtype=np.bool_)
    for actor, partner in (windows[:, :2].T, windows[:, 1::-1].T):
        found |= np.where(whom[actor] == partner, second[actor], first[actor]) < when
    return found
