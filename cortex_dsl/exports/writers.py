"""Formats that carry motion and the road: what `engine.interchange` writes, asked for one case."""

from typing import TYPE_CHECKING

from cortex_dsl.exports.cases import road_name
from engine.interchange.export import Export, ExportOptions

if TYPE_CHECKING:
    from cortex_dsl.exports.cases import ExportCase


def openscenario(case: "ExportCase", stem: str, options: ExportOptions) -> Export:
    """The `.xosc`, by replay or by maneuvers, and its road."""
    road = opendrive(case, stem, options)
    (road_file,) = road.files
    if options.mode == "maneuver":
        from cortex_dsl.exports.maneuvers import maneuver_files

        export = maneuver_files(case, stem, options)
    else:
        from engine.interchange.openscenario import write_trajectories

        export = write_trajectories(case.recording, stem, options, road_file)
    return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))


def opendrive(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    """The road, under a name that all cases of the scenario share."""
    from engine.interchange.opendrive import write_opendrive

    program, name = case.scenario.program, road_name(case.scenario)
    text = write_opendrive(program.road_spec, case.recording.signals, name, case.road_provenance)
    return Export({f"{name}.xodr": text})


def commonroad(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    from engine.interchange.commonroad import write_commonroad

    return write_commonroad(case.recording, stem)


def csv(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    from engine.interchange.tables import write_csv

    return write_csv(case.recording, stem)


def parquet(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    from engine.interchange.tables import write_parquet

    return write_parquet(case.recording, stem)


def mcap(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    from engine.interchange.mcap import write_mcap

    return write_mcap(case.recording, stem)


def scn(case: "ExportCase", stem: str, options: ExportOptions) -> Export:  # noqa: ARG001 - a Writer
    """The concrete scenario, and copies of what it imports."""
    facts = case.recording.provenance.facts
    remark = "\n".join(f"{name}: {facts[name]}" for name in ("scenario", "risk", "search", "command") if name in facts)
    return Export(case.scenario.concrete_files(case.scenes, remark=remark, name=f"{stem}.scn"))
