"""Check whether a block of acts ever ends the actor's turn: an endless loop within a step is a mistake."""

from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.semantics.errors.runs import MAY_NOT_ACT, NEVER_ACTS
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.quantities.bounds import leaves
from cortex_dsl.source import Span
from engine.opcodes import Op

TURN_ENDS = (ir.Take, ir.Wait, ir.Follow, ir.HoldSpeed, ir.Replay, ir.Terminate)
"""A `Demand` is none: it ends the run only where it fails."""
WAYS_OUT = (ir.Leave, ir.Abort)


def everything(block: ir.Block) -> Iterator[ir.Act]:
    """All acts of a block, nested ones included."""
    for act in block:
        yield act
        match act:
            case ir.Branch(then=then, otherwise=otherwise):
                yield from everything(then)
                yield from everything(otherwise)
            case ir.Loop(body=body) | ir.Scope(body=body):
                yield from everything(body)
            case ir.Pick(options=options):
                for option in options:
                    yield from everything(option.body)
            case ir.TryInterrupt(body=body, handlers=handlers):
                yield from everything(body)
                for _, acts in handlers:
                    yield from everything(acts)


def ever_acts(block: ir.Block) -> bool:
    """Return whether any act in the block may take, wait or end the run."""
    return any(isinstance(act, TURN_ENDS) for act in everything(block))


def check_loop(ev: Evaluator, condition: ir.Expr, body: ir.Block, span: Span) -> None:
    """Refuse a loop that neither acts, nor has a way out, nor changes its condition."""
    if not _goes_on(condition, body):
        ev.report(NEVER_ACTS.at(span, what="loop", words=_words(ev)))
    elif not _changes(condition, body) and _passes(body):
        ev.report(MAY_NOT_ACT.at(span))


def _changes(condition: ir.Expr, body: ir.Block) -> bool:
    """Return whether a pass may change the condition: it sets a variable, or the condition is random."""
    acts = list(everything(body))
    asked = [condition, *(act.condition for act in acts if isinstance(act, ir.Branch | ir.Loop))]
    chance = any(isinstance(leaf, ir.Apply) and leaf.op == Op.RANDOM for each in asked for leaf in leaves(each))
    return chance or any(isinstance(act, ir.SetLocal) for act in acts)


def _passes(block: ir.Block) -> bool:
    """Return whether the end of the block is certainly reachable without an action."""
    for act in block:
        match act:
            case ir.Branch(then=then, otherwise=otherwise):
                if not _passes(then) and not _passes(otherwise):
                    return False
            case ir.Demand():
                pass
            case _:
                return False
    return True


def check_handler(ev: Evaluator, condition: ir.Expr, body: ir.Block, span: Span) -> None:
    """Refuse a handler that ends without acting: its condition would be evaluated again at once."""
    if not _goes_on(condition, body):
        ev.report(NEVER_ACTS.at(span, what="handler", words=_words(ev)))


def _words(ev: Evaluator) -> str:
    """Statements that end a turn; a monitor has fewer."""
    return "`wait`" if ev.moment.actor is None else "`take`, `wait` or `do`"


def _goes_on(condition: ir.Expr, body: ir.Block) -> bool:
    if any(isinstance(act, (*TURN_ENDS, *WAYS_OUT)) for act in everything(body)):
        return True
    seen = leaves(condition)
    if any(isinstance(leaf, ir.Apply) and leaf.op == Op.RANDOM for leaf in seen):
        return True
    changed = {act.index for act in everything(body) if isinstance(act, ir.SetLocal)}
    return any(isinstance(leaf, ir.Local) and leaf.index in changed for leaf in seen)
