"""The scenario that the run is: set up with the file, and the first coroutine of the run."""

from cortex_dsl import ir
from cortex_dsl.semantics.composition.composing import Composer, composer_of
from cortex_dsl.semantics.composition.setting_up import number, set_up
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import ScenarioValue
from engine.vocabulary import Turns


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
