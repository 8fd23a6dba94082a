"""Files of parameter values for a scenario in maneuver mode: those of known cases, and the ranges to draw from.

Source: ParameterValueDistribution of ASAM OpenSCENARIO XML 1.1 and later; 1.0 has none.
"""

import math
from collections.abc import Mapping, Sequence

from engine.interchange.openscenario.document import header
from engine.interchange.openscenario.maneuvers.plan import Parameter
from engine.interchange.openscenario.versions import Version
from engine.interchange.recording import Provenance
from engine.interchange.xml_text import Element, child, decimal, xml_text

RUNS = 100
"""How many draws a stochastic file asks for."""
MOST_VALUES = 100
"""An integer with more values than these is drawn like any number: no law of OpenSCENARIO draws integers alone."""


def champions_file(
    scenario_file: str, sets: Sequence[Mapping[str, float]], provenance: Provenance, version: Version
) -> str:
    """A deterministic distribution: one set of values for each known case, of which there must be one."""
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
    """A stochastic distribution: every parameter as a plain run draws it."""
    root, body = _document(scenario_file, provenance, version)
    stochastic = child(body, "Stochastic", numberOfTestRuns=RUNS, randomSeed=seed)
    for parameter in parameters:
        _law(child(stochastic, "StochasticDistribution", parameterName=parameter.name), parameter)
    return xml_text(root)


def is_listed(parameter: Parameter) -> bool:
    """Whether the ranges name each value of a parameter, so that no other is drawn."""
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
