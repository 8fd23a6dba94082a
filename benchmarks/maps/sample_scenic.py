"""Scenes of a script as Scenic samples them, as JSON, for `benchmarks.maps`: run by a Python that has Scenic.

python sample_scenic.py FILE.scenic MAP.xodr COUNT SEED
"""

import json
import random
import sys
from pathlib import Path

import numpy
import scenic


def drawn(script: str, path: str, count: int, seed: int) -> list[list[list[float]]]:
    """By scene and object: x, y, heading from north. What Verifai would search is drawn evenly."""
    random.seed(seed)
    numpy.random.seed(seed)
    text = Path(script).read_text(encoding="utf-8").replace("Verifai", "")
    scenario = scenic.scenarioFromString(text, params={"map": path}, model="scenic.domains.driving.model", mode2D=True)
    scenes = (scenario.generate(maxIterations=100_000)[0] for _ in range(count))
    return [[[each.position.x, each.position.y, each.heading] for each in scene.objects] for scene in scenes]


if __name__ == "__main__":
    answer = drawn(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    sys.stdout.write("\n" + json.dumps(answer) + "\n")
