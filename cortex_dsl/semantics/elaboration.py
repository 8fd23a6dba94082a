"""Elaboration: from the syntax tree to the checked IR.

The file is run once for every way of making its finite choices. A run leaves behind the actors, requirements and
rules of its variant as expressions over what is still unknown: genes, draws, and the state of the simulation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

from cortex_dsl import ir
from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.semantics import acts as _acts  # noqa: F401 - fills the table of statements
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.behaviours import actor_behaviour, warn_if_idle
from cortex_dsl.semantics.choices import VARIANT_LIMIT, Oracle, TooManyVariants, enumerate_variants
from cortex_dsl.semantics.classes import OFF_ROAD, PROPERTIES
from cortex_dsl.semantics.context import Evaluator, FileContext, Moment, RuleKey, Variant
from cortex_dsl.semantics.expressions import evaluator
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.semantics.overrides import param_entries, read_overrides
from cortex_dsl.semantics.problems import Mistake, NeedsExpansion, Rejection
from cortex_dsl.semantics.roads import network_of
from cortex_dsl.semantics.scope import check_names, everything_in
from cortex_dsl.semantics.statements import run_statement, terminate_when
from cortex_dsl.semantics.values import Actor, BehaviourValue
from cortex_dsl.semantics.yielding import everything
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.program import RoadSpec, Settings
from engine.vocabulary import Column

NO_OVERRIDES: Mapping[str, str] = {}


def elaborate(
    module: nodes.Module, source: Source, overrides: Mapping[str, str] = NO_OVERRIDES
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """The checked scenario, and the warnings and notes about it. `overrides` are the `-p NAME=VALUE` of the command.

    Raises:
        CompileError: with every error found.
    """
    findings = Findings()
    if not module.statements:
        raise CompileError(source, [errors.EMPTY_FILE.at(Span(0, 0))])
    values = read_overrides(module, overrides)
    check_names(module, findings)
    default_road = _default_road(module, findings)
    expanded: frozenset[Span] = frozenset()
    while True:
        file = FileContext(source, values, default_road, expanded, findings.copy())
        try:
            drafts = _enumerate(module, file)
        except NeedsExpansion as need:
            expanded = _expanded(expanded, need.sites)
        else:
            return _scenario(module, file, drafts), tuple(file.findings)


def _expanded(known: frozenset[Span], needed: frozenset[Span]) -> frozenset[Span]:
    assert not needed <= known, "an expanded site was left symbolic"
    return known | needed


def _default_road(module: nodes.Module, findings: Findings) -> RoadSpec:
    """The road of a file without `map`: a T-junction where the file asks for one."""
    asked = {node.name for node in everything_in(module) if isinstance(node, nodes.Attribute)}
    road = RoadSpec(ways=3 if "is3Way" in asked and "is4Way" not in asked else 4)
    has_map = any(isinstance(statement, nodes.Map) for statement in module.statements)
    if not has_map and "map" not in param_entries(module):
        findings.add(errors.DEFAULT_MAP.at(Span(0, 0), ways=road.ways))
    return road


@dataclass(frozen=True)
class Draft:
    """A variant before the rules of all variants are known."""

    variant: ir.Variant
    conditions: Mapping[RuleKey, ir.Expr]
    span: Span
    """Where it was rejected, or its first object."""


def _enumerate(module: nodes.Module, file: FileContext) -> list[Draft]:
    """Every variant; stops at the first one with errors, since the others would repeat them."""
    drafts: list[Draft] = []
    try:
        for _, draft in enumerate_variants(lambda oracle: _elaborate_variant(module, file, oracle)):
            if draft is not None:
                drafts.append(draft)
            if file.findings.has_errors:
                break
    except TooManyVariants as too_many:
        file.findings.add(_too_many(too_many))
    return drafts


def _too_many(too_many: TooManyVariants) -> Diagnostic:
    sizes = ", ".join(f"`{d.name}` has {len(d.probabilities)}" for d in too_many.decisions if len(d.probabilities) > 1)
    largest = max(too_many.decisions, key=lambda d: len(d.probabilities))
    return errors.TOO_MANY_VARIANTS.at(largest.span, limit=VARIANT_LIMIT, sizes=sizes)


def _elaborate_variant(module: nodes.Module, file: FileContext, oracle: Oracle) -> Draft | None:
    """One variant; None when it has errors."""
    run = Variant(file, oracle)
    ev = evaluator(run)
    run.names.update({s.name: BehaviourValue(s) for s in module.statements if isinstance(s, nodes.BehaviorDefinition)})
    try:
        for statement in module.statements:
            run_statement(ev, statement)
        actors = _finished_actors(ev)
        rules = ev.at_moment(Moment(running=True))
        for statement in module.statements:
            if isinstance(statement, nodes.TerminateWhen):
                _tolerate_rule(rules, statement)
        behaviours = [_behaviour(ev, actor) for actor in actors]
    except Rejection as rejection:
        return Draft(_rejected(run, rejection), {}, rejection.span)
    if file.findings.has_errors:
        return None
    network_of(ev)
    variant = ir.Variant(
        probability=oracle.probability,
        choices=tuple(run.choices),
        gene_options=oracle.gene_options,
        rejection=None,
        actors=tuple(_ir_actor(a, b) for a, b in zip(actors, behaviours, strict=True)),
        requirements=tuple(run.requirements),
        draw_count=run.draw_count,
        local_count=run.local_count,
        draw_sites=tuple(run.draw_sites),
    )
    return Draft(variant, run.rule_conditions, actors[0].span)


def _tolerate_rule(ev: Evaluator, statement: nodes.TerminateWhen) -> None:
    try:
        terminate_when(ev, statement)
    except Mistake as mistake:
        ev.report(mistake)


def _rejected(run: Variant, rejection: Rejection) -> ir.Variant:
    return ir.Variant(
        probability=run.oracle.probability,
        choices=tuple(run.choices),
        gene_options=run.oracle.gene_options,
        rejection=rejection.reason,
        rejection_line=run.file.line(rejection.span),
    )


def _finished_actors(ev: Evaluator) -> list[Actor]:
    """All objects, the ego first; their numbers are final from now on."""
    ego = ev.run.ego
    if ego is None:
        if "ego" not in ev.run.names:
            ev.report(errors.NO_EGO.at(Span(0, 0)))
        return ev.run.actors
    actors = [ego, *(actor for actor in ev.run.actors if actor is not ego)]
    for index, actor in enumerate(actors):
        actor.index = index
    return actors


def _behaviour(ev: Evaluator, actor: Actor) -> ir.Block | None:
    try:
        block = actor_behaviour(ev, actor)
    except Mistake as mistake:
        ev.report(mistake)
        return None
    if block is not None:
        warn_if_idle(ev, actor, block)
    return block


def _ir_actor(actor: Actor, behaviour: ir.Block | None) -> ir.Actor:
    return ir.Actor(
        name=actor.name,
        kind=actor.kind,
        columns=_columns(actor),
        behaviour=behaviour,
        route=_route(behaviour),
        inside_road=actor.kind not in OFF_ROAD and actor.properties.get("regionContainedIn", actor) is not None,
        no_overlap=not actor.properties.get("allowCollisions", False),
        span=actor.span,
    )


def _columns(actor: Actor) -> tuple[ir.Expr, ...]:
    """One expression per `vocabulary.Column`."""
    by_column: dict[Column, ir.Expr] = {
        Column.X: actor.pose.x,
        Column.Y: actor.pose.y,
        Column.HEADING: actor.pose.heading,
    }
    for name, spec in PROPERTIES.items():
        value = actor.properties[name]
        assert isinstance(value, ir.Expr)
        by_column[spec.column] = value
    return tuple(by_column[column] for column in Column)


def _route(behaviour: ir.Block | None) -> int:
    """The first path that a behaviour is known to follow; -1 without one."""
    for act in everything(behaviour or ()):
        if isinstance(act, ir.Follow) and isinstance(act.path, ir.Literal):
            return int(act.path.value)
    return -1


# -- all variants together --------------------------------------------------------------------------------------------


def _scenario(module: nodes.Module, file: FileContext, drafts: Sequence[Draft]) -> ir.Scenario:
    """Check what only all variants together show, and assemble.

    Raises:
        CompileError: with every error found.
    """
    possible = [draft for draft in drafts if draft.variant.rejection is None]
    if not file.findings.has_errors:
        _check_together(file, drafts, possible)
    if file.findings.has_errors:
        raise CompileError(file.source, file.findings)
    (network,) = file.networks.values()
    requirements = _requirement_keys(possible)
    return ir.Scenario(
        source=file.source,
        name=PurePath(file.source.name).stem,
        description=module.docstring or "",
        road=network.spec,
        genes=tuple(file.genes.values()),
        settings=_settings(file),
        variants=tuple(_completed(file, draft, requirements) for draft in drafts),
        network=network,
        pool=tuple(file.pool.values),
    )


def _check_together(file: FileContext, drafts: Sequence[Draft], possible: Sequence[Draft]) -> None:
    if not possible:
        first = drafts[0]
        file.findings.add(errors.NO_OPTIONS.at(first.span, reason=first.variant.rejection))
        return
    for span, holds in file.require_holds.items():
        if not holds:
            file.findings.add(errors.ALWAYS_FALSE.at(span))
    objects = [[(a.name, a.kind) for a in draft.variant.actors] for draft in possible]
    for draft, here in zip(possible, objects, strict=True):
        if here != objects[0]:
            names = [", ".join(name for name, _ in each) for each in (objects[0], here)]
            file.findings.add(errors.DIFFERENT_OBJECTS.at(draft.span, here=names[0], there=names[1]))
            return


def _settings(file: FileContext) -> Settings:
    """`terminate after N steps` becomes a time."""
    if file.max_steps is None:
        return file.settings
    step = file.settings.time_step or SimulationConfig().time_step
    return replace(file.settings, max_time=file.max_steps * step)


Key = tuple[int, str, int]


def _keys(requirements: Sequence[ir.Requirement]) -> list[Key]:
    """What identifies a requirement in every variant: line, name, and which of its like it is."""
    names = [(r.line, r.name) for r in requirements]
    return [(*name, names[:i].count(name)) for i, name in enumerate(names)]


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
        requirements=tuple(own.get(key, replace(r, condition=always)) for key, r in requirements.items()),
        rules=tuple(
            ir.Rule(draft.conditions.get(key), name, file.line(key[0]), key[1]) for key, name in file.rules.items()
        ),
    )
