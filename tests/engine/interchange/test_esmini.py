"""esmini is named and never looked for, plays in a process of its own, and what it saw is held against the run.

A stub with the calls of esminiLib.hpp stands for the library; `benchmarks/validation/esmini.py` takes a real one.
"""

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.errors import InterchangeError
from engine.interchange import esmini
from engine.interchange.after_contact import shown_after_contact
from engine.interchange.contract import ExportOptions
from engine.interchange.esmini import Played, child, esmini_library, fidelity, recorded
from engine.interchange.esmini.fidelity import Certificate, certified
from engine.interchange.recording import RecordedCase, Recording, states_at
from engine.interchange.sources import read_recording, read_traffic
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.openscenario.read.files import scenario, teleport, vehicle, world
from tests.engine.interchange.test_after_contact import TOUCH, crash

CASE = RecordedCase(crash(), cast("Any", None), "paper")
NAMES = ["ego", "other"]


@dataclass
class Stub:
    """Plays a recording as esmini would, and sees outlines overlap along x."""

    recording: Recording
    time: float = 0.0
    opens: bool = True
    calls: list[str] = field(default_factory=list)

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *_: self.calls.append(name)

    def SE_Init(self, *_: object) -> int:  # noqa: N802
        return 0 if self.opens else -1

    def SE_StepDT(self, step: float) -> None:  # noqa: N802
        assert step > 0.0
        self.time += step

    def SE_GetIdByName(self, name: bytes) -> int:  # noqa: N802
        return NAMES.index(name.decode())

    def SE_GetNumberOfObjects(self) -> int:  # noqa: N802
        return len(NAMES)

    def SE_GetId(self, index: int) -> int:  # noqa: N802
        return index

    def SE_GetObjectName(self, number: int) -> bytes:  # noqa: N802
        return NAMES[number].encode()

    def SE_GetQuitFlag(self) -> int:  # noqa: N802
        return int(self.time > self.recording.time[-1] - 0.5)

    def SE_GetObjectState(self, number: int, reference: Any) -> int:  # noqa: N802
        state, actor = reference._obj, self.recording.actors[number]
        pose = states_at(self.recording, np.array([self.time]))[0, number]
        state.x, state.y, state.h = pose[State.X] - actor.rear_to_center, pose[State.Y], pose[State.HEADING]
        state.ahead, state.length, state.width = actor.rear_to_center, actor.length, actor.width
        state.speed, state.kind, state.category = pose[State.SPEED], 1, 2 * number
        return 0

    def SE_GetObjectNumberOfCollisions(self, _: int) -> int:  # noqa: N802
        one, other = states_at(self.recording, np.array([self.time]))[0, :, State.X]
        lengths = sum(actor.length for actor in self.recording.actors) / 2
        return int(other - one < lengths - 1e-9)

    def SE_GetObjectCollision(self, number: int, index: int) -> int:  # noqa: N802
        assert index == 0
        return 1 - number


def played(stub: Stub, instants: list[float]) -> dict[str, Any]:
    return child.play(stub, {"file": "case.xosc", "names": NAMES, "instants": instants, "filter": "0"})


def judged(monkeypatch: pytest.MonkeyPatch, shown: Recording, mode: str = "trajectory") -> Certificate:
    """The certificate of the crash, of which esmini plays what is given."""

    def play(_: Path, files: Mapping[str, bytes], name: str, recording: Recording, instants: Any) -> Played:
        assert (list(files), name, len(recording.actors)) == (["crossing.xosc"], "crossing.xosc", 2)
        answer = played(Stub(shown), instants.tolist())
        collisions = {frozenset((one, other)): time for time, one, other in reversed(answer["collisions"])}
        return Played(instants, np.array(answer["poses"]), collisions)

    monkeypatch.setattr(fidelity, "play", play)
    return certified(Path("lib"), CASE, {"crossing.xosc": b""}, ExportOptions(mode=mode))


def test_the_crash_arrives(monkeypatch: pytest.MonkeyPatch) -> None:
    """Outlines overlap after contact, and it is seen in the next millisecond."""
    certificate = judged(monkeypatch, shown_after_contact(crash(), "through"))
    assert certificate.findings == ()
    assert certificate.content["agrees"]
    assert certificate.content["contact"]["run"] == {"time": TOUCH, "partner": "other"}
    assert 0.0 < certificate.content["contact"]["played"]["time"] - TOUCH < 2e-3
    assert certificate.content["deviation"]["place"] < 1e-9
    assert "contact with other at 0.30" in certificate.line
    assert "as in the run" in certificate.line
    assert certificate.text.endswith("}\n")


