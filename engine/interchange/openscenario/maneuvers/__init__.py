"""Maneuver mode of OpenSCENARIO: a case as an `.xosc` in speeds, routes and triggers over parameters, for other tools
to vary, with files of parameter values: those of known cases, and the ranges to draw from.

formula -> maneuver_plan (intentions) -> storyboard (their notation) -> the files, here

Source: ParameterValueDistribution of ASAM OpenSCENARIO XML 1.1 and later; 1.0 has none.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from engine.errors import InterchangeError
from engine.interchange.contract import Export, ExportOptions
from engine.interchange.opendrive import RoadMap
from engine.interchange.openscenario.document import (
    ParameterDeclaration,
    add_entities,
    header,
    new_document,
    plain_name,
    remarks_on_environment,
)
from engine.interchange.openscenario.maneuvers.maneuver_plan import ManeuverPlan, Parameter
from engine.interchange.openscenario.maneuvers.positions import Places
from engine.interchange.openscenario.maneuvers.storyboard import Notation, add_storyboard
from engine.interchange.openscenario.versions import Version, version_of
from engine.interchange.openscenario.write import add_signals
from engine.interchange.own_metadata import FILE_PREFIX
from engine.interchange.recording import Provenance, Recording
from engine.interchange.xml_writing import Element, child, decimal, xml_text

__all__ = ["ManeuverPlan", "champions_file", "is_listed", "ranges_file", "write_maneuvers"]


def write_maneuvers(
    recording: Recording, plan: ManeuverPlan, stem: str, options: ExportOptions, road_file: str, road_map: RoadMap
) -> Export:
    """Write `<stem>.xosc`: the intentions of the actors of `plan`, on the road of `road_file`; names are the plan's.

    Raises:
        InterchangeError: the plan has no actor.
    """
    if not plan.actors:
        raise InterchangeError("a scenario without actors has no maneuvers", "record a run first")
    version, shown = version_of(options), recording.from_zero()
    starts = {actor.name: actor.start for actor in plan.actors}
    notation = Notation(version, plan.values, Places(road_map, starts, plan.values))
    varied = _varied(plan, version)
    declared = [*(_declared(each, version) for each in varied), *_units(varied)]
    document = new_document(_without(shown, varied), version, road_file, declared)
    add_signals(document.network, shown)
    add_entities(document.root, shown, [actor.name for actor in plan.actors], version)
    add_storyboard(document.root, shown, plan, notation)
    text = xml_text(document.root)
    return Export(
        {f"{stem}.xosc": text}, (*plan.remarks, *_remarks(plan, varied, version), *remarks_on_environment(shown))
    )


def _varied(plan: ManeuverPlan, version: Version) -> tuple[Parameter, ...]:
    """Return the parameters on which a part of the file depends."""
    if version.has_expressions:
        return plan.parameters
    bare = {each.name for each in plan.formulas() if each.name}
    return tuple(each for each in plan.parameters if each.name in bare)


def _declared(parameter: Parameter, version: Version) -> ParameterDeclaration:
    kind = version.integer if parameter.whole else "double"
    return ParameterDeclaration(parameter.name, decimal(parameter.value), kind, parameter.low, parameter.high)


def _units(varied: tuple[Parameter, ...]) -> Iterator[ParameterDeclaration]:
    """Yield the units of parameters, in the notation of provenance, as a parameter is a bare number."""
    for each in varied:
        if each.unit:
            yield ParameterDeclaration(f"{FILE_PREFIX}unit_of_{each.name}", each.unit)


def _without(recording: Recording, varied: tuple[Parameter, ...]) -> Recording:
    """Return the recording without the facts of provenance that are parameters."""
    provenance, names = recording.provenance, {each.name for each in varied}
    genome = {name: text for name, text in provenance.genome.items() if plain_name(name) not in names}
    return replace(recording, provenance=replace(provenance, genome=genome))


def _remarks(plan: ManeuverPlan, varied: tuple[Parameter, ...], version: Version) -> Iterator[str]:
    yield "speeds change at a steady rate and cars follow their lanes exactly: a maneuver is not a replay"
    yield "distances are taken between rear axles, the reference points of OpenSCENARIO; the simulation takes centres"
    fixed = [each.name for each in plan.parameters if each not in varied]
    if fixed:
        yield f"OpenSCENARIO {version.name} has no expressions: {', '.join(fixed)} stand as numbers of this case"


# -- files of parameter values -----------------------------------------------------------------------------------------

RUNS = 100
"""Number of draws that a stochastic file requests."""
MOST_VALUES = 100
"""Number of values from which on an integer is sampled as a real number: OpenSCENARIO has no distribution of integers.
"""


def champions_file(
    scenario_file: str, sets: Sequence[Mapping[str, float]], provenance: Provenance, version: Version
) -> str:
    """Return a deterministic distribution: one set of values per known case, of which there must be one."""
    root, body = _document(scenario_file, provenance, version)
    multi = child(child(body, "Deterministic"), "DeterministicMultiParameterDistribution")
    values = child(multi, "ValueSetDistribution")
    for each in sets:
        one = child(values, "ParameterValueSet")
        for name, value in each.items():
            child(one, "ParameterAssignment", parameterRef=name, value=decimal(value))
    return xml_text(root)


def ranges_file(
    scenario_file: str, parameters: Sequence[Parameter], provenance: Provenance, version: Version, seed: float
) -> str:
    """Return a stochastic distribution: every parameter with the law of a plain run."""
    root, body = _document(scenario_file, provenance, version)
    stochastic = child(body, "Stochastic", numberOfTestRuns=RUNS, randomSeed=seed)
    for parameter in parameters:
        _law(child(stochastic, "StochasticDistribution", parameterName=parameter.name), parameter)
    return xml_text(root)


def is_listed(parameter: Parameter) -> bool:
    """Return True if the ranges name each value of a parameter, so that no other value is sampled."""
    return parameter.whole and parameter.high - parameter.low < MOST_VALUES


def _document(scenario_file: str, provenance: Provenance, version: Version) -> tuple[Element, Element]:
    root = Element("OpenSCENARIO")
    header(root, provenance, version)
    body = child(root, "ParameterValueDistribution")
    child(body, "ScenarioFile", filepath=scenario_file)
    return root, body


def _law(parent: Element, parameter: Parameter) -> None:
    low, high = parameter.low, parameter.high
    if is_listed(parameter):
        values = child(parent, "ProbabilityDistributionSet")
        for value in range(round(low), round(high) + 1):
            child(values, "Element", value=str(value), weight=1)
        return
    if parameter.normal is None:
        law = child(parent, "UniformDistribution")
    else:
        mean, deviation = parameter.normal
        law = child(parent, "NormalDistribution", expectedValue=mean, variance=deviation**2)
    if math.isfinite(low) and math.isfinite(high):
        child(law, "Range", lowerLimit=low, upperLimit=high)
