"""Laws of what a recording comes to: noise is not motion, a jump is a gap, and the place of the axes, the units and the
columns of a table decide nothing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from engine.interchange import InterchangeError
from engine.interchange.every_pair import rank_pairs
from engine.interchange.measuring import Measured, measure
from engine.interchange.motion import along
from engine.interchange.motion_headings import noise_of
from engine.interchange.recording import Recording
from engine.interchange.sources import read_recording, read_traffic
from engine.vocabulary import State
from tests.engine.interchange import test_sources as sources
from tests.engine.interchange.tables.test_write import recordings
from tests.laws import share

CAR = (4.5, 1.8)
RATE = 10.0
TURNS = (0.1, 0.7, 1.3, 2.2, 3.0, 4.4, 5.9)


@dataclass(frozen=True)
class Way:
    """Centres of an actor (samples, 2) and its headings (samples,)."""

    name: str
    places: np.ndarray
    heading: np.ndarray

    def moved(self, turn: float, mirror: bool) -> "Way":
        sign = -1.0 if mirror else 1.0
        cos, sin = math.cos(turn), math.sin(turn)
        flat = self.places * (1.0, sign)
        places = flat @ np.array([[cos, sin], [-sin, cos]]) + (3.0, -2.0)
        return Way(self.name, places, np.remainder(sign * self.heading + turn + math.pi, 2.0 * math.pi) - math.pi)


def way(name: str, x: float, y: float, heading: float, speeds: Sequence[float], turning: float = 0.0) -> Way:
    headings = heading + turning * np.arange(len(speeds)) / RATE
    steps = (np.array(speeds) / RATE)[:, np.newaxis] * np.column_stack([np.cos(headings), np.sin(headings)])
    return Way(name, np.cumsum(np.vstack([[[x, y]], steps[:-1]]), axis=0), headings)


STEADY = [10.0] * 50
SCENES = {
    "parked beside": (way("ego", 0, 0, 0, STEADY), way("p", 25, 2.6, 0, [0.0] * 50)),
    "parked in the way": (way("ego", 0, 0, 0, STEADY), way("p", 25, 0.4, 0, [0.0] * 50)),
    "creeping": (way("ego", 0, 0, 0, STEADY), way("p", 30, 3.0, 0.05, [0.6] * 50)),
    "backing out": (way("ego", 0, 0, 0, STEADY), way("p", 40, 9, -1.6, [-1.5] * 25 + [3.0] * 25)),
    "crossing": (way("ego", -20, 0, 0, STEADY), way("o", 9, -21, 1.5, [9.0] * 50)),
    "turning": (way("ego", -20, 0, 0, [6.0] * 50, 0.4), way("o", 20, 12, 3.1, [7.0] * 50, 0.1)),
    "stop and go": (way("ego", 0, 0, 0, [8.0] * 20 + [0.0] * 15 + [5.0] * 15), way("o", 60, 3.2, 3.1, [9.0] * 50)),
}
COLUMNS = ("time", "id", "x", "y", "heading", "speed", "length", "width")


def table(ways: Sequence[Way], leave_out: Sequence[str] = ()) -> str:
    kept = [name for name in COLUMNS if name not in leave_out]
    rows = [",".join(kept)]
    for each in ways:
        speed = np.gradient(each.places, 1 / RATE, axis=0)
        ahead = speed[:, 0] * np.cos(each.heading) + speed[:, 1] * np.sin(each.heading)
        for k, (x, y) in enumerate(each.places.tolist()):
            cells = {"time": k / RATE, "id": each.name, "x": x, "y": y, "heading": each.heading[k], "speed": ahead[k]}
            cells |= {"length": CAR[0], "width": CAR[1]}
            rows.append(",".join(str(cells[name]) for name in kept))
    return "\n".join(rows) + "\n"


@pytest.fixture
def judged(tmp_path: Path) -> Callable[[str], Measured]:
    def read(text: str) -> Measured:
        (tmp_path / "t.csv").write_text(text)
        return measure(read_recording(tmp_path / "t.csv", ego="ego").recording)

    return read


def remarks_of(folder: Path, text: str, ego: str | None = "ego") -> str:
    (folder / "t.csv").write_text(text)
    return "\n".join(read_recording(folder / "t.csv", ego=ego).remarks)


def distance(found: Measured) -> float:
    return float(found.outcomes.min_distance[0, 0])


LEFT_OUT = ((), ("heading",), ("speed",), ("heading", "speed"))


@pytest.mark.parametrize("leave_out", LEFT_OUT, ids="+".join)
@pytest.mark.parametrize("scene", SCENES)
def test_turned_and_mirrored_tables_have_equal_metrics(judged, scene: str, leave_out: Sequence[str]) -> None:
    """To 1e-6; of mirrored ones all that does not say left or right."""
    first = judged(table(SCENES[scene], leave_out))
    for turn in TURNS:
        for mirror in (False, True):
            other = judged(table([each.moved(turn, mirror) for each in SCENES[scene]], leave_out))
            assert other.risk.score.tolist() == first.risk.score.tolist()
            for one, two in zip(first.metrics, other.metrics, strict=True):
                assert one.name == two.name
                assert two.value == pytest.approx(one.value, abs=1e-6, rel=1e-6, nan_ok=True)


@pytest.mark.parametrize("scene", SCENES)
def test_fewer_columns_keep_the_verdict(judged, scene: str) -> None:
    """Contact or none; the least distance to 5 cm."""
    first = judged(table(SCENES[scene]))
    for leave_out in LEFT_OUT[1:]:
        found = judged(table(SCENES[scene], leave_out))
        assert bool(found.outcomes.collided[0]) == bool(first.outcomes.collided[0])
        assert distance(found) == pytest.approx(distance(first), abs=0.05)


@pytest.mark.parametrize("scene", ["parked beside", "parked in the way", "creeping", "crossing", "stop and go"])
@pytest.mark.parametrize("noise", [0.002, 0.005, 0.01, 0.02])
def test_noise_is_not_motion(judged, scene: str, noise: float) -> None:
    """Noise of all positions below 20 mm changes the least distance by less than 5 cm."""
    random = np.random.default_rng(5)
    exact = distance(judged(table(SCENES[scene])))
    for _ in range(3):
        shaken = []
        for each in SCENES[scene]:
            angle, share_of = random.uniform(0, 1, (2, len(each.heading)))
            off = noise * share_of[:, np.newaxis] * along(2 * math.pi * angle)
            shaken.append(replace(each, places=each.places + off))
        assert distance(judged(table(shaken, ("heading", "speed")))) == pytest.approx(exact, abs=0.05)


@pytest.mark.parametrize("rate", [5.0, 10.0, 25.0, 100.0])
def test_noise_is_estimated(rate: float) -> None:
    """Of a car that brakes and turns; without noise there is next to none."""
    time = np.arange(200) / rate
    heading = 0.3 * np.sin(time)
    speed = 12.0 - 2.0 * np.minimum(time, 4.0)
    places = np.cumsum((speed / rate)[:, np.newaxis] * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    assert noise_of(time, places) < 0.002
    random = np.random.default_rng(1)
    for deviation in (0.005, 0.02, 0.1):
        found = noise_of(time, places + random.normal(0.0, deviation, places.shape))
        assert found == pytest.approx(deviation, rel=0.25)


def test_a_standing_actor_without_heading_is_named(tmp_path: Path) -> None:
    """Its heading is that of the traffic beside it, and said to be assumed."""
    for turn in (0.0, *TURNS):
        ways = [each.moved(turn, False) for each in SCENES["parked beside"]]
        assert "no motion shows the heading of `p`" in remarks_of(tmp_path, table(ways, ("heading", "speed")))
        tracks = read_traffic(tmp_path / "t.csv").tracks
        assert math.cos(tracks[1].heading[0] - turn) == pytest.approx(1.0)
        assert [track.assumed is not None and bool(track.assumed.all()) for track in tracks] == [False, True]


def test_no_contact_is_made_by_an_assumed_heading(judged, tmp_path: Path) -> None:
    """A car that stands across the road is not taken to reach as far as one along it; but who is run over is."""
    stop = [10.0] * 20 + [0.0] * 30
    across = (way("ego", 0, 0, 0, stop), way("p", 20 + 2.25 + 0.9 + 0.6, 0, math.pi / 2, [0.0] * 50), SIDE)
    assert distance(judged(table(across))) == pytest.approx(0.6, abs=1e-3)
    text = table(across, ("heading", "speed"))
    assert "whether `ego` and `p` touch depends on the heading of `p`" in remarks_of(tmp_path, text)
    assert not judged(text).outcomes.collided[0]
    ranked = rank_pairs(read_traffic(tmp_path / "t.csv"))
    assert any("whether `ego` and `p` touch depends on the heading" in remark for remark in ranked.remarks)
    assert {"ego", "p"} not in [{ranked.names[one], ranked.names[two]} for one, two in ranked.actors.tolist()]
    over = table(SCENES["parked in the way"], ("heading", "speed"))
    assert judged(over).outcomes.collided[0]
    assert "depends on the heading" not in remarks_of(tmp_path, over)


SIDE = way("s", 0, 12, 0, STEADY)


def test_without_any_motion_nothing_is_judged(tmp_path: Path) -> None:
    """Two that stand, of unknown headings."""
    text = "time,id,x,y\n" + "".join(f"{k / 10},{name},{x},0\n" for k in range(9) for name, x in (("ego", 0), ("b", 5)))
    with pytest.raises(InterchangeError, match="nothing shows the heading of `ego`, `b`") as caught:
        remarks_of(tmp_path, text)
    assert "heading" in caught.value.cure


def recorded_table(one: Recording, leave_out: Sequence[str]) -> str:
    """The rows of a run of ours as a plain table."""
    kept = [name for name in (*COLUMNS, "type") if name not in leave_out]
    rows = [",".join(kept)]
    for k, number in np.argwhere(one.there).tolist():
        state, actor = one.states[k, number], one.actors[number]
        cells = {"time": one.time[k], "id": actor.name, "x": state[State.X], "y": state[State.Y]}
        cells |= {"heading": math.remainder(state[State.HEADING], 2 * math.pi), "speed": state[State.SPEED]}
        cells |= {"length": actor.length, "width": actor.width, "type": actor.kind.name.lower()}
        rows.append(",".join(str(cells[name]) for name in kept))
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize("leave_out", LEFT_OUT[1:], ids="+".join)
def test_recordings_of_ours_keep_their_verdict_with_fewer_columns(tmp_path: Path, leave_out: Sequence[str]) -> None:
    """Who touches whom; the least distance to 5 cm. In a turn the centre of a car does not move where its front points.

    At its begin the heading of a turn that is not steady does not show: motion tells it after a length of the car.
    """
    for one in recordings():
        (tmp_path / "t.csv").write_text(recorded_table(one, leave_out))
        tracks = read_traffic(tmp_path / "t.csv").tracks
        read = read_recording(tmp_path / "t.csv", ego=one.actors[0].name).recording
        own, found = measure(one).outcomes, measure(read).outcomes
        assert [actor.name for actor in read.actors] == [actor.name for actor in one.actors]
        assert found.contact_actors.tolist() == own.contact_actors.tolist()
        assert found.end_time[0] == pytest.approx(own.end_time[0], abs=0.02)
        shown = {track.name for track in tracks if track.assumed is None}
        for number, actor in enumerate(one.actors[1:]):
            if actor.name in shown and own.min_distance_time[0, number] > 0.5:
                least = own.min_distance[0, number]
                assert found.min_distance[0, number] == pytest.approx(least, abs=0.05, rel=2e-3)


def test_rejected_velocities_show_no_heading(judged, tmp_path: Path) -> None:
    """Those of the body's own frame, for any course."""
    for turn in (0.5, 1.5, 2.5):
        pair = [each.moved(turn, False) for each in SCENES["crossing"]]
        rows = ["time,id,x,y,vx,vy,length,width"]
        for each, speed in zip(pair, (10.0, 9.0), strict=True):
            places = enumerate(each.places.tolist())
            rows += [f"{k / RATE},{each.name},{x},{y},{speed},0,4.5,1.8" for k, (x, y) in places]
        found = judged("\n".join(rows))
        exact = judged(table(pair))
        assert distance(found) == pytest.approx(distance(exact), abs=1e-6)
        assert found.outcomes.fault.tolist() == exact.outcomes.fault.tolist()
        assert "speeds of `ego` do not fit its positions" in remarks_of(tmp_path, "\n".join(rows))


