"""Maneuver mode: a case as an `.xosc` in speeds, routes and triggers, for other tools to vary."""

from collections.abc import Iterator
from dataclasses import replace

from engine.interchange.errors import InterchangeError
from engine.interchange.export import Export, ExportOptions
from engine.interchange.opendrive import RoadMap
from engine.interchange.openscenario.document import Parameter as Declared
from engine.interchange.openscenario.document import new_document
from engine.interchange.openscenario.entities import add_entities
from engine.interchange.openscenario.maneuvers.conditions import Words
from engine.interchange.openscenario.maneuvers.formula import decimal
from engine.interchange.openscenario.maneuvers.places import Places
from engine.interchange.openscenario.maneuvers.plan import ManeuverPlan, Parameter
from engine.interchange.openscenario.maneuvers.storyboard import add_storyboard
from engine.interchange.openscenario.names import plain_name
from engine.interchange.openscenario.signals import add_signals
from engine.interchange.openscenario.versions import version_of
from engine.interchange.openscenario.writing import from_zero
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child, xml_text


def write_maneuvers(
    recording: Recording, plan: ManeuverPlan, stem: str, options: ExportOptions, road_file: str, road_map: RoadMap
) -> Export:
    """`<stem>.xosc`: what the actors of `plan` intend, on the road of `road_file`; the names of actors are the plan's.

    Raises:
        InterchangeError: nobody takes part.
    """
    if not plan.actors:
        raise InterchangeError("a scenario without actors has no maneuvers", "record a run first")
    version, shown = version_of(options), from_zero(recording)
    starts = {actor.name: actor.start for actor in plan.actors}
    words = Words(version, plan.values, Places(road_map, starts))
    varied = _varied(plan, words)
    root = new_document(_without(shown, varied), version, road_file, [*map(_declared, varied), *_units(varied)])
    if words.has_expressions:
        for element, parameter in zip(root[1], varied, strict=False):
            _constrain(element, parameter)
    add_signals(root[-1], shown)
    add_entities(root, shown, [actor.name for actor in plan.actors], version)
    add_storyboard(root, shown, plan, words)
    text = xml_text(root)
    return Export({f"{stem}.xosc": text}, (*plan.remarks, *_remarks(plan, varied, words)))


def _varied(plan: ManeuverPlan, words: Words) -> tuple[Parameter, ...]:
    """Parameters on which something in the file depends."""
    if words.has_expressions:
        return plan.parameters
    bare = {each.name for each in plan.formulas() if each.name}
    return tuple(each for each in plan.parameters if each.name in bare)


def _declared(parameter: Parameter) -> Declared:
    return Declared(parameter.name, decimal(parameter.value), "double")


def _units(varied: tuple[Parameter, ...]) -> Iterator[Declared]:
    """A parameter is a bare number: its unit is one of provenance's words."""
    for each in varied:
        if each.unit:
            yield Declared(f"cortexc_unit_of_{each.name}", each.unit)


def _without(recording: Recording, varied: tuple[Parameter, ...]) -> Recording:
    """The recording, whose provenance no longer says what parameters of their own say."""
    provenance, names = recording.provenance, {each.name for each in varied}
    genome = {name: text for name, text in provenance.genome.items() if plain_name(name) not in names}
    return replace(recording, provenance=replace(provenance, genome=genome))


def _constrain(declaration: Element, parameter: Parameter) -> None:
    """The range within which a parameter may be varied, as 1.1 or later says it."""
    limits = (("greaterOrEqual", parameter.low), ("lessOrEqual", parameter.high))
    finite = [(rule, limit) for rule, limit in limits if abs(limit) < float("inf")]
    if finite:
        group = child(declaration, "ConstraintGroup")
        for rule, limit in finite:
            child(group, "ValueConstraint", rule=rule, value=decimal(limit))


def _remarks(plan: ManeuverPlan, varied: tuple[Parameter, ...], words: Words) -> Iterator[str]:
    yield "Speeds change by a steady rate and cars keep to their lanes exactly: a maneuver is no replay."
    yield "Distances are taken between rear axles, the reference points of OpenSCENARIO; the simulation takes centres."
    fixed = [each.name for each in plan.parameters if each not in varied]
    if fixed:
        yield f"OpenSCENARIO {words.version.name} has no expressions: {', '.join(fixed)} stand as numbers of this case."
