"""A case as a scenario of its own: the author's text with every random value replaced by its sample.

Numbers are written with the digits that restore the same floating-point value, nuisance values in SI units and genes in
the unit of the file, so that compiling the copy gives the registers of the original and a run of it the same outcome,
bit for bit. Comments of the author stay; the layout is that of `cortexc fmt`.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.composition.setting_up import pinned_scenario
from cortex_dsl.semantics.evaluation.roads import map_line
from cortex_dsl.semantics.names.linking import ImportedFile, import_statements, override_text
from cortex_dsl.semantics.names.tree import all_params, bound_name, everything_in, param_entries, scenic_model
from cortex_dsl.source import FileText, Source, Span
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.formatting import format_copy
from engine.config import SimulationConfig
from engine.maps import MapFile, RoadSpec, map_name
from engine.program import ChoiceLabel, DrawSite, Program
from engine.road.network import LISTED_IN
from engine.scenes import Scenes
from engine.streams import StreamKey, format_key
from engine.vocabulary import GeneKind

Imports = Mapping[Span, ImportedFile]


@dataclass(frozen=True)
class Edit:
    """Put `text` in the place of `span`."""

    span: Span
    text: str


@dataclass(frozen=True)
class Original:
    """A scenario of which single scenes are written."""

    program: Program
    module: nodes.Module
    """Syntax tree of the main text."""
    config: SimulationConfig
    """Settings of a run; the copy fixes those that the file leaves open."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """Constants given on the command line (`-p`), which the copy must contain as well."""
    imports: Imports = field(default_factory=dict)
    """File of each import statement."""
    scenario: str | None = None
    """Name of the requested scenario, if it is not the file's own choice."""


def concrete_files(
    original: Original, scenes: Scenes, row: int, *, remark: str = "", name: str = "copy.scn", laid_out: bool = True
) -> dict[str, str]:
    """Return scene `row`, which must be valid, alone as a scenario, by file name: the main text, then its imports.

    Args:
        original: scenario of the scenes.
        scenes: the sampled scenes.
        row: index of the scene.
        remark: text put as a comment at the top.
        name: name of the copy; its imports are written next to it, under names that begin with its stem.
        laid_out: whether the layout is that of `cortexc fmt`; else every line of the author stays in place.
    """
    program, imports = original.program, original.imports
    source = Source(program.name, program.source_text)
    for file in program.imported:
        source = source.with_import(file.name, file.text)
    modules = (original.module, *dict.fromkeys(file.module for file in imports.values()))
    names = _copied_names(source, name)
    edits = [
        *_param_edits(program, scenes.genomes[row], original.overrides, modules),
        *_variant_edits(program, scenes, row, source),
        *_import_edits(imports, source, modules, names),
        *_mutation_edits(modules, source),
        *_map_edits(program, modules),
        *_road_edits(program, modules),
        _simulation_edit(original, StreamKey(*scenes.keys[row].tolist()), source),
    ]
    edits = list(_requoted(edits, modules, source))
    texts = {names[file.start]: _apply(file, edits) for file in source.files}
    texts[name] = "".join(f"# {line}\n" for line in remark.splitlines()) + texts[name]
    return {file: _laid_out(file, text) for file, text in texts.items()} if laid_out else texts


def _laid_out(name: str, text: str) -> str:
    """Return the text in the layout of `cortexc fmt`; sampled values make lines longer."""
    try:
        return format_copy(Source(name, text))
    except CompileError:
        return text  # compiling it shows why


def _copied_names(source: Source, name: str) -> dict[int, str]:
    """Names of the copies, by the offset at which their originals begin."""
    stem = PurePath(name).stem
    names = {0: name}
    for file in source.imported:
        wanted = f"{stem}.{PurePath(file.name).stem}"
        taken = sum(each.startswith(f"{wanted}.") for each in names.values())
        names[file.start] = f"{wanted}.{taken + 1}.scn" if taken else f"{wanted}.scn"
    return names