# -- jumps -------------------------------------------------------------------------------------------------------------


def test_every_planted_jump_is_named_and_driven_by_nobody(tmp_path: Path) -> None:
    """Teleports once and for a sample, names used again, names exchanged: 100 of 100, and no contact comes from one."""
    random = np.random.default_rng(3)
    for number in range(share(100)):
        samples, at = 60, int(random.integers(3, 56))
        ego = way("ego", 0, 0, 0, [10.0] * samples)
        other = way("o", 30, 0, 0, [10.0] * samples)
        places = other.places.copy()
        jump = random.uniform(20.0, 90.0) * (1 if number % 2 else -1)
        leave_out = LEFT_OUT[number % 4]
        if number % 3 == 0:  # for one sample
            places[at] += (jump, 0.0)
        elif number % 3 == 1:
            places[at:] += (-math.copysign(70.0, 1.0), 0.0)
        else:  # two exchange their names
            third = way("t", -30, 0, 0, [10.0] * samples)
            places[at:] = third.places[at:]
        text = table([ego, replace(other, places=places)], leave_out)
        found = remarks_of(tmp_path, text)
        assert "`o` jumps" in found, (number, found)
        read = read_recording(tmp_path / "t.csv", ego="ego").recording
        result = measure(read)
        assert not result.outcomes.collided[0], number
        assert distance(result) == pytest.approx(25.5, abs=1e-6), number
        assert not measure(replace(read, step=0.5)).outcomes.collided[0]
        assert distance(measure(replace(read, step=0.5))) == pytest.approx(25.5, abs=1e-6)
        (window, *_) = rank_pairs(read_traffic(tmp_path / "t.csv"), near=100.0).outcomes.min_distance[:, 0]
        assert window == pytest.approx(25.5, abs=1e-6)


