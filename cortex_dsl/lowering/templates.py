"""One variant to symbolic code, and variants of the same code to one template with a column of constants for each."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cortex_dsl import ir
from cortex_dsl.lowering.blocks import BehaviourWriter, Coroutine, Coroutines, Numbers
from cortex_dsl.lowering.instructions import (
    CodeBuffer,
    Constant,
    Constants,
    DrawRegister,
    Dynamics,
    ExpressionWriter,
    GeneRegister,
    Jump,
    LocalRegister,
    Operand,
    Register,
    Row,
    SceneValue,
    Skipping,
    Target,
    Temporary,
)
from cortex_dsl.semantics.quantities.bounds import operands
from engine.frozen import frozen
from engine.opcodes import ROW_WIDTH, Op
from engine.vocabulary import Column


@frozen
class Segment:
    """Rows `start:end` of a buffer and the register of their result."""

    start: int
    end: int
    result: Register | None


NO_SEGMENT = Segment(-1, -1, None)


@frozen
class VariantCode:
    """A variant's code with symbolic operands."""

    constants: tuple[float, ...] = field(compare=False)
    """Values of the constants; left out of equality, so that variants with equal code share a template."""
    step_offsets: tuple[int, ...] = field(compare=False)
    scene_rows: tuple[Row, ...]
    scene_temporaries: int
    requirements: tuple[Segment, ...]
    margins: tuple[Segment, ...]
    output: Segment
    outputs: tuple[Register, ...]
    site_values: tuple[tuple[int, ...], ...]
    """Scene values of each draw site, and that of the weather's sight (-1: none)."""
    sight: int
    step_rows: tuple[Row, ...]
    step_temporaries: int
    rules: tuple[Segment, ...]
    objectives: tuple[Segment, ...]
    entries: tuple[int, ...]
    main_blocks: tuple[int, ...]
    monitor_entries: tuple[int, ...]
    monitor_blocks: tuple[int, ...]
    blocks: int
    locals: int


@dataclass
class SceneValues:
    """The values a scene hands to its run: actor columns, then whatever step code or a concrete copy asks for."""

    expressions: list[ir.Expr]
    numbers: dict[int, int] = field(init=False)
    """Number of each expression, by identity; a value that is also an actor's column is stored once."""
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
        """Return the register of a value that is settled with the scene; step code reads it without computing it."""
        return SceneValue(self.number(expression)) if self.is_settled(expression) else None

    def is_settled(self, expression: ir.Expr) -> bool:
        """Return True if an expression is one number that is settled with the scene."""
        is_wide = isinstance(expression, ir.Pack) or (isinstance(expression, ir.Apply) and expression.width > 1)
        return not is_wide and not self.dynamics.is_dynamic(expression)


def lower_variant(variant: ir.Variant) -> VariantCode:
    constants = Constants()
    values = SceneValues([column for actor in variant.actors for column in actor.columns])
    assert len(values.expressions) == len(variant.actors) * len(Column)

    step, numbered = CodeBuffer(), _Coroutines.of(variant)
    writer = ExpressionWriter(step, constants, values.hoist, monitor_blocks=numbered.monitor_blocks)
    rules = tuple(_looked_at(step, writer, rule.condition) for rule in variant.rules)
    numbered.write(variant, step, replace(writer, skipping=Skipping(values.is_settled)))
    objectives = tuple(_looked_at(step, writer, value) for value in variant.objectives)
    site_values = tuple(tuple(values.number(value) for value in site.values) for site in variant.draw_sites)
    sight = next((values.number(value) for name, value in variant.environment if name == "sight"), -1)

    scene = CodeBuffer()
    shades, before = outlines_that_hide(variant.actors), looks_of_actors(variant.actors)
    scene_writer = ExpressionWriter(scene, constants, shades=shades, before=before)
    tested = [_requirement(scene, scene_writer, requirement) for requirement in variant.requirements]
    start = len(scene.rows)
    outputs = tuple(scene_writer.register(expression) for expression in values.expressions)
    scene.emit(Op.END)
    return VariantCode(
        constants=tuple(constants.values),
        scene_rows=scene.resolved(),
        scene_temporaries=scene.temporaries,
        requirements=tuple(condition for condition, _ in tested),
        margins=tuple(margin for _, margin in tested),
        output=Segment(start, len(scene.rows), None),
        outputs=outputs,
        site_values=site_values,
        sight=sight,
        step_rows=step.resolved(),
        step_offsets=tuple(step.offsets),
        step_temporaries=step.temporaries,
        rules=rules,
        objectives=objectives,
        entries=tuple(coroutine.entry.row for coroutine in numbered.actors),
        main_blocks=tuple(coroutine.block for coroutine in numbered.actors),
        monitor_entries=tuple(coroutine.entry.row for coroutine in numbered.monitors),
        monitor_blocks=tuple(numbered.monitor_blocks),
        blocks=numbered.blocks.count,
        locals=numbered.locals.count,
    )


