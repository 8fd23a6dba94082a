"""Are scenes of a script of Scenic on a town drawn from one law by both tools?

Compared are x, y and the sine and cosine of the heading of every object, and the distance between every two, each by
the two-sample Kolmogorov-Smirnov test, at 0.01 over all of them (Bonferroni). Seeds are fixed.
"""

import json
import math
import os
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.stats import ks_2samp

from cortex_dsl import load
from engine.sampling import sample, uniform_genomes
from engine.scenes import actor_columns
from engine.streams import key_rows
from engine.tables import Floats
from engine.vocabulary import Column, Method

ASK = Path(__file__).with_name("sample_scenic.py")
LEVEL = 0.01
SEED = 1
MORE = 20
"""Our scenes for each of Scenic's."""


def compare(script: Path, folder: Path, count: int, python: str, *, as_json: bool) -> int:
    """Print what both have in common; 1 where one quantity differs."""
    os.environ["CORTEXC_MAPS"] = str(folder.resolve())
    scenario = load(script)
    path = getattr(scenario.program.road_spec, "path", None)
    if path is None:
        print(f"the map of {script} is not in {folder}")
        return 1
    asked = subprocess.run(
        [python, str(ASK), str(script), path, str(count), str(SEED)], capture_output=True, text=True, check=False
    )
    if asked.returncode:
        print(f"Scenic does not sample {script.name}: {(asked.stderr.strip().splitlines() or ['no reason'])[-1][:200]}")
        return 1
    theirs = quantities(np.array(json.loads(asked.stdout.strip().splitlines()[-1])))
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, range(MORE * count))
    config = replace(scenario.config.simulation, max_attempts=100_000)
    scenes = sample(scenario.program, uniform_genomes(scenario.program.space, keys), keys, config)
    values = np.array([actor_columns(scenario.program, row) for row in scenes.values[scenes.valid]])
    ours = quantities(values[:, :, [Column.X, Column.Y, Column.HEADING]] - (0.0, 0.0, math.pi / 2.0))
    found = {name: float(ks_2samp(ours[name], theirs[name]).pvalue) for name in theirs}
    bound = LEVEL / len(found)
    if as_json:
        print(json.dumps({"ours": len(values), "scenics": count, "bound": bound, "p": found}, indent=1))
    else:
        print(f"{script.name}: {len(values):,} scenes of ours, {count:,} of Scenic's; p at least {bound:.5f} asked for")
        for name, p in found.items():
            print(f"{name:24} p {p:.4f}")
    return int(min(found.values()) < bound)


def quantities(scenes: Floats) -> Mapping[str, Floats]:
    """By name, one number a scene; `scenes` are (n, objects, 3): x, y, heading."""
    found: dict[str, Floats] = {}
    for number in range(scenes.shape[1]):
        x, y, heading = scenes[:, number].T
        found |= {f"x of {number}": x, f"y of {number}": y}
        found |= {f"sine of {number}": np.sin(heading), f"cosine of {number}": np.cos(heading)}
    for one, other in combinations(range(scenes.shape[1]), 2):
        found[f"distance {one} to {other}"] = np.hypot(*(scenes[:, one, :2] - scenes[:, other, :2]).T)
    return found
