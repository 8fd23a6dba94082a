"""Monitors: behaviours of nobody, which watch the run from its start."""

from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting.behaviours import Inliner
from cortex_dsl.semantics.acting.yielding import everything
from cortex_dsl.semantics.context import Evaluator, Moment
from cortex_dsl.semantics.definitions import BehaviourCall, BehaviourValue, MonitorCall, MonitorValue
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.calls import monitor_call
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.values import Value
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

NOTHING_GIVEN: tuple[Given, ...] = ()


def required(ev: Evaluator, node: nodes.RequireMonitor) -> MonitorCall:
    """The monitor that a `require monitor` names, with its arguments.

    Raises:
        Mistake: when it names something else.
    """
    value = ev.evaluate(node.monitor)
    match value:
        case MonitorCall():
            return value
        case MonitorValue():
            return monitor_call(value, NOTHING_GIVEN, node.monitor.span)
    raise errors.NOT_A_MONITOR.mistake(node.monitor.span, actual=kind_name(value), cure=_cure(ev, value, node.monitor))


def _cure(ev: Evaluator, value: Value, node: nodes.Expression) -> str:
    monitors = [name for name, known in ev.names.items() if isinstance(known, MonitorValue)]
    name = node.function if isinstance(node, nodes.Call) else node
    if isinstance(name, nodes.Name) and (suggestion := did_you_mean(name.id, monitors)):
        return suggestion
    if isinstance(value, BehaviourCall | BehaviourValue):
        return "give a behavior to an object, `with behavior ...`; what only watches is defined by `monitor`"
    return "define it with `monitor`; a plain condition goes after `require always`"


def body(ev: Evaluator, call: MonitorCall, moment: Moment) -> ir.Block:
    """What a monitor does; warns of one that looks at the first sample only."""
    block = Inliner(ev.at_moment(moment), None).monitor(call)
    if not any(isinstance(act, ir.Wait | ir.Loop) for act in everything(block)):
        ev.report(errors.LOOKS_ONCE.at(call.monitor.node.name_span, name=call.name))
    return block


def started(ev: Evaluator) -> Iterator[ir.Monitor]:
    """The monitors that the file requires, in its order."""
    for name, call, span in ev.run.required_monitors:
        try:
            block = body(ev, call, Moment(running=True))
        except Mistake as mistake:
            ev.report(mistake)
        else:
            yield ir.Monitor(name or call.name, block, True, span)


def require_monitor(ev: Evaluator, node: nodes.RequireMonitor) -> None:
    ev.run.required_monitors.append((node.name, required(ev, node), node.span))


Required = tuple[str | None, MonitorCall, Span]
