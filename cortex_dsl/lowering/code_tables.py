"""Symbolic code of all variants to the final code tables: templates one after another, registers with numbers.

The tables also hold the groups of variants and the rows of temporal formulas.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from cortex_dsl import ir
from cortex_dsl.lowering.templates import (
    Merged,
    RegisterFile,
    Segment,
    Template,
    VariantCode,
    encode,
    merge,
)
from engine.frozen import frozen
from engine.opcodes import ROW_WIDTH
from engine.tables import CodeTables, Floats, Ints, ObjectiveTables, Size
from engine.vocabulary import GeneKind

# -- Variants arranged by the choices of the genes ---------------------------------------------------------------------


@frozen
class Grouping:
    """Variants arranged by the choices of the genes: within a group, random numbers alone select the variant."""

    genes: tuple[int, ...]
    sizes: tuple[int, ...]
    start: tuple[int, ...]
    variants: tuple[ir.Variant, ...]
    """Variants, group after group; a variant that leaves a gene open is in several groups."""
    cumulative: tuple[float, ...]


def group_variants(scenario: ir.Scenario) -> Grouping:
    genes = sorted({gene for variant in scenario.variants for gene, _ in variant.gene_options})
    sizes = [_option_count(scenario.genes[gene]) for gene in genes]
    start, arranged, cumulative = [0], [], []
    for options in product(*(range(size) for size in sizes)):
        decided = dict(zip(genes, options, strict=True))
        members = [v for v in scenario.variants if all(decided[g] == option for g, option in v.gene_options)]
        weights = np.array([v.probability for v in members])
        arranged += members
        cumulative += list(np.cumsum(weights) / weights.sum())
        start.append(len(arranged))
    return Grouping(tuple(genes), tuple(sizes), tuple(start), tuple(arranged), tuple(cumulative))


def _option_count(gene: ir.GeneInfo) -> int:
    return len(gene.options) if gene.kind == GeneKind.INDEX else int(gene.high - gene.low) + 1


# -- Temporal requirements to the rows that `engine.kernels.evaluate` reads --------------------------------------------

FormulaRow = tuple[int, int, int]


@dataclass
class FormulaWriter:
    """Writes formulas, operands above their operators; equal ones share a row."""

    rows: list[FormulaRow] = field(default_factory=list)
    numbers: dict[FormulaRow, int] = field(default_factory=dict)

    def row(self, formula: ir.Formula) -> int:
        """Number of the row that holds a formula."""
        operands = [self.row(operand) for operand in formula.operands] or [formula.watch, formula.margin]
        first, second = (*operands, -1)[:2]
        row = (int(formula.op), first, second)
        if row not in self.numbers:
            self.numbers[row] = len(self.rows)
            self.rows.append(row)
        return self.numbers[row]


def formula_rows(formulas: Sequence[ir.Formula | None]) -> tuple[list[FormulaRow], list[int]]:
    """All rows, and the root of each formula; -1 where there is none."""
    writer = FormulaWriter()
    roots = [-1 if formula is None else writer.row(formula) for formula in formulas]
    return writer.rows, roots


# -- Lists to the arrays that programs are made of ---------------------------------------------------------------------


def ints(values: object) -> Ints:
    return np.asarray(values, dtype=np.int32)


def floats(values: object) -> Floats:
    return np.asarray(values, dtype=np.float64)


EncodedSegment = tuple[int, int, int]
"""Start row, end row and result register; all -1 for a segment without code."""


def encode_segment(segment: Segment, template: Template, registers: RegisterFile, base: int) -> EncodedSegment:
    if segment.result is None:
        return (-1, -1, -1)
    return (base + segment.start, base + segment.end, registers.number(segment.result, template))


# -- The tables --------------------------------------------------------------------------------------------------------


@frozen
class Files:
    """The two register files, as `engine.tables.CodeTables` lays them out."""

    scene: RegisterFile
    step: RegisterFile
    draws: int
    values: int
    """Scene values of the template that has most."""


@frozen
class EncodedTemplate:
    """One template with all its numbers final."""

    scene_rows: list[list[int]]
    step_rows: list[list[int]]
    requirements: list[EncodedSegment]
    margins: list[EncodedSegment]
    output: tuple[int, int]
    output_registers: list[int]
    rules: list[EncodedSegment]
    objectives: list[EncodedSegment]
    entries: list[int]
    monitors: list[int]


def code_tables(
    scenario: ir.Scenario,
    grouping: Grouping,
    codes: Sequence[VariantCode | None],
    rejections: Sequence[tuple[int, str]],
) -> tuple[CodeTables, ObjectiveTables, list[int]]:
    """The code tables, those of objectives, and the source offset of each row of step code.

    Args:
        scenario: the checked scenario.
        grouping: its variants in the order of the tables.
        codes: their code; None for an impossible variant.
        rejections: (line, reason) of impossible variants, in the order of their pseudo requirements.
    """
    example = next(variant for variant in grouping.variants if variant.rejection is None)
    merged = merge(codes)
    files = _register_files(scenario, grouping, merged)
    encoded = _encode_all(merged, files)
    templates = [template.code for template in merged.templates]
    judged = [objective.formula for objective in scenario.objectives]
    formula, roots = formula_rows([*(temporal.formula for temporal in scenario.temporals), *judged])
    required = len(scenario.temporals)
    tables = CodeTables(
        scene_code=ints([row for e in encoded for row in e.scene_rows]).reshape(-1, ROW_WIDTH),
        step_code=ints([row for e in encoded for row in e.step_rows]).reshape(-1, ROW_WIDTH),
        literals=floats(merged.literals),
        pool=floats(scenario.pool),
        variant_values=np.ascontiguousarray(merged.variant_values),
        variant_template=ints(merged.template_of),
        variant_rejection=_rejection_numbers(grouping, rejections, len(example.requirements)),
        variant_cumulative=floats(grouping.cumulative),
        group_start=ints(grouping.start),
        group_gene=ints(grouping.genes),
        group_size=ints(grouping.sizes),
        gene_scale=floats([gene.scale for gene in scenario.genes]),
        requirement_segment=ints([e.requirements for e in encoded]).reshape(len(encoded), -1, 3),
        requirement_probability=floats([r.probability for r in example.requirements]),
        output_segment=ints([e.output for e in encoded]),
        output_register=ints([e.output_registers for e in encoded]),
        road_check=ints([actor.inside_road for actor in example.actors]),
        overlap_check=ints([actor.overlap_group for actor in example.actors]),
        actor_kind=ints([actor.kind for actor in example.actors]),
        behaviour_entry=ints([e.entries for e in encoded]),
        main_block=ints([code.main_blocks for code in templates]),
        rule_segment=ints([e.rules for e in encoded]).reshape(len(encoded), -1, 3),
        rule_kind=ints([rule.kind for rule in example.rules]),
        formula=ints(formula).reshape(-1, 3),
        temporal_root=ints(roots[:required]),
        temporal_rule=ints([temporal.rule for temporal in scenario.temporals]),
        monitor_entry=ints([e.monitors for e in encoded]).reshape(len(encoded), -1),
        monitor_block=ints([code.monitor_blocks for code in templates]).reshape(len(encoded), -1),
        monitor_started=ints([monitor.turns for monitor in example.monitors]),
        actor_present=ints([actor.present for actor in example.actors]),
        margin_segment=ints([e.margins for e in encoded]).reshape(len(encoded), -1, 3),
        sizes=_sizes(files, templates),
    )
    objectives = ObjectiveTables(
        root=ints(roots[required:]), segment=ints([e.objectives for e in encoded]).reshape(len(encoded), -1, 3)
    )
    return tables, objectives, [offset for code in templates for offset in code.step_offsets]


def _register_files(scenario: ir.Scenario, grouping: Grouping, merged: Merged) -> Files:
    constants = len(merged.literals) + merged.variant_values.shape[1]
    draws = max(variant.draw_count for variant in grouping.variants)
    locals_ = max(template.code.locals for template in merged.templates)
    values = max(len(template.code.outputs) for template in merged.templates)
    first_draw = constants + len(scenario.genes)
    return Files(
        scene=RegisterFile(constants=0, genes=constants, draws=first_draw, temporaries=first_draw + draws),
        step=RegisterFile(
            constants=0, values=constants, locals=constants + values, temporaries=constants + values + locals_
        ),
        draws=draws,
        values=values,
    )


def _encode_all(merged: Merged, files: Files) -> list[EncodedTemplate]:
    encoded: list[EncodedTemplate] = []
    scene_base = step_base = 0
    for template in merged.templates:
        encoded.append(_encode_template(template, files, scene_base, step_base))
        scene_base += len(encoded[-1].scene_rows)
        step_base += len(encoded[-1].step_rows)
    return encoded


def _encode_template(template: Template, files: Files, scene_base: int, step_base: int) -> EncodedTemplate:
    code = template.code
    registers = [files.scene.number(register, template) for register in code.outputs]
    return EncodedTemplate(
        scene_rows=encode(code.scene_rows, template, files.scene, scene_base),
        step_rows=encode(code.step_rows, template, files.step, step_base),
        requirements=[encode_segment(s, template, files.scene, scene_base) for s in code.requirements],
        margins=[encode_segment(s, template, files.scene, scene_base) for s in code.margins],
        output=(scene_base + code.output.start, scene_base + code.output.end),
        # A template with fewer scene values than another repeats its first: nothing reads the rest.
        output_registers=registers + registers[:1] * (files.values - len(registers)),
        rules=[encode_segment(s, template, files.step, step_base) for s in code.rules],
        objectives=[encode_segment(s, template, files.step, step_base) for s in code.objectives],
        entries=[entry if entry < 0 else step_base + entry for entry in code.entries],
        monitors=[step_base + entry for entry in code.monitor_entries],
    )


def _rejection_numbers(grouping: Grouping, rejections: Sequence[tuple[int, str]], first: int) -> np.ndarray:
    number = {reason: first + i for i, reason in enumerate(rejections)}
    return ints([-1 if v.rejection is None else number[v.rejection_line, v.rejection] for v in grouping.variants])


def _sizes(files: Files, templates: Sequence[VariantCode]) -> np.ndarray:
    """`CodeTables.sizes`."""
    sizes = {
        Size.SCENE_REGISTERS: files.scene.temporaries + max(code.scene_temporaries for code in templates),
        Size.DRAWS: files.draws,
        Size.SCENE_VALUES: files.values,
        Size.STEP_REGISTERS: files.step.temporaries + max(code.step_temporaries for code in templates),
        Size.LOCALS: files.step.locals,
        Size.BLOCKS: max(code.blocks for code in templates),
    }
    return ints([sizes[size] for size in Size])
