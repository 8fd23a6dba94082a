"""Variants with equal code become one template; their constants become literals or columns of variant values."""

from collections.abc import Sequence

import numpy as np

from cortex_dsl.lowering.operands import (
    Constant,
    DrawRegister,
    GeneRegister,
    Jump,
    LocalRegister,
    Operand,
    Register,
    Row,
    SceneValue,
    Target,
    Temporary,
)
from cortex_dsl.lowering.variant import Segment, VariantCode
from engine.frozen import frozen


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
        """For each constant occurrence, ("literal" | "variant", number). Values are compared by their bits."""
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


ROW_WIDTH = 6
"""Columns of a row of code: op, destination, a, b, c, d."""


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


EncodedSegment = tuple[int, int, int]
"""Start row, end row and result register; all -1 for a segment without code."""


def encode_segment(segment: Segment, template: Template, registers: RegisterFile, base: int) -> EncodedSegment:
    if segment.result is None:
        return (-1, -1, -1)
    return (base + segment.start, base + segment.end, registers.number(segment.result, template))
