"""A case in OpenSCENARIO's maneuver mode: the scenario, the values of a search's worst cases, and the ranges of the
params.

formulas (what depends on params) -> triggers, intentions (one actor) -> planning (all of them) -> the files, here
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cortex_dsl.interchange.maneuvers.planning import maneuver_plan
from engine.interchange.contract import Export, ExportOptions
from engine.interchange.opendrive import road_map
from engine.interchange.openscenario.maneuvers import (
    ManeuverPlan,
    champions_file,
    is_listed,
    ranges_file,
    write_maneuvers,
)
from engine.interchange.openscenario.versions import version_of
from engine.search.ranking import worst_cases

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from engine.search.ranking import Case

__all__ = ["maneuver_files", "maneuver_plan"]


CHAMPIONS = 50
"""Number of worst cases of a run among which cases with the same finite choices are selected."""
NOTHING_VARIES = "no file of parameter values is written: nothing in the scenario depends on a param"


def maneuver_files(case: "ExportCase", stem: str, options: ExportOptions, road_file: str) -> Export:
    """`<stem>.xosc` with `<stem>.champions.xosc` (of a run) and `<stem>.ranges.xosc`; the road is written elsewhere."""
    plan = maneuver_plan(case.scenario, case.scenes, run=case.recording)
    road = case.scenario.program.road_spec
    export = write_maneuvers(case.recording, plan, stem, options, road_file, road_map(road))
    values = _value_files(case, plan, stem, options)
    return Export({**export.files, **values.files}, (*export.remarks, *values.remarks))


def _value_files(case: "ExportCase", plan: ManeuverPlan, stem: str, options: ExportOptions) -> Export:
    version, provenance = version_of(options), case.recording.provenance
    if not version.has_distributions:
        return Export({}, (f"OpenSCENARIO {version.name} has no files of parameter values",))
    if not plan.parameters:
        return Export({}, (NOTHING_VARIES,))
    files, remarks, scenario = {}, [], f"{stem}.xosc"
    if case.run is not None:
        cases = worst_cases(case.run.record.evaluations, CHAMPIONS)
        found = _champions(case, plan, [each for each in cases if not each.lost])
        files[f"{stem}.champions.xosc"] = champions_file(scenario, found.sets, provenance, version)
        remarks += _of_champions(found)
    drawn = [each for each in plan.parameters if each.is_drawn]
    if drawn:
        seed = float(case.scenes.keys[0, 0])
        files[f"{stem}.ranges.xosc"] = ranges_file(scenario, drawn, provenance, version, seed)
    return Export(files, (*remarks, *_of_ranges(plan)))


def _of_champions(found: "_Champions") -> Iterator[str]:
    if found.others:
        which, make = f"{found.others} of the run's {found.looked_at}", "makes" if found.others == 1 else "make"
        yield (
            f"{which} worst cases {make} other finite choices (lane, maneuver …), which no parameter here can; "
            "export them by --case K"
        )


def _of_ranges(plan: ManeuverPlan) -> Iterator[str]:
    names = [each.name for each in plan.parameters if not each.is_drawn]
    if names:
        yield f"only params have ranges: drawn places ({', '.join(names)}) stay as in this case"
    names = [each.name for each in plan.parameters if each.is_drawn and each.whole and not is_listed(each)]
    if names:
        yield f"the ranges draw {', '.join(names)} from all numbers, not from the whole ones alone: they are too many"


class _Champions(NamedTuple):
    """Values of this case, then those of worst cases that make the same finite choices, the worst first."""

    sets: Sequence[Mapping[str, float]]
    others: int
    """Number of cases with other choices."""
    looked_at: int
    """Number of cases that were compared."""


def _champions(case: "ExportCase", plan: ManeuverPlan, worst: Sequence["Case"]) -> _Champions:
    sets, others = [dict(plan.values)], 0
    for each in worst:
        scenes = case.scenario.scene(each)
        if np.array_equal(scenes.keys, case.scenes.keys) and np.array_equal(scenes.genomes, case.scenes.genomes):
            continue
        if scenes.variant[0] != case.scenes.variant[0]:
            others += 1
            continue
        there = maneuver_plan(case.scenario, scenes).values
        if there.keys() >= plan.values.keys():
            sets.append({name: there[name] for name in plan.values})
    return _Champions(sets, others, len(worst))
