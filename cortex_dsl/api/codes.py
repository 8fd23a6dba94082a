"""All codes of diagnostics, with their pages; each is declared next to its check."""

from collections.abc import Iterator
from dataclasses import dataclass

from cortex_dsl.diagnostics import CompileError, Diagnostic, Page, Severity
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


@dataclass(frozen=True)
class Entry:
    """One code with its page."""

    code: str
    severity: Severity
    page: Page | None

    @property
    def title(self) -> str:
        return self.page.title if self.page else ""

    @property
    def family(self) -> str:
        return FAMILIES[self.code[3]]


def entries() -> tuple[Entry, ...]:
    """Return every code, in the order of their numbers."""
    return tuple(sorted(_declared(), key=lambda entry: entry.code))


def _declared() -> Iterator[Entry]:
    for code in syntax.CODES:
        yield Entry(code.id, Severity.NOTE if code is syntax.TOO_MANY else Severity.ERROR, code.page)
    for problem in declared().values():
        yield Entry(problem.code, problem.severity, problem.page)


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
