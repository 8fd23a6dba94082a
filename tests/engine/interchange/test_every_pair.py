"""Every pair of a recording: what is near, what it comes to, and what is set aside."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange import InterchangeError, every_pair
from engine.interchange.every_pair import RankedWindows, rank_pairs
from engine.interchange.measuring import measure
from engine.interchange.sources import read_traffic
from engine.interchange.tables.read import recording_of
from engine.interchange.tables.track import TableTrack, Tracks
from engine.vocabulary import ActorKind
from tests.laws import examples

STEP = 0.1


def track(name: str, begin: int, positions: np.ndarray, *, gap: tuple[int, int] | None = None) -> TableTrack:
    """One who drives along positions at steps from `begin`; not there between the steps of `gap`."""
    steps = np.arange(len(positions), dtype=np.float64)
    way = np.gradient(positions, axis=0) / STEP if len(positions) > 1 else np.zeros((1, 2))
    kept = np.ones(len(steps), bool) if gap is None else (steps < gap[0]) | (steps >= gap[1])
    heading = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
    return TableTrack(
        label=name,
        name=name,
        kind=ActorKind.CAR,
        is_ego=False,
        time=((begin + steps) * STEP)[kept],
        positions=positions[kept],
        heading=heading[kept],
        speed=np.hypot(*way.T)[kept],
        length=4.5,
        width=1.8,
        rear_to_center=1.4,
    )


def crowd(seed: int, count: int = 7) -> Tracks:
    rng = np.random.default_rng(seed)
    tracks = []
    for number in range(count):
        steps = np.arange(int(rng.integers(20, 60)))
        turn = rng.uniform(-math.pi, math.pi) + 0.02 * rng.uniform(-1.0, 1.0) * steps
        way = np.cumsum(rng.uniform(1.0, 14.0) * STEP * np.column_stack([np.cos(turn), np.sin(turn)]), axis=0)
        positions = way - way[len(way) // 2] + rng.uniform(-35.0, 35.0, 2)
        gap = (10, 20) if number % 3 == 0 else None
        tracks.append(track(f"a{number}", int(rng.integers(0, 30)), positions, gap=gap))
    return Tracks(tuple(tracks), (), "crowd")


def windows_by_hand(tracks: Tracks, near: float) -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Sample by sample: of each stretch in which two are there, the first and the last near sample."""
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    at = [{round(t / STEP): p for t, p in zip(each.time, each.positions, strict=True)} for each in tracks.tracks]
    for one in range(len(at)):
        for other in range(one + 1, len(at)):
            stretch: list[int] = []
            both = sorted(at[one].keys() & at[other].keys())
            for step in [*both, 10**9]:
                if stretch and step != stretch[-1] + 1:
                    if any(stretch_near := [k for k in stretch if np.hypot(*(at[one][k] - at[other][k])) < near]):
                        names = tracks.tracks[one].name, tracks.tracks[other].name
                        found.setdefault(names, []).append((stretch_near[0] * STEP, stretch_near[-1] * STEP))
                    stretch = []
                stretch.append(step)
    return found


def windows_of(ranked: RankedWindows) -> dict[tuple[str, str], list[tuple[float, float]]]:
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in np.lexsort((ranked.begin,)):
        one, other = (int(actor) for actor in ranked.actors[row])
        spans = found.setdefault((ranked.names[one], ranked.names[other]), [])
        spans.append((float(ranked.begin[row]), float(ranked.end[row])))
    return found


@examples(20)
@given(seed=st.integers(0, 10_000), near=st.sampled_from([5.0, 20.0, 50.0]))
def test_windows_are_those_of_a_search_by_hand(seed: int, near: float) -> None:
    """Steps are passed, and none is missed; who overlaps from the start is counted apart."""
    tracks = crowd(seed)
    ranked = rank_pairs(tracks, near=near)
    expected = windows_by_hand(tracks, near)
    aside = set(ranked.overlapping)
    ours = {pair: spans for pair, spans in windows_of(ranked).items() if pair not in aside}
    assert set(ours) == set(expected) - aside
    for pair, spans in ours.items():
        assert np.array(spans) == pytest.approx(np.array(expected[pair]), abs=1e-9)


