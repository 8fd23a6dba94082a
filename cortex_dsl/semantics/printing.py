"""A readable print of the checked IR, for `--emit ir`."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.bounds import operands
from engine.opcodes import Op
from engine.operators import OPERATORS, Infix
from engine.vocabulary import Column, Distribution, GeneKind, RuleKind, State, TemporalOp

# -- expressions and acts ----------------------------------------------------------------------------------------------

INFIX = {op: row.spelling.sign for op, row in OPERATORS.items() if isinstance(row.spelling, Infix)}
INDENT = "  "


@dataclass
class Printer:
    """Writes expressions; those with several users are written once, under a name."""

    uses: Counter[ir.Expr]
    names: dict[ir.Expr, str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, roots: Iterable[ir.Expr]) -> "Printer":
        uses: Counter[ir.Expr] = Counter()
        for root in roots:
            _count(root, uses)
        return cls(uses)

    def definitions(self) -> list[str]:
        return [f"{INDENT}{line}" for line in self.lines]

    def text(self, expression: ir.Expr) -> str:
        if self.uses[expression] < 2 or not operands(expression):
            return self._written(expression)
        if expression not in self.names:
            text = self._written(expression)
            self.names[expression] = f"e{len(self.names)}"
            self.lines.append(f"{self.names[expression]} = {text}")
        return self.names[expression]

    def _written(self, expression: ir.Expr) -> str:
        match expression:
            case ir.Literal(value=value):
                return repr(value)
            case ir.Gene(index=index):
                return f"gene{index}"
            case ir.Draw(index=index):
                return f"draw{index}"
            case ir.Local(index=index):
                return f"local{index}"
            case ir.Running(monitor=monitor):
                return f"running({monitor})"
            case ir.Item(bundle=bundle, index=index):
                return f"{self.text(bundle)}.{index}"
            case ir.Pack(items=items):
                return f"({', '.join(self.text(item) for item in items)})"
            case ir.Apply():
                return self._applied(expression)
        raise AssertionError(f"no text for {type(expression).__name__}")

    def _applied(self, expression: ir.Apply) -> str:
        arguments = [self.text(argument) for argument in expression.arguments]
        if expression.op in INFIX:
            return f"({arguments[0]} {INFIX[expression.op]} {arguments[1]})"
        if expression.op == Op.STATE:
            actor, column = expression.immediates
            return f"actor{actor}.{State(column).name.lower()}"
        return f"{expression.op.name.lower()}({', '.join([*map(str, expression.immediates), *arguments])})"

    def block(self, block: ir.Block) -> Iterator[str]:
        for act in block:
            yield from self._act(act)
        if not block:
            yield "(nothing)"

    def _inner(self, block: ir.Block) -> Iterator[str]:
        return (INDENT + line for line in self.block(block))

    def _act(self, act: ir.Act) -> Iterator[str]:
        match act:
            case ir.SetLocal(index=index, value=value):
                yield f"local{index} <- {self.text(value)}"
            case ir.Take(commands=commands):
                yield "take " + ", ".join(f"{c.name.lower()} {self.text(value)}" for c, value in commands)
            case ir.Follow():
                speed, lateral = self.text(act.target_speed), self.text(act.max_lateral)
                beside = "" if act.aside is None else f", aside {self.text(act.aside)}"
                yield (
                    f"follow path {self.text(act.path)} at {speed}, lateral {lateral}, progress local{act.progress}"
                    f"{beside}"
                )
            case ir.HoldSpeed(target_speed=speed):
                yield f"hold speed {self.text(speed)}"
            case ir.Replay(track=track, pace=pace, clock=clock):
                yield f"replay track {track} at pace {self.text(pace)}, clock local{clock}"
            case ir.Branch(condition=condition, then=then, otherwise=otherwise):
                yield f"if {self.text(condition)}"
                yield from self._inner(then)
                yield "else"
                yield from self._inner(otherwise)
            case ir.Loop(condition=condition, body=body):
                yield f"while {self.text(condition)}"
                yield from self._inner(body)
            case ir.Scope(name=name, scope=scope, body=body, invariants=invariants):
                yield f"scope {scope} {name}"
                yield from (f"{INDENT}invariant {self.text(c)}, else rule {rule}" for c, rule in invariants)
                yield from self._inner(body)
            case ir.Demand(condition=condition, rule=rule):
                yield f"demand {self.text(condition)}, else rule {rule}"
            case ir.Pick():
                yield from self._pick(act)
            case ir.Start(monitor=monitor):
                yield f"start monitor {monitor}"
            case ir.Advance(monitor=monitor):
                yield f"advance monitor {monitor}"
            case ir.Stop(monitors=monitors, actors=actors):
                yield "stop " + ", ".join([*(f"monitor {m}" for m in monitors), *(f"actor {a}" for a in actors)])
            case ir.Spawn(actors=actors):
                yield "spawn " + ", ".join(f"actor {actor}" for actor in actors)
            case ir.Enter(actor=actor, start=start):
                yield f"enter actor {actor} at " + ", ".join(map(self.text, start))
            case ir.TryInterrupt(body=body, handlers=handlers):
                yield "try"
                yield from self._inner(body)
                for condition, handler in handlers:
                    yield f"interrupt when {self.text(condition)}"
                    yield from self._inner(handler)
            case ir.Leave(kind=kind, scope=scope):
                yield f"{kind} (scope {scope})"
            case ir.Terminate(rule=rule):
                yield f"terminate by rule {rule}"
            case _:
                yield type(act).__name__.lower()

    def _pick(self, act: ir.Pick) -> Iterator[str]:
        yield f"{'shuffle' if act.shuffle else 'choose'}, else rule {act.rule}"
        for option in act.options:
            yield f"{INDENT}option {self.text(option.weight)} if {self.text(option.allowed)}"
            yield from (INDENT + line for line in self._inner(option.body))


def expressions_of(code: object) -> Iterator[ir.Expr]:
    """Expressions of a block, an act or whatever acts consist of, nested ones included."""
    if isinstance(code, ir.Expr):
        yield code
    elif isinstance(code, ir.Act | ir.Option):
        yield from expressions_of(tuple(vars(code).values()))
    elif isinstance(code, tuple):
        for item in code:
            yield from expressions_of(item)


def _count(expression: ir.Expr, uses: Counter[ir.Expr]) -> None:
    uses[expression] += 1
    if uses[expression] == 1:
        for operand in operands(expression):
            _count(operand, uses)


# -- scenarios ---------------------------------------------------------------------------------------------------------

RULES = {RuleKind.TERMINATE: "end when", RuleKind.ABORT: "abort when", RuleKind.WATCH: "watch"}


def format_ir(scenario: ir.Scenario) -> str:
    """The whole scenario; variants in full, expressions that are used twice with a name."""
    return "\n".join(
        [*_head(scenario), *(line for i, v in enumerate(scenario.variants) for line in _variant(i, v, scenario))]
    )


def _head(scenario: ir.Scenario) -> Iterator[str]:
    yield f"scenario {scenario.name}"
    if scenario.description:
        yield f"{INDENT}{scenario.description.splitlines()[0]}"
    limit = getattr(scenario.road, "speed_limit", None)
    yield f"road {scenario.road}" + (f", speed limit {limit:g} m/s" if limit else "")
    settings = ", ".join(f"{name}={value!r}" for name, value in scenario.settings.deciding().items())
    yield f"settings Settings({settings})"
    for i, gene in enumerate(scenario.genes):
        yield f"gene {i} {_gene(gene)}"
    if scenario.pool:
        yield f"pool {' '.join(f'{value:g}' for value in scenario.pool)}"
    for temporal in scenario.temporals:
        yield f"require {_formula(temporal.formula)}, else rule {temporal.rule}"
    for record in scenario.records:
        yield f"record {record.when} {record.name}: rule {record.watch}"
    for number, reading in enumerate(scenario.readings):
        yield f"reading {number}: {reading.kind.name.lower()} {reading.result or f'rule {reading.rule}'}"
    for objective in scenario.objectives:
        formula = "" if objective.formula is None else f": {_formula(objective.formula)}"
        yield f"{objective.sense.name.lower()} {objective.name!r}{formula}"


def _formula(formula: ir.Formula) -> str:
    """In words; an operand that is no atom in parentheses."""
    if formula.op == TemporalOp.ATOM:
        return f"rule{formula.watch}" if formula.margin < 0 else f"rule{formula.watch}/{formula.margin}"
    texts = [_formula(operand) for operand in formula.operands]
    first, *second = [f"({text})" if " " in text else text for text in texts]
    word = formula.op.name.lower()
    return f"{first} {word} {second[0]}" if second else f"{word} {first}"


def _gene(gene: ir.GeneInfo) -> str:
    distribution = Distribution(gene.distribution).name.lower()
    if gene.kind == GeneKind.INDEX:
        return f"{gene.name}: {distribution} over {', '.join(gene.options)}"
    shape = f", mean {gene.mean:g}, deviation {gene.deviation:g}" if gene.deviation else ""
    kind = GeneKind(gene.kind).name.lower()
    return f"{gene.name}: {kind} {distribution} {gene.low:g} .. {gene.high:g} {gene.unit}".rstrip() + shape


def _variant(number: int, variant: ir.Variant, scenario: ir.Scenario) -> Iterator[str]:
    yield ""
    yield f"variant {number}  probability {variant.probability:.6g}"
    for choice in variant.choices:
        yield f"{INDENT}choice {choice.name} = {choice.option}"
    for gene, option in variant.gene_options:
        yield f"{INDENT}gene {scenario.genes[gene].name} = option {option}"
    if variant.rejection is not None:
        yield f"{INDENT}rejected: {variant.rejection} (line {variant.rejection_line})"
        return
    printer = Printer.of(_roots(variant))
    body = list(_body(variant, printer, scenario))
    yield from printer.definitions()
    yield from body


def _body(variant: ir.Variant, printer: Printer, scenario: ir.Scenario) -> Iterator[str]:
    for requirement in variant.requirements:
        soft = "" if requirement.probability == 1.0 else f"[{requirement.probability:g}]"
        yield f"{INDENT}require{soft} {printer.text(requirement.condition)}  as {requirement.name!r}"
    for i, rule in enumerate(variant.rules):
        condition = "code says so" if rule.condition is None else printer.text(rule.condition)
        yield f"{INDENT}rule {i}: {RULES[rule.kind]} {condition}  (line {rule.line})"
    for objective, value in zip(scenario.objectives, variant.objectives, strict=True):
        if value is not None:
            yield f"{INDENT}{objective.sense.name.lower()} {printer.text(value)}  as {objective.name!r}"
    for i, monitor in enumerate(variant.monitors):
        yield f"{INDENT}monitor {i} {monitor.name}{monitor.turns.words}"
        yield from (INDENT * 2 + line for line in printer.block(monitor.body))
    for i, actor in enumerate(variant.actors):
        absent = "" if actor.present else ", absent at the start"
        yield f"{INDENT}actor {i} {actor.name}: {actor.kind.name.lower()}{absent}"
        for column, value in zip(Column, actor.columns, strict=True):
            yield f"{INDENT * 2}{column.name.lower()} = {printer.text(value)}"
        if actor.behaviour is not None:
            yield f"{INDENT * 2}behaviour"
            yield from (INDENT * 3 + line for line in printer.block(actor.behaviour))
    for site in variant.draw_sites:
        yield f"{INDENT}drawn {site.kind}: {', '.join(printer.text(value) for value in site.values)}"
    if (lights := variant.lights) is not None:
        times = ("green", "yellow", "all_red", "offset")
        yield f"{INDENT}lights {', '.join(f'{time} {printer.text(getattr(lights, time))}' for time in times)}"


def _roots(variant: ir.Variant) -> Iterator[ir.Expr]:
    for actor in variant.actors:
        yield from actor.columns
        yield from expressions_of(actor.behaviour or ())
    for monitor in variant.monitors:
        yield from expressions_of(monitor.body)
    yield from (requirement.condition for requirement in variant.requirements)
    yield from (rule.condition for rule in variant.rules if rule.condition is not None)
    yield from (value for value in variant.objectives if value is not None)
    yield from (value for site in variant.draw_sites for value in site.values)
    if (lights := variant.lights) is not None:
        yield from (lights.green, lights.yellow, lights.all_red, lights.offset)
