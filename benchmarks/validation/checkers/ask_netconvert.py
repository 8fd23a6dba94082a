"""SUMO's netconvert: every line that it warns with, and what it made of the junctions."""

import os
import subprocess
import tempfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import sumo
from answering import answer

PROGRAM = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
ENVIRONMENT = {**os.environ, "SUMO_HOME": sumo.SUMO_HOME}


def check(job: dict) -> list[str]:
    """No warning, no error, and as many connections between each two roads as maneuvers."""
    with tempfile.TemporaryDirectory() as folder:
        network = Path(folder) / "network.net.xml"
        command = [PROGRAM, "--opendrive-files", job["file"], "--output-file", network]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, env=ENVIRONMENT)
        found = [line for line in done.stderr.splitlines() if line.strip()]
        if done.returncode:
            return [*found, f"netconvert ended with {done.returncode}"]
        return found + compare(ElementTree.parse(network).getroot(), job)


def compare(network: ElementTree.Element, job: dict) -> list[str]:
    """Connections between each two roads, against our maneuvers; what lies inside junctions and U-turns left out.

    Counts are compared without their direction: netconvert reads left-hand roads as right-hand ones that are driven the
    other way, even those that it wrote itself (`--opendrive-output.lefthand-left`). There it works out for itself which
    lane leads to which, so that of left-hand roads only the number of roads that are connected is compared.
    """
    between = [each for each in network.iter("connection") if not each.get("from", "").startswith(":")]
    turns = Counter((each.get("from"), each.get("to")) for each in between if each.get("dir") not in ("t", "T"))
    seen = sorted(turns.values())
    alike = len(seen) == len(job["turns"]) if job["left_hand"] else seen == job["turns"]
    return [] if alike else [f"connections between roads: {seen}, maneuvers: {job['turns']}"]


answer(check)
