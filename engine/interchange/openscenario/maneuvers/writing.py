"""Maneuver mode: a case as an `.xosc` in speeds, routes and triggers, for other tools to vary."""

from collections.abc import Iterator
from dataclasses import replace

from engine.interchange.errors import InterchangeError
from engine.interchange.export import Export, ExportOptions
from engine.interchange.opendrive import RoadMap
from engine.interchange.openscenario.document import ParameterDeclaration, new_document
from engine.interchange.openscenario.entities import add_entities
from engine.interchange.openscenario.maneuvers.conditions import Notation
from engine.interchange.openscenario.maneuvers.places import Places
from engine.interchange.openscenario.maneuvers.plan import ManeuverPlan, Parameter
from engine.interchange.openscenario.maneuvers.storyboard import add_storyboard
from engine.interchange.openscenario.names import plain_name
from engine.interchange.openscenario.signals import add_signals
from engine.interchange.openscenario.versions import Version, version_of
from engine.interchange.properties import FILE_PREFIX
from engine.interchange.recording import Recording
from engine.interchange.xml_text import decimal, xml_text


def write_maneuvers(
    recording: Recording, plan: ManeuverPlan, stem: str, options: ExportOptions, road_file: str, road_map: RoadMap
) -> Export:
    """`<stem>.xosc`: what the actors of `plan` intend, on the road of `road_file`; the names of actors are the plan's.

    Raises:
        InterchangeError: nobody takes part.
    """
    if not plan.actors:
        raise InterchangeError("a scenario without actors has no maneuvers", "record a run first")
    version, shown = version_of(options), recording.from_zero()
    starts = {actor.name: actor.start for actor in plan.actors}
    notation = Notation(version, plan.values, Places(road_map, starts))
    varied = _varied(plan, version)
    declared = [*(_declared(each, version) for each in varied), *_units(varied)]
    document = new_document(_without(shown, varied), version, road_file, declared)
    add_signals(document.network, shown)
    add_entities(document.root, shown, [actor.name for actor in plan.actors], version)
    add_storyboard(document.root, shown, plan, notation)
    text = xml_text(document.root)
    return Export({f"{stem}.xosc": text}, (*plan.remarks, *_remarks(plan, varied, version)))


def _varied(plan: ManeuverPlan, version: Version) -> tuple[Parameter, ...]:
    """Parameters on which something in the file depends."""
    if version.has_expressions:
        return plan.parameters
    bare = {each.name for each in plan.formulas() if each.name}
    return tuple(each for each in plan.parameters if each.name in bare)


def _declared(parameter: Parameter, version: Version) -> ParameterDeclaration:
    kind = version.integer if parameter.whole else "double"
    return ParameterDeclaration(parameter.name, decimal(parameter.value), kind, parameter.low, parameter.high)


def _units(varied: tuple[Parameter, ...]) -> Iterator[ParameterDeclaration]:
    """A parameter is a bare number: its unit is one of provenance's notation."""
    for each in varied:
        if each.unit:
            yield ParameterDeclaration(f"{FILE_PREFIX}unit_of_{each.name}", each.unit)


def _without(recording: Recording, varied: tuple[Parameter, ...]) -> Recording:
    """The recording, whose provenance no longer says what parameters of their own say."""
    provenance, names = recording.provenance, {each.name for each in varied}
    genome = {name: text for name, text in provenance.genome.items() if plain_name(name) not in names}
    return replace(recording, provenance=replace(provenance, genome=genome))


def _remarks(plan: ManeuverPlan, varied: tuple[Parameter, ...], version: Version) -> Iterator[str]:
    yield "speeds change by a steady rate and cars keep to their lanes exactly: a maneuver is no replay"
    yield "distances are taken between rear axles, the reference points of OpenSCENARIO; the simulation takes centres"
    fixed = [each.name for each in plan.parameters if each not in varied]
    if fixed:
        yield f"OpenSCENARIO {version.name} has no expressions: {', '.join(fixed)} stand as numbers of this case"
