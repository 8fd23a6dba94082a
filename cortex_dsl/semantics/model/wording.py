"""Values as text for users and as text of the language, and the unit of a dimension in a file.

Messages about the requirements of a file use the same unit.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import chain

from cortex_dsl import ir
from cortex_dsl.semantics.model.areas import Area, Elements, RoadSection, Velocity
from cortex_dsl.semantics.model.values import (
    ActionCall,
    Actor,
    Alignment,
    BehaviourCall,
    BehaviourValue,
    BuiltinValue,
    Centerline,
    ClassValue,
    Closure,
    Colour,
    DirectionField,
    Effect,
    EnumValue,
    Function,
    GlobalParameters,
    GroupNow,
    LaneNow,
    MonitorCall,
    MonitorValue,
    Namespace,
    Pose,
    Quantity,
    Region,
    ScenarioCall,
    ScenarioValue,
    Sighted,
    Signal,
    SimulationNow,
    SurfaceNow,
    Truth,
    Value,
    Vector,
    Weights,
)
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.semantics.quantities.bounds import leaves
from cortex_dsl.semantics.quantities.units import (
    UNITS,
    dimension_name,
    si_word,
)
from cortex_dsl.syntax import nodes
from engine.road.alignment import Segment
from engine.road.network import Intersection, Lane, LaneGroup, Maneuver, Network, Road, RoadSign, Surface
from engine.road.sections import LaneSection
from engine.vocabulary import ManeuverType

_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    (Truth, "a truth value"),
    (Vector, "a point"),
    (Velocity, "a velocity"),
    (Pose, "an oriented point"),
    (Region, "a region"),
    (Area, "a region"),
    (Centerline, "a centre line"),
    (Alignment, "a path"),
    (Segment, "a segment of a path"),
    (LaneNow, "a lane"),
    (LaneSection, "a lane section"),
    (LaneGroup, "a lane group"),
    (GroupNow, "a lane group"),
    (SurfaceNow, "a part of the street"),
    (Road, "a road"),
    (RoadSection, "a road section"),
    (Signal, "a traffic light"),
    (RoadSign, "a sign of the map"),
    (Colour, "the colour of a traffic light"),
    (Effect, "nothing"),
    (DirectionField, "a direction field"),
    (Closure, "a lambda"),
    (Function, "a function"),
    (SimulationNow, "the simulation"),
    (Sighted, "a part of a region"),
    (BehaviourValue, "a behavior"),
    (BehaviourCall, "a behavior"),
    (ClassValue, "a class"),
    (Namespace, "an imported file"),
    (ScenarioValue, "a scenario"),
    (ScenarioCall, "a scenario"),
    (MonitorValue, "a monitor"),
    (MonitorCall, "a monitor"),
    (ActionCall, "an action"),
    (Weights, "a dictionary"),
    (EnumValue, "an enumeration"),
    (ManeuverType, "a maneuver type"),
    (GlobalParameters, "`globalParameters`"),
    (Lane, "a lane"),
    (Maneuver, "a maneuver"),
    (Intersection, "an intersection"),
    (Network, "the network"),
    (Elements, "the elements of the map"),
    (str, "text"),
    (tuple, "a list"),
)
NAMED = (
    Lane, Maneuver, Intersection, Actor, Region, Area, LaneSection, LaneGroup, Road, Signal, RoadSign, ManeuverType,
    Surface,
)  # fmt: skip
"""Types that are shown by name."""


def kind_name(value: Value) -> str:
    """Return the kind of a value for messages: `a length`, `a lane`."""
    if value is None:
        return "none"
    if isinstance(value, Quantity):
        return dimension_name(value.dimension)
    if isinstance(value, Actor):
        return f"an object ({value.kind.name.capitalize()})"
    if isinstance(value, Area):
        return value.name
    if isinstance(value, Surface):
        return f"a {value.kind.value.replace('_', ' ')}"
    if isinstance(value, BuiltinValue):
        return f"`{value.name}`"
    return next((name for kind, name in _KINDS if isinstance(value, kind)), "something else")


def option_name(value: Value) -> str:
    """Return the name of an option of a choice for users."""
    if isinstance(value, NAMED):
        return value.name
    if isinstance(value, str):
        return value
    if isinstance(value, Quantity | Truth) and isinstance(value.expr, ir.Literal):
        return source_text(value) or kind_name(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(option_name(item) for item in value) + "]"
    return kind_name(value)


def number_text(number: float) -> str:
    """Digits that bring back the same number; whole ones without a point."""
    return str(int(number)) if number.is_integer() and abs(number) < 1e16 else repr(number)


def source_text(value: Value) -> str | None:
    """Text that names a value again in the language; None where there is none."""
    match value:
        case None:
            return "None"
        case Lane() | Maneuver() | Intersection() | LaneSection() | Road():
            return value.source
        case Surface():
            return value.source or None
        case ManeuverType():
            return f"ManeuverType.{value.name}"
        case str():
            return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
        case Truth(ir.Literal(value=number)):
            return "True" if number else "False"
        case Quantity(ir.Literal(value=number), dimension):
            unit = si_word(dimension)
            return f"{number_text(number)} {unit}".rstrip()
        case tuple():
            items = [source_text(item) for item in value]
            return None if None in items else "[" + ", ".join(filter(None, items)) + "]"
    return None


# -- units that a file speaks in ---------------------------------------------------------------------------------------


def spoken_unit(
    written: nodes.Expression, condition: ir.Expr, dimension: ir.Dimension, genes: Sequence[ir.GeneInfo]
) -> str:
    """The first unit of a dimension that a condition writes, else that of a param it reads; "" where there is none."""
    words = chain(_written(written), param_units(condition, genes))
    return next((word for word in words if word in UNITS and UNITS[word].dimension == dimension), "")


def _written(condition: nodes.Expression) -> Iterator[str]:
    for node in (condition, *everything_in(condition)):
        match node:
            case nodes.Number(unit=str(word)) | nodes.WithUnit(unit=word):
                yield word
            case nodes.Degrees():
                yield "deg"


def param_units(condition: ir.Expr, genes: Sequence[ir.GeneInfo]) -> Iterator[str]:
    """The units of the params that an expression reads, in the order of the file; "" of those without."""
    for index in sorted({each.index for each in leaves(condition) if isinstance(each, ir.Gene)}):
        yield genes[index].unit


def range_text(low: float, high: float, dimension: ir.Dimension, above: bool) -> str:
    if math.isfinite(low) and math.isfinite(high) and above:
        return f"above {shown(low, dimension)} and at most {shown(high, dimension)}"
    if math.isfinite(low) and math.isfinite(high):
        return f"between {shown(low, dimension)} and {shown(high, dimension)}"
    if math.isfinite(low):
        return f"above {shown(low, dimension)}" if above else f"at least {shown(low, dimension)}"
    return f"at most {shown(high, dimension)}"


def shown(value: float, dimension: ir.Dimension | None) -> str:
    """An SI number for people: `3.5 m`; of a large one all digits, in which it may differ from a limit."""
    number = number_text(value) if 1e5 <= abs(value) < 1e15 else f"{value:.6g}"
    return f"{number} {si_word(dimension)}".rstrip()
