"""Does esmini replay our cases? `python -m benchmarks.validation.esmini LIBRARY`, the path of a built libesminiLib.so.

Steps esmini from sample to sample and compares centres and headings with the recording. For the instant of contact, a
case goes on after first contact as it went before it, so that outlines overlap (contact physics keep ours apart), and
esmini is stepped by a millisecond until it reports a collision.

Build it from https://github.com/esmini/esmini without its viewer, which takes no download but its submodule fmt:
`cmake -B build -D DOWNLOAD_EXTERNALS=OFF -D USE_OSG=OFF -D USE_OSI=OFF -D USE_SUMO=OFF -D USE_GTEST=OFF
-D USE_IMPLOT=OFF -D BUILD_REPLAYER=OFF -D BUILD_ODRPLOT=OFF -D BUILD_EXAMPLES=OFF` and
`cmake --build build --target esminiLib`.
"""

import argparse
import ctypes
from collections.abc import Iterator, Sequence
from ctypes import c_double, c_int, c_uint32
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import numpy as np

from benchmarks.validation.material import CONSTRUCTS, EXAMPLES, cases
from cortex_dsl.interchange.cases import ExportCase
from engine.interchange.contract import OSC_VERSIONS, ExportOptions
from engine.interchange.opendrive import write_opendrive
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.document import entity_names
from engine.interchange.recording import Recording
from engine.vocabulary import State

FINE = 0.001
"""Step of the search for esmini's own collision [s]."""
ONWARD = 0.2
"""How long a case goes on after first contact for it [s]."""
ROAD = "road.xodr"


class ObjectState(ctypes.Structure):
    """`SE_ScenarioObjectState` of esminiLib.hpp, esmini 3.6.0."""

    _fields_: ClassVar = [
        *((name, c_int) for name in ("id", "model_id", "ctrl_type")),
        *((name, c_double) for name in ("timestamp", "x", "y", "z", "h", "p", "r")),
        *((name, c_uint32) for name in ("road", "junction")),
        ("t", c_double),
        ("lane", c_int),
        *((name, c_double) for name in ("lane_offset", "s", "speed", "ahead", "aside", "above")),
        *((name, c_double) for name in ("width", "length", "height")),
        *((name, c_int) for name in ("type", "category")),
        *((name, c_double) for name in ("wheel_angle", "wheel_rotation")),
        ("visibility", c_int),
    ]

    def center(self) -> tuple[float, float]:
        """Of the bounding box [m]."""
        x = self.x + self.ahead * np.cos(self.h) - self.aside * np.sin(self.h)
        return x, self.y + self.ahead * np.sin(self.h) + self.aside * np.cos(self.h)


class Player:
    """esmini without a window; one scenario at a time."""

    def __init__(self, library: Path, trajectory_filter: str) -> None:
        self.library = ctypes.CDLL(str(library))
        self.library.SE_StepDT.argtypes = [c_double]
        self.library.SE_GetSimulationTime.restype = c_double
        self.trajectory_filter = trajectory_filter

    def open(self, file: Path) -> None:
        self.library.SE_LogToConsole(False)
        self.library.SE_SetLogFilePath(str(file.with_suffix(".log")).encode())
        self.library.SE_SetOptionValue(b"traj_filter", self.trajectory_filter.encode())
        self.library.SE_CollisionDetection(True)
        if self.library.SE_Init(str(file).encode(), 0, 0, 0, 0) != 0:
            raise SystemExit(f"esmini does not open {file}")

    def state(self, name: str) -> ObjectState | None:
        """None while the entity is not there."""
        state, entity = ObjectState(), self.library.SE_GetIdByName(name.encode())
        known = entity >= 0 and self.library.SE_GetObjectState(entity, ctypes.byref(state)) == 0
        return state if known else None

    def collides(self, name: str) -> bool:
        entity = self.library.SE_GetIdByName(name.encode())
        return entity >= 0 and self.library.SE_GetObjectNumberOfCollisions(entity) > 0


@dataclass(frozen=True)
class Replay:
    """How far esmini was from a recording."""

    before: float
    """Largest distance of centres up to first contact [m]."""
    after: float
    """The same from there on [m]."""
    turned: float
    """Largest difference of headings up to first contact [rad]."""
    absent: int
    """Samples at which esmini has an actor that is not there, or has it not."""
    late: float | None
    """esmini's collision after our contact [s]; None without contact, infinite if it sees none."""