@examples(10)
@given(seed=st.integers(0, 10_000))
def test_a_window_is_judged_as_a_recording_of_the_two_alone(seed: int) -> None:
    """The same numbers as `measure`, whoever else is there."""
    tracks = crowd(seed, count=5)
    ranked = rank_pairs(tracks)
    for row in range(len(ranked)):
        pair = [tracks.tracks[actor] for actor in ranked.actors[row].tolist()]
        cut = [_within(each, ranked.begin[row], ranked.end[row]) for each in pair]
        alone = measure(recording_of(Tracks(tuple(cut), (), "pair"), "pair", cut[0].name, STEP).recording)
        assert ranked.score[row] == alone.risk.score[0]
        for name in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms", "closing_speed"):
            ours, theirs = getattr(ranked.outcomes, name)[row, 0], getattr(alone.outcomes, name)[0, 0]
            assert ours == pytest.approx(theirs, abs=1e-9), name
        nearest = ranked.outcomes.min_distance_time[row, 0] - ranked.begin[row]
        assert nearest == pytest.approx(alone.outcomes.min_distance_time[0, 0], abs=1e-9)
        assert bool(ranked.outcomes.collided[row]) == bool(alone.outcomes.collided[0])


def _within(one: TableTrack, begin: float, end: float) -> TableTrack:
    from dataclasses import replace

    kept = (one.time >= begin - 1e-9) & (one.time <= end + 1e-9)
    return replace(
        one, time=one.time[kept], positions=one.positions[kept], heading=one.heading[kept], speed=one.speed[kept]
    )


def straight(x: float, y: float, vx: float, vy: float, steps: int = 60) -> np.ndarray:
    return np.array([(x + vx * STEP * k, y + vy * STEP * k) for k in range(steps)])


def test_the_worst_comes_first_and_third_parties_end_nothing() -> None:
    """`a` runs into `b`; who passes `a` later is judged, and marked; a trailer is set aside."""
    tracks = Tracks(
        (
            track("a", 0, straight(0.0, 0.0, 10.0, 0.0)),
            track("b", 0, straight(20.0, 0.0, 0.001, 0.0)),
            track("c", 0, straight(60.0, 6.0, -5.0, 0.0)),
            track("trailer", 0, straight(-4.0, 0.0, 10.0, 0.0)),
        ),
        (),
        "four",
    )
    ranked = rank_pairs(tracks)
    names = [tuple(ranked.names[actor] for actor in pair) for pair in ranked.actors.tolist()]
    assert names[0] == ("a", "b")
    assert ranked.outcomes.collided[0]
    assert ranked.ttc[0] == 0.0
    assert ranked.ttc_time[0] == pytest.approx((20.0 - 4.5) / 10.0, abs=0.01)
    assert list(ranked.overlapping) == [("a", "trailer")]
    passing = names.index(("a", "c"))
    assert not ranked.outcomes.collided[passing]
    assert ranked.outcomes.min_distance[passing, 0] == pytest.approx(6.0 - 1.8)
    assert ranked.after_contact[passing]
    assert not ranked.after_contact[0]
    assert (np.diff(ranked.score) <= 0).all()


@given(seed=st.integers(0, 2**32 - 1))
@examples(40)
def test_who_had_touched_a_third_is_who_a_search_of_all_finds(seed: int) -> None:
    """Before the two were nearest, one of them had a contact with somebody else."""
    rng = np.random.default_rng(seed)
    windows = np.array([rng.choice(5, 2, replace=False) for _ in range(12)])
    when, touched = rng.integers(0, 5, 12).astype(float), rng.random(12) < 0.6
    outcomes = SimpleNamespace(min_distance_time=when[:, np.newaxis], collided=touched)

    def had(actor: int, partner: int, time: float) -> bool:
        rows = [row for row in range(12) if touched[row] and actor in windows[row] and when[row] < time]
        return any(partner not in windows[row] for row in rows)

    wanted = [had(a, b, t) or had(b, a, t) for (a, b), t in zip(windows.tolist(), when, strict=True)]
    assert every_pair._after_contact(windows, cast("Any", outcomes), 5).tolist() == wanted


def test_what_is_too_much_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples and windows are bounded, with a cure; an unknown profile has one, too."""
    tracks = crowd(1)
    with pytest.raises(InterchangeError, match="there is no risk profile"):
        rank_pairs(tracks, profile="mine")
    monkeypatch.setattr(every_pair, "MOST_JUDGED", 7)
    with pytest.raises(InterchangeError, match="near one another at"):
        rank_pairs(tracks)
    monkeypatch.setattr(every_pair, "MOST_WINDOWS", 2)
    with pytest.raises(InterchangeError, match="more than 2 times"):
        rank_pairs(tracks)
    monkeypatch.setattr(every_pair, "MOST_ROWS", 5)
    with pytest.raises(InterchangeError, match="samples on steps"):
        rank_pairs(tracks)


def test_nobody_near_is_no_row(tmp_path: Path) -> None:
    """One alone, and two far apart."""
    path = tmp_path / "t.csv"
    for rows in (["0,a,0,0"], ["0,a,0,0", "0,b,900,0", "0.1,a,1,0", "0.1,b,900,0"]):
        path.write_text("\n".join(["time,id,x,y", *rows]))
        assert len(rank_pairs(read_traffic(path))) == 0
