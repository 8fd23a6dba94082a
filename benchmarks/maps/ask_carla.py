"""CARLA's topology of a file, as JSON, for `benchmarks.maps`: run by a Python that has `carla`; no simulator is needed.

python ask_carla.py FILE.xodr

CARLA's parser takes the junction at the end of a road for a road where one has its number, and finds no way into it
(`MapBuilder::GetLaneNext` asks whether there is a road of that number). ASAM OpenDRIVE numbers both apart, and so do
files. Their junctions get other numbers here before CARLA reads them.
"""

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

try:
    import carla  # type: ignore[import-not-found]
except ModuleNotFoundError:
    sys.exit(3)  # which `topology` knows


def numbered_apart(text: str) -> str:
    """The file with junctions whose numbers no road has; as it is where that is so."""
    root = ElementTree.fromstring(text)
    roads = {road.get("id") for road in root.iter("road")}
    junctions = {junction.get("id") for junction in root.iter("junction")}
    if not roads & junctions:
        return text
    free = 1 + max(int(number) for number in roads | junctions if number is not None)
    other = {number: str(free + index) for index, number in enumerate(sorted(filter(None, junctions)))}
    for junction in root.iter("junction"):
        junction.set("id", other[junction.get("id", "")])
    for road in root.iter("road"):
        road.set("junction", other.get(road.get("junction", ""), "-1"))
        for end in road.findall("link/*"):
            if end.get("elementType") == "junction":
                end.set("elementId", other.get(end.get("elementId", ""), "-1"))
    return ElementTree.tostring(root, encoding="unicode")


if __name__ == "__main__":
    town = carla.Map("town", numbered_apart(Path(sys.argv[1]).read_text(encoding="utf-8")))
    pairs = [(a.road_id, a.lane_id, b.road_id, b.lane_id) for a, b in town.get_topology()]
    sys.stdout.write("\n" + json.dumps(pairs) + "\n")