def _requirement(buffer: CodeBuffer, writer: ExpressionWriter, requirement: ir.Requirement) -> tuple[Segment, Segment]:
    """Write condition and margin. Later code must not reuse the results of a soft requirement or a margin."""
    within = writer if requirement.probability >= 1 else writer.branch()
    condition = _segment(buffer, within, requirement.condition)
    if requirement.margin is None:
        return condition, NO_SEGMENT
    return condition, _segment(buffer, within.branch(), requirement.margin)


def _looked_at(buffer: CodeBuffer, writer: ExpressionWriter, value: ir.Expr | None) -> Segment:
    if value is None:
        return NO_SEGMENT
    buffer.offset = value.span.start
    return _segment(buffer, writer.branch(), value)


def _segment(buffer: CodeBuffer, writer: ExpressionWriter, expression: ir.Expr) -> Segment:
    start = len(buffer.rows)
    result = writer.register(expression)
    buffer.emit(Op.END)
    return Segment(start, len(buffer.rows), result)


@dataclass
class _Coroutines:
    """A variant's behaviours and monitors, numbered before any of them is written."""

    actors: Sequence[Coroutine]
    monitors: Sequence[Coroutine]
    blocks: Numbers
    locals: Numbers

    @classmethod
    def of(cls, variant: ir.Variant) -> "_Coroutines":
        blocks = Numbers()
        actors = [Coroutine(blocks.new(), Target()) for _ in variant.actors]
        monitors = [Coroutine(blocks.new(), Target()) for _ in variant.monitors]
        return cls(actors, monitors, blocks, Numbers(variant.local_count))

    @property
    def monitor_blocks(self) -> list[int]:
        return [monitor.block for monitor in self.monitors]

    def write(self, variant: ir.Variant, buffer: CodeBuffer, expressions: ExpressionWriter) -> None:
        """The code of all; an entry without code stays at row -1."""
        behaving = [c if a.behaviour is not None else None for a, c in zip(variant.actors, self.actors, strict=True)]
        known = Coroutines(behaving, self.monitors)
        bodies = [*(actor.behaviour for actor in variant.actors), *(monitor.body for monitor in variant.monitors)]
        for number, (coroutine, body) in enumerate(zip([*self.actors, *self.monitors], bodies, strict=True)):
            if body is not None:
                buffer.place(coroutine.entry)
                caller = known.callers.get(number - len(self.actors), -1)
                writer = BehaviourWriter(buffer, expressions, known, self.blocks, self.locals, coroutine.block, caller)
                writer.write_coroutine(body)


# -- Variants with equal code become one template; their constants become literals or columns of variant values --------


@frozen
class Template:
    """Code shared by variants, with the register (literal or variant value) of each constant occurrence."""

    code: VariantCode
    constant_registers: tuple[int, ...]


@frozen
class Merged:
    """All templates of a scenario and the constants they read."""

    templates: tuple[Template, ...]
    template_of: tuple[int, ...]
    """Template of each variant, -1 for one without code."""
    literals: np.ndarray
    variant_values: np.ndarray
    """(variants, columns)"""


def merge(codes: Sequence[VariantCode | None]) -> Merged:
    """Group the variants (None: impossible, without code) by equal code and place their constants."""
    groups: dict[VariantCode, list[int]] = {}
    for variant, code in enumerate(codes):
        if code is not None:
            groups.setdefault(code, []).append(variant)
    placement = _Placement(len(codes))
    placed = [
        (code, placement.place([c for v in members if (c := codes[v]) is not None], members))
        for code, members in groups.items()
    ]
    template_of = [-1] * len(codes)
    for number, members in enumerate(groups.values()):
        for variant in members:
            template_of[variant] = number
    literal_count = len(placement.literals)
    templates = tuple(
        Template(code, tuple(n if kind == "literal" else literal_count + n for kind, n in places))
        for code, places in placed
    )
    return Merged(templates, tuple(template_of), placement.literal_values(), placement.table())


