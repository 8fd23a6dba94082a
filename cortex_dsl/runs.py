"""Runs on disk: a journal alone is enough to compile its scenario again and to go on with what was done with it.

>>> from cortex_dsl.runs import open_run
>>> run = open_run("runs/left_turn-ga-001")
>>> run.record.evaluations.collided.sum()
>>> run.scenario.watch(run.scenario.scene_of(genome, key))
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from errno import ENOENT
from pathlib import Path

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.semantics.composition.imports import import_statements
from cortex_dsl.session import Scenario
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.reading import read_source
from engine.search.journal_reader import Record, read_journal
from engine.search.manifest import Link, Manifest, Origin, Text
from engine.search.protocol import Box
from engine.search.ranking import Case, order_of_risk, worst_cases
from engine.search.run import follow
from engine.search.searchers import build_searcher
from engine.search.store import JOURNAL, StoreError, example_run
from engine.study.database import is_study
from engine.vocabulary import GeneKind

WORST = 10
"""Cases of which the run's folder has a scenario each; no two of them are nearly the same."""


@dataclass(frozen=True)
class OpenedRun:
    """A run and the scenario that it searched, compiled from the texts that its journal keeps."""

    folder: Path
    record: Record
    scenario: Scenario
    """With the settings of the run."""
    edited: tuple[str, ...]
    """Files that say something else now; the run goes by what they said when it was started."""


@dataclass(frozen=True)
class KeptFiles:
    """The imported files of a manifest, as a compiler asks for them (see `cortex_dsl.files.Files`)."""

    origin: Origin

    def find(self, importer: str, paths: Sequence[str]) -> str | None:
        links = (link for link in self.origin.links if (link.importer, link.path) == (importer, paths[0]))
        return next((link.name for link in links), None)

    def read(self, name: str) -> Source:
        for file in self.origin.imports:
            if file.name == name:
                return Source(name, file.text)
        raise FileNotFoundError(ENOENT, "the journal does not hold its text", name)

    def identity(self, name: str) -> str:
        return name

    def beside(self, importer: str, path: str) -> list[str]:  # noqa: ARG002 - asked for spellings, which a journal has right
        return []


def open_run(folder: str | Path) -> OpenedRun:
    """Read a run directory and compile its scenario.

    Raises:
        StoreError: there is no readable journal, or this version of cortexc compiles the scenario to something else.
    """
    folder = _run_folder(Path(folder))
    record = read_journal(folder / JOURNAL)
    manifest = record.manifest
    compiled = _compiled(folder, manifest)
    origin = manifest.origin
    scenario = Scenario(compiled, manifest.config, origin.overrides, origin.scenario)
    return OpenedRun(folder, record, scenario, tuple(_edited(manifest)))


def check_journal(run: OpenedRun) -> None:
    """Whether a journal follows from its own beginning: a new searcher, told the results one generation after the
    other, must propose every individual of it, by the same operator and from the same parents. Nothing is simulated.

    Raises:
        ForeignPastError: it does not.
        UnknownMethodError, MissingExtraError, PluginError: there is no such searcher here.
    """
    space, config = run.scenario.program.space, run.scenario.config
    manifest = run.record.manifest
    searcher = build_searcher(manifest.method, Box.of(space), config, manifest.method_number)
    follow(searcher, run.record.past())


