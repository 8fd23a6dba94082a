"""All codes of diagnostics. The folder of a code holds its page, its two examples and the expected output of the first:
`page.md`, `wrong.scn`, `right.scn`, `said.txt`.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from importlib.resources.abc import Traversable

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.files import DISK
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.errors import declared
from cortex_dsl.semantics.names.linking import link
from cortex_dsl.source import Source
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import errors as syntax
from cortex_dsl.syntax import parse

FAMILIES = {
    "1": "syntax",
    "2": "names",
    "3": "units and types",
    "4": "values and meaning",
    "5": "what is random",
    "6": "behaviors and runs",
}
"""Titles by the first digit of a code."""
PAGE = re.compile(r"(?:---\n(?P<fields>.*?)---\n)?# (?P<title>[^\n]+)\n\n(?P<why>.+)", re.DOTALL)
"""Layout of `page.md`: optional lines `NAME: VALUE`, the title, the text."""


@dataclass(frozen=True)
class Page:
    """Text and examples of a code, as `cortexc explain` prints them."""

    title: str
    why: str
    wrong: str
    """The smallest whole program that raises the code; empty if no single file does."""
    right: str
    """The same program, corrected."""
    options: tuple[str, str]
    """The `-p NAME=VALUE` that `wrong` and `right` are compiled with."""
    shown: str
    """The occasion at which the code is raised, if it is not the compilation of `wrong`: `while the file is read`."""


@dataclass(frozen=True)
class Entry:
    """One code with its page."""

    code: str
    severity: Severity

    @cached_property
    def page(self) -> Page:
        """The page in the folder of the code, which is read when it is first used."""
        home = folder(self.code)
        page = PAGE.fullmatch((home / "page.md").read_text(encoding="utf-8"))
        assert page is not None, self.code
        fields = dict(line.split(": ", 1) for line in (page["fields"] or "").splitlines())
        assert fields.keys() <= {"shown", "wrong", "right"}, self.code
        programs = (program(home / "wrong.scn"), program(home / "right.scn"))
        options = (fields.get("wrong", ""), fields.get("right", ""))
        return Page(page["title"], " ".join(page["why"].split()), *programs, options, fields.get("shown", ""))

    @property
    def title(self) -> str:
        return self.page.title

    @property
    def family(self) -> str:
        return FAMILIES[self.code[3]]


def folder(code: str) -> Traversable:
    """Return the folder with the page and the examples of a code."""
    return files(__name__) / code


def program(file: Traversable) -> str:
    """Return the text of an example; the one that is not UTF-8, as its page says, is Latin-1."""
    if not file.is_file():
        return ""
    held = file.read_bytes()
    try:
        return held.decode("utf-8")
    except UnicodeDecodeError:
        return held.decode("latin-1")


def entries() -> tuple[Entry, ...]:
    """Return every code, in the order of their numbers."""
    return tuple(sorted(_declared(), key=lambda entry: entry.code))


def _declared() -> Iterator[Entry]:
    for row in (*syntax.CODES, *declared().values()):
        yield Entry(row.code, row.severity)


def find(text: str) -> Entry | None:
    """Return the code that a person means by `SCN203`, `scn203` or `203`; None if there is no such code."""
    number = text.strip().upper().removeprefix("SCN")
    return next((entry for entry in entries() if entry.code == f"SCN{number}"), None)


def near(text: str) -> list[Entry]:
    """Return codes that may be meant: those of nearly the same number, or with nearly that title."""
    known = {entry.code: entry for entry in entries()}
    digits = "".join(character for character in text if character in "0123456789")
    if digits:
        distances = sorted(known, key=lambda code: abs(int(code[3:]) - int(digits[:6])))
        return [known[code] for code in distances[:3]]
    title = nearest(text, [entry.title for entry in known.values()])
    return [entry for entry in known.values() if entry.title == title]


def judged(name: str, text: str, option: str = "") -> tuple[Source, tuple[Diagnostic, ...]]:
    """Return the diagnostics of a text compiled under one `-p NAME=VALUE`, and the source that they refer to."""
    source = Source(name, text)
    parameter, _, value = option.partition("=")
    try:
        module = parse(source)
        linked = link(module, source, DISK)
        overrides = {parameter: value} if option else {}
        return linked.source, elaborate(module, linked.source, overrides, imports=linked.files)[1]
    except CompileError as error:
        return error.source, error.diagnostics
