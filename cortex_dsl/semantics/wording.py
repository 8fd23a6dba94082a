"""How values are told to people, and written down again as text of the language."""

from cortex_dsl import ir
from cortex_dsl.semantics.definitions import (
    Actor,
    BehaviourCall,
    BehaviourValue,
    ClassValue,
    MonitorCall,
    MonitorValue,
    Namespace,
    ScenarioCall,
    ScenarioValue,
)
from cortex_dsl.semantics.quantities.units import dimension_name, si_word
from cortex_dsl.semantics.values import (
    ActionCall,
    BuiltinValue,
    Centerline,
    Closure,
    Colour,
    DirectionField,
    Effect,
    EnumValue,
    GlobalParameters,
    LaneNow,
    Pose,
    Quantity,
    Region,
    Signal,
    Truth,
    Value,
    Vector,
    Weights,
)
from engine.road.network import Intersection, Lane, Maneuver, Network
from engine.road.sections import LaneGroup, LaneSection, Road
from engine.vocabulary import ManeuverType

_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    (Truth, "a truth value"),
    (Vector, "a point"),
    (Pose, "an oriented point"),
    (Region, "a region"),
    (Centerline, "a centre line"),
    (LaneNow, "a lane"),
    (LaneSection, "a lane section"),
    (LaneGroup, "a lane group"),
    (Road, "a road"),
    (Signal, "a traffic light"),
    (Colour, "the colour of a traffic light"),
    (Effect, "nothing"),
    (DirectionField, "a direction field"),
    (Closure, "a lambda"),
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
    (str, "text"),
    (tuple, "a list"),
)


def kind_name(value: Value) -> str:
    """What a value is, for messages: `a length`, `a lane`."""
    if value is None:
        return "none"
    if isinstance(value, Quantity):
        return dimension_name(value.dimension)
    if isinstance(value, Actor):
        return f"an object ({value.kind.name.capitalize()})"
    if isinstance(value, BuiltinValue):
        return f"`{value.name}`"
    return next((name for kind, name in _KINDS if isinstance(value, kind)), "something else")


def option_name(value: Value) -> str:
    """How one option of a choice is shown to people."""
    if isinstance(value, Lane | Maneuver | Intersection | Actor | Region | LaneSection | LaneGroup | Road | Signal):
        return value.name
    if isinstance(value, ManeuverType):
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
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def source_text(value: Value) -> str | None:
    """Text that names a value again in the language; None where there is none."""
    match value:
        case None:
            return "None"
        case Lane() | Maneuver() | Intersection() | LaneSection() | Road():
            return value.source
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