def _apply(file: FileText, edits: Sequence[Edit]) -> str:
    """Apply all edits of a file at once.

    An edit inside another one is dropped, since the outer one replaces its text anyway. An insertion between two
    characters precedes an edit that begins there.
    """
    result, position, text = [], 0, file.text
    for edit in sorted(edits, key=lambda edit: (edit.span.start, edit.span.end > edit.span.start, -edit.span.end)):
        start, end = edit.span.start - file.start, edit.span.end - file.start
        if start < position or end > len(text):
            continue
        result += [text[position:start], edit.text]
        position = end
    return "".join([*result, text[position:]])


def _requoted(edits: Sequence[Edit], modules: Sequence[nodes.Module], source: Source) -> Iterator[Edit]:
    """Yield the edits with the other quotes if an edit lies in a text with values that begins with these."""
    found = (node.span for module in modules for node in everything_in(module) if isinstance(node, nodes.Formatted))
    texts = [span for span in found if source.slice(span)[1] == '"']
    for edit in edits:
        if '"' in edit.text and any(span.start < edit.span.start and edit.span.end < span.end for span in texts):
            text = edit.text.replace("'", r"\x27").replace(r"\"", r"\x22").replace('"', "'")
            yield Edit(edit.span, text)
        else:
            yield edit


def _import_edits(
    imports: Imports, source: Source, modules: Sequence[nodes.Module], names: Mapping[int, str]
) -> Iterator[Edit]:
    """Imports read the copies."""
    for statement in (s for module in modules for s in import_statements(module)):
        path = f'"{names[source.file(imports[statement.span].module.span.start).start]}"'
        if isinstance(statement, nodes.Import):
            yield Edit(statement.span, f"import {path} as {bound_name(statement)}")
        else:
            yield Edit(statement.path_span, path)


def _mutation_edits(modules: Sequence[nodes.Module], source: Source) -> Iterator[Edit]:
    """Leave the statement out: the drawn poses contain the noise already."""
    for node in (n for module in modules for n in everything_in(module) if isinstance(n, nodes.Mutate)):
        yield Edit(node.span, f"pass  # {source.slice(node.span)}")


def _map_edits(program: Program, modules: Sequence[nodes.Module]) -> Iterator[Edit]:
    """Yield edits so that the map file next to the copy is used."""
    spec = program.road_spec
    if not isinstance(spec, MapFile):
        return
    entries = (entry.value for module in modules for name, entry in param_entries(module).items() if name == "map")
    statements = (each for module in modules for each in module.statements if isinstance(each, nodes.Map))
    # Such as `localPath(FILE)` and `map opendrive(FILE)`, whatever expression names the file.
    calls = (each for each in (*entries, *statements) if not isinstance(each, nodes.Map) or each.kind == spec.kind)
    for call in calls:
        arguments = call.arguments if isinstance(call, nodes.Map | nodes.Call) else ()
        files = [each for each in arguments if each.name in (None, "file")]
        yield Edit((files[0].value if files else call).span, f'"{map_name(spec)}"')


def _road_edits(program: Program, modules: Sequence[nodes.Module]) -> Iterator[Edit]:
    """The road of a file without `map` follows from its words, of which a copy has fewer."""
    spec = program.road_spec
    said = any(isinstance(each, nodes.Map) for module in modules for each in module.statements)
    if isinstance(spec, RoadSpec) and spec != RoadSpec() and not said:
        start = modules[0].statements[0].span.start
        yield Edit(Span(start, start), f"{map_line(spec)}\n")


def map_copies(program: Program) -> dict[str, bytes]:
    """Return the files that a concrete file needs next to it: its map file, as it was read."""
    spec = program.road_spec
    return {map_name(spec): Path(spec.path).read_bytes()} if isinstance(spec, MapFile) else {}


