"""A readable print of the checked IR, for `--emit ir`."""

from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.semantics.printing.listing_code import INDENT, Printer, expressions_of
from engine.vocabulary import Column, Distribution, GeneKind, RuleKind, TemporalOp

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
    yield f"road {scenario.road}"
    yield f"settings {scenario.settings}"
    for i, gene in enumerate(scenario.genes):
        yield f"gene {i} {_gene(gene)}"
    if scenario.pool:
        yield f"pool {' '.join(f'{value:g}' for value in scenario.pool)}"
    for temporal in scenario.temporals:
        yield f"require {_formula(temporal.formula)}, else rule {temporal.rule}"
    for record in scenario.records:
        yield f"record {record.when} {record.name}: rule {record.watch}"


def _formula(formula: ir.Formula) -> str:
    """In words; an operand that is no atom in parentheses."""
    if formula.op == TemporalOp.ATOM:
        return f"rule{formula.watch}"
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
    body = list(_body(variant, printer))
    yield from printer.definitions()
    yield from body


def _body(variant: ir.Variant, printer: Printer) -> Iterator[str]:
    for requirement in variant.requirements:
        soft = "" if requirement.probability == 1.0 else f"[{requirement.probability:g}]"
        yield f"{INDENT}require{soft} {printer.text(requirement.condition)}  as {requirement.name!r}"
    for i, rule in enumerate(variant.rules):
        condition = "code says so" if rule.condition is None else printer.text(rule.condition)
        yield f"{INDENT}rule {i}: {RULES[rule.kind]} {condition}  (line {rule.line})"
    for i, monitor in enumerate(variant.monitors):
        yield f"{INDENT}monitor {i} {monitor.name}{', from the start' if monitor.started else ''}"
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
    yield from (value for site in variant.draw_sites for value in site.values)
    if (lights := variant.lights) is not None:
        yield from (lights.green, lights.yellow, lights.all_red, lights.offset)
