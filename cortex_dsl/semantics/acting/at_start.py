"""Requirements of temporal formulas on the first sample: as in Scenic, a scene whose start breaks one is rejected.

The state at sample 0 follows from the scene: positions and speeds of all actors, steering and pedals at rest,
visibility, and time 0. With these values in place of the state of the run, a formula becomes a condition of the scene.
All other values (stored or sampled by a behaviour) are unknown, and logic has three values (Kleene, "Introduction to
Metamathematics", 1952, section 64): each part has two truths, whether it may hold and whether it certainly holds, for
every value of the unknown and every course of the run:

    always f: may hold where f may          eventually f: surely holds where f does          next f: unknown
    f until g: may hold where f or g may, surely holds where g does
"""

from typing import NamedTuple

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.evaluation import seeing
from cortex_dsl.semantics.model.context import SCENE, Evaluator
from cortex_dsl.semantics.model.state import RuleKey
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.model.wording import spoken_unit
from cortex_dsl.semantics.names.tree import is_timed, subformulas
from cortex_dsl.semantics.quantities.algebra import Operation, Term
from cortex_dsl.semantics.quantities.bounds import folded, margin_of
from cortex_dsl.syntax import nodes
from engine.opcodes import Op
from engine.vocabulary import RuleKind, State

SUFFIX = " (at the start)"


class _Said(NamedTuple):
    """Of a part of a formula at sample 0."""

    may_hold: Term
    holds: Term


def require_start(ev: Evaluator, node: nodes.Require, name: str) -> None:
    """Require that a temporal requirement, after evaluation of its atoms, may still hold at the start of the scene."""
    try:
        condition = _Start(ev).of(node.condition).may_hold
    except Mistake:  # a chain of operations as long as there may be: the run decides
        return
    if ev.truth_of(condition)[0] > 0.0:
        return
    margin = margin_of(condition, ev.run.compared)
    unit = spoken_unit(node.condition, condition, margin[1], ev.file.genes.infos)
    required = ir.Requirement(condition, 1.0, name + SUFFIX, ev.facts.line(node.span), *margin, unit)
    ev.run.built.requirements.append(required)


class _Start:
    """Formulas at the first sample of the run."""

    def __init__(self, ev: Evaluator) -> None:
        self.ev = ev
        self.true, self.false = ev.algebra.truth(True), ev.algebra.truth(False)
        self.unknown = _Said(self.true, self.false)
        self.actors = {actor.index: actor for actor in ev.run.built.actors}
        self.states = {index: _states(ev, actor) for index, actor in self.actors.items()}

    def of(self, node: nodes.Expression) -> _Said:
        if not is_timed(node):
            key: RuleKey = (node.span, RuleKind.WATCH)
            return self._condition(self.ev.run.built.rule_conditions[key])
        operator = node.operator if isinstance(node, nodes.Temporal | nodes.BoolOp) else "not"
        first, *others = [self.of(part) for part in subformulas(node)]
        match operator:
            case "not":
                return _Said(~first.holds, ~first.may_hold)
            case "always":
                return _Said(first.may_hold, self.false)
            case "eventually":
                return _Said(self.true, first.holds)
            case "next":
                return self.unknown
            case "until":
                return _Said(first.may_hold | others[0].may_hold, others[0].holds)
            case "implies":
                return _Said(~first.holds | others[0].may_hold, ~first.may_hold | others[0].holds)
        for other in others:
            first = _and(first, other) if operator == "and" else _or(first, other)
        return first

    def _condition(self, condition: Term) -> _Said:
        """Return the truth values of an atom, or of a logical combination."""
        match condition:
            case Operation(op=Op.AND, arguments=(one, other)):
                return _and(self._condition(one), self._condition(other))
            case Operation(op=Op.OR, arguments=(one, other)):
                return _or(self._condition(one), self._condition(other))
            case Operation(op=Op.NOT, arguments=(inner,)):
                said = self._condition(inner)
                return _Said(~said.holds, ~said.may_hold)
        known = folded(condition, self._worth)
        return self.unknown if known is None else _Said(known, known)

    def _worth(self, part: ir.Expr, operands: list[Term | None]) -> Term | None:
        """An expression at the start; None where the scene does not decide."""
        assert isinstance(part, Term)
        if isinstance(part, ir.Local) and part.index in self.ev.run.built.zeroed:
            return self.ev.algebra.literal(0.0)
        if isinstance(part, ir.Local | ir.Running) or None in operands:
            return None
        known = [operand for operand in operands if operand is not None]
        make = self.ev.algebra.apply
        match part:
            case Operation(op=Op.STATE, immediates=(actor, column)):
                return self.states[actor].get(State(column))
            case Operation(op=Op.TIME):
                return self.ev.algebra.literal(0.0)
            case Operation(op=Op.SEES, immediates=(one, other)) if one >= 0 <= other and all(
                map(_is_here, self.actors.values())
            ):
                return seeing.sees(self.ev.at_moment(SCENE), self.actors[one], self.actors[other])
            case Operation(op=op) if op > Op.STATE:
                return None
            case Operation(op=op, immediates=immediates, width=width):
                made = make(op, *known, immediates=immediates, width=width)
                self._compare(part, made)
                return made
            case ir.Pack():
                return self.ev.algebra.pack(*known)
            case ir.Item(index=index):
                return self.ev.algebra.items(known[0], index + 1)[index]
        return part

    def _compare(self, part: Term, made: Term) -> None:
        """Copy the dimension of a compared part to the comparison that replaces it."""
        if part in self.ev.run.compared:
            self.ev.run.compared.setdefault(made, self.ev.run.compared[part])


def _and(one: _Said, other: _Said) -> _Said:
    return _Said(one.may_hold & other.may_hold, one.holds & other.holds)


def _or(one: _Said, other: _Said) -> _Said:
    return _Said(one.may_hold | other.may_hold, one.holds | other.holds)


def _states(ev: Evaluator, actor: Actor) -> dict[State, Term]:
    """Return the state values of an actor at sample 0."""
    speed = actor.properties["speed"]
    assert isinstance(speed, Term)
    still = dict.fromkeys((State.STEER, State.ACCELERATION, State.THROTTLE, State.BRAKE), ev.algebra.literal(0.0))
    pose = {State.X: actor.pose.x, State.Y: actor.pose.y, State.HEADING: actor.pose.heading}
    return {**still, **pose, State.SPEED: speed, State.PRESENT: ev.algebra.truth(_is_here(actor))}


def _is_here(actor: Actor) -> bool:
    """Return whether an actor is present from the start."""
    return actor.scenario is None or actor.scenario.present
