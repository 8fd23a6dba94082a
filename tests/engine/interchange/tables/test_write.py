"""Trajectories in omega-prime's columns, there and back."""

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import load
from engine.interchange import Contact, InterchangeError, Recording
from engine.interchange.kinds import KINDS, Code, kind_of
from engine.interchange.measuring import measure
from engine.interchange.recording import recorded_run
from engine.interchange.tables import COLUMNS, read_table, write_csv, write_parquet
from engine.interchange.tables.write import omega_prime_table, wrapped
from engine.metrics.table import OF_ACTORS
from engine.vocabulary import ActorKind, State, Verdict
from engine.world import run

ROOT = Path(__file__).parents[4]
FILES = [
    ROOT / "examples" / "left_turn.scn",
    *(ROOT / "tests" / "agreement" / f"{n}.scn" for n in ("library", "guards")),
]
WRITERS = {"csv": write_csv, "parquet": write_parquet}


@cache
def recordings() -> tuple[Recording, ...]:
    """Runs with contact and without, with actors of several kinds and such that come and go."""
    found = []
    for path in FILES:
        scenario = load(path)
        scenes = scenario.sample(24, seed=4)
        for row in np.flatnonzero(scenes.valid).tolist()[:9]:
            ran = run(scenario.program, scenes, row, scenario.config)
            if ran.outcomes.verdict[0] == Verdict.VALID:
                step = scenario.config.simulation.time_step
                found.append(recorded_run(scenario.program, scenes, ran, row=row, step=step))
    return tuple(found)


def with_contact() -> Recording:
    return next(recording for recording in recordings() if recording.contact and recording.scored_samples() > 10)


def written(recording: Recording, folder: Path, kind: str) -> Path:
    ((name, content),) = WRITERS[kind](recording, "case").files.items()
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("kind", WRITERS)
def test_a_written_table_measures_as_the_recording_does(kind: str, tmp_path: Path) -> None:
    """Every metric of motion to 1e-6, the same risk, the same pair in contact, the same step."""
    ends, of_commands = set(), {each.symbol for each in OF_ACTORS if each.of_commands}
    for recording in recordings():
        back = read_table(written(recording, tmp_path, kind)).recording
        own, other = measure(recording), measure(back)
        assert back.step == pytest.approx(recording.step, rel=1e-12)
        assert other.risk.score[0] == own.risk.score[0]
        assert other.outcomes.contact_actors.tolist() == own.outcomes.contact_actors.tolist()
        assert other.outcomes.end_time[0] == pytest.approx(own.outcomes.end_time[0], abs=1e-6)
        of_motion = [metric for metric in own.metrics if metric.name not in of_commands]
        assert [m.name for m in other.metrics] == [m.name for m in of_motion]
        values = [m.value for m in of_motion]
        assert [m.value for m in other.metrics] == pytest.approx(values, abs=1e-6, rel=1e-6, nan_ok=True)
        ends.add(recording.contact is not None)
    assert ends == {True, False}


def test_the_columns_are_those_of_omega_prime() -> None:
    """In their order, under their names, and then our own; the version that this was held against is 0.3."""
    header = next(iter(write_csv(recordings()[0], "case").files.values())).splitlines()[0]  # type: ignore[union-attr]
    assert header == (
        "total_nanos,idx,x,y,z,vel_x,vel_y,vel_z,acc_x,acc_y,acc_z,length,width,height,roll,pitch,yaw,type,role,subtype"
        ",name"
    )


def test_names_come_back_from_csv(tmp_path: Path) -> None:
    """Whatever stands in them; two of the same name are refused."""
    recording = recordings()[0]
    first, second = recording.actors
    named = replace(recording, actors=(replace(first, name='the "ego", one'), replace(second, name="b")))
    (text,) = write_csv(named, "case").files.values()
    path = tmp_path / "case.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    assert [actor.name for actor in read_table(path).recording.actors] == ['the "ego", one', "b"]
    path.write_text(str(text).replace('"the ""ego"", one"', "b"), encoding="utf-8")
    with pytest.raises(InterchangeError, match="two actors have the same name"):
        read_table(path)


