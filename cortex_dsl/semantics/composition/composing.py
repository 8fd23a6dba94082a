"""Compile `compose` blocks: the acts of a scenario's coroutine, and of the scenarios that it starts.

A started scenario is a coroutine with a higher number than its parent, which gives it its turns until its end: its
objects appear, its rules hold, its `compose` runs. A scenario that an interrupt leaves by `abort`, or that `until` or
`for` ends, is stopped with the behaviours of its objects; an interrupted scenario waits.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.acting import bodies
from cortex_dsl.semantics.acting.acts import CLOCK_TOLERANCE
from cortex_dsl.semantics.acting.behaviours import Inliner, monitor_body, stop
from cortex_dsl.semantics.acting.bodies import Body, Guards, Invocation
from cortex_dsl.semantics.acting.rules import keep_record
from cortex_dsl.semantics.acting.statements import known_limit, required_monitor
from cortex_dsl.semantics.composition.setting_up import number, place_of, set_up, surely_first
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import (
    LATER_TEMPORAL,
    MADE_AGAIN,
    NOT_A_SCENARIO,
    SCENARIO_CYCLE,
    STARTED_TWICE,
)
from cortex_dsl.semantics.evaluation.calls import as_scenario
from cortex_dsl.semantics.evaluation.geometry import is_present
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import Actor, Instance, ScenarioCall, ScenarioValue, Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.tree import always_condition, assigned_names
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.vocabulary import Turns

# -- the coroutine of a scenario that another one starts ---------------------------------------------------------------


@frozen
class Written:
    block: ir.Block
    preconditions: Guards
    invariants: Guards


@frozen
class Coroutine:
    """Writes it; `span` is where the scenario is started."""

    composer: "Composer"
    span: Span

    def written(self) -> Written:
        composer, instance, span = self.composer, self.composer.instance, self.span
        body = composer.body()
        before, during = composer.guarded(body, span)
        during = (*during, *self._always(body))
        starts = tuple(ir.Start(span, number) for number in self._watchers(body))
        number = composer.reserve() if any(self._rules(nodes.TerminateWhen)) else -1
        acts = body.block(composer.node.compose) if composer.node.compose else self._for_ever()
        inner: ir.Block = (ir.Scope(span, composer.node.name, body.scope, acts, during),)
        if number >= 0:
            inner = self._until(body, inner, number)
        clock, handlers = self._time_limits(body, during)
        if handlers:
            inner = (ir.TryInterrupt(span, inner, handlers),)
        own = [actor.index for actor in instance.actors if not actor.late]
        spawn = (ir.Spawn(span, tuple(own)),) if own and not instance.present else ()
        return Written((*spawn, *instance.entering, *starts, *clock, *inner, stop((instance,), span)), before, during)

    def _for_ever(self) -> ir.Block:
        return (ir.Loop(self.span, self.composer.ev.algebra.truth(True), (ir.Wait(self.span),)),)

    def _rules(self, kind: type) -> Iterator[nodes.Statement]:
        return (statement for statement in self.composer.instance.rules if isinstance(statement, kind))

    def _always(self, body: Body) -> Iterator[tuple[Term, int]]:
        """`require always c` holds while the scenario runs; no other formula can be judged over a part of a run."""
        for statement in self._rules(nodes.Require):
            assert isinstance(statement, nodes.Require)
            condition = always_condition(statement.condition)
            if condition is None or statement.probability is not None:
                self._refuse(body, statement, "require", "it is judged over the whole run", "write it at the top level")
                continue
            try:
                holds = body.condition(condition, repeated=True)
            except Mistake as mistake:
                body.ev.report(mistake)
                continue
            name = statement.name or body.ev.facts.source.words(statement.condition.span)
            yield holds, bodies.abort_rule(body.ev, statement.span, name)

    def _refuse(self, body: Body, statement: nodes.Statement, word: str, reason: str, cure: str) -> None:
        body.ev.report(LATER_TEMPORAL.at(statement.span, statement=word, reason=reason, cure=cure))

    def _watchers(self, body: Body) -> Iterator[int]:
        """The monitors that the scenario requires; they start with it."""
        run = body.ev.run
        for statement in self._rules(nodes.Record):
            assert isinstance(statement, nodes.Record)
            try:
                keep_record(body.ev, statement, body.ev.algebra.running(self.composer.instance.monitor))
            except Mistake as mistake:
                body.ev.report(mistake)
        for statement in self._rules(nodes.Domain):
            self._refuse(body, statement, "domain", "its cells are those of whole runs", "write it at the top level")
        for kind in (nodes.Expect, nodes.Optimize):
            for statement in self._rules(kind):
                word = statement.sense if isinstance(statement, nodes.Optimize) else "expect"
                self._refuse(body, statement, word, "it is judged over the whole run", "write it at the top level")
        for statement in self._rules(nodes.RequireMonitor):
            assert isinstance(statement, nodes.RequireMonitor)
            try:
                call = required_monitor(place(body.ev, self.composer.instance), statement)
                block = monitor_body(body.ev, call, Moment(running=True, scenario=self.composer.instance))
            except Mistake as mistake:
                body.ev.report(mistake)
                continue
            self.composer.instance.watchers.append(len(run.built.monitors))
            run.built.monitors.append(ir.Monitor(statement.name or call.name, block, Turns.LATER, statement.span))
            yield len(run.built.monitors) - 1

    def _until(self, body: Body, acts: ir.Block, number: int) -> ir.Block:
        """Return the acts for `terminate when` of the setup.

        As in Scenic, the condition is evaluated after the turn of `compose`, so that it sees events of the same sample.
        """
        span, name, scope = self.span, self.composer.node.name, body.ev.run.new_scope(self.span)
        body.ev.run.built.monitors[number] = ir.Monitor(name, acts, Turns.CALLED, span)
        going, ends = body.ev.algebra.running(number), []
        for node in self._rules(nodes.TerminateWhen):
            assert isinstance(node, nodes.TerminateWhen)
            try:
                condition = body.condition(node.condition, repeated=True)
            except Mistake as mistake:
                body.ev.report(mistake)
                continue
            ends.append(ir.Branch(node.span, condition, (self._end(body, node, scope),), ()))
        turn = (ir.Advance(span, number), ir.Branch(span, going, (*ends, ir.Wait(span)), ()))
        return (ir.Start(span, number), ir.Scope(span, name, scope, (ir.Loop(span, going, turn),)))

    def _time_limits(self, body: Body, during: Guards) -> tuple[ir.Block, tuple[tuple[Term, ir.Block], ...]]:
        """Return the acts for `terminate after` of the setup: acts at the start, and handlers.

        Conditions that must hold while the scenario runs must also hold at its last sample.
        """
        clock: list[ir.Act] = []
        handlers = []
        for node in self._rules(nodes.TerminateAfter):
            assert isinstance(node, nodes.TerminateAfter)
            demands = tuple(ir.Demand(node.span, holds, rule) for holds, rule in during)
            try:
                handlers.append((self._elapsed(body, node, clock), (*demands, ir.Abort(node.span))))
            except Mistake as mistake:
                body.ev.report(mistake)
        return tuple(clock), tuple(handlers)

    def _end(self, body: Body, node: nodes.TerminateWhen, scope: int) -> ir.Act:
        """`terminate when` ends the scenario, `terminate simulation when` the run."""
        if not node.simulation:
            return ir.Leave(node.span, "return", scope)
        name = node.name or body.ev.facts.source.words(node.condition.span)
        return ir.Terminate(node.span, body.ev.file.run.rule(node.span, name))

    def _elapsed(self, body: Body, node: nodes.TerminateAfter, clock: list[ir.Act]) -> Term:
        algebra, scene = body.ev.algebra, place(body.ev, self.composer.instance)
        limit = known_limit(scene, node, may_vary=True)
        seconds = limit * scene.file.settings.time_step if node.in_steps else limit
        start = body.ev.run.new_local()
        clock.append(ir.SetLocal(node.span, start, algebra.time()))
        passed = algebra.time() - algebra.local(start)
        return seconds - CLOCK_TOLERANCE <= passed


def place(ev: Evaluator, instance: Instance) -> Evaluator:
    """Return the evaluator of this place, with the scene."""
    return ev.at_moment(Moment(scenario=instance))


# -- statements of a `compose` -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Composer(Inliner):
    """Turns the `compose` of a scenario into acts; `ev` is the place of its setup."""

    instance: Instance = field(default_factory=Instance)
    scenarios: tuple[ScenarioValue, ...] = ()
    """The scenarios that are being written out, the outermost first."""
    first: frozenset[Span] = frozenset()
    """Places of the invocations that surely start with this scenario."""

    @property
    def owner(self) -> str:
        return self.scenarios[-1].node.name

    @property
    def lets_appear(self) -> bool:
        return True

    @property
    def node(self) -> nodes.ScenarioDefinition:
        return self.scenarios[-1].node

    @property
    def acts(self) -> bool:
        """Return whether it has acts while it runs: it composes, or has guards."""
        return bool(self.node.compose or self.node.preconditions or self.node.invariants)

    # -- its own block -----------------------------------------------------------------------------------------------

    def body(self) -> Body:
        moment = Moment(running=True, scenario=self.instance)
        counts = list(assigned_names(self.node.compose, repeated=False))
        assigned = frozenset(name for name in counts if counts.count(name) > 1)
        return Body(self, moment, assigned=assigned, scope=self.ev.run.new_scope(self.node.name_span))

    def guarded(self, body: Body, call: Span) -> tuple[Guards, Guards]:
        """Preconditions and invariants, `require always` of the setup among the latter."""

        def condition(node: nodes.Expression) -> Term:
            return body.condition(node, repeated=True)

        node = self.node
        before = bodies.tested_guards(body.ev, node.preconditions, "precondition", node.name, condition, call)
        during = bodies.tested_guards(body.ev, node.invariants, "invariant", node.name, condition, call)
        return before, during

    # -- started scenarios ---------------------------------------------------------------------------------------------

    def mark(self) -> int:
        return len(self.instance.children)

    def stopped(self, mark: int, span: Span) -> ir.Block:
        children = self.instance.children[mark:]
        return (stop(children, span),) if children else ()

    def together(self, body: Body, invocations: Sequence[nodes.Expression]) -> ir.Block:
        started = [self._child(body.ev.evaluate(node), node, body.moment) for node in invocations]
        demands = (ir.Demand(child.span, holds, rule) for child in started for holds, rule in child.preconditions)
        return (*demands, *self._awaited([child.instance for child in started], invocations[0].span))

    def invocation(self, value: Value, node: nodes.Expression, moment: Moment) -> Invocation:
        child = self._child(value, node, moment)
        acts = self._awaited([child.instance], node.span)
        return Invocation((), acts, child.preconditions, child.invariants)

    def _awaited(self, children: Sequence[Instance], span: Span) -> ir.Block:
        """Start scenarios, and wait until all have ended. They have their turns here, so the end is seen at once."""
        algebra = self.ev.algebra
        going: Term = algebra.truth(False)
        for child in children:
            going = going | algebra.running(child.monitor)
        starts = tuple(ir.Start(span, child.monitor) for child in children)
        turns = tuple(ir.Advance(span, child.monitor) for child in children)
        return (*starts, ir.Loop(span, going, (*turns, ir.Branch(span, going, (ir.Wait(span),), ()))))

    def over(self, body: Body, node: nodes.Terminate) -> ir.Block:
        if node.simulation or self.instance is self.ev.run.root:
            words = "terminate simulation" if node.simulation else "terminate"
            return (ir.Terminate(node.span, self.ev.file.run.rule(node.span, f"`{words}` in {self.owner}")),)
        return (ir.Leave(node.span, "return", body.scope),)

    def _child(self, value: Value, node: nodes.Expression, moment: Moment) -> "Child":
        call = as_scenario(value, node.span)
        if call is None:
            known = [name for name, each in self.ev.names.items() if isinstance(each, ScenarioValue)]
            cure = did_you_mean(node.id, known) if isinstance(node, nodes.Name) else ""
            cure = cure or "behaviors belong to objects; what a `compose` runs is defined by `scenario`"
            raise NOT_A_SCENARIO.mistake(node.span, actual=kind_name(value), cure=cure)
        self._check_started(call, node.span)
        if call.instance is not None:
            raise STARTED_TWICE.mistake(node.span, name=call.name)
        call.instance = self._instance(call, node, moment)
        before = len(self.ev.run.built.actors)
        set_up(self.ev, call.scenario, call.instance, dict(call.arguments))
        child = self._written(call, call.instance)
        made = self.ev.run.built.actors[before:]
        return self._once(child, made, call, moment) if made and moment.repeated else child

    def _instance(self, call: ScenarioCall, node: nodes.Expression, moment: Moment) -> Instance:
        surely = self.instance.present and node.span in self.first and not moment.repeated
        number = len(self.ev.run.built.monitors)
        instance = Instance(call.name, parent=self.instance, present=surely, monitor=number, span=node.span)
        self.ev.run.built.monitors.append(None)
        self.instance.children.append(instance)
        return instance

    def reserve(self) -> int:
        """The number of a coroutine that belongs to this scenario, lower than those of all that it is going to run."""
        monitors = self.ev.run.built.monitors
        monitors.append(None)
        self.instance.watchers.append(len(monitors) - 1)
        return len(monitors) - 1

    def _once(self, child: "Child", made: Sequence[Actor], call: ScenarioCall, moment: Moment) -> "Child":
        """Return a child that starts at most once, since it makes objects.

        Raises:
            Mistake: it starts in a loop. In a handler, the second start aborts the run.
        """
        if moment.looping:
            here = Label(made[0].span, "made here")
            raise MADE_AGAIN.mistake(call.span, name=call.name, secondary=(here,))
        fresh = ~is_present(self.ev, made[0])
        rule = bodies.abort_rule(self.ev, call.span, f"{call.name} starts a second time")
        return replace(child, preconditions=((fresh, rule), *child.preconditions))

    def _written(self, call: ScenarioCall, instance: Instance) -> "Child":
        """Work out the coroutine of a scenario that this one starts."""
        composer = composer_of(self, call.scenario, instance)
        written = Coroutine(composer, call.span).written()
        self.ev.run.built.monitors[instance.monitor] = ir.Monitor(call.name, written.block, Turns.CALLED, call.span)
        return Child(instance, written.preconditions, written.invariants, call.span)

    def _check_started(self, call: ScenarioCall, span: Span) -> None:
        running = [each.node.name for each in self.scenarios]
        if any(call.scenario.node is each.node for each in self.scenarios):
            cycle = " -> ".join([*running[running.index(call.name) :], call.name])
            raise SCENARIO_CYCLE.mistake(span, name=call.name, cycle=cycle)


@frozen
class Child:
    """A scenario that another one starts, written out."""

    instance: Instance
    preconditions: Guards
    invariants: Guards
    span: Span


def composer_of(parent: Composer | Evaluator, scenario: ScenarioValue, instance: Instance) -> Composer:
    ev = parent.ev if isinstance(parent, Composer) else parent
    around = parent.scenarios if isinstance(parent, Composer) else ()
    return Composer(
        place_of(ev, scenario, instance),
        None,
        instance=instance,
        scenarios=(*around, scenario),
        first=surely_first(scenario.node.compose),
    )


# -- the scenario that the run is --------------------------------------------------------------------------------------


def set_up_run(ev: Evaluator) -> Composer | None:
    """Set up the scenario that the run is; None where the top level is all."""
    node = ev.facts.entry
    if node is None:
        number(ev.run)
        return None
    root, scenario = ev.run.root, ev.names.get(node.name)
    if not isinstance(scenario, ScenarioValue):
        number(ev.run)
        return None  # it was said that something else has its name
    root.name = node.name
    set_up(ev, scenario, root, {})
    return composer_of(ev, scenario, root)


def run_by(composer: Composer) -> None:
    """Work out the coroutine of the scenario that the run is; it is over when its `compose` is."""
    node, span = composer.node, composer.node.name_span
    body = composer.body()
    before, during = composer.guarded(body, span)
    demands = (ir.Demand(span, holds, rule) for holds, rule in before)
    acts = body.block(node.compose) or (ir.Loop(span, composer.ev.algebra.truth(True), (ir.Wait(span),)),)
    end: ir.Block = ()
    if node.compose:
        end = (ir.Terminate(span, composer.ev.file.run.rule(span, f"the end of {node.name}")),)
    block = (*demands, ir.Scope(span, node.name, body.scope, acts, during), *end)
    monitor = ir.Monitor(node.name, block, Turns.BEFORE_RULES, span)
    composer.ev.run.built.monitors[composer.instance.monitor] = monitor
