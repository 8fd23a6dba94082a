"""One variant to symbolic code: requirements and outputs of its scenes, rules and behaviours of its runs."""

from dataclasses import dataclass, field

from cortex_dsl import ir
from cortex_dsl.lowering.behaviours import BehaviourWriter, BlockNumbers
from cortex_dsl.lowering.expressions import Dynamics, ExpressionWriter
from cortex_dsl.lowering.operands import CodeBuffer, Constants, Register, Row, SceneValue
from engine.vocabulary import Column, Op


@dataclass(frozen=True)
class Segment:
    """Rows `start:end` of a buffer and the register of their result."""

    start: int
    end: int
    result: Register | None


@dataclass(frozen=True)
class VariantCode:
    """A variant's code with symbolic operands."""

    constants: tuple[float, ...] = field(compare=False)
    """Values of the constants; left out of equality, so that variants with equal code share a template."""
    step_offsets: tuple[int, ...] = field(compare=False)
    scene_rows: tuple[Row, ...]
    scene_temporaries: int
    requirements: tuple[Segment, ...]
    output: Segment
    outputs: tuple[Register, ...]
    site_values: tuple[tuple[int, ...], ...]
    """Scene values of each draw site."""
    step_rows: tuple[Row, ...]
    step_temporaries: int
    rules: tuple[Segment, ...]
    entries: tuple[int, ...]
    main_blocks: tuple[int, ...]
    blocks: int


@dataclass
class SceneValues:
    """The values a scene hands to its run: actor columns, then whatever step code or a concrete copy asks for."""

    expressions: list[ir.Expr]
    numbers: dict[int, int] = field(init=False)
    """By the identity of the expression; a value that is an actor's column too is kept once."""
    dynamics: Dynamics = field(default_factory=Dynamics)

    def __post_init__(self) -> None:
        self.numbers = {id(expression): number for number, expression in enumerate(self.expressions)}

    def number(self, expression: ir.Expr) -> int:
        """Index of the scene value that holds this expression."""
        if (key := id(expression)) not in self.numbers:
            self.numbers[key] = len(self.expressions)
            self.expressions.append(expression)
        return self.numbers[key]

    def hoist(self, expression: ir.Expr) -> Register | None:
        """Step code reads what is settled with the scene instead of computing it again."""
        if isinstance(expression, ir.Pack) or self.dynamics.is_dynamic(expression):
            return None
        if isinstance(expression, ir.Apply) and expression.width > 1:
            return None
        return SceneValue(self.number(expression))


def lower_variant(variant: ir.Variant) -> VariantCode:
    constants = Constants()
    values = SceneValues([column for actor in variant.actors for column in actor.columns])
    assert len(values.expressions) == len(variant.actors) * len(Column)

    step = CodeBuffer()
    writer = ExpressionWriter(step, constants, values.hoist)
    rules = tuple(_rule(step, writer, rule) for rule in variant.rules)
    blocks, entries, main_blocks = BlockNumbers(), [], []
    for actor in variant.actors:
        main_blocks.append(blocks.new())
        entries.append(_behaviour(step, writer, blocks, main_blocks[-1], actor))
    site_values = tuple(tuple(values.number(value) for value in site.values) for site in variant.draw_sites)

    scene = CodeBuffer()
    scene_writer = ExpressionWriter(scene, constants)
    requirements = tuple(_requirement(scene, scene_writer, requirement) for requirement in variant.requirements)
    start = len(scene.rows)
    outputs = tuple(scene_writer.register(expression) for expression in values.expressions)
    scene.emit(Op.END)
    return VariantCode(
        constants=tuple(constants.values),
        scene_rows=scene.resolved(),
        scene_temporaries=scene.temporaries,
        requirements=requirements,
        output=Segment(start, len(scene.rows), None),
        outputs=outputs,
        site_values=site_values,
        step_rows=step.resolved(),
        step_offsets=tuple(step.offsets),
        step_temporaries=step.temporaries,
        rules=rules,
        entries=tuple(entries),
        main_blocks=tuple(main_blocks),
        blocks=blocks.count,
    )


def _requirement(buffer: CodeBuffer, writer: ExpressionWriter, requirement: ir.Requirement) -> Segment:
    """A soft requirement may be skipped, so later code must not rely on what it computed."""
    start = len(buffer.rows)
    within = writer if requirement.probability >= 1 else writer.branch()
    result = within.register(requirement.condition)
    buffer.emit(Op.END)
    return Segment(start, len(buffer.rows), result)


def _rule(buffer: CodeBuffer, writer: ExpressionWriter, rule: ir.Rule) -> Segment:
    if rule.condition is None:
        return Segment(-1, -1, None)
    start = len(buffer.rows)
    buffer.offset = rule.condition.span.start
    result = writer.branch().register(rule.condition)
    buffer.emit(Op.END)
    return Segment(start, len(buffer.rows), result)


def _behaviour(buffer: CodeBuffer, writer: ExpressionWriter, blocks: BlockNumbers, main: int, actor: ir.Actor) -> int:
    if actor.behaviour is None:
        return -1
    entry = len(buffer.rows)
    BehaviourWriter(buffer, writer, blocks, main).write(actor.behaviour)
    buffer.emit(Op.HALT)
    return entry