@pytest.mark.parametrize("aside", [1.9, 2.5, 3.5])
@pytest.mark.parametrize("rate", [10.0, 25.0])
def test_exchanged_names_are_no_contact(judged, tmp_path: Path, aside: float, rate: float) -> None:
    """Two cars side by side whose names are exchanged on the way did not drive through one another."""
    rows, seconds = [], np.arange(0.0, 5.0, 1.0 / rate)
    for time in seconds.tolist():
        places = [(10.0 * time, 0.0), (10.0 * time + 1.0, aside)]
        for name, (x, y) in zip(("ego", "b"), places if time < 2.5 else places[::-1], strict=True):
            rows.append(f"{time:.3f},{name},{x:.4f},{y},4.5,1.8")
    text = "\n".join(["time,actor,x,y,length,width", *rows])
    assert not judged(text).outcomes.collided[0]
    assert "jumps" in remarks_of(tmp_path, text)


def test_seconds_without_rows_are_named(tmp_path: Path) -> None:
    """Whoever has few rows is absent between them, or the rates are mixed: `measure` and `--all` say which."""
    dense = [f"{k / 10},ego,{k},0,4.5,1.8" for k in range(51)]
    for times, said in (((0.0, 0.1, 5.0), "missing from 0.1 to 5 s"), ((0.0, 5.0), "rates are mixed")):
        rows = [f"{time},b,{10 * time},{30 - 12 * time},4.5,1.8" for time in times]
        text = "\n".join(["time,actor,x,y,length,width", *dense, *rows])
        assert said in remarks_of(tmp_path, text)
        assert said in " ".join(rank_pairs(read_traffic(tmp_path / "t.csv")).remarks)


