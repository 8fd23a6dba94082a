"""CARLA's topology of a file, as JSON, for `benchmarks.maps`: run by a Python that has `carla`; no simulator is needed.

python ask_carla.py FILE.xodr
"""

import json
import sys
from pathlib import Path

try:
    import carla  # type: ignore[import-not-found]
except ModuleNotFoundError:
    sys.exit(3)  # which `topology` knows

if __name__ == "__main__":
    town = carla.Map("town", Path(sys.argv[1]).read_text(encoding="utf-8"))
    pairs = [(a.road_id, a.lane_id, b.road_id, b.lane_id) for a, b in town.get_topology()]
    sys.stdout.write("\n" + json.dumps(pairs) + "\n")
