"""Compile behaviours to rows: structured acts become jumps over resumable blocks.

A block is a stretch of behaviour with a place of its own: the main line of an actor, the body of a `try`, each of its
handlers. `YIELD b` ends the actor's turn and stores the place at which block b continues; `RESUME b` continues there. A
`try` stores in its parent that the next turn starts at its dispatch, which tests the handlers from the last to the
first for whether they are running or should start, and resumes the first such handler, else the body. This implements
Scenic's interrupts: later clauses take precedence and may interrupt earlier ones, which then resume. Monitors and
`compose` are such code without an actor. A coroutine that a `compose` runs has its turn within its caller's and ends it
by resuming the caller's block.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from cortex_dsl import ir
from cortex_dsl.lowering.instructions import CodeBuffer, ExpressionWriter, LocalRegister, Register, SceneValue, Target
from engine.frozen import frozen
from engine.opcodes import Op
from engine.vocabulary import Column, Command


@dataclass
class Numbers:
    """Hands out numbers, of blocks or locals, unique over all coroutines of a template."""

    count: int = 0

    def new(self) -> int:
        self.count += 1
        return self.count - 1


@dataclass
class LoopTargets:
    top: Target
    end: Target


@frozen
class Coroutine:
    """A behaviour or monitor, which code may name before it is written: its main block and its first row."""

    block: int
    entry: Target


@frozen
class Coroutines:
    """All of a variant."""

    actors: Sequence[Coroutine | None]
    """None for an actor without behaviour."""
    monitors: Sequence[Coroutine]
    callers: dict[int, int] = field(default_factory=dict)
    """Block that advances each monitor, once that block has been written."""


@dataclass
class BehaviourWriter:
    """Writes one behaviour or monitor. The stacks mirror the nesting of the acts being written."""

    buffer: CodeBuffer
    expressions: ExpressionWriter
    coroutines: Coroutines
    blocks: Numbers
    locals: Numbers
    block: int
    """Block that is being written."""
    caller: int = -1
    """Block that continues after this coroutine's turn; -1: none, which ends the turn of all."""
    loops: list[LoopTargets] = field(default_factory=list)
    tries: list[Target] = field(default_factory=list)
    scopes: dict[int, Target] = field(default_factory=dict)
    invariants: Sequence[tuple[ir.Expr, int]] = ()
    """Invariants of the scope whose code is being written."""

    def write(self, acts: ir.Block) -> None:
        for act in acts:
            self.buffer.offset = act.span.start
            self._act(act)

    def _act(self, act: ir.Act) -> None:
        match act:
            case ir.SetLocal(index=index, value=value):
                self.expressions.branch().into(LocalRegister(index), value)
            case ir.Take(commands=commands):
                self._take(commands)
            case ir.Wait():
                self._yield()
            case ir.Follow():
                self._follow(act)
            case ir.HoldSpeed():
                self._hold_speed(act.target_speed)
            case ir.Replay():
                self._replay(act)
            case ir.Branch():
                self._branch(act)
            case ir.Loop():
                self._loop(act)
            case ir.Leave(kind=kind, scope=scope):
                self._leave(kind, scope)
            case ir.Scope():
                self._scope(act)
            case ir.TryInterrupt():
                self._try(act)
            case ir.Abort():
                self.buffer.emit(Op.JUMP, None, self.tries[-1])
            case ir.Terminate(rule=rule):
                self.buffer.emit(Op.TERMINATE, None, rule)
            case ir.Demand(condition=condition, rule=rule):
                self._demand(condition, rule)
            case ir.Pick():
                self._pick(act)
            case ir.Start(monitor=monitor):
                self._start(self.coroutines.monitors[monitor])
            case ir.Advance(monitor=monitor):
                self._advance(monitor)
            case ir.Stop(monitors=monitors, actors=actors):
                self._stop(monitors, actors)
            case ir.Spawn(actors=actors):
                self._spawn(actors)
            case ir.Enter(actor=actor, start=start):
                self._enter(actor, start)
            case _:
                raise AssertionError(f"no code for {type(act).__name__}")

    def _take(self, commands: tuple[tuple[int, ir.Expr], ...]) -> None:
        writer = self.expressions.branch()
        registers = [writer.register(value) for _, value in commands]
        for (command, _), register in zip(commands, registers, strict=True):
            self.buffer.emit(Op.COMMAND, None, int(command), register)
        self._yield()

    def _follow(self, act: ir.Follow) -> None:
        again, done, progress = Target(), Target(), LocalRegister(act.progress)
        self.buffer.emit(Op.MOVE, progress, self.expressions.constants.add(-1.0))
        self.buffer.place(again)
        writer = self.expressions.branch()
        if act.aside is not None:  # before the target speed, which may depend on the actor ahead at that offset
            self.buffer.emit(Op.COMMAND, None, int(Command.ASIDE), writer.register(act.aside))
        path, speed, lateral = (writer.register(e) for e in (act.path, act.target_speed, act.max_lateral))
        if act.offset is not None:
            self.buffer.emit(Op.COMMAND, None, int(Command.OFFSET), writer.register(act.offset))
        self.buffer.emit(Op.FOLLOW, progress, path, speed, lateral, done)
        self._turn_then(again)
        self.buffer.place(done)

    def _hold_speed(self, target_speed: ir.Expr) -> None:
        self.buffer.place(again := Target())
        self.buffer.emit(Op.HOLD_SPEED, None, self.expressions.branch().register(target_speed))
        self._turn_then(again)

    def _replay(self, act: ir.Replay) -> None:
        again, done, clock = Target(), Target(), LocalRegister(act.clock)
        self.buffer.emit(Op.MOVE, clock, self.expressions.constants.add(0.0))
        self.buffer.place(again)
        self.buffer.emit(Op.REPLAY, clock, act.track, self.expressions.branch().register(act.pace), done)
        self._turn_then(again)
        self.buffer.place(done)

    def _turn_then(self, target: Target) -> None:
        self._yield()
        self.buffer.emit(Op.JUMP, None, target)

    def _yield(self) -> None:
        """End the turn; invariants are tested when the scope itself continues."""
        if self.caller < 0:
            self.buffer.emit(Op.YIELD, None, self.block)
        else:
            self._return_at(again := Target())
            self.buffer.place(again)
        self._test_invariants()

    def _return_at(self, again: Target | int) -> None:
        """Continue the caller; in its next turn this block continues at a row of its own, or (-1) never."""
        self.buffer.emit(Op.SET_RESUME, None, self.block, again)
        self.buffer.emit(Op.RESUME, None, self.caller)

    def write_coroutine(self, body: ir.Block) -> None:
        """All of it; `HALT` is the last row of each, reached or not, so that listings see where it ends."""
        self.write(body)
        if self.caller >= 0:
            self._return_at(-1)
        self.buffer.emit(Op.HALT)

    def _test_invariants(self) -> None:
        for condition, rule in self.invariants:
            self._demand(condition, rule)

    def _demand(self, condition: ir.Expr, rule: int) -> None:
        broken, holds = Target(), Target()
        self._unless(condition, broken)
        self.buffer.emit(Op.JUMP, None, holds)
        self.buffer.place(broken)
        self.buffer.emit(Op.TERMINATE, None, rule)
        self.buffer.place(holds)

    def _unless(self, condition: ir.Expr, target: Target) -> None:
        self.buffer.emit(Op.JUMP_UNLESS, None, self.expressions.branch().register(condition), target)

    def _branch(self, act: ir.Branch) -> None:
        otherwise, end = Target(), Target()
        self._unless(act.condition, otherwise)
        self.write(act.then)
        self.buffer.emit(Op.JUMP, None, end)
        self.buffer.place(otherwise)
        self.write(act.otherwise)
        self.buffer.place(end)

    def _loop(self, act: ir.Loop) -> None:
        targets = LoopTargets(Target(), Target())
        self.buffer.place(targets.top)
        self._unless(act.condition, targets.end)
        self.loops.append(targets)
        self.write(act.body)
        self.loops.pop()
        self.buffer.emit(Op.JUMP, None, targets.top)
        self.buffer.place(targets.end)

    def _leave(self, kind: str, scope: int) -> None:
        targets = {
            "break": lambda: self.loops[-1].end,
            "continue": lambda: self.loops[-1].top,
            "return": lambda: self.scopes[scope],
        }
        self.buffer.emit(Op.JUMP, None, targets[kind]())

    def _scope(self, act: ir.Scope) -> None:
        self.scopes[act.scope] = Target()
        around, self.invariants = self.invariants, act.invariants
        self._test_invariants()
        self.write(act.body)
        self.buffer.place(self.scopes[act.scope])
        self.invariants = around
        self._test_invariants()

    def _pick(self, act: ir.Pick) -> None:
        picker = Picker(self.buffer, self.expressions, self.write)
        if act.shuffle:
            picker.shuffle(act, [LocalRegister(self.locals.new()) for _ in act.options])
        else:
            picker.choose(act)

    def _start(self, coroutine: Coroutine) -> None:
        self.buffer.emit(Op.SET_RESUME, None, coroutine.block, coroutine.entry)

    def _advance(self, monitor: int) -> None:
        """The turn of another coroutine, which comes back to this block when it is over."""
        coroutine, enter, after = self.coroutines.monitors[monitor], Target(), Target()
        self.coroutines.callers[monitor] = self.block
        self.buffer.emit(Op.JUMP_IF_RUNNING, None, coroutine.block, enter)
        self.buffer.emit(Op.JUMP, None, after)
        self.buffer.place(enter)
        self.buffer.emit(Op.SET_RESUME, None, self.block, after)
        self.buffer.emit(Op.RESUME, None, coroutine.block)
        self.buffer.place(after)

    def _stop(self, monitors: Sequence[int], actors: Sequence[int]) -> None:
        stopped = [*(self.coroutines.monitors[m] for m in monitors), *(self.coroutines.actors[a] for a in actors)]
        for coroutine in filter(None, stopped):
            self.buffer.emit(Op.SET_RESUME, None, coroutine.block, -1)

    def _spawn(self, actors: Sequence[int]) -> None:
        """An actor that comes in again, in a scenario that is run again, begins its behaviour again."""
        for actor in actors:
            if (behaviour := self.coroutines.actors[actor]) is not None:
                self._start(behaviour)
            self.buffer.emit(Op.SPAWN, None, actor)

    def _enter(self, actor: int, start: Sequence[ir.Expr]) -> None:
        """Write the start of an actor where its scene would have it, and spawn it."""
        writer = self.expressions.branch()
        registers = [writer.register(value) for value in start]
        for column, register in zip((Column.X, Column.Y, Column.HEADING, Column.SPEED), registers, strict=True):
            self.buffer.emit(Op.MOVE, SceneValue(actor * len(Column) + column), register)
        self._spawn((actor,))

    def _try(self, act: ir.TryInterrupt) -> None:
        body_block, body_start = self.blocks.new(), Target()
        handlers = [(self.blocks.new(), Target(), condition, acts) for condition, acts in act.handlers]
        dispatch, end = Target(), Target()

        self.buffer.emit(Op.SET_RESUME, None, body_block, body_start)
        for block, *_ in handlers:
            self.buffer.emit(Op.SET_RESUME, None, block, -1)
        self.buffer.place(dispatch)
        self.buffer.emit(Op.SET_RESUME, None, self.block, dispatch)
        for block, start, condition, _ in reversed(handlers):
            self._dispatch_to(block, start, condition)
        self.buffer.emit(Op.RESUME, None, body_block)

        self.tries.append(end)
        self.buffer.place(body_start)
        self._write_in(body_block, act.body)
        self.buffer.emit(Op.JUMP, None, end)
        for block, start, _, acts in handlers:
            self.buffer.place(start)
            self._write_in(block, acts)
            self.buffer.emit(Op.SET_RESUME, None, block, -1)
            self.buffer.emit(Op.JUMP, None, dispatch)
        self.tries.pop()
        self.buffer.place(end)

    def _dispatch_to(self, block: int, start: Target, condition: ir.Expr) -> None:
        enter, skip = Target(), Target()
        self.buffer.emit(Op.JUMP_IF_RUNNING, None, block, enter)
        self._unless(condition, skip)
        self.buffer.emit(Op.SET_RESUME, None, block, start)
        self.buffer.place(enter)
        self.buffer.emit(Op.RESUME, None, block)
        self.buffer.place(skip)

    def _write_in(self, block: int, acts: ir.Block) -> None:
        parent, self.block = self.block, block
        self.write(acts)
        self.block = parent