def test_who_shares_a_name_with_another_is_left_out(tmp_path: Path) -> None:
    """Two in turn under one name are not one who goes to and fro, nor one at a great speed."""
    rows = [f"{k / 10},ego,{k},0,0" for k in range(30)]
    rows += [f"{k / 10},o,{k + (40 if k % 2 else 80)},0,0" for k in range(30)]
    rows += [f"{k / 10},q,{k},9,0" for k in range(30)]
    text = "\n".join(["time,id,x,y,heading", *rows])
    assert "`o` jumps 29 times" in remarks_of(tmp_path, text)
    assert [track.name for track in read_traffic(tmp_path / "t.csv").tracks] == ["ego", "q"]


def test_no_impact_and_no_hard_driver_jumps(tmp_path: Path) -> None:
    """A stop from 30 m/s within a step, 10 m/s^2 of braking, and 170 m/s all the way."""
    for speeds in ([30.0] * 20 + [0.0] * 20, [30.0] * 10 + [max(0.0, 30.0 - k) for k in range(40)], [170.0] * 30):
        assert "jumps" not in remarks_of(tmp_path, table([way("ego", 0, 0, 0.4, speeds)]))


LAYOUTS = (
    *(sources.levelx, sources.interaction, sources.argoverse, sources.ngsim, sources.fcd, sources.fcd_table),
    *(sources.esmini_log, sources.dat_table, sources.carla_log, sources.commonroad),
)


@pytest.mark.parametrize("write", LAYOUTS)
def test_every_layout_names_its_jumps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write) -> None:
    """One who is put 400 m away and back is not driven there, whatever the file's kind."""
    at = sources.Drive.at

    def teleported(drive: sources.Drive, k: int) -> tuple[float, float]:
        x, y = at(drive, k)
        return x + (400.0 if drive.name == "2" and k > 20 else 0.0), y

    monkeypatch.setattr(sources.Drive, "at", teleported)
    read = read_recording(write(tmp_path))
    assert any("`2` jumps 400" in remark for remark in read.remarks), read.remarks
    there = read.recording.there[:, 1]
    assert there.sum() == len(there) - 1
