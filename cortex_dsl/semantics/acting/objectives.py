"""Expectations on the system under test, and objectives of a search.

`expect` is a formula like that of `require`, but it rejects nothing: a run that breaks it is a finding. Each of its
atoms is evaluated twice in every sample, as a truth and as a number (`robustness_of`); after the run the formula is
evaluated from both. `maximize` and `minimize` are one expression of the whole run (`over_run`).
"""

from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.acting.rules import OPERATORS, Conditions, Folder, seen, waiting_part
from cortex_dsl.semantics.errors.names import DUPLICATE, NO_END
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import (
    ALWAYS_BROKEN,
    AT_THE_START,
    NEVER_BROKEN,
    NOT_ONE_LINE,
    NOT_ONE_NUMBER,
    TAKEN_NAME,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.over_run import judged
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import FileContext, FileFacts
from cortex_dsl.semantics.names.tree import atoms, is_timed, subformulas
from cortex_dsl.semantics.quantities.algebra import (
    Operation,
    Term,
    equal,
    maximum,
    minimum,
    region_box_depth,
    region_depth,
    where,
)
from cortex_dsl.semantics.quantities.bounds import Dimensions, changes, is_dynamic, margin_of, parts
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.opcodes import Op
from engine.vocabulary import OBJECTIVES, RuleKind, Sense, TemporalOp

# -- one variant -------------------------------------------------------------------------------------------------------


def expect(ev: Evaluator, node: nodes.Expect) -> None:
    """The conditions of its atoms, and how far they hold."""
    _declare(ev, node, ir.Objective(Sense.EXPECT, _name_of(ev.facts, node, node.condition), ev.facts.line(node.span)))
    here, conditions = judged(ev), ev.run.built.rule_conditions
    for atom in atoms(node.condition):
        condition = numbers.truth(here, here.evaluate(atom), atom.span)
        conditions[atom.span, RuleKind.WATCH] = condition
        conditions[_behind(atom), RuleKind.WATCH] = robustness_of(condition, ev.run.compared)


def optimize(ev: Evaluator, node: nodes.Optimize) -> None:
    """The number that a search may make large or small."""
    value = numbers.quantity(judged(ev, over=True).evaluate(node.value), node.value.span, f"what `{node.sense}` takes")
    if any(changes(part) and not isinstance(part, ir.Local) for part in parts(value.expr)):
        raise NOT_ONE_NUMBER.mistake(node.value.span, sense=node.sense)
    name, line = _name_of(ev.facts, node, node.value), ev.facts.line(node.span)
    _declare(ev, node, ir.Objective(Sense[node.sense.upper()], name, line, value.dimension or PURE))
    ev.run.built.objectives[node.span] = value.expr


def _declare(ev: Evaluator, node: nodes.Expect | nodes.Optimize, made: ir.Objective) -> None:
    """Declare the objective, which is the same in all variants, and refuse a second one of its name."""
    if made.name in OBJECTIVES:
        raise TAKEN_NAME.mistake(node.span, name=made.name)
    first = next((span for span, (_, known) in ev.file.run.objectives.items() if known.name == made.name), node.span)
    if first != node.span:
        first_here = (Label(first, "first here"),)
        raise DUPLICATE.mistake(node.span, secondary=first_here, what="the objective", name=made.name)
    ev.file.run.objectives.setdefault(node.span, (node, made))


def _name_of(facts: FileFacts, node: nodes.Expect | nodes.Optimize, said: nodes.Expression) -> str:
    if node.name and not node.name.isprintable():
        raise NOT_ONE_LINE.mistake(node.span, what="an objective", name=ascii(node.name)[1:-1])
    return node.name or _in_words(facts, said)


def _in_words(facts: FileFacts, said: nodes.Expression) -> str:
    """An expression as it is written, on one line."""
    return facts.source.words(said.span)


def _behind(atom: nodes.Expression) -> Span:
    """The place of an atom's number: no rule but its own ends there."""
    return Span(atom.span.end, atom.span.end)


# -- how far a condition of one moment holds or is broken, as one number -----------------------------------------------

ANGLE_UNIT = 0.1
"""Angle that counts as much as 1 m, 1 m/s, 1 m/s^2, 1 s or a pure 1 [rad]."""

_DEPTHS = {Op.REGION_CONTAINS: region_depth, Op.REGION_CONTAINS_BOX: region_box_depth}
_COMPARISONS = (Op.LT, Op.LE, Op.EQ, Op.NE)
_ENDLESS = (Op.TTC, Op.LEAD, Op.CROSSING)
"""Operations with infinite results if nothing lies ahead."""


def robustness_of(condition: Term, compared: Dimensions) -> Term:
    """Return the robustness of a condition: above 0 it holds, below 0 it is broken.

    `compared` are the dimensions of its comparisons.

    Margins (`bounds`) are in units that make them comparable. A condition without margin gets a number: a bare truth 1
    or -1, a position in a region its depth. Donze and Maler (2010), "Robust satisfaction of temporal logic over
    real-valued signals", FORMATS 2010, section 2; the units are ours. `engine.kernels.temporal` evaluates the samples
    of a run.
    """
    try:
        return _robustness(condition, compared)
    except Mistake:  # a chain of operations as long as there may be: the condition fits, and is no more than true
        return _of_truth(condition)


def _robustness(condition: Term, compared: Dimensions) -> Term:
    match condition:
        case Operation(op=Op.AND, arguments=(one, other)):
            return minimum(_robustness(one, compared), _robustness(other, compared))
        case Operation(op=Op.OR, arguments=(one, other)):
            return maximum(_robustness(one, compared), _robustness(other, compared))
        case Operation(op=Op.NOT, arguments=(inner,)):
            return -_robustness(inner, compared)
        case Operation(op=op, arguments=arguments) if op in _DEPTHS:
            return _DEPTHS[op](*arguments)
        case Operation(op=op, arguments=(left, right)) if op in _COMPARISONS:
            return _of_comparison(condition, left, right, compared)
    return _of_truth(condition)


def _of_truth(condition: Term) -> Term:
    return where(condition, 1.0, -1.0)


def _of_comparison(condition: Term, left: Term, right: Term, compared: Dimensions) -> Term:
    margin, dimension = margin_of(condition, compared)
    if margin is None:
        return _of_truth(condition)
    if _may_be_infinite(left) and _may_be_infinite(right):
        margin = where(equal(left, right), 0.0, margin)  # the difference of two infinities is no number
    return margin / ANGLE_UNIT**dimension.angle if dimension.angle else margin


def _may_be_infinite(side: Term) -> bool:
    return any(isinstance(part, ir.Apply) and part.op in _ENDLESS for part in parts(side))


# -- all variants together ---------------------------------------------------------------------------------------------


def objectives_of(file: FileContext, conditions: Conditions, *, has_end: bool) -> tuple[ir.Objective, ...]:
    """Return the objectives in the order of the file; report those that no run, or every run, breaks."""
    found = []
    for node, made in file.run.objectives.values():
        if isinstance(node, nodes.Expect):
            known = Folder(file, conditions).formula(node.condition)
            _report(file, node, known, conditions, has_end=has_end)
            found.append(replace(made, formula=_formula(file, node.condition)))
        else:
            found.append(made)
    return tuple(found)


def _report(
    file: FileContext, node: nodes.Expect, known: ir.Formula | bool, conditions: Conditions, *, has_end: bool
) -> None:
    span = node.condition.span
    if file.is_pinned:
        return
    if known is True:
        file.findings.add(NEVER_BROKEN.at(span))
    elif known is False:
        file.findings.add(ALWAYS_BROKEN.at(span))
    elif not is_timed(node.condition):
        if not any(map(is_dynamic, seen(node, conditions))):
            return  # it is constant in time, such as one of params
        words = _in_words(file.facts, node.condition)
        joined = isinstance(node.condition, nodes.BoolOp)
        file.findings.add(AT_THE_START.at(span, condition=f"({words})" if joined else words))
    elif not has_end and (waiting := waiting_part(node.condition)) is not None:
        file.findings.add(NO_END.at(waiting.span, limit=SimulationConfig().max_time))


def _formula(file: FileContext, node: nodes.Expression) -> ir.Formula:
    """Return the whole formula, including known parts: their robustness still matters."""
    if not is_timed(node):
        name = _in_words(file.facts, node)
        truth, number = (file.run.rule(at, name, RuleKind.WATCH) for at in (node.span, _behind(node)))
        return ir.Formula(TemporalOp.ATOM, watch=truth, margin=number)
    operator = node.operator if isinstance(node, nodes.Temporal | nodes.BoolOp) else "not"
    first, *others = [_formula(file, part) for part in subformulas(node)]
    if not others:
        return ir.Formula(OPERATORS[operator], (first,))
    for other in others:
        first = ir.Formula(OPERATORS[operator], (first, other))
    return first
