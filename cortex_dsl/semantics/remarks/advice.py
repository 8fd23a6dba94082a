"""What is said of a file that compiles, once all of its variants are known: params and requirements that do nothing,
and better ways to write what is right already.

A comment `# allow SCN481` anywhere in a file says that it means it: no warning, note or hint of that code is shown.
"""

import re
from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label, Severity
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.names.overrides import param_entries
from cortex_dsl.semantics.names.unused import shadowing_names, unused_definitions, unused_names
from cortex_dsl.semantics.remarks.bare_numbers import bare_numbers
from cortex_dsl.semantics.remarks.contacts import contacts
from cortex_dsl.semantics.remarks.liveness import live_genes
from cortex_dsl.semantics.remarks.windows import windows
from cortex_dsl.semantics.state import FileContext
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

_ALLOWED = re.compile(r"#[ \t]*allow[ \t]+(SCN\d+(?:[ \t,]+SCN\d+)*)")
MOST_USES = 3
"""Places of use that a dead param shows."""


def advised(
    module: nodes.Module, file: FileContext, scenario: ir.Scenario
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """The scenario with everything that is said about it. What `-p` or a concrete copy pins is nobody's slip."""
    pinned = bool(file.overrides) or file.settings.stream is not None
    for diagnostic in () if pinned else _advice(module, file, scenario):
        file.findings.add(diagnostic)
    allowed = {code for match in _ALLOWED.finditer(file.source.text) for code in re.findall(r"SCN\d+", match[1])}
    return scenario, tuple(d for d in file.findings if d.severity is Severity.ERROR or d.code not in allowed)


def _advice(module: nodes.Module, file: FileContext, scenario: ir.Scenario) -> Iterator[Diagnostic]:
    yield from _dead(module, file, scenario)
    yield from _certain(file)
    yield from bare_numbers(module, file.genes)
    yield from windows(module, file.source)
    yield from contacts(module, file.settings.time_step)
    yield from unused_names(module)
    yield from unused_definitions(module, file.entry)
    yield from shadowing_names(module)


def _dead(module: nodes.Module, file: FileContext, scenario: ir.Scenario) -> Iterator[Diagnostic]:
    """Params that are used, but in no place that matters; of a `require` that always holds is told anyway."""
    live = live_genes(scenario, file.gene_bounds())
    decided = [span for span, weight in file.weights.items() if weight.certain]
    for gene in (gene for index, gene in enumerate(scenario.genes) if index not in live):
        uses = _uses(module, gene.name)
        if any(not any(span.start <= use.start < span.end for span in decided) for use in uses):
            labels = tuple(Label(use, "used here, without effect") for use in uses[:MOST_USES])
            entry = param_entries(module).get(gene.name)
            place = gene.span if entry is None else entry.name_span
            yield errors.DEAD_GENE.at(place, name=gene.name, secondary=labels)


def _uses(module: nodes.Module, name: str) -> list[Span]:
    return [
        node.span
        for node in everything_in(module)
        if (isinstance(node, nodes.Name) and node.id == name)
        or (isinstance(node, nodes.Attribute) and node.name == name and _is_params(node.value))
    ]


def _is_params(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Name) and node.id == "globalParameters"


def _certain(file: FileContext) -> Iterator[Diagnostic]:
    for span, weight in file.weights.items():
        if weight.certain:
            yield errors.ALWAYS_TRUE.at(span, secondary=weight.labels(file.genes))
