"""What the product says and writes, subject by subject: name and text of each, made by running it.

Two runs of one version give the same texts. What differs from run to run, or from machine to machine, is left out:
how long something took, where the files lie, and the versions of other packages.
"""

import contextlib
import io
import os
import re
import shutil
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pyarrow.parquet

from cortex_dsl import pipeline
from cortex_dsl.cli import analyse, main
from cortex_dsl.cli.command_table import SUBCOMMANDS
from cortex_dsl.report.terminal.kernel_progress import COMPILED
from cortex_dsl.semantics.model import state
from cortex_dsl.source import Source
from engine.search.insight import analysis
from engine.search.searchers import SEARCHERS

ROOT = Path(__file__).parent.parent.parent
EXAMPLE = "examples/left_turn.scn"
SMALL = ("--generations", "3", "--population", "20", "--seed", "1")
STUDY = ("--methods", "ga,random", "--runs", "2", "--generations", "2", "--population", "10")
EXPORTS = "xosc,xodr,commonroad,scenic,csv,parquet,mcap,scn"
TABLES = ("generation", "individual", "simulation")
"""What a journal holds of a search; its manifest and its pace are no part of it."""
_TIME = r"(?:\d+ h )?(?:\d+ min )?[\d.,]+ (?:m?s|min|h)"
DURATIONS = re.compile(
    rf"in {_TIME}, [\d.,]+ a second|[\d.,]+ simulations a second +{_TIME} left|{_TIME} of work"
    rf"|(?<=It took ){_TIME}"
    r"|(?<=name=\"checksum\" content=\")[0-9a-f]+"  # it covers durations, as does the seal of a study
    r"|(?<=name=\"journal\" content=\")[0-9a-f]+"
    r"|(?<=, )[\d.,e-]+ (?:a|per) second"
    r"|\"(seconds|seconds_per_simulation|simulations_per_second|runs_per_second|jobs)\": ?\"?[\d.e+-]+\"?"
    r"|\"engine\": ?\"[0-9a-f]{16}\""
    r"|\"per_second\": ?(\{[^}]*\}|null|[\d.e+-]+)"
    r"|\"(cortexc|lark|llvmlite|numba|numpy|pymunk|python|scipy)\": ?\"[^\"]*\""
    r"|(?<=versions</th><td>)[^<]*"
    r"|(?<=\.parquet) +[\d.]+ kB"
)
"""What depends on a machine: durations, number of processes, versions of packages, and the digest of the sources."""

ROUNDED = f" (numpy {version('numpy')}, scipy {version('scipy')})"
"""Behind the names of subjects whose last bits differ between versions of these."""
CURVED = ("examples/roads/village.scn",)
"""Files with roads whose arcs are fitted to curves of other kinds."""

Subjects = Iterator[tuple[str, str]]


def command(*words: str, at: Path = ROOT) -> str:
    """Exit code, stdout and stderr of a command, 80 columns wide and 24 lines high, without its durations."""
    out, err = io.StringIO(), io.StringIO()
    with _standing(at), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([*words])
    said = COMPILED.sub("", err.getvalue())  # said by whoever comes first, or after the cache was tidied
    return DURATIONS.sub("DURATION", f"exit {code}\n{out.getvalue()}\n-- stderr --\n{said}")


@contextlib.contextmanager
def _standing(at: Path) -> Iterator[None]:
    """In a folder, before a terminal of one size, at no date of its own."""
    before, names = Path.cwd(), ("COLUMNS", "LINES", "SOURCE_DATE_EPOCH")
    values = {name: os.environ.pop(name, None) for name in names}
    os.environ.update(COLUMNS="80", LINES="24")
    os.chdir(at)
    try:
        yield
    finally:
        os.chdir(before)
        for name, value in values.items():
            os.environ.pop(name, None) if value is None else os.environ.update({name: value})


def scenarios() -> list[str]:
    """Every scenario of the repository, by its path from the root."""
    folders = ("examples", "tests")
    return sorted(str(path.relative_to(ROOT)) for folder in folders for path in (ROOT / folder).rglob("*.scn"))


@contextlib.contextmanager
def _less_patience() -> Iterator[None]:
    """A file that takes too long to work out is given up after a tenth of what users wait."""
    before, state.EVALUATION_LIMIT = state.EVALUATION_LIMIT, state.EVALUATION_LIMIT // 10
    try:
        yield
    finally:
        state.EVALUATION_LIMIT = before


