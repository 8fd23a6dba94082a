"""Conditions of a running simulation as triggers."""

from collections.abc import Callable
from dataclasses import dataclass

from cortex_dsl import ir
from cortex_dsl.interchange.maneuvers.formulas import Case, UnsayableError, formula_of, settled
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ALWAYS,
    NEVER,
    Condition,
    Measure,
    Trigger,
    all_of,
    any_of,
    none_of,
)
from engine.opcodes import Op
from engine.vocabulary import Column, State

MOST_GROUPS = 32
"""Most alternatives of a trigger: with more, it is a calculation that no reader understands."""


@dataclass(frozen=True)
class Unlimited:
    """A measure without its limit. `makes` turns limit and side into the trigger."""

    makes: Callable[[formula.Formula, bool], Trigger]


def trigger_of(case: Case, names: tuple[str, ...], condition: ir.Expr) -> Trigger:
    """Return the trigger of a condition; `names` are those of the actors.

    Raises:
        UnsayableError: OpenSCENARIO has no such condition.
    """
    trigger = _trigger(case, names, condition)
    if len(trigger) > MOST_GROUPS:
        raise UnsayableError("a condition of very many alternatives", condition.span)
    for each in (each for group in trigger for each in group if not each.can_be_said):
        raise UnsayableError(f"the opposite of `{each.measure.value}`", condition.span)
    return trigger


def _trigger(case: Case, names: tuple[str, ...], condition: ir.Expr) -> Trigger:
    if isinstance(condition, ir.Literal):
        return ALWAYS if condition.value else NEVER
    if not isinstance(condition, ir.Apply):
        raise UnsayableError("a condition on what it remembers", condition.span)
    parts = condition.arguments
    if condition.op == Op.WITHIN:
        return _apart(names, condition.immediates[0], None).makes(formula_of(case, parts[0]), True)
    if condition.op in (Op.LT, Op.LE):
        return _comparison(case, names, parts[0], parts[1])
    if condition.op == Op.NOT:
        return none_of(_trigger(case, names, parts[0]))
    if condition.op in (Op.AND, Op.OR):
        both = [_trigger(case, names, part) for part in parts]
        return all_of(both) if condition.op == Op.AND else any_of(both)
    if _is_there(case, condition) or condition.op == Op.NOTICES:
        return ALWAYS
    raise UnsayableError(f"a condition on {condition.op.name.lower().replace('_', ' ')}", condition.span)


def _is_there(case: Case, condition: ir.Apply) -> bool:
    """Return whether the condition is the presence of an actor that is present from the start."""
    if condition.op != Op.STATE or condition.immediates[1] != State.PRESENT:
        return False
    return case.actors[condition.immediates[0]].present


def _comparison(case: Case, names: tuple[str, ...], less: ir.Expr, more: ir.Expr) -> Trigger:
    """Return the trigger of `less < more`; for measured values it also stands for `<=`."""
    if (measured := _measured(case, names, less)) is not None:
        return measured.makes(formula_of(case, more), True)
    if (measured := _measured(case, names, more)) is not None:
        return measured.makes(formula_of(case, less), False)
    one, other = formula_of(case, less), formula_of(case, more)
    if one.plain and other.plain:
        return ALWAYS if one.number < other.number else NEVER
    raise UnsayableError("a condition on params alone", less.span)


def _measured(case: Case, names: tuple[str, ...], expression: ir.Expr) -> Unlimited | None:
    if not isinstance(expression, ir.Apply):
        return None
    if expression.op == Op.TIME:
        return _single(Measure.TIME)
    if expression.op == Op.STATE and expression.immediates[1] == State.SPEED:
        return _single(Measure.SPEED, names[expression.immediates[0]])
    if expression.op == Op.TTC:
        other = expression.immediates[1]
        return _several(Measure.TIME_TO_COLLISION, names, expression.immediates[0], None if other < 0 else other)
    if expression.op == Op.HYPOT:
        return _distance(case, names, expression)
    return None


def _single(measure: Measure, actor: str = "", other: str = "", point: tuple[float, float] = (0.0, 0.0)) -> Unlimited:
    return Unlimited(lambda limit, below: ((Condition(measure, limit, below, actor, other, point),),))


def _several(measure: Measure, names: tuple[str, ...], actor: int, other: int | None) -> Unlimited:
    """Return the trigger on one other actor, or on the least value over all."""
    others = [name for index, name in enumerate(names) if index != actor and other in (None, index)]

    def makes(limit: formula.Formula, below: bool) -> Trigger:
        each = [((Condition(measure, limit, below, names[actor], name),),) for name in others]
        return any_of(each) if below else all_of(each)

    return Unlimited(makes)


def _apart(names: tuple[str, ...], actor: int, other: int | None) -> Unlimited:
    return _several(Measure.RELATIVE_DISTANCE, names, actor, other)


# -- distances --------------------------------------------------------------------------------------------------------


def _distance(case: Case, names: tuple[str, ...], expression: ir.Apply) -> Unlimited | None:
    """hypot(x1 - x0, y1 - y0), where one end at least is an actor."""
    across, along = expression.arguments
    if not (_is_difference(across) and _is_difference(along)):
        return None
    assert isinstance(across, ir.Apply)
    assert isinstance(along, ir.Apply)
    ends = [(across.arguments[i], along.arguments[i]) for i in (0, 1)]
    actors = [_actor_at(*end) for end in ends]
    if actors[0] is not None and actors[1] is not None:
        return _apart(names, actors[0], actors[1])
    for actor, (x, y) in zip(actors, reversed(ends), strict=True):
        if actor is not None:
            return _from_place(case, names, actor, x, y)
    return None


def _is_difference(expression: ir.Expr) -> bool:
    return isinstance(expression, ir.Apply) and expression.op == Op.SUB


def _actor_at(x: ir.Expr, y: ir.Expr) -> int | None:
    """Return the actor with its centre at (x, y) during the run; None without one."""
    states = [each.immediates if isinstance(each, ir.Apply) and each.op == Op.STATE else (-1, -1) for each in (x, y)]
    same = states[0][0] == states[1][0] and (states[0][1], states[1][1]) == (State.X, State.Y)
    return states[0][0] if same else None


def _from_place(case: Case, names: tuple[str, ...], actor: int, x: ir.Expr, y: ir.Expr) -> Unlimited:
    own = case.actors[actor].columns
    if x is own[Column.X] and y is own[Column.Y]:
        return _single(Measure.DISTANCE_TO_START, names[actor])
    point = settled(case, x), settled(case, y)
    if not all(each.plain for each in point):
        raise UnsayableError("the distance from a place that depends on a param", x.span)
    return _single(Measure.DISTANCE_TO_POINT, names[actor], point=(point[0].number, point[1].number))
