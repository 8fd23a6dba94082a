"""A found case as a scenario of its own: the author's text with every random value replaced by what was drawn.

Numbers are written with the digits that bring back the same floating-point value, nuisance values in SI units and
genes in the unit of the file, so that compiling the copy gives the registers of the original and a run of it the same
outcome, bit for bit. Comments and layout of the author stay.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from cortex_dsl.semantics.overrides import override_text
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.program import ChoiceLabel, DrawSite, Program
from engine.scenes import Scenes, StreamKey
from engine.streams import format_key
from engine.vocabulary import GeneKind

NO_OVERRIDES: Mapping[str, str] = {}


@dataclass(frozen=True)
class Edit:
    """Put `text` in the place of `span`."""

    span: Span
    text: str


def concrete_source(
    program: Program,
    module: nodes.Module,
    scenes: Scenes,
    row: int,
    config: SimulationConfig,
    *,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    remark: str = "",
) -> str:
    """The scenario that is scene `row` and nothing else.

    Args:
        program: what the scenes were drawn from.
        module: the syntax tree of its text.
        scenes: the drawn scenes; `row` must be valid.
        row: which of them.
        config: the settings it was run with; what the file leaves open is pinned in the copy.
        overrides: constants given on the command line (`-p`), which the copy must hold as well.
        remark: text put as a comment at the top.
    """
    source = Source(program.name, program.source_text)
    edits = [
        *_param_edits(program, scenes.genomes[row], overrides, module),
        *_variant_edits(program, scenes, row),
        _simulation_edit(config, StreamKey(*scenes.keys[row].tolist()), module, source),
    ]
    text = _apply(source.text, edits)
    return "".join(f"# {line}\n" for line in remark.splitlines()) + text


def _apply(text: str, edits: Sequence[Edit]) -> str:
    """All edits at once; one inside another is dropped, since the outer one replaces its text anyway."""
    result, position = [], 0
    for edit in sorted(edits, key=lambda edit: (edit.span.start, -edit.span.end)):
        if edit.span.start < position:
            continue
        result += [text[position : edit.span.start], edit.text]
        position = edit.span.end
    return "".join([*result, text[position:]])


def _param_edits(
    program: Program, genome: Sequence[float], overrides: Mapping[str, str], module: nodes.Module
) -> Iterator[Edit]:
    genes = {name: index for index, name in enumerate(program.space.names)}
    for statement in module.statements:
        for entry in statement.entries if isinstance(statement, nodes.Param) else ():
            if entry.name in overrides:
                yield Edit(entry.value.span, override_text(entry, overrides[entry.name]))
            elif entry.name in genes:
                yield Edit(entry.value.span, _gene_text(program, genes[entry.name], float(genome[genes[entry.name]])))


def _gene_text(program: Program, gene: int, value: float) -> str:
    space = program.space
    match GeneKind(space.kinds[gene]):
        case GeneKind.INDEX:
            return space.options[gene][int(value)]
        case GeneKind.INTEGER:
            return _number(int(value), space.units[gene])
        case GeneKind.CONTINUOUS:
            return _number(value, space.units[gene])


def _number(value: float, unit: str) -> str:
    return f"{value!r} {unit}".rstrip()


def _variant_edits(program: Program, scenes: Scenes, row: int) -> Iterator[Edit]:
    variant = program.variants[int(scenes.variant[row])]
    choices: dict[Span, list[ChoiceLabel]] = defaultdict(list)
    for choice in variant.choices:
        choices[Span(choice.start, choice.end)].append(choice)
    for span, made in choices.items():
        yield Edit(span, _successive([choice.option_source for choice in made]))
    sites: dict[Span, list[DrawSite]] = defaultdict(list)
    for site in variant.sites:
        sites[Span(site.start, site.end)].append(site)
    for span, evaluated in sites.items():
        drawn = [scenes.values[row][list(site.values)].tolist() for site in evaluated]
        yield Edit(span, _site_text(evaluated[0], drawn))


def _successive(texts: Sequence[str]) -> str:
    """One value, or those that successive evaluations of the same place had (in a comprehension, say)."""
    return texts[0] if len(texts) == 1 else f"Fixed({', '.join(texts)})"


def _site_text(site: DrawSite, drawn: Sequence[Sequence[float]]) -> str:
    if site.kind == "number":
        return _successive([_number(values[0], site.unit) for values in drawn])
    place = _successive([f"({values[0]!r} m, {values[1]!r} m)" for values in drawn])
    if site.kind == "point":
        return f"at {place}"
    return f"at {place}, facing {_successive([_number(values[2], 'rad') for values in drawn])}"


def _simulation_edit(config: SimulationConfig, key: StreamKey, module: nodes.Module, source: Source) -> Edit:
    """The `simulation(...)` statement: what the file leaves to the command line is pinned.

    The stream is pinned too: coins of soft requirements and random numbers inside behaviours come from it.
    """
    settings = [f"time_step={config.time_step!r} s", f"max_attempts={config.max_attempts}"]
    if not any(isinstance(statement, nodes.TerminateAfter) for statement in module.statements):
        settings.append(f"max_time={config.max_time!r} s")
    text = f'simulation({", ".join(settings)}, stream="{format_key(key)}")'
    for statement in module.statements:
        if isinstance(statement, nodes.Simulation):
            return Edit(statement.span, text)
    end = len(source.text.rstrip())
    return Edit(Span(end, len(source.text)), f"\n\n{text}\n")