@contextlib.contextmanager
def _compiled_once() -> Iterator[None]:
    """All modes that look at a file see what one compilation of it gave."""
    compile_source, known = pipeline.compile_source, dict[Any, Any]()

    def once(source: Source, *arguments: Any, **options: Any) -> Any:
        key = (source.name, source.text, repr(arguments), repr(options))
        if key not in known:
            known[key] = compile_source(source, *arguments, **options)
        return known[key]

    pipeline.compile_source = once
    try:
        yield
    finally:
        pipeline.compile_source = compile_source


@contextlib.contextmanager
def _analysed_once() -> Iterator[None]:
    """The commands that show the analysis of one run in several forms see one analysis."""
    known: list[Any] = []

    def once(*arguments: Any, made: Callable[..., Any] = analyse.analyse) -> Any:
        known[:] = known or [made(*arguments)]
        return known[0]

    with patch.object(analyse, "analyse", once):
        yield


@contextlib.contextmanager
def _designed_once() -> Iterator[None]:
    """The commands that show which params matter in one run see one design of simulations."""
    known = dict[tuple[int, int], Any]()

    def once(space: Any, evaluate: Any, budget: int, seed: int, made: Callable[..., Any] = analysis.sensitivity) -> Any:
        if (budget, seed) not in known:
            known[budget, seed] = made(space, evaluate, budget, seed)
        return known[budget, seed]

    with patch.object(analysis, "sensitivity", once):
        yield


def files(paths: Sequence[str]) -> Subjects:
    """What `cortexc FILE --check` says of each file; where that finds no mistake, what the other modes say."""
    for path in paths:
        with _less_patience(), _compiled_once():
            yield f"check {path}", (checked := command(path, "--check"))
            if checked.startswith("exit 0\n"):
                for mode, words in MODES.items():
                    yield f"{mode} {path}{ROUNDED if path in CURVED else ''}", command(path, *words)


def helps(_: Path) -> Subjects:
    """`--help` of every command, and the lists that commands print."""
    yield "help", command("--help")
    yield "help-all", command("--help-all")
    for name in SUBCOMMANDS:
        yield f"help {name}", command(name, "--help")
    yield "methods", command("--method", "list")
    yield "explain", command("explain")
    yield "paper-check", command("paper-check")
    yield "paper-check json", command("paper-check", "--json")


def searches(folder: Path) -> Subjects:
    """A search of 3 generations of 20 by each of our methods: its journal row by row, and its tables."""
    yield from _searches(folder, {name: name for name, entry in SEARCHERS.items() if not entry.package})


def package_searches(folder: Path) -> Subjects:
    """The same by methods of other packages, whose sums and exponentials differ between processors."""
    packages = {name: entry.package for name, entry in SEARCHERS.items() if entry.package}
    yield from _searches(folder, {name: f"{name} ({each} {version(each)})" for name, each in packages.items()})


def _searches(folder: Path, methods: Mapping[str, str]) -> Subjects:
    for method, by in methods.items():
        yield f"search {by}", command(_example(folder), "--method", method, *SMALL, "--out", method, at=folder)
        yield f"journal {by}", journal(folder / method / "journal.sqlite")
        for path in sorted([*folder.glob(f"{method}/*.csv"), *folder.glob(f"{method}/worst/*.scn")]):
            yield f"search {by} {path.name}", path.read_text(encoding="utf-8")


def _example(folder: Path) -> str:
    """The example, copied to where a command stands, so that no path of this machine comes into what it writes."""
    shutil.copyfile(ROOT / EXAMPLE, folder / "left_turn.scn")
    return "left_turn.scn"


def journal(path: Path) -> str:
    """Every row of a search, as text."""
    with contextlib.closing(sqlite3.connect(path)) as store:
        rows = [f"{table} {row!r}" for table in TABLES for row in store.execute(f"select * from {table}")]
        schema = [str(sql) for (sql,) in store.execute("select sql from sqlite_master order by name")]
        manifest = [f"{name} {value}" for name, value in store.execute("select * from manifest order by field")]
    return "\n".join([*schema, *(line for line in manifest if not line.startswith("versions ")), *rows])


