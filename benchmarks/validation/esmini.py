"""Does esmini replay our cases? `python -m benchmarks.validation.esmini LIBRARY`, the path of a built libesminiLib.so.

Steps esmini from sample to sample and compares centres and headings with the recording. For the instant of contact, a
case goes on after first contact as it went before it, so that outlines overlap (contact physics keep ours apart), and
esmini is stepped by a millisecond until it reports a collision.

With `--certificates` the worst collisions of A to F are exported in both modes as `cortexc export` does it, and it is
counted how many of them have a certificate of fidelity that says: with the same partner, in time.

Build it from https://github.com/esmini/esmini without its viewer, which takes no download but its submodule fmt:
`cmake -B build -D DOWNLOAD_EXTERNALS=OFF -D USE_OSG=OFF -D USE_OSI=OFF -D USE_SUMO=OFF -D USE_GTEST=OFF
-D USE_IMPLOT=OFF -D BUILD_REPLAYER=OFF -D BUILD_ODRPLOT=OFF -D BUILD_EXAMPLES=OFF` and
`cmake --build build --target esminiLib`.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.validation.material import CONSTRUCTS, EXAMPLES, cases
from cortex_dsl.interchange.cases import ExportCase
from cortex_dsl.interchange.formats import gather
from engine.interchange.contract import OSC_VERSIONS, ExportOptions
from engine.interchange.esmini import Played, play
from engine.interchange.esmini.fidelity import WITHIN, certified
from engine.interchange.opendrive import write_opendrive
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.document import entity_names
from engine.interchange.recording import Recording
from engine.tables import Floats
from engine.vocabulary import State

FINE = 0.001
"""Step of the search for esmini's own collision [s]."""
ONWARD = 0.2
"""How long a case goes on after first contact for it [s]."""
ROAD = "road.xodr"


@dataclass(frozen=True)
class Player:
    """esmini as it is asked here."""

    library: Path
    trajectory_filter: str

    def play(self, recording: Recording, road: bytes, osc: str, instants: Floats) -> Played:
        """The file of a recording in one version of OpenSCENARIO, at these instants."""
        export = write_trajectories(recording, "case", ExportOptions(osc=osc), ROAD)
        files = {ROAD: road, **{name: str(text).encode() for name, text in export.files.items()}}
        return play(self.library, files, "case.xosc", recording, instants, self.trajectory_filter)


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


def replayed(player: Player, recording: Recording, road: bytes, osc: str) -> Replay:
    """Plays a recording in one version of OpenSCENARIO, and looks for its contact."""
    off, turned, absent = _deviations(player.play(recording, road, osc, recording.time), recording)
    scored = recording.scored_samples()
    late = None
    if recording.contact is not None and len(recording.contact.actors) > 1:  # esmini knows no buildings
        late = _collision(player, onward(recording), road, osc) - recording.contact.time
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


def _deviations(played: Played, recording: Recording) -> tuple[Floats, Floats, int]:
    """(samples,) of the worst actor [m], [rad], and how often one is there for one side only."""
    ours, theirs = recording.states, played.poses
    there, seen = ours[:, :, State.PRESENT] != 0.0, np.isfinite(theirs[:, :, 0])
    off = np.hypot(*np.moveaxis(theirs[:, :, :2] - ours[:, :, [State.X, State.Y]], 2, 0))
    turned = np.abs((theirs[:, :, 2] - ours[:, :, State.HEADING] + np.pi) % (2 * np.pi) - np.pi)
    worst = (np.where(there & seen, each, 0.0).max(axis=1) for each in (off, turned))
    return *worst, int(np.count_nonzero(there != seen))


def _collision(player: Player, recording: Recording, road: bytes, osc: str) -> float:
    assert recording.contact is not None
    names = entity_names(recording)
    pair = frozenset(names[actor] for actor in recording.contact.actors)
    instants = np.arange(0.0, recording.contact.time + ONWARD, FINE)
    return player.play(recording, road, osc, instants).collisions.get(pair, float("inf"))


def _played(player: Player, found: Sequence[ExportCase]) -> Iterator[Replay]:
    for case in found:
        road = write_opendrive(case.scenario.program.road_spec, case.recording.signals, "road", case.road_provenance)
        yield from (replayed(player, case.recording, road.encode(), osc) for osc in OSC_VERSIONS)


def certificates(library: Path, top: int) -> None:
    """A line for each of A to F: how many of its worst cases that collide do so in esmini, by mode."""
    for file in EXAMPLES:
        with TemporaryDirectory() as folder:
            found = [case for case in cases(file, Path(folder) / "run", top, 0) if case.recording.contact is not None]
        told = ", ".join(f"{mode} {_agreeing(library, found, mode)} of {len(found)}" for mode in WITHIN)
        print(f"{file.stem:28} {told}", flush=True)


def _agreeing(library: Path, found: Sequence[ExportCase], mode: str) -> int:
    """Of so many cases the certificate says what the run says."""
    options = ExportOptions(mode=mode)
    files = gather(found, ("xosc",), options).files
    return sum(certified(library, case, files, options).content["agrees"] for case in found)


def main() -> None:
    """A line for each scenario: its worst case in its worst version."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.validation.esmini")
    parser.add_argument("library", type=Path, help="libesminiLib.so")
    parser.add_argument("--top", type=int, default=3, help="worst cases of each of A to F")
    parser.add_argument("--others", type=int, default=1, help="scenes without contact")
    parser.add_argument("--certificates", action="store_true", help="count certificates of fidelity, in both modes")
    parser.add_argument("--traj-filter", default="0", help="esmini's own default, 0.1, merges vertices that are close")
    arguments = parser.parse_args()
    if arguments.certificates:
        certificates(arguments.library, arguments.top)
        return
    player = Player(arguments.library, arguments.traj_filter)
    print(f"{'':28} {'before contact':>22} {'after':>10} {'absent':>7} {'collision':>12}")
    for file in [*EXAMPLES, *CONSTRUCTS]:
        with TemporaryDirectory() as folder:
            found = cases(file, Path(folder) / "run", arguments.top, arguments.others)
            all_of_it = list(_played(player, found))
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
