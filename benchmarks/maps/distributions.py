"""Are scenes of a script of Scenic on a town drawn from one law by both tools?

Compared is what `make validate` compares of scripts on a road of ours (`benchmarks.validation.samples`), in the same
way, at 0.01 over all quantities (Bonferroni). Seeds are fixed.
"""

import json
import os
from dataclasses import replace
from pathlib import Path

from benchmarks.validation.checks import answers
from benchmarks.validation.items import Item
from benchmarks.validation.samples import LEVEL, asked, of_valid
from cortex_dsl import load
from engine.sampling import sample, uniform_genomes
from engine.streams import key_rows
from engine.vocabulary import Method

SEED = 1
ON_THE_MAP = "OpenDriveWarning"
"""What Scenic says of the map itself, whatever is sampled on it."""
MORE = 20
"""Our scenes for each of Scenic's."""


def compare(script: Path, folder: Path, count: int, python: str, *, as_json: bool) -> int:
    """Print in which quantities both differ; 1 where one does."""
    os.environ["CORTEXC_MAPS"] = str(folder.resolve())
    scenario = load(script)
    path = getattr(scenario.program.road_spec, "path", None)
    if path is None:
        print(f"the map of {script} is not in {folder}")
        return 1
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, range(MORE * count))
    config = replace(scenario.config.simulation, max_attempts=100_000)
    ours = of_valid(scenario, sample(scenario.program, uniform_genomes(scenario.program.space, keys), keys, config))
    facts = {**asked(ours, count, LEVEL / len(ours)), "map": path}
    (said,) = answers("scenic", [Item("samples", script.resolve(), facts)], python)
    findings = [each for each in said if not each.startswith(ON_THE_MAP)]
    if as_json:
        print(json.dumps({"scenics": count, "quantities": len(ours), "findings": findings}, indent=1))
    else:
        print(f"{script.name}: {len(ours)} quantities of {count:,} scenes of Scenic's, {len(findings)} findings")
        print("\n".join(findings), end="\n" if findings else "")
    return int(bool(findings))