@pytest.mark.parametrize("number", [0, -1, len(FILES) * 4])
def test_the_table_holds_what_omega_primes_own_check_asks_for(number: int) -> None:
    """Its schema: types and ranges, one row an actor and time, a role and subtype of vehicles alone."""
    table = omega_prime_table(recordings()[number])
    whole = {"total_nanos", "idx", "type", "role", "subtype"}
    assert {name for name in COLUMNS if table[name].dtype == np.int64} == whole
    assert all(table[name].dtype == np.float64 for name in set(COLUMNS) - whole)
    assert all(np.isfinite(table[name]).all() for name in COLUMNS)
    assert (table["total_nanos"] >= 0).all()
    assert (np.abs(table["yaw"]) <= math.pi).all()
    assert (table["length"] > 0).all()
    assert (table["height"] > 0).all()
    vehicles = table["type"] == 2
    assert ((table["role"] == -1) == ~vehicles).all()
    assert ((table["subtype"] == -1) == ~vehicles).all()
    assert len(set(zip(table["total_nanos"].tolist(), table["idx"].tolist(), strict=True))) == len(table["idx"])


def test_velocity_is_the_centres() -> None:
    """Along the heading it is the rear axle's speed; over a step it leads from one row to the next."""
    recording = recordings()[0]
    table = omega_prime_table(recording)
    for actor in range(len(recording.actors)):
        own = {name: column[table["idx"] == actor] for name, column in table.items()}
        speed = own["vel_x"] * np.cos(own["yaw"]) + own["vel_y"] * np.sin(own["yaw"])
        scored = min(recording.scored_samples(), len(speed))
        assert speed[:scored] == pytest.approx(recording.states[:scored, actor, State.SPEED], abs=1e-12)
        way = np.diff(own["x"][:scored]) / np.diff(own["total_nanos"][:scored] / 1e9)
        assert own["vel_x"][1:scored] == pytest.approx(way, abs=0.25)


def test_contact_stands_at_the_next_nanosecond() -> None:
    """Its row is where linear motion has everybody then, so that the line through it is the same."""
    recording = with_contact()
    assert recording.contact is not None
    table = omega_prime_table(recording)
    first = recording.contact.actors[0]
    at = recording.scored_samples() - 1
    nanos = table["total_nanos"][table["idx"] == first][at]
    assert 0.0 <= nanos - recording.contact.time * 1e9 < 1.0
    x, before = table["x"][table["idx"] == first][at], recording.states[at - 1, first, State.X]
    slope = (recording.states[at, first, State.X] - before) / (recording.time[at] - recording.time[at - 1])
    assert (x - before) / (nanos / 1e9 - recording.time[at - 1]) == pytest.approx(slope, rel=1e-12)


@given(st.floats(-50.0, 50.0))
def test_yaw_is_wrapped_and_keeps_its_digits(heading: float) -> None:
    """(-pi, pi]; what lies there is not touched."""
    (yaw,) = wrapped(np.array([heading])).tolist()
    assert -math.pi < yaw <= math.pi
    assert math.cos(yaw - heading) == pytest.approx(1.0)
    if -math.pi < heading <= math.pi:
        assert yaw == heading


def test_kinds_come_back() -> None:
    """Each kind has a code of its own."""
    assert {kind: kind_of(row.code) for kind, row in KINDS.items()} == {kind: kind for kind in ActorKind}
    assert kind_of(Code(4)) is None
    assert kind_of(Code(2, 2, 0)) is None


def test_what_the_columns_cannot_hold_is_said() -> None:
    """Commands, the road, the instant of contact."""
    remarks = " ".join(write_csv(with_contact(), "case").remarks)
    for word in ("pedals", "road", "nanoseconds"):
        assert word in remarks


def test_who_comes_back_is_named() -> None:
    """omega-prime's own check allows no gap."""
    recording = recordings()[0]
    states = recording.states.copy()
    states[5:8, 1, State.PRESENT] = 0.0
    remarks = write_csv(replace(recording, states=states), "case").remarks
    assert any(recording.actors[1].name in remark and "gap" in remark for remark in remarks)


def test_samples_within_a_nanosecond_are_refused() -> None:
    """They would be one row."""
    recording = replace(recordings()[0], contact=None)
    with pytest.raises(InterchangeError, match="nanosecond"):
        write_csv(replace(recording, time=recording.time * 1e-9), "case")
    with pytest.raises(InterchangeError, match="nanosecond"):
        write_csv(replace(recording, time=recording.time * 1e-9, contact=Contact(2e-11, (0, 1))), "case")