def _param_edits(
    program: Program, genome: Sequence[float], overrides: Mapping[str, str], modules: Sequence[nodes.Module]
) -> Iterator[Edit]:
    genes = {name: index for index, name in enumerate(program.space.names)}
    for entry in (each for module in modules for each in all_params(module)):
        if entry.name in overrides:
            yield Edit(entry.value.span, override_text(entry, overrides[entry.name]))
        elif entry.name in genes:
            yield Edit(entry.value.span, gene_text(program, genes[entry.name], float(genome[genes[entry.name]])))
    declared = {entry.name for module in modules for entry in all_params(module)}
    model = next(filter(None, map(scenic_model, modules)), None)
    if model is not None and (outside := overrides.keys() - declared):
        lines = (f"param {name} = {text}\n" for name, text in overrides.items() if name in outside)
        yield Edit(Span(model.span.start, model.span.start), "".join(lines))


def gene_text(program: Program, gene: int, value: float) -> str:
    """A gene's value as the file would write it, with every digit; `value` in its unit, which stays away if bare."""
    space = program.space
    unit = "" if space.names[gene] in space.bare else space.units[gene]
    match GeneKind(space.kinds[gene]):
        case GeneKind.INDEX:
            return space.options[gene][int(value)]
        case GeneKind.INTEGER:
            return _number(int(value), unit)
        case GeneKind.CONTINUOUS:
            return _number(value, unit)


def _number(value: float, unit: str) -> str:
    return f"{value!r} {unit}".rstrip()


def _variant_edits(program: Program, scenes: Scenes, row: int, source: Source) -> Iterator[Edit]:
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
        text = _site_text(evaluated[0], drawn)
        if not evaluated[0].kind.endswith(" added"):
            yield Edit(span, text)
        else:
            yield Edit(span, f"{source.slice(span)} {text}{_comma(source, span)}")


def _comma(source: Source, span: Span) -> str:
    """Return the separator after a specifier that is inserted after a class name."""
    rest = source.whole[span.end :].lstrip(" ")
    return "" if not rest or rest[0] in "\r\n#,)]}" else ","


def _successive(texts: Sequence[str]) -> str:
    """One value, or those that successive evaluations of the same place had (in a comprehension, say)."""
    return texts[0] if len(texts) == 1 else f"Fixed({', '.join(texts)})"


DRAWN_FROM: Mapping[str, str] = {"lane": "lanes", **{name: name for name in LISTED_IN.values() if name}}
"""Tuples of the network from which a scene draws elements, by the kind of the site."""


def _site_text(site: DrawSite, drawn: Sequence[Sequence[float]]) -> str:
    if site.kind == "number":
        return _successive([_number(values[0], site.unit) for values in drawn])
    if (listed := DRAWN_FROM.get(site.kind)) is not None:
        return _successive([f"network.{listed}[{int(values[0])}]" for values in drawn])
    if site.kind == "heading":
        return f"facing {_successive([_number(values[0], 'rad') for values in drawn])}"
    place = _successive([f"({values[0]!r} m, {values[1]!r} m)" for values in drawn])
    if site.kind.startswith("point"):
        return f"at {place}"
    return f"at {place}, facing {_successive([_number(values[2], 'rad') for values in drawn])}"


def _simulation_edit(original: Original, key: StreamKey, source: Source) -> Edit:
    """Return the edit of the `simulation(...)` statement, which fixes settings that the file leaves open.

    The stream is fixed too: samples of soft requirements and random numbers inside behaviours come from it.
    """
    config, module = original.config, original.module
    settings = [f"time_step={config.time_step!r} s", f"max_attempts={config.max_attempts}"]
    if not any(isinstance(statement, nodes.TerminateAfter) for statement in module.statements):
        settings.append(f"max_time={config.max_time!r} s")
    scenario = original.scenario or pinned_scenario(module)
    if scenario is not None:
        settings.append(f'scenario="{scenario}"')
    stated = [each for each in module.statements if isinstance(each, nodes.Simulation)]
    late = (each.value for statement in stated for each in statement.arguments if each.name == "late")
    settings += [f"late={source.slice(value.span)}" for value in late]
    text = f'simulation({", ".join(settings)}, stream="{format_key(key)}")'
    for statement in module.statements:
        if isinstance(statement, nodes.Simulation):
            return Edit(statement.span, text)
    end = len(source.text.rstrip())
    return Edit(Span(end, len(source.text)), f"\n\n{text}\n")
