"""Elaboration: from the syntax tree to the checked IR.

The file is run once for every combination of its finite choices. Each run yields the actors, requirements and rules of
its variant as expressions over unknowns: genes, draws, and the state of the simulation.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath

from cortex_dsl import ir
from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.semantics.acting.objectives import objectives_of
from cortex_dsl.semantics.acting.rules import temporal_requirements
from cortex_dsl.semantics.advice import with_advice
from cortex_dsl.semantics.composition import setting_up
from cortex_dsl.semantics.errors.names import ALWAYS_FALSE, DIFFERENT_OBJECTS, EMPTY_FILE
from cortex_dsl.semantics.errors.problems import Findings, NeedsExpansion
from cortex_dsl.semantics.errors.scene import DEFAULT_MAP
from cortex_dsl.semantics.errors.values import EMPTY_REGION, NEVER_EQUAL, NO_OPTIONS, TOO_MANY_VARIANTS
from cortex_dsl.semantics.evaluation.roads import (
    beyond_any_road,
    default_road,
    has_plan,
    map_line,
    map_with_lights,
    reasons_for_road,
)
from cortex_dsl.semantics.model.choices import (
    CHOSEN_LANES_LIMIT,
    VARIANT_LIMIT,
    Oracle,
    TooManyVariants,
    enumerate_variants,
)
from cortex_dsl.semantics.model.context import Observer
from cortex_dsl.semantics.model.marks import Marks
from cortex_dsl.semantics.model.state import ChoicePlan, FileContext, FileFacts, MapFinder, RunSettings, no_maps
from cortex_dsl.semantics.names.linking import NO_FILES, ImportedFile, read_overrides, with_outside_params
from cortex_dsl.semantics.names.scope import check_names
from cortex_dsl.semantics.names.tree import (
    attributes_read,
    attributes_set,
    door_openers,
    door_sides,
    everything_in,
    lets_appear,
    param_entries,
    reads_warnings,
    system_params,
)
from cortex_dsl.semantics.quantities.units import si_word
from cortex_dsl.semantics.variants import Draft, elaborate_variant
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.maps import MapFile, RoadSpec
from engine.program import Settings
from engine.road.network import Network

NO_OVERRIDES: Mapping[str, str] = {}


def elaborate(
    module: nodes.Module,
    source: Source,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    *,
    imports: Mapping[Span, ImportedFile] = NO_FILES,
    scenario: str | None = None,
    observe: Observer | None = None,
    find_map: MapFinder = no_maps,
    domains: ir.DomainUse | None = None,
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """Return the checked scenario, and the warnings and notes about it.

    `overrides` are the `-p NAME=VALUE` of the command, `imports` maps each import statement to its file, `scenario` is
    the name to run, `observe` is called with every value, and `find_map` returns the path of a map's file. `domains` is
    the effect of `domain` lines: without it, they are checked, and the scenario is that of the file without them.

    Raises:
        CompileError: with every error found.
    """
    files = {"": module, **{file.name: file.module for file in imports.values()}}
    if domains is not None or not any(isinstance(s, nodes.Domain) for each in files.values() for s in each.statements):
        return _elaborated(module, source, overrides, imports, scenario, observe, find_map, domains)
    use = ir.DomainUse()
    measured, found = _elaborated(module, source, overrides, imports, scenario, observe, find_map, use)
    bare = {span: replace(file, module=_without_domains(file.module)) for span, file in imports.items()}
    plain, _ = _elaborated(_without_domains(module), source, overrides, bare, scenario, None, find_map, None)
    return replace(plain, domains=measured.domains), found


def _without_domains(module: nodes.Module) -> nodes.Module:
    return replace(module, statements=tuple(s for s in module.statements if not isinstance(s, nodes.Domain)))


def _elaborated(
    module: nodes.Module,
    source: Source,
    overrides: Mapping[str, str],
    imports: Mapping[Span, ImportedFile],
    scenario: str | None,
    observe: Observer | None,
    find_map: MapFinder,
    domains: ir.DomainUse | None,
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """Elaborate with one effect of `domain` lines.

    Raises:
        CompileError: with every error found.
    """
    findings = Findings()
    if not module.statements:
        raise CompileError(source, [EMPTY_FILE.at(Span(0, 0))])
    module = with_outside_params(module, _whole(module, imports), overrides)
    whole = _whole(module, imports)
    values = read_overrides(whole, overrides)
    check_names(module, findings, imports)
    system = system_params(module, param_entries(whole), findings)
    facts = FileFacts(
        source,
        values,
        imports,
        default_road=_default_road(whole, findings),
        entry=setting_up.entry(module, scenario, findings),
        find_map=find_map,
        has_map=any(isinstance(statement, nodes.Map) for statement in whole.statements),
        has_plan=has_plan(whole),
        default_signals=map_with_lights(whole),
        from_scenic=any(isinstance(statement, nodes.Model) for statement in whole.statements),
        attributes_read=attributes_read(whole),
        reads_warnings=reads_warnings(whole),
        attributes_set=attributes_set(whole),
        lets_appear=lets_appear(whole),
        domains=domains,
        door_openers=door_openers(whole),
        door_sides=door_sides(whole),
    )
    file, drafts = _drafted(module, facts, findings, observe)
    return with_advice(module, file, replace(_scenario(module, file, drafts), system=system))


def _drafted(
    module: nodes.Module, facts: FileFacts, findings: Findings, observe: Observer | None
) -> tuple[FileContext, list[Draft]]:
    """Return every variant; start again where a choice that was left symbolic has to be known, and where there are so
    many variants that the scene has to draw lanes. Where it cannot, lanes are chosen as in any other file.
    """
    plan, limit = ChoicePlan(), CHOSEN_LANES_LIMIT
    while True:
        settings = RunSettings(Settings(pedals_stay=facts.from_scenic))
        file = FileContext(facts, plan, findings.copy(), settings)
        try:
            drafts = _enumerate(module, file, observe, limit)
        except NeedsExpansion as need:
            plan = replace(plan, expanded=_expanded(plan.expanded, need.sites))
            continue
        except TooManyVariants:
            plan, limit = replace(plan, draws_lanes=True), VARIANT_LIMIT
            continue
        if not (plan.draws_lanes and file.findings.has_errors):
            return file, drafts
        plan = ChoicePlan()


def _whole(module: nodes.Module, imports: Mapping[Span, ImportedFile]) -> nodes.Module:
    """Return all files as one module, for checks over all of them."""
    modules = dict.fromkeys(file.module for file in imports.values())
    return replace(module, statements=(*(s for each in modules for s in each.statements), *module.statements))


def _expanded(known: frozenset[Span], needed: frozenset[Span]) -> frozenset[Span]:
    assert not needed <= known, "an expanded site was left symbolic"
    return known | needed


def _default_road(module: nodes.Module, findings: Findings) -> RoadSpec:
    """The road of a file without `map`."""
    road = default_road(module)
    has_map = any(isinstance(statement, nodes.Map) for statement in module.statements)
    for finding in () if has_map else beyond_any_road(module):
        findings.add(finding)
    if not has_map and "map" not in param_entries(module):
        lanes = "one lane" if road.lanes == 1 else f"{road.lanes} lanes"
        findings.add(
            DEFAULT_MAP.at(Span(0, 0), ways=road.ways, lanes=lanes, reason=reasons_for_road(road), road=map_line(road))
        )
    return road


def _enumerate(module: nodes.Module, file: FileContext, observe: Observer | None, lanes_limit: int) -> list[Draft]:
    """Return the drafts of all variants; stop at the first variant with errors, which the other variants would repeat.

    Raises:
        TooManyVariants: the number is within the general limit, but exceeds the limit for lanes.
    """
    drafts: list[Draft] = []
    # An observer keeps the places of values, and scenarios change when they are composed.
    marks = Marks() if observe is None and file.facts.entry is None else None

    def one(oracle: Oracle) -> Draft | None:
        return elaborate_variant(module, file, oracle, observe, marks)

    try:
        for _, draft in enumerate_variants(one, lanes_limit):
            if draft is not None:
                drafts.append(draft)
            if file.findings.has_errors:
                break
    except TooManyVariants as too_many:
        if lanes_limit < VARIANT_LIMIT and any(decision.drawable for decision in too_many.decisions):
            raise
        # Errors of all variants come first: after correction there may be fewer choices.
        elaborate_variant(module, file, Oracle(lanes_limit=math.inf, limit=math.inf), observe)
        if not file.findings.has_errors:
            file.findings.add(_too_many(too_many))
    finally:
        if marks is not None:
            marks.close()
    return drafts


def _too_many(too_many: TooManyVariants) -> Diagnostic:
    sizes = ", ".join(f"`{d.name}` has {len(d.probabilities)}" for d in too_many.decisions if len(d.probabilities) > 1)
    largest = max(too_many.decisions, key=lambda d: len(d.probabilities))
    return TOO_MANY_VARIANTS.at(largest.span, limit=VARIANT_LIMIT, sizes=sizes)


# -- all variants together --------------------------------------------------------------------------------------------


def _scenario(module: nodes.Module, file: FileContext, drafts: Sequence[Draft]) -> ir.Scenario:
    """Check the properties of all variants together, and assemble the scenario.

    Raises:
        CompileError: with every error found.
    """
    possible = [draft for draft in drafts if draft.variant.rejection is None]
    temporals: tuple[ir.Temporal, ...] = ()
    objectives: tuple[ir.Objective, ...] = ()
    if not file.findings.has_errors:
        _check_together(file, drafts, possible)
        conditions, has_end = [draft.conditions for draft in possible], _has_end(module, file)
        temporals = temporal_requirements(file, conditions, has_end=has_end)
        objectives = objectives_of(file, conditions, has_end=has_end)
    if file.findings.has_errors:
        raise CompileError(file.facts.source, file.findings)
    (network,) = file.roads.networks.values()
    requirements = _requirement_keys(possible)
    return ir.Scenario(
        source=file.facts.source,
        name=PurePath(file.facts.source.name).stem,
        description=module.docstring or "",
        road=network.spec,
        genes=tuple(_measured(file)),
        settings=file.settings.resolved(),
        variants=tuple(_completed(file, draft, requirements) for draft in drafts),
        network=network,
        pool=tuple(file.pool.values),
        temporals=temporals,
        records=tuple(record for _, record in file.run.records.values()),
        objectives=objectives,
        readings=tuple(file.run.readings),
        controls=tuple(file.run.controls.values()),
        domains=tuple(file.run.domains.values()),
    )


def _measured(file: FileContext) -> Iterator[ir.GeneInfo]:
    """Yield the genes; a gene without a unit takes the dimension of its places if they agree."""
    for index, gene in enumerate(file.genes.infos):
        words = {si_word(dimension) for dimension in file.genes.dimensions.get(index, ())}
        bare = not gene.unit and len(words) == 1 and words != {""}
        yield replace(gene, unit=words.pop(), bare=True) if bare else gene


def _has_end(module: nodes.Module, file: FileContext) -> bool:
    """Return whether the file limits the time of a run."""
    ends = any(isinstance(statement, nodes.TerminateAfter) for statement in everything_in(module))
    return ends or file.settings.given.max_time is not None


def _how_to_have_options(file: FileContext, span: Span) -> str:
    if any(d.code == NEVER_EQUAL.code and span.start <= d.label.span.start < span.end for d in file.findings):
        return "correct the comparison in it, which never holds"
    if re.search(r"is[34]Way", file.facts.source.slice(span)) and (cure := _other_intersections(file)):
        return cure
    if "ManeuverType." in file.facts.source.slice(span) and (has := _maneuvers(file)):
        return f"choose another map, or other maneuvers: this one has some of {has}"
    if "U_TURN" in file.facts.source.slice(span):
        return "gridded intersections have no U-turns: choose `STRAIGHT`, `LEFT_TURN` or `RIGHT_TURN`"
    return "widen the filter, or choose another map"


def _network_of_file(file: FileContext) -> Network | None:
    """Return the roads of an OpenDRIVE file; None for other maps, which their `map` line describes."""
    network = next(iter(file.roads.networks.values()), None)
    return network if network is not None and isinstance(network.spec, MapFile) else None


def _other_intersections(file: FileContext) -> str:
    """Return a cure that lists the intersections of the map by number of roads; empty without a map."""
    network = _network_of_file(file)
    if network is None:
        return ""
    counts = Counter(len(each.legs) for each in network.intersections)
    if not counts:
        return "choose another map: this one has no intersections"
    some = ", ".join(f"{ways} roads ({count})" for ways, count in sorted(counts.items()))
    return f"choose another map, or other intersections: this one has some of {some}"


def _maneuvers(file: FileContext) -> str:
    """Return the types of maneuvers of a file's map, and the number of each."""
    network = _network_of_file(file)
    counts = Counter(each.type.name for each in network.maneuvers) if network else {}
    return ", ".join(f"{kind} ({count})" for kind, count in sorted(counts.items()))


