"""Checked scenario to `Program`: the only part of the compiler that knows how programs are laid out."""

from collections.abc import Sequence
from os.path import relpath
from pathlib import PurePath

from cortex_dsl import ir
from cortex_dsl.lowering.code_tables import code_tables, floats, group_variants, ints
from cortex_dsl.lowering.templates import VariantCode, lower_variant
from cortex_dsl.semantics.quantities.units import UNITS, si_word
from cortex_dsl.source import Source
from engine.judged import Judged, Objective, Reading
from engine.program import (
    ChoiceLabel,
    DrawSite,
    ImportedText,
    ParamSpace,
    Program,
    Record,
    Requirement,
    Rule,
    VariantLabel,
    program_digest,
)
from engine.road import road_tables

BUILT_IN_REQUIREMENTS = (
    Requirement("outlines inside the road", 0),
    Requirement("no overlap at the start", 0),
)
FAIR = (Requirement("fair start", 0),)


def lower(scenario: ir.Scenario) -> Program:
    """Compile a checked scenario. All its variants hold the same actors, requirements and rules."""
    grouping = group_variants(scenario)
    example = next(variant for variant in grouping.variants if variant.rejection is None)
    codes = [lower_variant(v) if v.rejection is None else None for v in grouping.variants]
    rejections = sorted({(v.rejection_line, v.rejection) for v in grouping.variants if v.rejection is not None})
    requirements = (
        *map(_requirement, example.requirements),
        *(Requirement(reason, line) for line, reason in rejections),
        *BUILT_IN_REQUIREMENTS,
        *(FAIR if scenario.settings.fair else ()),
    )
    space = _param_space(scenario.genes, scenario.system)
    code, tables, step_offsets = code_tables(scenario, grouping, codes, rejections)
    road = road_tables(scenario.network)
    if any(actor.level for actor in example.actors):
        levels = [(number, lane) for number, actor in enumerate(example.actors) for lane in actor.level]
        road = road._replace(first_lanes=ints(levels).reshape(-1, 2))
    judged = Judged(tuple(map(_objective, scenario.objectives)), tuple(map(_reading, scenario.readings)), tables)
    return Program(
        name=scenario.name,
        description=scenario.description,
        digest=program_digest(space, code, road, scenario.settings, judged, scenario.controls),
        source_text=scenario.source.text,
        imported=_imported(scenario.source),
        space=space,
        actors=tuple(actor.name for actor in example.actors),
        requirements=requirements,
        rules=tuple(Rule(rule.name, rule.line, rule.kind) for rule in example.rules),
        variants=tuple(_label(v, c) for v, c in zip(grouping.variants, codes, strict=True)),
        settings=scenario.settings,
        code=code,
        road=road,
        road_spec=scenario.road,
        step_lines=ints([scenario.source.row(offset) for offset in step_offsets]),
        routes=ints([[actor.route for actor in v.actors] or [-1] * len(example.actors) for v in grouping.variants]),
        records=tuple(map(_record, scenario.records)),
        monitors=tuple(monitor.name for monitor in example.monitors),
        judged=judged,
        controls=scenario.controls,
    )


def _requirement(required: ir.Requirement) -> Requirement:
    scale = UNITS[required.unit].factor if required.unit else 1.0
    unit = si_word(required.dimension)
    return Requirement(required.name, required.line, required.probability, unit, required.unit, scale)


def _record(record: ir.Record) -> Record:
    unit = si_word(record.dimension)
    return Record(record.name, record.when, record.watch, unit, record.line, record.during)


def _objective(objective: ir.Objective) -> Objective:
    unit = si_word(objective.dimension) if objective.formula is None else ""
    return Objective(objective.name, objective.sense, unit, objective.line)


def _reading(reading: ir.Reading) -> Reading:
    return Reading(reading.kind, reading.rule, reading.result)


def _imported(source: Source) -> tuple[ImportedText, ...]:
    """Return the imported files, named relative to the main file."""
    folder = str(PurePath(source.name).parent)
    return tuple(ImportedText(relpath(f.name, folder), f.start, f.first_line, f.text) for f in source.imported)


def _label(variant: ir.Variant, code: VariantCode | None) -> VariantLabel:
    choices = tuple(ChoiceLabel(c.name, c.option, c.option_source, c.span.start, c.span.end) for c in variant.choices)
    values = () if code is None else code.site_values
    sites = tuple(
        DrawSite(site.kind, site.unit, site.span.start, site.span.end, numbers)
        for site, numbers in zip(variant.draw_sites, values, strict=code is not None)
    )
    return VariantLabel(variant.probability, choices, sites, -1 if code is None else code.sight)


def _param_space(genes: Sequence[ir.GeneInfo], system: tuple[str, ...]) -> ParamSpace:
    return ParamSpace(
        names=tuple(g.name for g in genes),
        units=tuple(g.unit for g in genes),
        kinds=ints([g.kind for g in genes]),
        low=floats([g.low for g in genes]),
        high=floats([g.high for g in genes]),
        distribution=ints([g.distribution for g in genes]),
        shape=floats([(g.mean, g.deviation) for g in genes]).reshape(-1, 2),
        scale=floats([g.scale for g in genes]),
        options=tuple(g.options for g in genes),
        weights=tuple(g.weights for g in genes),
        bare=tuple(g.name for g in genes if g.bare),
        system=system,
    )