def test_a_crash_that_does_not_arrive_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contact physics keeps outlines apart; so would a player that drives otherwise."""
    for mode in ("trajectory", "maneuver"):
        certificate = judged(monkeypatch, crash(), mode)
        (finding,) = certificate.findings
        assert finding.reason == "esmini sees no contact of the ego, the run had contact with other at 0.300 s"
        assert "OTHERWISE" in certificate.line


def test_a_replay_that_is_off_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = shown_after_contact(crash(), "through")
    shown.states[:, 1, State.Y] += 0.02
    certificate = judged(monkeypatch, shown)
    assert [finding.reason for finding in certificate.findings] == ["other is 0.02 m off in esmini at 0.000 s"]


def test_what_esmini_refuses_is_told() -> None:
    assert played(Stub(crash(), opens=False), [0.0]) == {"refused": True}


def test_other_fields_are_not_believed() -> None:
    """A library whose structure is another gives numbers that mean nothing."""
    sizes = {"ego": [4.0, 1e300], "other": [1.0, 1.0]}
    with pytest.raises(InterchangeError, match="lays its states out otherwise"):
        esmini._refuse_other_layout(sizes, crash(), NAMES)
    assert ctypes.sizeof(child.ObjectState) > 200


# -- the library, and its process --------------------------------------------------------------------------------------


def test_the_library_is_named_and_never_looked_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """By a path, or a variable with a whole path; a folder may hold it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(esmini.VARIABLE, raising=False)
    (tmp_path / "bin").mkdir()
    library = tmp_path / "bin" / esmini.LIBRARIES[0]
    library.write_bytes(b"")
    with pytest.raises(InterchangeError, match="not known here"):
        esmini_library(None)
    assert esmini_library(tmp_path) == esmini_library(library) == library
    monkeypatch.setenv(esmini.VARIABLE, "bin")
    with pytest.raises(InterchangeError, match="no whole path"):
        esmini_library(None)
    monkeypatch.setenv(esmini.VARIABLE, str(tmp_path))
    assert esmini_library(None) == library
    with pytest.raises(InterchangeError, match="there is no esmini"):
        esmini_library(tmp_path / "nowhere")


def told(script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """What is said where the process runs a script in place of the child's."""
    (tmp_path / "script.py").write_text(script, encoding="utf-8")
    monkeypatch.setattr(esmini, "CHILD", tmp_path / "script.py")
    with pytest.raises(InterchangeError) as error:
        esmini.play(tmp_path, {}, "case.xosc", crash(), np.array([0.0]))
    assert error.value.place == "case.xosc"
    return error.value.message


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("import os; os.abort()", "esmini crashes (SIGABRT)"),
        ("import sys; sys.exit('no more')", 'esmini ends without an answer: "no more"'),
        ("import sys; open(sys.argv[1], 'w').write('{\"refused\": true}')", "esmini does not open it"),
        ("import sys; open(sys.argv[1], 'w').write('{\"memory\": true}')", "esmini takes more than 4 GB"),
    ],
)
def test_a_process_that_ends_is_told(
    script: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert told(script, tmp_path, monkeypatch) == message


def test_a_process_that_hangs_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(esmini, "PATIENCE", 0.3)
    assert told("import time; time.sleep(60)", tmp_path, monkeypatch) == "esmini hangs: no end after 0.3 s"


def test_what_is_no_library_is_told(tmp_path: Path) -> None:
    """By the very child."""
    (tmp_path / "lib").write_text("nothing", encoding="utf-8")
    with pytest.raises(InterchangeError, match="not a library of esmini"):
        esmini.play(tmp_path / "lib", {}, "case.xosc", crash(), np.array([0.0]))


# -- files that only a simulator can work out --------------------------------------------------------------------------

DRIVEN = scenario([vehicle("ego"), vehicle("other")], [(name, teleport(world(0, 0, 0))) for name in NAMES])


def test_a_file_that_has_to_be_played_is_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until it stops, in even steps: middles of outlines, sizes and kinds; what the file lacks alone is remarked."""
    shown = shown_after_contact(crash(), "through")
    monkeypatch.setattr(recorded, "answer_of", lambda job, *_: child.record(Stub(shown), job))
    file = tmp_path / "driven.xosc"
    file.write_text(DRIVEN)
    with pytest.raises(InterchangeError):
        read_recording(file)
    found = read_recording(file, esmini=Path("lib"))
    assert found.remarks[0].startswith("played by esmini, as it cannot be read alone: driven.xosc")
    assert [actor.name for actor in found.recording.actors] == NAMES
    assert [actor.kind for actor in found.recording.actors] == [ActorKind.CAR, ActorKind.TRUCK]
    wanted = states_at(shown, found.recording.time)
    assert found.recording.states[:, :, [State.X, State.Y]] == pytest.approx(wanted[:, :, [State.X, State.Y]])
    job = {"file": "a.xosc", "step": 0.05, "until": 1.0}
    rows = np.array([[row[0], *row[2:5]] for row in child.record(Stub(shown), job)["rows"]])
    at = states_at(shown, rows[:: len(NAMES), 0])[..., : State.HEADING + 1].reshape(-1, 3)
    assert rows[:, 1:] == pytest.approx(at)
    assert rows[0, 0] == 0.0
    assert len(read_traffic(file, esmini=Path("lib")).tracks) == 2
    assert child.record(Stub(shown, opens=False), {"file": "a.xosc"}) == {"refused": True}