def _check_together(file: FileContext, drafts: Sequence[Draft], possible: Sequence[Draft]) -> None:
    if not possible:
        first = drafts[0]
        cure = _how_to_have_options(file, first.span)
        file.findings.add(NO_OPTIONS.at(first.span, reason=first.variant.rejection, cure=cure))
        return
    for span, weight in file.scene.weights.items():
        if not weight.possible:
            file.findings.add(ALWAYS_FALSE.at(span, secondary=weight.labels(file.genes.infos)))
    for span, possible_there in file.scene.places.items():
        if not possible_there:
            file.findings.add(EMPTY_REGION.at(span, text=file.facts.source.words(span)))
    objects = [[(a.name + _on_level(file, a), a.kind) for a in draft.variant.actors] for draft in possible]
    for draft, here in zip(possible, objects, strict=True):
        if here != objects[0]:
            names = [", ".join(name for name, _ in each) for each in (objects[0], here)]
            file.findings.add(DIFFERENT_OBJECTS.at(draft.span, here=names[0], there=names[1]))
            return


def _on_level(file: FileContext, actor: ir.Actor) -> str:
    """Return on which level an object begins, in words; "" where its heading decides."""
    network = _network_of_file(file) if actor.level else None
    return f" on the level of `{network.lanes[actor.level[0]].name}`" if network else ""


