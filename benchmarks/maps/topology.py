"""Do lanes lead into the same lanes as in CARLA's own reading of a file, from road to road?

Ways into a lane of a junction that goes on to no lane are counted apart: CARLA lists them, and here as in Scenic no
maneuver leads over such a lane.
"""

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path

from engine.maps import digest_of
from engine.road import build_network
from engine.road.opendrive.lanes import THROUGH
from engine.road.opendrive.network import map_file
from engine.road.opendrive.planning import plan_of

ASK = Path(__file__).with_name("ask_carla.py")
NO_CARLA = 3
"""What `ASK` ends with where its Python has no package `carla`."""
LONGEST = 600.0
"""That CARLA may take for a file [s]."""
Ways = set[tuple[str, int, str, int]]
"""From a lane of a road to one of another road."""


def compare_with_carla(paths: Sequence[Path], python: str) -> int:
    """Print by file how many ways both know, and which one does not.

    Returns 1 where one does not, or CARLA does not read a file; 2 where none could be compared.
    """
    differs, compared = False, 0
    for path in paths:
        asked = subprocess.run(
            [python, str(ASK), str(path)], capture_output=True, text=True, timeout=LONGEST, check=False
        )
        if asked.returncode == NO_CARLA:
            print(f"{python} has no package `carla`: install it there, or name another Python", flush=True)
            return 2
        if asked.returncode:
            last = (asked.stderr.strip().splitlines() or [f"it ended with {asked.returncode}"])[-1][:120]
            print(f"{path.name:24} CARLA does not read it: {last}", flush=True)
            differs = True
            continue
        compared += 1
        ours, carlas = ways(path), ways_of_carla(json.loads(asked.stdout.strip().splitlines()[-1]))
        nowhere = into_dead_ends(path, carlas)
        lacking, more = sorted(carlas - ours - nowhere), sorted(ours - carlas)
        differs |= bool(lacking or more)
        print(f"{path.name:24} {len(ours & carlas)} ways as CARLA, {len(lacking)} only there {lacking[:4]}, "
              f"{len(more)} only here {more[:4]}, {len(nowhere - ours)} only there into lanes that end in a junction",
              flush=True)  # fmt: skip
    if not compared:
        print("no file was compared: name a folder with files *.xodr that CARLA reads", flush=True)
    return int(differs) if compared else 2


def ways(path: Path) -> Ways:
    """Ours."""
    links = plan_of(str(path), digest_of(path)).links
    network = build_network(map_file(path, path.name))
    found = ((links.lanes[lane.id], links.lanes[after.id]) for lane in network.lanes for after in lane.successors)
    return {(a.road, a.last.lane, b.road, b.first.lane) for a, b in found if a.road != b.road}


def into_dead_ends(path: Path, known: Ways) -> Ways:
    """Of some ways, those that lead to a lane of a junction from which none of them goes on."""
    roads = plan_of(str(path), digest_of(path)).links.sections
    onward = {(road, lane) for road, lane, _, _ in known}
    return {way for way in known if roads[way[2]].road.junction != THROUGH and way[2:] not in onward}


def ways_of_carla(pairs: Sequence[Sequence[int]]) -> Ways:
    return {(str(a), one, str(b), other) for a, one, b, other in pairs if a != b}
