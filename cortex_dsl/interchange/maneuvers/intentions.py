"""Acts of a behaviour, as far as speeds, a route and triggers can express them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.interchange.maneuvers.formulas import Case, UnsayableError, formula_of, settled, value_at_start
from cortex_dsl.interchange.maneuvers.triggers import trigger_of
from cortex_dsl.source import Span
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import Change, Reaction, Trigger, all_of, none_of
from engine.interchange.recording import Recording
from engine.kernels.steering import MAX_ACCELERATION
from engine.opcodes import Op
from engine.vocabulary import ActorKind, Column, Command, State

LEAST_RATE = 0.0001
"""Offset of braking rates [m/s^2]: readers reject a rate of 0, that of a pedal which is not pressed."""


@dataclass(frozen=True)
class Drive:
    """Speeds and route of an actor, without its start."""

    target: Formula
    """Speed it goes for [m/s]."""
    rate: Formula
    """Acceleration with which it does so [m/s^2]."""
    path: int | None = None
    """Path that it follows; None for an actor that only maintains a speed."""
    lateral: float = math.inf
    """Lateral acceleration that it accepts in bends [m/s^2]."""
    reactions: tuple[Reaction, ...] = ()
    """Reactions in order of precedence; their triggers are exclusive."""
    ends: tuple[tuple[Trigger, int], ...] = ()
    """When it ends the run, and by which rule."""


@dataclass
class Reader:
    """Reads the behaviour of one actor; `remarks` lists the omitted parts."""

    case: Case
    names: tuple[str, ...]
    actor: int
    remarks: list[str] = field(default_factory=list)

    @property
    def kind(self) -> ActorKind:
        return self.case.actors[self.actor].kind

    def drive(self) -> Drive:
        """Return the whole drive of the actor.

        Raises:
            UnsayableError: only its trajectory describes the motion of the actor.
        """
        block = self.case.actors[self.actor].behaviour
        if self.kind == ActorKind.OBSTACLE:
            return Drive(formula.ZERO, self._acceleration())
        if self.kind == ActorKind.PEDESTRIAN:
            raise UnsayableError("the path of a pedestrian, who follows no lane", self.case.actors[self.actor].span)
        return self._coasting() if not block else self._block(block)

    def _coasting(self) -> Drive:
        speed = settled(self.case, self.case.actors[self.actor].columns[Column.SPEED])
        return Drive(speed, self._acceleration())

    def _block(self, block: ir.Block) -> Drive:
        main = [act for act in self._opened(block) if not self._is_demand(act)]
        while main and isinstance(main[0], ir.SetLocal):
            self._remember(main.pop(0), main)
        if not main:
            return self._coasting()
        if len(main) > 1:
            raise UnsayableError(f"what it does after {_name(main[0])}", main[1].span)
        return self._main(main[0])

    def _remember(self, act: ir.Act, later: Sequence[ir.Act]) -> None:
        """A number that is settled before anything is done, and never again."""
        assert isinstance(act, ir.SetLocal)
        if act.index in {index for each in later for index in _set_by(each)}:
            raise UnsayableError("a number that changes while it drives", act.span)
        try:
            value = formula_of(self.case, act.value)
        except UnsayableError:
            value = formula.number(self._at_start(act))
        self.case = replace(self.case, remembered={**self.case.remembered, act.index: value})

    def _at_start(self, act: ir.SetLocal) -> float:
        try:
            return value_at_start(self.case, act.value)
        except UnsayableError as error:
            raise UnsayableError(error.what, act.span) from error

    def _opened(self, block: ir.Block) -> Iterator[ir.Act]:
        """Acts of a block, those of inlined behaviours among them."""
        for act in block:
            if not isinstance(act, ir.Scope):
                yield act
                continue
            for _ in act.invariants:
                self._leave_out(f"an invariant of {act.name}", act.span)
            yield from self._opened(act.body)

    def _is_demand(self, act: ir.Act) -> bool:
        if isinstance(act, ir.Demand):
            self._leave_out("a `require` or precondition in a behavior", act.span)
        return isinstance(act, ir.Demand)

    def _main(self, act: ir.Act) -> Drive:
        if isinstance(act, ir.Follow):
            return self._following(act)
        if isinstance(act, ir.HoldSpeed):
            return Drive(self._number(act.target_speed, act, "a speed"), self._acceleration())
        if isinstance(act, ir.TryInterrupt):
            return self._interrupted(act)
        if isinstance(act, ir.Loop) and _is_true(act.condition) and len(act.body) == 1:
            if isinstance(act.body[0], ir.Wait):
                return self._coasting()
            if isinstance(act.body[0], ir.Take):
                change = self._taken(act.body[0])
                return Drive(change.speed, change.rate)
        raise UnsayableError(_name(act), act.span)

    def _following(self, act: ir.Follow) -> Drive:
        if act.aside is not None:
            raise UnsayableError("an offset from the lane", act.span)
        path, lateral = (
            self._number(act.path, act, "a way"),
            self._number(act.max_lateral, act, "a lateral acceleration"),
        )
        if not path.plain:
            raise UnsayableError("a way that depends on a param", act.span)
        if not lateral.plain:
            self._leave_out("a lateral acceleration that depends on a param: it is as in this case", act.span)
        most = lateral.value(dict(zip(self.case.names, self.case.scenes.genomes[self.case.row], strict=True)))
        target = self._number(act.target_speed, act, "a target speed")
        return Drive(target, self._acceleration(), int(path.number), most)

    def _number(self, expression: ir.Expr, act: ir.Act, what: str) -> Formula:
        try:
            return settled(self.case, expression)
        except UnsayableError as error:
            raise UnsayableError(f"{what} that depends on {error.what}", act.span) from error

    # -- interrupts ---------------------------------------------------------------------------------------------------

    def _interrupted(self, act: ir.TryInterrupt) -> Drive:
        """Return the drive of the body, with later handlers before earlier ones."""
        drive = self._block(act.body)
        reactions, ends = [], []
        for condition, acts in reversed(act.handlers):
            try:
                trigger, what = trigger_of(self.case, self.names, condition), self._handled(acts)
            except UnsayableError as error:
                self._leave_out(f"`interrupt` with {error.what}", condition.span if condition.span.end else act.span)
                continue
            self._note_senses(condition)
            if isinstance(what, int):
                ends.append((_unless(trigger, reactions), what))
            else:
                reactions.append(Reaction(f"brakes_{len(reactions) + 1}", _unless(trigger, reactions), what))
        inner = tuple(replace(each, when=_unless(each.when, reactions)) for each in drive.reactions)
        inner_ends = tuple((_unless(trigger, reactions), rule) for trigger, rule in drive.ends)
        return replace(drive, reactions=_numbered((*reactions, *inner)), ends=(*ends, *inner_ends))

    def _handled(self, block: ir.Block) -> Change | int:
        """Return the act of a handler: a change of speed while its condition holds, or the rule that ends the run."""
        acts = list(self._opened(block))
        first = acts[0] if acts else None
        if isinstance(first, ir.Terminate):
            return first.rule
        if len(acts) == 1 and isinstance(first, ir.Take):
            return self._taken(first)
        raise UnsayableError("; ".join(dict.fromkeys(map(_name, acts))) or "nothing to do", block[0].span)

    def _taken(self, act: ir.Take) -> Change:
        commands = dict(act.commands)
        if set(commands) not in ({Command.BRAKE}, {Command.STOP}):
            names = ", ".join(sorted(command.name.lower() for command in commands))
            raise UnsayableError(f"an action other than a brake ({names})", act.span)
        (command,) = commands.values()
        pedal = self._number(command, act, "a pedal")
        most = formula_of(self.case, self.case.actors[self.actor].columns[Column.MAX_BRAKING])
        return Change(formula.ZERO, formula.add(formula.multiply(pedal, most), formula.number(LEAST_RATE)))

    # -- remarks ------------------------------------------------------------------------------------------------------

    def _note_senses(self, condition: ir.Expr) -> None:
        name = self.names[self.actor]
        if _mentions(condition, Op.WITHIN):
            self.remarks.append(f"`{name}` notices others within a distance all around, not in its view sector only")
        if _mentions(condition, Op.NOTICES) and self.case.may_hide:
            self.remarks.append(f"`{name}` also notices others that are hidden")
        if _mentions(condition, Op.TTC):
            self.remarks.append(f"`{name}` reacts to times to collision as the reader defines them")

    def _leave_out(self, what: str, span: Span) -> None:
        self.remarks.append(f"left out of `{self.names[self.actor]}`: {what} ({self.case.place(span)})")

    def _acceleration(self) -> Formula:
        most = self.case.column(self.actor, Column.MAX_ACCELERATION)
        return formula.number(max(min(most, MAX_ACCELERATION), LEAST_RATE))


def _set_by(act: ir.Act) -> Iterator[int]:
    """Locals that an act sets, or acts inside it."""
    if isinstance(act, ir.SetLocal):
        yield act.index
    for block in _inside(act):
        for each in block:
            yield from _set_by(each)


def _inside(act: ir.Act) -> tuple[ir.Block, ...]:
    if isinstance(act, ir.TryInterrupt):
        return (act.body, *(block for _, block in act.handlers))
    if isinstance(act, ir.Branch):
        return (act.then, act.otherwise)
    if isinstance(act, ir.Pick):
        return tuple(option.body for option in act.options)
    return (act.body,) if isinstance(act, ir.Loop | ir.Scope) else ()


def _unless(trigger: Trigger, reactions: list[Reaction]) -> Trigger:
    """A trigger, where none of those before it holds."""
    return all_of([trigger, *(none_of(each.when) for each in reactions)])


def _numbered(reactions: tuple[Reaction, ...]) -> tuple[Reaction, ...]:
    return tuple(replace(each, name=f"brakes_{i}") for i, each in enumerate(reactions, 1))


def _is_true(condition: ir.Expr) -> bool:
    return isinstance(condition, ir.Literal) and bool(condition.value)


def _mentions(expression: ir.Expr, op: Op) -> bool:
    if not isinstance(expression, ir.Apply):
        return False
    return expression.op == op or any(_mentions(argument, op) for argument in expression.arguments)


NAMES: dict[type[ir.Act], str] = {
    ir.SetLocal: "a number that it remembers",
    ir.Take: "an action of its own",
    ir.Wait: "`wait`",
    ir.Follow: "following a path",
    ir.HoldSpeed: "holding a speed",
    ir.Replay: "a recorded track",
    ir.Branch: "`if`",
    ir.Loop: "a loop",
    ir.Leave: "`break`, `continue` or `return`",
    ir.Demand: "`require`",
    ir.Pick: "`do choose` or `do shuffle`",
    ir.Start: "starting a monitor",
    ir.Advance: "what a scenario does",
    ir.Stop: "stopping a scenario",
    ir.Spawn: "letting others in",
    ir.Enter: "letting others in",
    ir.TryInterrupt: "`try`",
    ir.Abort: "the end of a `try`, or of what a `do` does until or for a while",
    ir.Terminate: "`terminate`",
}


def _name(act: ir.Act) -> str:
    return NAMES.get(type(act), "an act")


# -- facts that only a run shows ---------------------------------------------------------------------------------------

WIDE = 0.5
"""Largest distance from the middle of its lanes at which an actor keeps to them [m]."""


def refuse_wide(case: Case, actor: int, drive: Drive, run: Recording | None) -> None:
    """Raises UnsayableError where an actor is too fast for a bend: players keep it on its lane, whatever its speed."""
    if drive.path is None or run is None:
        return
    paths, path = case.whole.network.paths, drive.path
    scored = run.there[: run.scored_samples(), actor]
    wide = 0.0
    for x, y in run.states[: len(scored)][scored, actor, State.X : State.Y + 1].tolist():
        foot = paths.pose(path, paths.project(path, x, y))
        wide = max(wide, abs((y - foot.y) * math.cos(foot.heading) - (x - foot.x) * math.sin(foot.heading)))
    if wide > WIDE:
        raise UnsayableError(f"that it runs {wide:.1f} m wide of its lanes", case.actors[actor].span)