def _run_folder(path: Path) -> Path:
    """The folder of a run, named itself or by its journal."""
    folder = path.parent if path.name == JOURNAL else path
    if (folder / JOURNAL).exists():
        return folder
    if not folder.exists():
        names = [each.name for each in folder.parent.iterdir() if each.is_dir()] if folder.parent.is_dir() else []
        near = nearest(folder.name, names)
        cure = (
            f"did you mean `{folder.with_name(near)}`?"
            if near
            else f"name the folder of a run, such as {example_run()}"
        )
        raise StoreError(f"there is no folder `{folder}`", cure)
    if not folder.is_dir():
        raise StoreError(f"`{folder}` is no folder", f"name the folder of a run, such as {example_run()}")
    if inside := sorted(each.parent for each in folder.glob(f"*/{JOURNAL}")):
        raise StoreError(f"`{folder}` holds {len(inside)} runs", f"name one of them, such as `{inside[0]}`")
    if is_study(folder):
        raise StoreError(f"`{folder}` is a study, and no single run", f"`cortexc report {folder}` tells it")
    raise StoreError(
        f"there is no journal in `{folder}`", "if a search into it was ended before it began, start that search again"
    )


def origin_of(scenario: Scenario) -> Origin:
    """What a manifest keeps of a scenario beside its main text."""
    compiled = scenario.compiled
    imports = tuple(Text(file.name, file.text) for file in compiled.source.imported)
    return Origin(imports, tuple(_links(compiled)), dict(scenario.overrides), scenario.chosen)


def _links(compiled: Compiled) -> Iterator[Link]:
    """The file behind each import statement, of the main file and of all others."""
    modules: dict[str, nodes.Module] = {compiled.source.name: compiled.module}
    modules |= {file.name: file.module for file in compiled.imports.values()}
    for importer, module in modules.items():
        for statement in import_statements(module):
            if statement.span in compiled.imports:
                yield Link(importer, _first_path(statement), compiled.imports[statement.span].name)


def _first_path(node: nodes.Import | nodes.ImportFrom) -> str:
    return node.path if node.quoted else node.path.replace(".", "/") + ".scn"


def _compiled(folder: Path, manifest: Manifest) -> Compiled:
    """The program of the manifest, and no other."""
    wrote = manifest.versions.get("cortexc", "unknown")
    cure = f"use the version that started it, cortexc {wrote}; what it found can still be read from its journal"
    source, origin = Source(manifest.file, manifest.file_text), manifest.origin
    overrides: Mapping[str, str] = origin.overrides
    try:
        compiled = compile_source(source, overrides, scenario=origin.scenario, files=KeptFiles(origin))
    except CompileError as error:
        raise StoreError(f"this version of cortexc does not compile the scenario of `{folder}`", cure) from error
    if compiled.program.digest != manifest.program_digest:
        raise StoreError(f"this version of cortexc compiles the scenario of `{folder}` to another program", cure)
    return compiled


def _edited(manifest: Manifest) -> Iterator[str]:
    """Files of the run that are there and differ."""
    for file in (Text(manifest.file, manifest.file_text), *manifest.origin.imports):
        with suppress(OSError, ValueError):
            if _text_of(file.name) != file.text:
                yield file.name


def _text_of(name: str) -> str | None:
    """The text of a file as the compiler reads it; None where it could not."""
    try:
        return read_source(name).text
    except CompileError:
        return None


# -- its cases by number: those of its folder `worst` first, then all others, worst first ------------------------------


def every_case(record: Record) -> tuple[Case, ...]:
    """Every genome with a valid simulation. Number 7 is `worst/07.scn`; from 11 on it is what is left."""
    evaluations = record.evaluations
    first = worst_cases(evaluations, WORST, box_of(record))
    taken = {case.row for case in first}
    rest = [c for c in worst_cases(evaluations, len(order_of_risk(evaluations))) if c.row not in taken]
    return (*first, *(replace(case, rank=rank) for rank, case in enumerate(rest, start=len(first) + 1)))


def first_cases(record: Record, count: int) -> tuple[Case, ...]:
    """The first `count` of them."""
    return every_case(record)[:count]


def box_of(record: Record) -> Box:
    """The space that a run searched."""
    rows = record.manifest.parameters
    return Box(
        tuple(p.name for p in rows),
        tuple(p.low for p in rows),
        tuple(p.high for p in rows),
        tuple(GeneKind(p.kind) for p in rows),
    )
