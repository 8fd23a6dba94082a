"""Checked scenario to `Program`: the only part of the compiler that knows how programs are laid out."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from cortex_dsl import ir
from cortex_dsl.lowering.templates import Merged, RegisterFile, encode, encode_segment, merge
from cortex_dsl.lowering.variant import VariantCode, lower_variant
from engine.archive import program_digest
from engine.program import (
    ChoiceLabel,
    DrawSite,
    ParamSpace,
    Program,
    Requirement,
    Rule,
    VariantLabel,
)
from engine.road import road_tables
from engine.tables import CodeTables, Floats, Ints
from engine.vocabulary import GeneKind

BUILT_IN_REQUIREMENTS = (
    Requirement("outlines inside the road", 0),
    Requirement("no overlap at the start", 0),
)


def lower(scenario: ir.Scenario) -> Program:
    """Compile a checked scenario. All its variants hold the same actors, requirements and rules."""
    grouping = _group(scenario)
    example = next(variant for variant in grouping.variants if variant.rejection is None)
    codes = [lower_variant(v) if v.rejection is None else None for v in grouping.variants]
    rejections = sorted({(v.rejection_line, v.rejection) for v in grouping.variants if v.rejection is not None})
    requirements = (
        *(Requirement(r.name, r.line, r.probability) for r in example.requirements),
        *(Requirement(reason, line) for line, reason in rejections),
        *BUILT_IN_REQUIREMENTS,
    )
    space = _param_space(scenario.genes)
    code, step_offsets = _code_tables(scenario, grouping, codes, rejections)
    road = road_tables(scenario.network)
    return Program(
        name=scenario.name,
        description=scenario.description,
        digest=program_digest(space, code, road, scenario.settings),
        source_text=scenario.source.text,
        space=space,
        actors=tuple(actor.name for actor in example.actors),
        requirements=requirements,
        rules=tuple(Rule(rule.name, rule.line) for rule in example.rules),
        variants=tuple(_label(v, c) for v, c in zip(grouping.variants, codes, strict=True)),
        settings=scenario.settings,
        code=code,
        road=road,
        road_spec=scenario.road,
        step_lines=_ints([scenario.source.position(offset).line for offset in step_offsets]),
        routes=_ints([_routes(v, len(example.actors)) for v in grouping.variants]),
    )


def _routes(variant: ir.Variant, actors: int) -> list[int]:
    return [actor.route for actor in variant.actors] or [-1] * actors


def _label(variant: ir.Variant, code: VariantCode | None) -> VariantLabel:
    choices = tuple(ChoiceLabel(c.name, c.option, c.option_source, c.span.start, c.span.end) for c in variant.choices)
    values = () if code is None else code.site_values
    sites = tuple(
        DrawSite(site.kind, site.unit, site.span.start, site.span.end, numbers)
        for site, numbers in zip(variant.draw_sites, values, strict=code is not None)
    )
    return VariantLabel(variant.probability, choices, sites)


def _param_space(genes: Sequence[ir.GeneInfo]) -> ParamSpace:
    return ParamSpace(
        names=tuple(g.name for g in genes),
        units=tuple(g.unit for g in genes),
        kinds=_ints([g.kind for g in genes]),
        low=_floats([g.low for g in genes]),
        high=_floats([g.high for g in genes]),
        distribution=_ints([g.distribution for g in genes]),
        shape=_floats([(g.mean, g.deviation) for g in genes]).reshape(-1, 2),
        scale=_floats([g.scale for g in genes]),
        options=tuple(g.options for g in genes),
        weights=tuple(g.weights for g in genes),
    )


def _code_tables(
    scenario: ir.Scenario,
    grouping: Grouping,
    codes: Sequence[VariantCode | None],
    rejections: Sequence[tuple[int, str]],
) -> tuple[CodeTables, list[int]]:
    """The code tables, and the source offset of each row of step code."""
    variants = grouping.variants
    example = next(variant for variant in variants if variant.rejection is None)
    merged = merge(codes)
    templates = [template.code for template in merged.templates]
    constants = len(merged.literals) + merged.variant_values.shape[1]
    genes, draws = len(scenario.genes), max(v.draw_count for v in variants)
    values, locals_ = max(len(t.outputs) for t in templates), max(v.local_count for v in variants)
    scene_file = RegisterFile(constants, constants + genes, 0, 0, constants + genes + draws)
    step_file = RegisterFile(0, 0, constants, constants + values, constants + values + locals_)

    scene_rows: list[list[int]] = []
    step_rows: list[list[int]] = []
    step_offsets: list[int] = []
    requirement_segments, output_segments, output_registers, rule_segments, entries = [], [], [], [], []
    for template in merged.templates:
        code, scene_base, step_base = template.code, len(scene_rows), len(step_rows)
        scene_rows += encode(code.scene_rows, template, scene_file, scene_base)
        step_rows += encode(code.step_rows, template, step_file, step_base)
        step_offsets += code.step_offsets
        requirement_segments.append([encode_segment(s, template, scene_file, scene_base) for s in code.requirements])
        output_segments.append((scene_base + code.output.start, scene_base + code.output.end))
        registers = [scene_file.number(register, template) for register in code.outputs]
        output_registers.append(registers + [0] * (values - len(registers)))
        rule_segments.append([encode_segment(s, template, step_file, step_base) for s in code.rules])
        entries.append([entry if entry < 0 else step_base + entry for entry in code.entries])

    first_rejection = len(example.requirements)
    rejection_index = {reason: first_rejection + i for i, reason in enumerate(rejections)}
    tables = CodeTables(
        scene_code=_ints(scene_rows).reshape(-1, 6),
        step_code=_ints(step_rows).reshape(-1, 6),
        literals=_floats(merged.literals),
        pool=_floats(scenario.pool),
        variant_values=np.ascontiguousarray(merged.variant_values),
        variant_template=_ints(merged.template_of),
        variant_rejection=_ints(
            [-1 if v.rejection is None else rejection_index[v.rejection_line, v.rejection] for v in variants]
        ),
        variant_cumulative=_floats(grouping.cumulative),
        group_start=_ints(grouping.start),
        group_gene=_ints(grouping.genes),
        group_size=_ints(grouping.sizes),
        gene_scale=_floats([g.scale for g in scenario.genes]),
        requirement_segment=_ints(requirement_segments).reshape(len(templates), -1, 3),
        requirement_probability=_floats([r.probability for r in example.requirements]),
        output_segment=_ints(output_segments).reshape(-1, 2),
        output_register=_ints(output_registers),
        road_check=_ints([actor.inside_road for actor in example.actors]),
        overlap_check=_ints([actor.no_overlap for actor in example.actors]),
        actor_kind=_ints([actor.kind for actor in example.actors]),
        behaviour_entry=_ints(entries),
        main_block=_ints([code.main_blocks for code in templates]),
        rule_segment=_ints(rule_segments).reshape(len(templates), -1, 3),
        sizes=_ints(
            [
                scene_file.temporaries + max(t.scene_temporaries for t in templates),
                draws,
                values,
                step_file.temporaries + max(t.step_temporaries for t in templates),
                step_file.locals,
                max(t.blocks for t in templates),
            ]
        ),
    )
    return tables, step_offsets


@dataclass(frozen=True)
class Grouping:
    """Variants arranged by what the genes decide: within a group, chance alone picks the variant."""

    genes: tuple[int, ...]
    sizes: tuple[int, ...]
    start: tuple[int, ...]
    variants: tuple[ir.Variant, ...]
    """Group after group; a variant that leaves a gene open stands in several groups."""
    cumulative: tuple[float, ...]


def _group(scenario: ir.Scenario) -> Grouping:
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


def _ints(values: object) -> Ints:
    return np.asarray(values, dtype=np.int32)


def _floats(values: object) -> Floats:
    return np.asarray(values, dtype=np.float64)