def exports(folder: Path) -> Subjects:
    """One case in every format, byte for byte, in both modes of OpenSCENARIO."""
    command(_example(folder), "--ga", *SMALL, "--out", "run", "--json", at=folder)
    for name, words in (("trajectory", ["--to", EXPORTS]), ("maneuver", ["--to", "xosc", "--mode", "maneuver"])):
        yield f"export {name}", command("export", "run", *words, "--check", "--out", name, at=folder)
        for path in sorted((folder / name).iterdir()):
            yield f"export {name} {path.name}", _content(path)


def _content(path: Path) -> str:
    """The bytes of a file; of Parquet, whose bytes are its library's, all columns and values."""
    if path.suffix != ".parquet":
        return path.read_bytes().decode("latin-1")
    table: Any = pyarrow.parquet.read_table(path)
    return f"{table.schema.to_string(show_schema_metadata=True)}\n{table.to_pydict()}"


def views(folder: Path) -> Subjects:
    """What the terminal shows of a scene, of sampling, of a search and of what is asked of a run afterwards."""
    yield "view run", command(_example(folder), "--seed", "4", at=folder)
    yield "view world", command("left_turn.scn", "--seed", "4", "--engine", "world", "--json", at=folder)
    yield "view sample", command("left_turn.scn", "--sample", "--seed", "4", at=folder)
    yield "view search", command("left_turn.scn", "--ga", *SMALL, "--out", "run", at=folder)
    with _designed_once():
        with _analysed_once():
            yield "view analyse", command("analyse", "run", at=folder)
            yield f"view analyse json{ROUNDED}", command("analyse", "run", "--json", at=folder)
        yield "view probability", command("probability", "left_turn.scn", "--samples", "500", at=folder)
        yield "view replay", command("replay", "run", at=folder)
        yield "view report", command("report", "run", "--out", "page.html", at=folder)
    for path in (folder / "run" / "summary.json", folder / "run" / "README.md", folder / "page.html"):
        rounded = ROUNDED if path.suffix == ".html" else ""
        yield f"view {path.name}{rounded}", DURATIONS.sub("DURATION", path.read_text(encoding="utf-8"))


def study(folder: Path) -> Subjects:
    """A study of two methods, two runs each: what it says, and its tables."""
    yield "study", command("study", _example(folder), *STUDY, "--out", "study", at=folder).partition("-- stderr --")[0]
    for path in sorted((folder / "study").glob("*.csv")):
        yield f"study {path.name}", DURATIONS.sub("DURATION", path.read_text(encoding="utf-8"))


def documents(folder: Path) -> Subjects:
    """The JSON document of every command that has one, each over one small input, and the page of a study."""
    file = _example(folder)
    lines = {
        "examples": ["examples"],
        "explain": ["explain"],
        "explain SCN203": ["explain", "SCN203"],
        "check": [file, "--check"],
        "sample": [file, "--sample", "200", "--seed", "4"],
        "search": [file, "--ga", *SMALL, "--out", "run"],
        "resume": ["resume", "run"],
        "verify": ["verify", "run"],
        "export": ["export", "run", "--to", "xosc,csv", "--out", "cases"],
        "measure": ["measure", "cases/left_turn-case01.csv"],
        "import": ["import", "cases/left_turn-case01.xosc"],
        "probability": ["probability", file, "--samples", "500"],
        "study": ["study", file, *STUDY, "--out", "study"],
    }
    for name, words in lines.items():
        rounded = ROUNDED if name in ("probability", "study") else ""
        yield f"document {name}{rounded}", command(*words, "--json", at=folder)
    command("report", "study", at=folder)
    yield (
        f"document study.html{ROUNDED}",
        DURATIONS.sub("DURATION", (folder / "study" / "report.html").read_text("utf-8")),
    )


MADE: dict[str, Callable[[Path], Subjects]] = {
    "documents": documents,
    "helps": helps,
    "searches": searches,
    "exports": exports,
    "views": views,
    "study": study,
}
"""Subjects that are no scenario files; each is given an empty folder."""
ON_THE_OLDEST: dict[str, Callable[[Path], Subjects]] = {
    "searches": searches,
    "views": views,
    "package_searches": package_searches,
}
"""Subjects that are made as the oldest processor makes them, too, or only so."""
MODES = {"ir": ("--emit", "ir"), "program": ("--emit", "program"), "run": ("--json",)}