Key = tuple[int, str, int]


def _keys(requirements: Sequence[ir.Requirement]) -> list[Key]:
    """Return the key of each requirement, equal in all variants: line, name, index among requirements with both."""
    met: Counter[tuple[int, str]] = Counter()
    keys = []
    for each in requirements:
        name = (each.line, each.name)
        keys.append((*name, met[name]))
        met[name] += 1
    return keys


def _requirement_keys(possible: Sequence[Draft]) -> dict[Key, ir.Requirement]:
    """The requirements of all variants, in the order of the file."""
    merged: dict[Key, ir.Requirement] = {}
    for draft in possible:
        merged.update(zip(_keys(draft.variant.requirements), draft.variant.requirements, strict=True))
    return dict(sorted(merged.items(), key=lambda item: item[0][0]))


def _completed(file: FileContext, draft: Draft, requirements: Mapping[Key, ir.Requirement]) -> ir.Variant:
    """The variant with the rules and requirements of all: those that it lacks never end it and always hold."""
    if draft.variant.rejection is not None:
        return draft.variant
    own = dict(zip(_keys(draft.variant.requirements), draft.variant.requirements, strict=True))
    always = ir.Literal(draft.span, 1.0)
    return replace(
        draft.variant,
        requirements=tuple(own.get(key, replace(r, condition=always, margin=None)) for key, r in requirements.items()),
        rules=tuple(
            ir.Rule(draft.conditions.get(key), name, file.facts.line(key[0]), key[1])
            for key, name in file.run.rules.items()
        ),
        objectives=tuple(draft.objectives.get(span) for span in file.run.objectives),
        local_count=max(draft.variant.local_count, len(file.run.readings)),
    )