def test_parquet_names_the_ego_and_all_actors(tmp_path: Path) -> None:
    """omega-prime reads the one from its own key, we the others from ours."""
    import pyarrow.parquet

    recording = with_contact()
    path = written(recording, tmp_path, "parquet")
    metadata: Mapping[bytes, bytes] = pyarrow.parquet.read_schema(path).metadata
    assert metadata[b"host_vehicle_idx"] == b"0"
    assert [actor.name for actor in read_table(path).recording.actors] == [actor.name for actor in recording.actors]


def marked(path: Path, **metadata: str) -> Path:
    """The same table with other metadata."""
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    pyarrow.parquet.write_table(table.replace_schema_metadata(metadata), path)
    return path


def test_the_ego_of_parquet_is_the_one_of_its_key(tmp_path: Path) -> None:
    """Whatever anybody is called; without the key it is idx 0, which is said, and --ego goes before all."""
    recording = with_contact()
    others = [replace(actor, name="ego" if number else "tested") for number, actor in enumerate(recording.actors[:2])]
    path = written(replace(recording, actors=(*others, *recording.actors[2:])), tmp_path, "parquet")
    assert read_table(path).recording.actors[0].name == "tested"
    assert read_table(path, ego="ego").recording.actors[0].name == "ego"
    names = json.dumps([actor.name for actor in (*others, *recording.actors[2:])])
    read = read_table(marked(path, host_vehicle_idx="1", cortexc_names=names))
    assert read.recording.actors[0].name == "ego"
    assert not any("--ego" in remark for remark in read.remarks)
    for said in ({}, {"host_vehicle_idx": "one"}, {"host_vehicle_idx": "99"}):
        read = read_table(marked(path, cortexc_names=names, **said))
        assert read.recording.actors[0].name == "tested"
        assert any("which idx is the ego's: `tested` is taken" in remark for remark in read.remarks)


def test_the_ego_of_csv_is_idx_0(tmp_path: Path) -> None:
    """In omega-prime's columns a name means nothing, nor who is there first."""
    recording = with_contact()
    others = [replace(actor, name="ego" if number else "tested") for number, actor in enumerate(recording.actors[:2])]
    path = written(replace(recording, actors=(*others, *recording.actors[2:])), tmp_path, "csv")
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, *(row for row in rows if not row.startswith("0,0,"))]))
    assert read_table(path).recording.actors[0].name == "tested"


@pytest.mark.parametrize("names", ["[" * 50_000 + "]" * 50_000, "[[", '{"a":1}', "[null, {}]", '["only one"'])
def test_names_that_are_none_are_left(tmp_path: Path, names: str) -> None:
    """Numbers stand for them."""
    path = marked(written(with_contact(), tmp_path, "parquet"), cortexc_names=names)
    assert read_table(path).recording.actors[0].name == "0"


def test_doubled_names_are_refused(tmp_path: Path) -> None:
    path = marked(written(with_contact(), tmp_path, "parquet"), cortexc_names='["a", "a"]')
    with pytest.raises(InterchangeError, match="same name"):
        read_table(path)


@pytest.mark.parametrize("factor", [0.0, 3.0, -1.0])
def test_velocities_that_positions_contradict_are_not_believed(tmp_path: Path, factor: float) -> None:
    """The score is that of the motion, as nearly as positions give it, and a remark says so."""
    path = written(with_contact(), tmp_path, "csv")
    head, *rows = (line.split(",") for line in path.read_text().splitlines())
    for row in rows:
        for name in ("vel_x", "vel_y"):
            row[head.index(name)] = repr(float(row[head.index(name)]) * factor)
    path.write_text("\n".join(",".join(row) for row in (head, *rows)))
    read, own = read_table(path), measure(with_contact())
    assert measure(read.recording).outcomes.max_closing_speed == pytest.approx(own.outcomes.max_closing_speed, rel=0.05)
    assert any("taken from motion" in remark for remark in read.remarks)


def test_what_we_wrote_is_believed(tmp_path: Path) -> None:
    """Nothing of a run of ours is taken from elsewhere."""
    for recording in recordings():
        assert not any("motion" in remark for remark in read_table(written(recording, tmp_path, "csv")).remarks)


def test_parquet_without_pyarrow_is_a_clear_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It names the extra, for writing and for reading."""
    path = written(recordings()[0], tmp_path, "parquet")
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    for use in (lambda: write_parquet(recordings()[0], "case"), lambda: read_table(path)):
        with pytest.raises(InterchangeError, match="pyarrow") as caught:
            use()
        assert "[export]" in caught.value.cure
