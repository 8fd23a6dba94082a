"""All files of all cases that were asked for, in memory, before the first of them is written; and each format that
needs more of a case than its recording.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import PurePath

from cortex_dsl.api.concrete import map_copies
from cortex_dsl.interchange.cases import ExportCase, road_name
from cortex_dsl.interchange.formats import FORMATS, missing_extra, writer_of
from engine.interchange.after_contact import shown_after_contact
from engine.interchange.contract import Export, ExportOptions, InterchangeError
from engine.maps import MapFile


@dataclass(frozen=True)
class Gathered:
    """What is to be written, and what is to be said about it."""

    files: dict[str, bytes] = field(default_factory=dict)
    """Contents by file name; several cases may share one."""
    formats: dict[str, str] = field(default_factory=dict)
    """By file name, the format whose row first asked for it."""
    names: list[list[str]] = field(default_factory=list)
    """Of each case, the names of all its files."""
    remarks: dict[tuple[str, str], list[int]] = field(default_factory=dict)
    """By format and sentence, the cases (from 0) that it is about."""
    refused: dict[str, InterchangeError] = field(default_factory=dict)
    """By format, why it cannot carry a case; nothing is written in it."""


def gather(cases: Sequence[ExportCase], formats: Sequence[str], options: ExportOptions) -> Gathered:
    """The files of every case in every format that can carry them all; the others are `refused`.

    Raises:
        InterchangeError: none can; its place names case and format.
    """
    made: dict[str, list[Export]] = {}
    gathered = Gathered()
    for name in formats:
        try:
            _refuse_without_package(name)
            made[name] = [_export(case, name, options) for case in cases]
        except InterchangeError as error:
            gathered.refused[name] = error
    if not made:
        raise next(iter(gathered.refused.values()))
    for number in range(len(cases)):
        gathered.names.append([])
        for name, exports in made.items():
            _add(gathered, number, name, exports[number])
    return gathered


def _refuse_without_package(name: str) -> None:
    """Raises InterchangeError where a package is missing; the other formats are written all the same."""
    if cure := missing_extra(name):
        raise InterchangeError(f"it needs the package `{FORMATS[name].package}`, which is not installed", cure, name)


def _export(case: ExportCase, name: str, options: ExportOptions) -> Export:
    stem = case.recording.name
    try:
        return writer_of(name)(case, stem, options)
    except InterchangeError as error:
        raise InterchangeError(error.message, error.cure, error.place or f"{stem} as {name}") from error


def _add(gathered: Gathered, number: int, name: str, export: Export) -> None:
    for file, content in export.files.items():
        data = content if isinstance(content, bytes) else content.encode("utf-8")
        if gathered.files.setdefault(file, data) != data:
            raise ValueError(f"two exports differ about {file}")
        gathered.formats.setdefault(file, name)
        if file not in gathered.names[number]:
            gathered.names[number].append(file)
    for remark in export.remarks:
        gathered.remarks.setdefault((name, remark), []).append(number)


# -- one case in one format, with its road -----------------------------------------------------------------------------


def openscenario(case: ExportCase, stem: str, options: ExportOptions) -> Export:
    """The `.xosc`, by replay or by maneuvers, and its road."""
    road = opendrive(case, stem, options)
    (road_file,) = road.files
    if options.mode == "maneuver":
        from cortex_dsl.interchange.maneuvers import maneuver_files

        export = maneuver_files(case, stem, options, road_file)
        return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))
    if options.player == "carla":
        from engine.interchange.openscenario.carla import write_for_carla as write
    else:
        from engine.interchange.openscenario import write_trajectories as write
    replay = shown_after_contact(case.replay, options.after_contact or "through")
    export = write(replay, stem, options, road_file)
    return Export({**export.files, **road.files}, (*case.left_out, *export.remarks, *road.remarks))


def opendrive(case: ExportCase, _stem: str, options: ExportOptions) -> Export:
    """The road, under a name that all cases of the scenario share."""
    from engine.interchange.opendrive import SOMEWHERE, write_opendrive

    program, name = case.scenario.program, road_name(case.scenario)
    if isinstance(program.road_spec, MapFile):
        return Export(dict(map_copies(program)))
    place = SOMEWHERE if options.player == "carla" else ""
    text = write_opendrive(program.road_spec, case.recording.signals, name, case.road_provenance, place)
    return Export({f"{name}.xodr": text})


def parquet(case: ExportCase, stem: str, options: ExportOptions) -> Export:
    """The table of trajectories, and in its metadata the road, as omega-prime keeps it.

    Raises:
        InterchangeError: pyarrow is not installed.
    """
    from engine.interchange.tables import write_parquet

    ((name, road),) = opendrive(case, stem, options).files.items()
    text = road if isinstance(road, str) else road.decode("utf-8", "replace")
    replay = shown_after_contact(case.replay, options.after_contact or "physics")
    export = write_parquet(replay, stem, (PurePath(name).stem, text))
    return Export(export.files, (*case.left_out, *export.remarks))


def scenic(case: ExportCase, stem: str, options: ExportOptions) -> Export:
    """`<stem>.scenic` and the road that it reads.

    Raises:
        InterchangeError: the road, or what the scenario imports, is nothing that Scenic reads.
    """
    from cortex_dsl.interchange.scenic import refuse_left_hand, write_scenic

    refuse_left_hand(case)
    road = opendrive(case, stem, options)
    (road_file,) = road.files
    export = write_scenic(case, f"{stem}.scenic", road_file)
    return Export({**export.files, **road.files}, (*export.remarks, *road.remarks))
