"""Tables of trajectories as recordings: omega-prime's columns, or a plain table with one row per actor and time; and
the check of a written table, which is read back and compared with the run.

Positions are centres of outlines. `.columns` has the columns of a plain table and their units.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.errors import InterchangeError, cited, name_cure, reading
from engine.host import MAX_SAMPLES
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.motion import LONGEST_STEP, gaps_between, unseen_steps
from engine.interchange.openscenario.read import Imported
from engine.interchange.read_back import same_run
from engine.interchange.recording import MOST_ACTORS, SAME_INSTANT, RecordedActor, RecordedCase, Recording
from engine.interchange.tables.cells import Cells, read_csv_cells, read_parquet_cells
from engine.interchange.tables.columns import NO_NAMES
from engine.interchange.tables.conventions import pedestrians_beside
from engine.interchange.tables.facing import set_aside, with_assumed_headings
from engine.interchange.tables.heights import on_one_level
from engine.interchange.tables.track import TableTrack, Tracks
from engine.interchange.tables.tracks import tracks_of
from engine.tables import SLIDING, Bools, Floats
from engine.vehicles import MODELS
from engine.vocabulary import State

MOST_BYTES = 300_000_000
MOST_STATES = 2_000_000
"""Maximum number of samples times actors; such a recording takes 150 MB."""
NEARBY = 200.0
"""Distance to the ego [m]: from too large a recording, actors that never come nearer are omitted."""
MOST_NAMED = 3
"""Actors that a remark names."""
MIXED = 0.2
"""Largest difference between the usual steps of two actors with one rate, as a share of a step."""
ON_STEP = 0.01
"""Largest distance of a sample from a whole step on which it counts, in steps."""
DIGITS = 9
"""Decimals to which steps are rounded: nanoseconds."""


def read_table(path: Path, ego: str | None = None, step: float | None = None, rate: float | None = None) -> Imported:
    """Return the recording of a `.csv` or `.parquet` file; tables contain no road.

    `ego`: name of the ego, by default the table's ego, else its first actor; `step` [s]: time step of the measurement,
    by default the usual step of the table; `rate`: samples per second, if the time counts samples.

    Raises:
        InterchangeError: unreadable, or not a table of trajectories; with line and column if known.
    """
    return recording_of(read_tracks(path, rate), path.stem, ego, step)


def read_tracks(path: Path, rate: float | None = None, named: Mapping[str, str] = NO_NAMES) -> Tracks:
    """Return all actors of a table, and of the second table of a data set that writes two; as `read_table`.

    `named`: its columns by meaning, if their own names do not show it (`columns.choose`).
    """
    cells = _cells(path, rate, named)
    tracks = tracks_of(cells)
    if (other := pedestrians_beside(cells.layout, path)) is not None:
        tracks = joined(tracks, tracks_of(_cells(other, rate)))
    return with_assumed_headings(tracks)


def joined(one: Tracks, other: Tracks) -> Tracks:
    """Return the tracks of two tables of one recording; times count from the earlier beginning.

    Raises:
        InterchangeError: two actors have the same name.
    """
    begin = min(one.begin, other.begin)
    tracks = [replace(t, time=t.time + (each.begin - begin)) for each in (one, other) for t in each.tracks]
    if len({track.name for track in tracks}) < len(tracks):
        raise InterchangeError("two actors have the same name", f"rename one: `{one.file}` has it, too", other.file)
    remarks = dict.fromkeys((*one.remarks, f"`{other.file}` lies beside it, and is read, too", *other.remarks))
    return Tracks(tuple(tracks), tuple(remarks), one.file, begin, one.numbered)


Window = tuple[float, float]
"""Beginning and end [s] after the first row of a recording."""


def recording_of(
    tracks: Tracks, name: str, ego: str | None = None, step: float | None = None, window: Window | None = None
) -> Imported:
    """Return the recording of an ego and all actors, or of the actors near it if all are too many; only in `window` if
    given.

    Raises:
        InterchangeError: no actor has this name, even the near ones are too many, or the ego is not in the window.
    """
    ordered, chosen = _ego_first(tracks, ego)
    if window is not None:
        ordered = _within(ordered, window, tracks.file)
    ordered, on_levels = on_one_level(ordered)
    remaining, left_out = _whom_it_meets(ordered, tracks.file)
    time, remarks = _clock(remaining, tracks)
    remaining, aside = set_aside(remaining, lambda pair: states_of(pair, time), tracks.file)
    recording = Recording(
        name=name,
        actors=tuple(map(actor_of, remaining)),
        time=time - time[0],
        states=states_of(remaining, time),
        step=usual_step(time) if step is None else step,
        buildings=tracks.buildings,
        commands=False,
    )
    gaps = tuple(absences(remaining))
    return Imported(recording, None, (*tracks.remarks, *chosen, *on_levels, *left_out, *aside, *remarks, *gaps))


def _cells(path: Path, rate: float | None = None, named: Mapping[str, str] = NO_NAMES) -> Cells:
    """Return the cells of a file; raise InterchangeError if it does not exist or is of another kind."""
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise InterchangeError("this is not a table", "name a file that ends in .csv or .parquet", path.name)
    with reading(path, "a table of trajectories"):
        if (size := path.stat().st_size) > MOST_BYTES:
            message = f"the file has {size / 1e6:,.0f} MB"
            raise InterchangeError(
                message, f"leave out actors or samples: at most {MOST_BYTES / 1e6:.0f} MB", path.name
            )
        read = read_csv_cells if path.suffix.lower() == ".csv" else read_parquet_cells
        return read(path, rate, named)


def _ego_first(found: Tracks, ego: str | None) -> tuple[list[TableTrack], tuple[str, ...]]:
    """Return the tracks with the ego first, and remarks on the choice."""
    tracks = found.tracks
    names = [track.name for track in tracks]
    if ego is not None and ego not in names:
        raise InterchangeError(f"no actor is called {cited(ego)}", name_cure(ego, names), found.file)
    remarks: tuple[str, ...] = ()
    if ego is not None:
        first = names.index(ego)
    elif any(track.is_ego for track in tracks):
        first = [track.is_ego for track in tracks].index(True)
    else:
        labels = [track.label for track in tracks]
        first = labels.index("0") if found.numbered and "0" in labels else 0
        why = "the table does not say which idx is the ego's" if found.numbered else "no actor is called ego"
        remarks = (f"{why}: {cited(names[first])} is taken; name another with --ego",)
    return [tracks[first], *tracks[:first], *tracks[first + 1 :]], remarks


def actor_of(track: TableTrack) -> RecordedActor:
    """Return the actor of a track; properties that a table lacks are usual for its kind."""
    model, scale = MODELS[track.kind], track.length / MODELS[track.kind].length
    return RecordedActor(
        name=track.name,
        kind=track.kind,
        length=track.length,
        width=track.width,
        rear_to_center=track.rear_to_center,
        wheelbase=model.wheelbase * scale if model.rear_to_center else model.wheelbase,
        mass=model.mass,
        max_acceleration=model.max_acceleration,
        max_braking=model.max_braking,
        max_steer=model.max_steer,
        max_speed=model.top_speed,
    )


# -- presence with the ego --------------------------------------------------------------------------------------------


def _too_many(tracks: Sequence[TableTrack]) -> bool:
    instants = len(np.unique(np.concatenate([track.time for track in tracks])))
    return instants > 2 * MAX_SAMPLES or instants * len(tracks) > MOST_STATES or len(tracks) > MOST_ACTORS


def _whom_it_meets(tracks: list[TableTrack], file: str) -> tuple[list[TableTrack], tuple[str, ...]]:
    """Return all tracks, or the part near the ego while it is present if they are too many at too many instants."""
    if not _too_many(tracks):
        return tracks, ()
    ego = tracks[0]
    first, last = float(ego.time[0]), float(ego.time[-1])
    near = [ego, *(cut for track in tracks[1:] if (cut := _cut(track, first, last)) and _comes_near(cut, ego))]
    if len(near) > MOST_ACTORS:
        raise InterchangeError(f"there are {len(near):,} actors", f"leave at most {MOST_ACTORS:,} in it", file)
    message = (
        f"of {len(tracks):,} actors, those are judged who come nearer than {NEARBY:g} m to the ego: {len(near) - 1:,}"
    )
    return near, (f"{message}; times count from its first, {first:.12g} s",)


def _within(tracks: list[TableTrack], window: Window, file: str) -> list[TableTrack]:
    """Return the tracks within a window; the ego stays the first."""
    remaining = [cut for track in tracks if (cut := _cut(track, *window))]
    if not remaining or remaining[0].name != tracks[0].name:
        ego = tracks[0]
        there = f"name a window within {ego.time[0]:.6g} to {ego.time[-1]:.6g} s"
        raise InterchangeError(f"{cited(ego.name)} is not there from {window[0]:g} to {window[1]:g} s", there, file)
    return remaining


def _cut(track: TableTrack, first: float, last: float) -> TableTrack | None:
    """Return a track while the ego is present; None if it has no row then."""
    remaining = slice(*np.searchsorted(track.time, [first - SAME_INSTANT, last + SAME_INSTANT]).tolist())
    if remaining.start >= remaining.stop:
        return None
    return track.only(remaining)


def _comes_near(track: TableTrack, ego: TableTrack) -> bool:
    ways = [np.interp(track.time, ego.time, ego.positions[:, axis]) - track.positions[:, axis] for axis in (0, 1)]
    return bool((np.hypot(*ways) < NEARBY).any())


# -- time -------------------------------------------------------------------------------------------------------------


def _clock(tracks: Sequence[TableTrack], found: Tracks) -> tuple[Floats, tuple[str, ...]]:
    """Return all instants at which an actor has a row, and one in each gap, and remarks on them."""
    time = np.unique(np.concatenate([track.time for track in tracks]))
    if len(time) > 2 * MAX_SAMPLES or len(time) * len(tracks) > MOST_STATES:
        message = f"{len(time):,} instants of {len(tracks):,} actors"
        raise InterchangeError(message, "leave out actors, or take fewer samples a second", found.file)
    remarks = [] if found.begin == 0.0 else [f"times count from the table's first, {found.begin:.12g} s"]
    step = usual_step(time)
    steps = np.diff(time) / step
    uneven = np.count_nonzero(np.abs(steps - np.round(steps)) > ON_STEP)
    if uneven > 2:  # one instant of contact between two steps is regular
        uneven_steps = f"{uneven:,} of {len(steps):,} steps are uneven"
        remarks.append(f"{uneven_steps}: motion is taken as linear, in steps of {step:g} s")
    remarks.extend(mixed_rates(tracks, step))
    edges = np.array([track.time[[gap, gap + 1]] for track in tracks for gap in track.gaps]).reshape(-1, 2)
    empty = np.searchsorted(time, edges[:, 0], "right") == np.searchsorted(time, edges[:, 1])
    return np.unique(np.concatenate([time, edges[empty].mean(axis=1)])), tuple(remarks)


def absences(tracks: Sequence[TableTrack]) -> Iterator[str]:
    """Yield remarks on the first absences of a few actors."""
    found = [(track, gaps) for track in tracks if len(gaps := gaps_between(track.time))]
    for track, gaps in found[:MOST_NAMED]:
        begin, end = track.time[gaps[0]], track.time[gaps[0] + 1]
        more = f", and {len(gaps) - 1:,} times more" if len(gaps) > 1 else ""
        yield f"{cited(track.name)} is missing from {begin:.6g} to {end:.6g} s{more}"
    if len(found) > MOST_NAMED:
        yield f"{len(found) - MOST_NAMED:,} more actors are missing for a while"
    unseen = [(track, steps) for track in tracks if (steps := _unseen(track)).any()]
    for track, steps in unseen[:1]:
        first, number = int(np.argmax(steps)), sum(int(np.count_nonzero(each)) for _, each in unseen)
        where = f"{cited(track.name)} moves between rows {np.diff(track.time)[first]:.4g} s apart"
        yield (
            f"{where}, at {track.time[first]:.6g} s ({number:,} such steps in all): its way is not known there, and no "
            f"pair is judged; record a row every {LONGEST_STEP:g} s at least"
        )


def _unseen(track: TableTrack) -> Bools:
    """Return the unseen steps (samples - 1,) of an actor that is not missing at them."""
    found = unseen_steps(track.time, track.positions)
    found[gaps_between(track.time)] = False
    return found


def mixed_rates(tracks: Sequence[TableTrack], step: float) -> Iterator[str]:
    """Yield a remark on actors whose rows have other steps than the recording."""
    others = [(t.name, float(np.median(np.diff(t.time)))) for t in tracks if len(t.time) > 1]
    others = [(name, own) for name, own in others if abs(own - step) > MIXED * step]
    if others:
        named = ", ".join(f"{cited(name)} every {own:.4g} s" for name, own in others[:3])
        more = f" and {len(others) - 3:,} more" if len(others) > 3 else ""
        cure = "record all at one rate if that matters"
        yield f"rates are mixed: rows every {step:.4g} s, of {named}{more}; between them motion is linear: {cure}"


def usual_step(time: Floats) -> float:
    """Return the usual time between two instants, from all instants at its multiples [s]; 1 for a single instant."""
    if len(time) < 2:
        return 1.0
    usual = float(np.median(np.diff(time)))
    steps = (time - float(time[0])) / usual
    on = np.flatnonzero(np.abs(steps - np.round(steps)) < ON_STEP)
    last = int(on[-1])
    step = (time[last] - time[0]) / round(steps[last]) if last else usual
    return round(step, DIGITS) if abs(round(step, DIGITS) - step) * len(time) < 10.0**-DIGITS else float(step)


# -- states -----------------------------------------------------------------------------------------------------------


def states_of(tracks: Sequence[TableTrack], time: Floats) -> Floats:
    """Return (instants, actors, len(State)): an actor moves linearly between two of its rows and is absent outside
    them.
    """
    states = np.zeros((len(time), len(tracks), len(State)))
    for actor, track in enumerate(tracks):
        motion = np.column_stack([track.positions, track.heading, track.speed])
        for column, values in zip((State.X, State.Y, State.HEADING, State.SPEED), motion.T, strict=True):
            states[:, actor, column] = np.interp(time, track.time, values)
        there = (time >= track.time[0]) & (time <= track.time[-1])
        for gap in track.gaps:
            there &= (time <= track.time[gap]) | (time >= track.time[gap + 1])
        before = np.maximum(np.searchsorted(track.time, time, "right") - 1, 0)
        loose = False if track.slides is None else track.slides[before]
        states[:, actor, State.PRESENT] = np.where(loose, SLIDING, 1.0) * there
        states[1:, actor, State.ACCELERATION] = np.diff(states[:, actor, State.SPEED]) / np.diff(time)
    return states


# -- An exported table read back, and held against the run -------------------------------------------------------------


def check_table(case: RecordedCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """Yield differences between rows and the run above a millimetre."""
    for name in (each for each in names if each.endswith((".csv", ".parquet"))):
        try:
            read = read_table(folder / name, step=case.recording.step).recording
        except InterchangeError as error:
            yield Finding(error.place or name, error.message, error.cure)
            continue
        yield from same_run(case, read, name)
