"""How long it takes to judge every pair of a recording, and how much memory: `python -m benchmarks.recordings`.

The recording is made up, in inD's columns: tracks that bend across a crossing, each 300 rows at 25 Hz, some forty at a
time. It is read and judged in a process of its own, once kernels are compiled.
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

ROWS, RATE = 300, 25
HEADER = (
    "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,xAcceleration,"
    "yAcceleration,lonVelocity,latVelocity,lonAcceleration,latAcceleration"
)


def main() -> None:
    """Write the recording, judge it twice, print what the second time took."""
    parser = argparse.ArgumentParser(description="Judge every pair of a made-up recording in inD's columns.")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--tracks", type=int, default=1000)
    parser.add_argument("--judge", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.judge:
        print(json.dumps(judged(options.judge)))
        return
    with TemporaryDirectory() as folder:
        file = written(Path(folder), options.tracks)
        child = [sys.executable, "-m", "benchmarks.recordings", "--judge", str(file)]
        subprocess.run(child, check=True, capture_output=True)  # compiles kernels
        found = json.loads(subprocess.run(child, check=True, capture_output=True, text=True).stdout)
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        print("| tracks | rows | windows | reading | judging | whole process | memory |")
        print("|---|---|---|---|---|---|---|")
        print(table_row(found))


def table_row(found: dict) -> str:
    """One row of the table in the documentation."""
    seconds = " | ".join(f"{found[key]:.1f} s" for key in ("reading", "judging", "process"))
    return (
        f"| {found['tracks']:,} | {found['rows']:,} | {found['windows']:,} | {seconds} | {found['megabytes']:.0f} MB |"
    )


def judged(file: Path) -> dict:
    """Processor time of this process [s], its largest memory [MB], and what it found."""
    from engine.interchange.every_pair import rank_pairs
    from engine.interchange.sources import read_traffic

    start = time.process_time()
    tracks = read_traffic(file)
    middle = time.process_time()
    ranked = rank_pairs(tracks)
    return {
        "tracks": len(tracks.tracks),
        "rows": sum(len(track.time) for track in tracks.tracks),
        "windows": len(ranked),
        "reading": middle - start,
        "judging": time.process_time() - middle,
        "process": time.process_time(),
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def written(folder: Path, tracks: int, seed: int = 1) -> Path:
    """The recording's three files; the table's path."""
    rng = np.random.default_rng(seed)
    rows, meta = [], []
    for track in range(tracks):
        begin = int(rng.integers(0, 7200))
        k = np.arange(ROWS)
        heading = rng.uniform(-np.pi, np.pi) + 0.3 * np.sin(k / 80)
        speed = rng.uniform(0.5, 14.0)
        velocity = speed * np.column_stack([np.cos(heading), np.sin(heading)])
        way = np.cumsum(velocity, axis=0) / RATE
        places = way - way[ROWS // 2] + rng.uniform(-30.0, 30.0, 2)
        degrees = np.degrees(heading) % 360.0
        meta.append(f"1,{track},{begin},{begin + ROWS - 1},{ROWS},1.8,4.5,car")
        for i in range(ROWS):
            (x, y), (vx, vy) = places[i], velocity[i]
            pose = f"{x:.5f},{y:.5f},{degrees[i]:.5f},1.8,4.5,{vx:.5f},{vy:.5f}"
            rows.append(f"1,{track},{begin + i},{i},{pose},0.0,0.0,{speed:.5f},0.0,0.0,0.0")
    head = "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class"
    (folder / "01_tracks.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    (folder / "01_tracksMeta.csv").write_text("\n".join([head, *meta]) + "\n")
    (folder / "01_recordingMeta.csv").write_text(f"recordingId,locationId,frameRate\n1,1,{RATE}.0\n")
    return folder / "01_tracks.csv"


if __name__ == "__main__":
    main()