# -- `do choose` and `do shuffle` --------------------------------------------------------------------------------------


@frozen
class Picker:
    """Writes one `Pick`; `write` writes the body of an option."""

    buffer: CodeBuffer
    expressions: ExpressionWriter
    write: Callable[[ir.Block], None]

    def choose(self, act: ir.Pick) -> None:
        """One option."""
        end = Target()
        for option, start in zip(act.options, self._draw(act, ()), strict=True):
            self.buffer.place(start)
            self.write(option.body)
            self.buffer.emit(Op.JUMP, None, end)
        self.buffer.place(end)

    def shuffle(self, act: ir.Pick, left: Sequence[LocalRegister]) -> None:
        """Write all options, one after another. `left` stores, in a local each, which options remain."""
        top, end = Target(), Target()
        for flag in left:
            self.buffer.emit(Op.MOVE, flag, self.expressions.constants.add(1.0))
        self.buffer.place(top)
        self.buffer.emit(Op.JUMP_UNLESS, None, self._any(left), end)
        for option, flag, start in zip(act.options, left, self._draw(act, left), strict=True):
            self.buffer.place(start)
            self.buffer.emit(Op.MOVE, flag, self.expressions.constants.add(0.0))
            self.write(option.body)
            self.buffer.emit(Op.JUMP, None, top)
        self.buffer.place(end)

    def _draw(self, act: ir.Pick, left: Sequence[Register]) -> list[Target]:
        """Write code that continues at the target of one option; the caller places the targets."""
        ends = self._shares(act.options, left)
        nothing, starts = Target(), [Target() for _ in ends]
        zero, drawn = self.expressions.constants.add(0.0), self.buffer.temporary()
        self.buffer.emit(Op.JUMP_UNLESS, None, self._new(Op.LT, zero, ends[-1]), nothing)
        self.buffer.emit(Op.RANDOM, drawn)
        self.buffer.emit(Op.MUL, drawn, drawn, ends[-1])
        for end, start in zip(ends, starts, strict=True):
            following = Target()
            self.buffer.emit(Op.JUMP_UNLESS, None, self._new(Op.LT, drawn, end), following)
            self.buffer.emit(Op.JUMP, None, start)
            self.buffer.place(following)
        self.buffer.place(nothing)
        self.buffer.emit(Op.TERMINATE, None, act.rule)
        return starts

    def _shares(self, options: Sequence[ir.Option], left: Sequence[Register]) -> list[Register]:
        """Return the cumulative end of each option's share."""
        writer, ends = self.expressions.branch(), []
        zero = self.expressions.constants.add(0.0)
        end: Register = zero
        for number, option in enumerate(options):
            allowed, weight = writer.register(option.allowed), writer.register(option.weight)
            if left:
                allowed = self._new(Op.AND, allowed, left[number])
            end = self._new(Op.ADD, end, self._new(Op.SELECT, allowed, weight, zero))
            ends.append(end)
        return ends

    def _any(self, flags: Sequence[Register]) -> Register:
        result = flags[0]
        for flag in flags[1:]:
            result = self._new(Op.OR, result, flag)
        return result

    def _new(self, op: Op, *operands: Register) -> Register:
        destination = self.buffer.temporary()
        self.buffer.emit(op, destination, *operands)
        return destination