def replayed(player: Player, recording: Recording, folder: Path, osc: str) -> Replay:
    """Plays a recording in one version of OpenSCENARIO, and looks for its contact."""
    player.open(_written(recording, folder, osc))
    off, turned, absent = _deviations(player, recording)
    player.library.SE_Close()
    scored = recording.scored_samples()
    late = None
    if recording.contact is not None:
        player.open(_written(onward(recording), folder, osc))
        late = _collision(player, recording) - recording.contact.time
        player.library.SE_Close()
    return Replay(off[:scored].max(), off[scored:].max(initial=0.0), turned[:scored].max(), absent, late)


def onward(recording: Recording) -> Recording:
    """The same up to first contact, and from there on as it went before, straight through each other."""
    last = recording.scored_samples() - 1
    before = next(sample for sample in range(last - 1, -1, -1) if recording.time[last] - recording.time[sample] > FINE)
    share = ONWARD / (recording.time[last] - recording.time[before])
    states = recording.states[last].copy()
    pose = slice(State.X, State.HEADING + 1)
    states[:, pose] += share * (states[:, pose] - recording.states[before, :, pose])
    time = np.append(recording.time[: last + 1], recording.time[last] + ONWARD)
    return replace(recording, time=time, states=np.append(recording.states[: last + 1], states[np.newaxis], axis=0))


def _written(recording: Recording, folder: Path, osc: str) -> Path:
    (content,) = write_trajectories(recording, "case", ExportOptions(osc=osc), ROAD).files.values()
    file = folder / "case.xosc"
    file.write_text(str(content), encoding="utf-8")
    return file


def _deviations(player: Player, recording: Recording) -> tuple[np.ndarray, np.ndarray, int]:
    """(samples,) of the worst actor [m], [rad], and how often one is there for one side only."""
    off, turned, absent = np.zeros(len(recording)), np.zeros(len(recording)), 0
    for sample, step in enumerate(np.diff(recording.time, prepend=0.0)):
        if sample:
            player.library.SE_StepDT(float(step))
        for actor, name in enumerate(entity_names(recording)):
            ours, theirs = recording.states[sample, actor], player.state(name)
            if theirs is None or not ours[State.PRESENT]:
                absent += (theirs is not None) != bool(ours[State.PRESENT])
                continue
            distance = float(np.hypot(*(np.array(theirs.center()) - ours[[State.X, State.Y]])))
            angle = abs((theirs.h - ours[State.HEADING] + np.pi) % (2 * np.pi) - np.pi)
            off[sample], turned[sample] = max(off[sample], distance), max(turned[sample], angle)
    return off, turned, absent


def _collision(player: Player, recording: Recording) -> float:
    assert recording.contact is not None
    names = entity_names(recording)
    pair = [names[actor] for actor in recording.contact.actors]
    while player.library.SE_GetSimulationTime() < recording.contact.time + ONWARD:
        player.library.SE_StepDT(FINE)
        if all(player.collides(name) for name in pair):
            return player.library.SE_GetSimulationTime()
    return float("inf")


def _played(player: Player, found: Sequence[ExportCase], folder: Path) -> Iterator[Replay]:
    for case in found:
        road = write_opendrive(case.scenario.program.road_spec, case.recording.signals, "road", case.road_provenance)
        (folder / ROAD).write_text(road, encoding="utf-8")
        yield from (replayed(player, case.recording, folder, osc) for osc in OSC_VERSIONS)


def main() -> None:
    """A line for each scenario: its worst case in its worst version."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.validation.esmini")
    parser.add_argument("library", type=Path, help="libesminiLib.so")
    parser.add_argument("--top", type=int, default=3, help="worst cases of each of A to F")
    parser.add_argument("--others", type=int, default=1, help="scenes without contact")
    parser.add_argument("--traj-filter", default="0", help="esmini's own default, 0.1, merges vertices that are close")
    arguments = parser.parse_args()
    player = Player(arguments.library, arguments.traj_filter)
    print(f"{'':28} {'before contact':>22} {'after':>10} {'absent':>7} {'collision':>12}")
    for file in [*EXAMPLES, *CONSTRUCTS]:
        with TemporaryDirectory() as folder:
            found = cases(file, Path(folder) / "run", arguments.top, arguments.others)
            all_of_it = list(_played(player, found, Path(folder)))
        if all_of_it:
            print(_line(file.stem, all_of_it), flush=True)


def _line(name: str, replays: Sequence[Replay]) -> str:
    before, turned, after = (max(getattr(each, what) for each in replays) for what in ("before", "turned", "after"))
    late = [each.late for each in replays if each.late is not None]
    seen = f"{min(late) * 1000:+.1f} {max(late) * 1000:+.1f} ms" if late else "none"
    absent = max(each.absent for each in replays)
    return f"{name:28} {before:10.1e} m {turned:7.1e} rad {after:8.1e} m {absent:7} {seen:>14}"


if __name__ == "__main__":
    main()
