"""The coroutine of a scenario that another one starts: its objects come in, its rules hold, its `compose` runs."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting import guards
from cortex_dsl.semantics.acting.behaviours import stop
from cortex_dsl.semantics.acting.bodies import Body, Guards
from cortex_dsl.semantics.context import Evaluator, Moment
from cortex_dsl.semantics.definitions import Instance
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.quantities import numbers
from cortex_dsl.semantics.quantities.units import TIME
from cortex_dsl.semantics.running import monitors
from cortex_dsl.semantics.running.temporal import always_condition
from cortex_dsl.semantics.statements import known_number
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.frozen import frozen
from engine.vocabulary import Op

if TYPE_CHECKING:
    from cortex_dsl.semantics.composition.composing import Composer

CLOCK_TOLERANCE = 1e-9
"""Slack of `terminate after`: sums of time steps do not hit a duration exactly [s]."""


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
        acts = body.block(composer.node.compose) if composer.node.compose else self._for_ever()
        clock, handlers = self._ends(body, during)
        inner: ir.Block = (ir.Scope(span, composer.node.name, body.scope, acts, during),)
        if handlers:
            inner = (ir.TryInterrupt(span, inner, handlers),)
        own = [actor.index for actor in instance.actors]
        spawn = (ir.Spawn(span, tuple(own)),) if own and not instance.present else ()
        return Written((*spawn, *starts, *clock, *inner, stop((instance,), span)), before, during)

    def _for_ever(self) -> ir.Block:
        return (ir.Loop(self.span, self.composer.ev.algebra.truth(True), (ir.Wait(self.span),)),)

    def _rules(self, kind: type) -> Iterator[nodes.Statement]:
        return (statement for statement in self.composer.instance.rules if isinstance(statement, kind))

    def _always(self, body: Body) -> Iterator[tuple[ir.Expr, int]]:
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
            name = statement.name or guards.source_of(body.ev, statement.condition)
            yield holds, guards.abort_rule(body.ev, statement.span, name)

    def _refuse(self, body: Body, statement: nodes.Statement, word: str, reason: str, cure: str) -> None:
        body.ev.report(errors.LATER_TEMPORAL.at(statement.span, statement=word, reason=reason, cure=cure))

    def _watchers(self, body: Body) -> Iterator[int]:
        """The monitors that the scenario requires; they start with it."""
        run = body.ev.run
        for statement in self._rules(nodes.Record):
            self._refuse(body, statement, "record", "a value is kept over the whole run", "record it at the top level")
        for statement in self._rules(nodes.RequireMonitor):
            assert isinstance(statement, nodes.RequireMonitor)
            try:
                call = monitors.required(place(body.ev, self.composer.instance), statement)
                block = monitors.body(body.ev, call, Moment(running=True, scenario=self.composer.instance))
            except Mistake as mistake:
                body.ev.report(mistake)
                continue
            self.composer.instance.watchers.append(len(run.monitors))
            run.monitors.append(ir.Monitor(statement.name or call.name, block, False, statement.span))
            yield len(run.monitors) - 1

    def _ends(self, body: Body, during: Guards) -> tuple[ir.Block, tuple[tuple[ir.Expr, ir.Block], ...]]:
        """What `terminate when` and `terminate after` of the setup do: acts at the start, and handlers. What must hold
        while the scenario runs must hold at its last sample too.
        """
        clock: list[ir.Act] = []
        handlers = []
        for statement in self.composer.instance.rules:
            demands = tuple(ir.Demand(statement.span, holds, rule) for holds, rule in during)
            try:
                if isinstance(statement, nodes.TerminateAfter):
                    leave = ir.Abort(statement.span)
                    handlers.append((self._elapsed(body, statement, clock), (*demands, leave)))
                elif isinstance(statement, nodes.TerminateWhen):
                    condition = body.condition(statement.condition, repeated=True)
                    handlers.append((condition, (*demands, self._end(body, statement))))
            except Mistake as mistake:
                body.ev.report(mistake)
        return tuple(clock), tuple(handlers)

    def _end(self, body: Body, node: nodes.TerminateWhen) -> ir.Act:
        """`terminate when` ends the scenario, `terminate simulation when` the run."""
        if not node.simulation:
            return ir.Abort(node.span)
        name = node.name or guards.source_of(body.ev, node.condition)
        return ir.Terminate(node.span, body.ev.file.rule(node.span, name))

    def _elapsed(self, body: Body, node: nodes.TerminateAfter, clock: list[ir.Act]) -> ir.Expr:
        algebra, scene = body.ev.algebra, place(body.ev, self.composer.instance)
        amount = Given(scene.evaluate(node.amount), node.amount.span)
        if node.in_steps:
            number_of = scene.constant(numbers.quantity(amount.value, amount.span), amount.span, "a number of steps")
            seconds = number_of * (scene.file.settings.time_step or SimulationConfig().time_step)
        else:
            seconds = known_number(scene, amount, TIME, "the time of `terminate after`", 1e-4, 1e5)
        start = body.ev.run.new_local()
        clock.append(ir.SetLocal(node.span, start, algebra.apply(Op.TIME)))
        passed = algebra.sub(algebra.apply(Op.TIME), algebra.local(start))
        return algebra.apply(Op.LE, algebra.literal(seconds - CLOCK_TOLERANCE), passed)


def place(ev: Evaluator, instance: Instance) -> Evaluator:
    """The same place, with the scene."""
    return ev.at_moment(Moment(scenario=instance))