class _Placement:
    """Decides where constants live: equal in all variants of a template -> literal, else a column."""

    def __init__(self, variants: int) -> None:
        self.variants = variants
        self.literals: dict[bytes, int] = {}
        self.columns: list[np.ndarray] = []

    def place(self, codes: Sequence[VariantCode], members: Sequence[int]) -> list[tuple[str, int]]:
        """Return ("literal" | "variant", number) for each use of a constant. Values are compared by their bits."""
        known: dict[bytes, int] = {}
        places = []
        for column in np.array([code.constants for code in codes], dtype=float).T.copy():
            key = column.tobytes()
            if key == column[:1].tobytes() * len(column):
                places.append(("literal", self.literals.setdefault(column[:1].tobytes(), len(self.literals))))
                continue
            if key not in known:
                known[key] = self._fill_column(len(known), members, column)
            places.append(("variant", known[key]))
        return places

    def _fill_column(self, number: int, members: Sequence[int], values: np.ndarray) -> int:
        """Columns are shared by templates: each variant fills only its own rows."""
        if number == len(self.columns):
            self.columns.append(np.zeros(self.variants))
        self.columns[number][list(members)] = values
        return number

    def literal_values(self) -> np.ndarray:
        return np.frombuffer(b"".join(self.literals), dtype=float).copy()

    def table(self) -> np.ndarray:
        return np.stack(self.columns, axis=1) if self.columns else np.zeros((self.variants, 0))


@frozen
class RegisterFile:
    """Where each kind of register starts in one family of code (scene or step)."""

    constants: int
    temporaries: int
    genes: int = 0
    draws: int = 0
    values: int = 0
    locals: int = 0

    def number(self, register: Register, template: Template) -> int:
        match register:
            case Constant(number):
                return self.constants + template.constant_registers[number]
            case GeneRegister(index):
                return self.genes + index
            case DrawRegister(index):
                return self.draws + index
            case SceneValue(index):
                return self.values + index
            case LocalRegister(index):
                return self.locals + index
            case Temporary(index):
                return self.temporaries + index


def encode(rows: Sequence[Row], template: Template, registers: RegisterFile, base: int) -> list[list[int]]:
    """Final rows; `base` is where this template's code starts."""

    def operand(symbolic: Operand) -> int:
        match symbolic:
            case int():
                return symbolic
            case Jump(row):
                return base + row
            case Target():
                raise AssertionError("jump targets are resolved before encoding")
        return registers.number(symbolic, template)

    def encoded(row: Row) -> list[int]:
        destination = 0 if row.destination is None else registers.number(row.destination, template)
        operands = [operand(o) for o in row.operands]
        return [int(row.op), destination, *operands, *([0] * (ROW_WIDTH - 2 - len(operands)))]

    return [encoded(row) for row in rows]


# -- occlusion at the start of a scene ---------------------------------------------------------------------------------


HIDING = (Column.X, Column.Y, Column.HEADING, Column.LENGTH, Column.WIDTH)
"""Columns of an outline that `Op.CAN_SEE` reads, before the flag for whether it hides others."""


def outlines_that_hide(actors: Sequence[ir.Actor]) -> tuple[ir.Expr, ...]:
    """Return all outlines at the start, in the order of the actors; an actor that appears later hides nothing yet."""
    items: list[ir.Expr] = []
    for actor in actors:
        items += [actor.columns[column] for column in HIDING]
        items.append(actor.columns[Column.OCCLUDING] if actor.present else ir.Literal(actor.span, 0.0))
    return tuple(items)


def looks_of_actors(actors: Sequence[ir.Actor]) -> dict[int, int]:
    """Return the number of the first actor that depends on a look, by the look's identity.

    If an object is placed or measured by visibility, only earlier objects hide others, since the object itself does not
    exist yet.
    """
    first: dict[int, int] = {}
    seen: set[int] = set()
    for number, actor in enumerate(actors):
        stack = list(actor.columns)
        while stack:
            if id(part := stack.pop()) in seen:
                continue
            seen.add(id(part))
            if isinstance(part, ir.Apply) and part.op == Op.CAN_SEE:
                first[id(part)] = number
            stack += operands(part)
    return first
