"""The files of one case: the scenario, the values of a search's worst cases, and the ranges of the params."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from cortex_dsl.exports.cases import road_name
from cortex_dsl.exports.maneuvers.planning import maneuver_plan
from engine.interchange.export import Export, ExportOptions
from engine.interchange.opendrive import road_map
from engine.interchange.openscenario.maneuvers import ManeuverPlan, champions_file, ranges_file, write_maneuvers
from engine.interchange.openscenario.versions import version_of
from engine.search.ranking import worst_cases

if TYPE_CHECKING:
    from cortex_dsl.exports.cases import ExportCase

CHAMPIONS = 50
"""As many of a run's worst cases are looked at for such as start on the same lanes."""
NO_DISTRIBUTIONS = "OpenSCENARIO 1.0 has no files of parameter values."
NOTHING_VARIES = "No file of parameter values is written: nothing in the scenario depends on a param."


def maneuver_files(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """`<stem>.xosc` with `<stem>.champions.xosc` (of a run) and `<stem>.ranges.xosc`; the road is written elsewhere."""
    plan = maneuver_plan(case.scenario, case.scenes)
    road = case.scenario.program.road_spec
    export = write_maneuvers(case.recording, plan, stem, options, f"{road_name(case.scenario)}.xodr", road_map(road))
    values = _value_files(case, plan, stem, options)
    return Export({**export.files, **values.files}, (*export.remarks, *values.remarks))


def _value_files(case: "ExportCase", plan: ManeuverPlan, stem: str, options: ExportOptions) -> Export:
    version, provenance = version_of(options), case.recording.provenance
    if not version.minor:
        return Export({}, (NO_DISTRIBUTIONS,))
    if not plan.parameters:
        return Export({}, (NOTHING_VARIES,))
    files, remarks, scenario = {}, [], f"{stem}.xosc"
    if case.run is not None:
        sets, others = _champions(case, plan)
        files[f"{stem}.champions.xosc"] = champions_file(scenario, sets, provenance, version)
        if others:
            remarks.append(f"{others} of the run's worst cases begin on other lanes; their own files have them.")
    drawn = [each for each in plan.parameters if each.is_drawn]
    if drawn:
        seed = float(case.scenes.keys[0, 0])
        files[f"{stem}.ranges.xosc"] = ranges_file(scenario, drawn, provenance, version, seed)
    return Export(files, (*remarks, *_undrawn(plan)))


def _undrawn(plan: ManeuverPlan) -> Iterator[str]:
    names = [each.name for each in plan.parameters if not each.is_drawn]
    if names:
        yield f"The ranges leave {', '.join(names)} as in this case: they stand for what was drawn of the starts."


def _champions(case: "ExportCase", plan: ManeuverPlan) -> tuple[list[Mapping[str, float]], int]:
    """Values of the worst cases that make the same finite choices, worst first, and how many make others."""
    assert case.run is not None
    names = [each.name for each in plan.parameters]
    sets, others = [], 0
    for worst in worst_cases(case.run.record.evaluations, CHAMPIONS):
        scenes = case.scenario.scene(worst)
        if scenes.variant[0] != case.scenes.variant[0]:
            others += 1
            continue
        there = maneuver_plan(case.scenario, scenes).values
        if all(name in there for name in names):
            sets.append({name: there[name] for name in names})
    return sets, others
