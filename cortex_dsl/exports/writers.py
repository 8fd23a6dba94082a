"""Formats that carry motion and the road: what `engine.interchange` writes, asked for one case."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from cortex_dsl.exports.cases import road_name
from engine.interchange.export import Export, ExportOptions
from engine.interchange.recording import Recording

if TYPE_CHECKING:
    from cortex_dsl.exports.cases import ExportCase
    from cortex_dsl.exports.formats import Writer


def of_recording(write: Callable[[Recording, str], Export]) -> "Writer":
    """What writes a recording, as the writer of a case: those who take part, and a word on who does not."""

    def written(case: "ExportCase", stem: str, _options: ExportOptions) -> Export:
        export = write(case.replay, stem)
        return Export(export.files, (*case.left_out, *export.remarks))

    return written


def openscenario(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """The `.xosc`, by replay or by maneuvers, and its road."""
    road = opendrive(case, stem, options)
    (road_file,) = road.files
    if options.mode == "maneuver":
        from cortex_dsl.exports.maneuvers import maneuver_files

        export = maneuver_files(case, stem, options)
        return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))
    from engine.interchange.openscenario import write_trajectories

    export = write_trajectories(case.replay, stem, options, road_file)
    return Export({**export.files, **road.files}, (*case.left_out, *export.remarks, *road.remarks))


def opendrive(case: "ExportCase", _stem: str, _options: ExportOptions) -> Export:
    """The road, under a name that all cases of the scenario share."""
    from engine.interchange.opendrive import write_opendrive

    program, name = case.scenario.program, road_name(case.scenario)
    text = write_opendrive(program.road_spec, case.recording.signals, name, case.road_provenance)
    return Export({f"{name}.xodr": text})


def scn(case: "ExportCase", stem: str, _options: ExportOptions) -> Export:
    """The concrete scenario, and copies of what it imports."""
    facts = case.recording.provenance.facts
    remark = "\n".join(f"{name}: {facts[name]}" for name in ("scenario", "risk", "search", "command") if name in facts)
    return Export(case.scenario.concrete_files(case.scenes, remark=remark, name=f"{stem}.scn"))
