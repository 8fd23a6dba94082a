"""What a file expects of the system under test, and what it lets a search make large or small.

`expect` is a formula as `require` has them, but it rejects nothing: a run that breaks it is a finding. Each of its
atoms is looked at twice in every sample, as a truth and as a number (`robustness`), and when the run is over the
formula is worked out of both. `maximize` and `minimize` are one expression of the whole run (`over_run`).
"""

from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.acting.rules import OPERATORS, Conditions, Folder, seen, waiting_part
from cortex_dsl.semantics.errors.names import DUPLICATE
from cortex_dsl.semantics.errors.objectives import (
    ALWAYS_BROKEN,
    AT_THE_START,
    NEVER_BROKEN,
    NOT_ONE_LINE,
    NOT_ONE_NUMBER,
    TAKEN_NAME,
)
from cortex_dsl.semantics.errors.statements import NO_END
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.over_run import judged
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import FileContext
from cortex_dsl.semantics.names.tree import atoms, is_timed, subformulas
from cortex_dsl.semantics.quantities.bounds import changes, is_dynamic, parts
from cortex_dsl.semantics.quantities.robustness import robustness_of
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.vocabulary import OBJECTIVES, RuleKind, Sense, TemporalOp

# -- one variant -------------------------------------------------------------------------------------------------------


def expect(ev: Evaluator, node: nodes.Expect) -> None:
    """The conditions of its atoms, and how far they hold."""
    _declare(ev, node, ir.Objective(Sense.EXPECT, _name_of(ev.file, node, node.condition), ev.file.line(node.span)))
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
    name, line = _name_of(ev.file, node, node.value), ev.file.line(node.span)
    _declare(ev, node, ir.Objective(Sense[node.sense.upper()], name, line, value.dimension or PURE))
    ev.run.built.objectives[node.span] = value.expr


def _declare(ev: Evaluator, node: nodes.Expect | nodes.Optimize, made: ir.Objective) -> None:
    """The same objective in all variants, and no other of its name."""
    if made.name in OBJECTIVES:
        raise TAKEN_NAME.mistake(node.span, name=made.name)
    first = next((span for span, (_, known) in ev.file.objectives.items() if known.name == made.name), node.span)
    if first != node.span:
        where = (Label(first, "first here"),)
        raise DUPLICATE.mistake(node.span, secondary=where, what="the objective", name=made.name)
    ev.file.objectives.setdefault(node.span, (node, made))


def _name_of(file: FileContext, node: nodes.Expect | nodes.Optimize, said: nodes.Expression) -> str:
    if node.name and not node.name.isprintable():
        raise NOT_ONE_LINE.mistake(node.span, name=ascii(node.name)[1:-1])
    return node.name or _in_words(file, said)


def _in_words(file: FileContext, said: nodes.Expression) -> str:
    """An expression as it is written, on one line."""
    return file.source.words(said.span)


def _behind(atom: nodes.Expression) -> Span:
    """The place of an atom's number: no rule but its own ends there."""
    return Span(atom.span.end, atom.span.end)


# -- all variants together ---------------------------------------------------------------------------------------------


def objectives_of(file: FileContext, conditions: Conditions, *, has_end: bool) -> tuple[ir.Objective, ...]:
    """The objectives in the order of the file; reports what no run, or every run, breaks."""
    found = []
    for node, made in file.objectives.values():
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
    if file.overrides or file.settings.stream is not None:
        return  # what is pinned from outside is no mistake of the file
    if known is True:
        file.findings.add(NEVER_BROKEN.at(span))
    elif known is False:
        file.findings.add(ALWAYS_BROKEN.at(span))
    elif not is_timed(node.condition):
        if not any(map(is_dynamic, seen(node, conditions))):
            return  # it is the same at every instant, such as one of params
        words = _in_words(file, node.condition)
        joined = isinstance(node.condition, nodes.BoolOp)
        file.findings.add(AT_THE_START.at(span, condition=f"({words})" if joined else words))
    elif not has_end and (waiting := waiting_part(node.condition)) is not None:
        file.findings.add(NO_END.at(waiting.span, limit=SimulationConfig().max_time))


def _formula(file: FileContext, node: nodes.Expression) -> ir.Formula:
    """The whole formula: of what is known to hold it still matters how far."""
    if not is_timed(node):
        name = _in_words(file, node)
        truth, number = (file.rule(at, name, RuleKind.WATCH) for at in (node.span, _behind(node)))
        return ir.Formula(TemporalOp.ATOM, watch=truth, margin=number)
    operator = node.operator if isinstance(node, nodes.Temporal | nodes.BoolOp) else "not"
    first, *others = [_formula(file, part) for part in subformulas(node)]
    if not others:
        return ir.Formula(OPERATORS[operator], (first,))
    for other in others:
        first = ir.Formula(OPERATORS[operator], (first, other))
    return first
