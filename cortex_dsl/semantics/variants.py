"""One variant: the file run once, with one combination of its finite choices.

The result is actors, requirements, rules and coroutines as expressions over unknowns: genes, draws, and the state of
the simulation.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.acting.behaviours import actor_behaviour, started_monitors, warn_if_idle
from cortex_dsl.semantics.acting.domains import domain
from cortex_dsl.semantics.acting.objectives import expect, optimize
from cortex_dsl.semantics.acting.rules import keep_record, require_domains, require_over_run
from cortex_dsl.semantics.acting.statements import terminate_when
from cortex_dsl.semantics.acting.yielding import everything
from cortex_dsl.semantics.composition.composing import Composer, run_by, set_up_run
from cortex_dsl.semantics.composition.setting_up import OF_THE_RUN, run_module
from cortex_dsl.semantics.errors.names import DUPLICATE
from cortex_dsl.semantics.errors.problems import Mistake, Rejection
from cortex_dsl.semantics.errors.runs import TOO_MANY_APPEAR, WHICH_SCENARIO
from cortex_dsl.semantics.errors.scene import NO_EGO
from cortex_dsl.semantics.evaluation import calls, geometry, lists, objects, operators, relations, seeing, texts
from cortex_dsl.semantics.evaluation.appearing import DEEPEST
from cortex_dsl.semantics.evaluation.levels import lanes_in
from cortex_dsl.semantics.evaluation.objects import starts_on_road
from cortex_dsl.semantics.evaluation.roads import ROAD, network_of
from cortex_dsl.semantics.evaluation.seeing import in_environment
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.choices import Decisions, Oracle
from cortex_dsl.semantics.model.context import Evaluator, Handler, Moment, Observer
from cortex_dsl.semantics.model.marks import Marks, Rewind
from cortex_dsl.semantics.model.state import FileContext, RuleKey, VariantState
from cortex_dsl.semantics.model.values import POISON, Actor, Value
from cortex_dsl.semantics.names.properties import PROPERTIES
from cortex_dsl.semantics.names.tree import speaks_of_run
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.road.areas import vehicle_region
from engine.vocabulary import Column

# -- which function gives the value of which kind of expression --------------------------------------------------------

HANDLERS: Mapping[type, Handler] = {
    nodes.Number: operators.number,
    nodes.WithUnit: operators.with_unit,
    nodes.Degrees: operators.degrees,
    nodes.String: operators.string,
    nodes.Formatted: texts.formatted,
    nodes.Constant: operators.constant,
    nodes.InitialScenario: operators.initial_scenario,
    nodes.Name: operators.name,
    nodes.Attribute: operators.attribute,
    nodes.Index: lists.index,
    nodes.Call: calls.call,
    nodes.Starred: operators.starred,
    nodes.ListDisplay: lists.display,
    nodes.TupleDisplay: lists.display,
    nodes.DictDisplay: lists.dictionary,
    nodes.Comprehension: lists.comprehension,
    nodes.Lambda: operators.lambda_,
    nodes.Unary: operators.unary,
    nodes.Binary: operators.binary,
    nodes.BoolOp: operators.boolean,
    nodes.Compare: operators.compare,
    nodes.Conditional: operators.conditional,
    nodes.Distance: relations.distance,
    nodes.RelativeHeading: relations.relative_heading,
    nodes.SeenFrom: relations.seen_from,
    nodes.Angle: relations.angle,
    nodes.Follow: relations.follow,
    nodes.SideOf: relations.side_of,
    nodes.VisiblePart: seeing.visible_part,
    nodes.RelativeTo: relations.relative_to,
    nodes.FieldAt: relations.field_at,
    nodes.CanSee: seeing.can_see,
    nodes.Intersects: relations.intersects,
    nodes.OffsetBy: geometry.offset_by,
    nodes.OffsetAlong: geometry.offset_along,
    nodes.New: objects.new,
    nodes.Temporal: operators.implication,
}  # type: ignore[dict-item]


OVER_RUN: Mapping[type, Callable[[Evaluator, nodes.Statement], None]] = {
    nodes.Require: require_over_run,
    nodes.Expect: expect,
    nodes.Optimize: optimize,
    nodes.TerminateWhen: terminate_when,
    nodes.Record: keep_record,
    nodes.Domain: domain,
}  # type: ignore[dict-item]
"""Function for each statement about the running simulation; for `require`, only temporal ones."""


# -- the variant -------------------------------------------------------------------------------------------------------


@frozen
class Draft:
    """A variant before the rules of all variants are known."""

    variant: ir.Variant
    conditions: Mapping[RuleKey, Term]
    span: Span
    """Place of the rejection, or of the first object."""
    objectives: Mapping[Span, Term]


def elaborate_variant(
    module: nodes.Module,
    file: FileContext,
    oracle: Oracle,
    observe: Observer | None = None,
    marks: Marks | None = None,
) -> Draft | None:
    """One variant; None when it has errors. `observe` is called with every value; `marks` are those of the variant
    before.
    """
    file.budget.begin_variant()
    run, first = (marks and marks.back(oracle)) or (VariantState(file, Decisions(oracle)), 0)
    try:
        return _elaborated(Evaluator(run, HANDLERS, observe=observe), module, first, marks)
    finally:
        if marks is None or marks.run is not run:
            run.close()


def _elaborated(ev: Evaluator, module: nodes.Module, first: int, marks: Marks | None) -> Draft | None:
    """Return the variant with a new state, or with one that continues at a statement."""
    run, oracle = ev.run, ev.run.decisions.oracle
    try:
        run_module(ev, module.statements, first, marks)
        composer = set_up_run(ev)
        _compose(ev, composer)
        _find_late(ev)
        actors = _finished_actors(ev)
        require_domains(ev, actors)
        _require_visible(ev, actors)
        _require_workspace(ev, actors)
        _rules(ev, module.statements, composer)
        behaviours = [_behaviour(ev, actor) for actor in actors]
    except Rejection as rejection:
        return Draft(_rejected(run, rejection), {}, rejection.span, {})
    if ev.file.findings.has_errors:
        return None
    assert len(actors) == len(run.built.actors)
    network_of(ev)
    variant = ir.Variant(
        probability=oracle.probability,
        choices=tuple(run.decisions.choices),
        gene_options=oracle.gene_options,
        rejection=None,
        actors=tuple(_ir_actor(ev, a, b) for a, b in zip(actors, behaviours, strict=True)),
        requirements=tuple(run.built.requirements),
        draw_count=run.decisions.draw_count,
        local_count=run.built.local_count,
        draw_sites=tuple(run.decisions.draw_sites),
        monitors=tuple(monitor for monitor in run.built.monitors if monitor is not None),
        environment=() if run.built.environment is None else tuple(run.built.environment.values.items()),
        lights=None if run.built.signals is None else run.built.signals.as_ir(),
    )
    return Draft(variant, run.built.rule_conditions, actors[0].span, run.built.objectives)


def _rejected(run: VariantState, rejection: Rejection) -> ir.Variant:
    return ir.Variant(
        probability=run.decisions.oracle.probability,
        choices=tuple(run.decisions.choices),
        gene_options=run.decisions.oracle.gene_options,
        rejection=rejection.reason,
        rejection_line=run.file.facts.line(rejection.span),
    )


HIDES_THE_EGO = (WHICH_SCENARIO.code, DUPLICATE.code)
"""Mistakes after which it is unknown whether there is an ego."""


def _finished_actors(ev: Evaluator) -> list[Actor]:
    """All objects by number, the ego first."""
    ego = ev.run.ego
    undecided = any(finding.code in HIDES_THE_EGO for finding in ev.file.findings)
    taken = ev.run.names.get("ego") is POISON
    if (ego is None or ego.index != 0) and not taken and not undecided:
        end = len(ev.facts.source.text.rstrip())
        ev.report(NO_EGO.at(Span(end, end), label="the file ends without one"))
    return sorted(ev.run.built.actors, key=lambda actor: actor.index)


def _require_visible(ev: Evaluator, actors: Sequence[Actor]) -> None:
    """Add a requirement for each object with `requireVisible`: the ego sees it at the start."""
    ego = ev.run.ego
    if ego is None:
        return
    for actor in actors:
        if actor is not ego and actor.present and actor.properties.get("requireVisible", False) is True:
            name, line = f"{actor.name} is visible from the ego", ev.facts.line(actor.span)
            ev.run.built.requirements.append(ir.Requirement(seeing.sees(ev, ego, actor), 1.0, name, line))


def _require_workspace(ev: Evaluator, actors: Sequence[Actor]) -> None:
    """Require all objects to lie in the workspace, except those with a `regionContainedIn`."""
    names = {**ev.run.root.names, **ev.run.names}
    workspace = names.get("workspace")
    if not isinstance(workspace, Area) or not workspace.is_workspace:
        return
    scene = ev.at_moment(Moment())
    for actor in actors:
        if "regionContainedIn" not in actor.properties and actor.present:
            inside = geometry.inside(scene, actor, workspace, actor.span)
            name = f"{actor.name} lies in the workspace"
            ev.run.built.requirements.append(ir.Requirement(inside, 1.0, name, ev.facts.line(actor.span)))


def _find_late(ev: Evaluator) -> None:
    """Make the objects that behaviours let appear, so that all behaviours know them when they are written.

    Each round writes the behaviours of the objects that the round before has made, and resets the choices, draws and
    locals. Then all behaviours are written anew, as those of a file without such objects.
    """
    run, built = ev.run, ev.run.built
    if not ev.facts.lets_appear:
        return
    composed, acting = built.late_met, sorted(built.actors, key=lambda each: each.index)
    for _ in range(DEEPEST + 1):
        made, before = len(built.late), Rewind(run)
        for actor in acting:
            _behaviour(ev, actor)
        before.restore()
        acting, built.late_met = built.late[made:], len(built.late)
        if not acting:
            break
    else:
        limit = f"{DEEPEST} objects, each by the one before,"
        ev.report(TOO_MANY_APPEAR.at(acting[0].span, limit=limit))
    built.late_met = composed


def _compose(ev: Evaluator, composer: Composer | None) -> None:
    """Work out the coroutine of the scenario that the run is, the first of all; the monitors that are required, and
    then those that are started, come after it.
    """
    run, leads = ev.run, composer is not None and composer.acts
    run.built.monitors[:] = [None] * (leads + len(run.built.required_monitors))
    if composer is not None and leads:
        run.root.monitor = 0
        try:
            run_by(composer)
        except Mistake as mistake:
            ev.report(mistake)


def _rules(ev: Evaluator, statements: Sequence[nodes.Statement], composer: Composer | None) -> None:
    """Evaluate the statements about the run, after all objects are made."""
    running = ev.at_moment(Moment(running=True))
    places = [(running.at_home(names), own) for names, own in _imported(ev)]
    places.append((running, statements))
    if composer is not None:
        root = ev.run.root
        places.append((composer.ev.at_moment(Moment(running=True, scenario=root)), root.rules))
    late = [(at, statement) for at, own in places for statement in own if speaks_of_run(statement)]
    # Of the rules that are true in one sample the first decides, so those that abort the run come before those that end
    # it, whichever file or scenario says so.
    for at, statement in sorted(late, key=lambda each: not isinstance(each[1], nodes.Require)):
        try:
            OVER_RUN[type(statement)](at, statement)
        except Mistake as mistake:
            at.report(mistake)
    required, first = list(started_monitors(ev)), ev.run.root.monitor + 1
    ev.run.built.monitors[first : first + len(required)] = required


def _imported(ev: Evaluator) -> Iterator[tuple[dict[str, Value], Sequence[nodes.Statement]]]:
    """Variables and statements of the imported files; how a run ends is not up to them."""
    modules = {file.name: file.module for file in ev.facts.imports.values()}
    for name, names in ev.run.imported.items():
        yield names, [s for s in modules[name].statements if type(s) not in OF_THE_RUN]


def _behaviour(ev: Evaluator, actor: Actor) -> ir.Block | None:
    try:
        block = actor_behaviour(ev, actor)
    except Mistake as mistake:
        ev.report(mistake)
        return None
    if block is not None:
        warn_if_idle(ev, actor, block)
    return block


def _ir_actor(ev: Evaluator, actor: Actor, behaviour: ir.Block | None) -> ir.Actor:
    return ir.Actor(
        name=actor.name,
        kind=actor.kind,
        columns=_columns(ev, actor),
        behaviour=behaviour,
        route=_route(behaviour),
        inside_road=not actor.late and starts_on_road(actor) and vehicle_region(network_of(ev)) == ROAD.id,
        overlap_group=0 if actor.late or actor.properties.get("allowCollisions", False) else _coming_with(actor),
        span=actor.span,
        present=actor.present,
        level=tuple(lane.id for lane in lanes_in(actor.properties.get("level"))),
    )


def _coming_with(actor: Actor) -> int:
    """Return the group of actors that appear together: 1 from the start, else by the monitor of the scenario."""
    return 1 if actor.scenario is None or actor.scenario.present else actor.scenario.monitor + 2


def _columns(ev: Evaluator, actor: Actor) -> tuple[ir.Expr, ...]:
    """One expression per `vocabulary.Column`."""
    by_column: dict[Column, ir.Expr] = {
        Column.X: actor.pose.x,
        Column.Y: actor.pose.y,
        Column.HEADING: actor.pose.heading,
    }
    for name, spec in PROPERTIES.items():
        value = actor.properties[name]
        assert isinstance(value, Term)
        by_column[spec.column] = in_environment(ev, name, value)
    return tuple(by_column[column] for column in Column)


def _route(behaviour: ir.Block | None) -> int:
    """Return the first path that a behaviour is known to follow; -1 without one."""
    for act in everything(behaviour or ()):
        if isinstance(act, ir.Follow) and isinstance(act.path, ir.Literal):
            return int(act.path.value)
    return -1
