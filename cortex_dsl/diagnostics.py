"""Diagnostics of the compiler for a file: data only. `cortex_dsl.report.findings.snippet` draws them."""

from collections.abc import Iterable
from enum import Enum
from html import escape

from cortex_dsl.source import Source, Span
from engine.errors import CortexError
from engine.frozen import frozen


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"
    """Interpretation of a text that leaves it open."""
    HINT = "hint"
    """Better form of correct text; `--check` shows it, runs do not."""


@frozen
class Label:
    """A place in the source and its text; an empty text draws the carets alone."""

    span: Span
    text: str = ""


@frozen
class Diagnostic:
    """One finding: the error (`message`), its place, the reason (`reason`), and how to correct it (`cure`)."""

    code: str
    """Stable: SCN1xx syntax, SCN2xx names, SCN3xx units and types, SCN4xx values and meaning, SCN5xx random
    structure and sampling, SCN6xx behaviours."""
    message: str
    label: Label
    severity: Severity = Severity.ERROR
    secondary: tuple[Label, ...] = ()
    reason: str = ""
    cure: str = ""


class CompileError(CortexError):
    """The one exception that carries diagnostics out of the compiler; message and cure are those of the first error.

    `drawn` is its text with the marked lines of the source, where the code that raises it can draw them.
    """

    def __init__(self, source: Source, diagnostics: Iterable[Diagnostic], drawn: str = "") -> None:
        self.source = source
        self.diagnostics = tuple(diagnostics)
        self.drawn = drawn
        first = next((d for d in self.diagnostics if d.severity is Severity.ERROR), None)
        super().__init__(f"{first.code}: {first.message}" if first else "", first.cure if first else "")

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"

    def _render_traceback_(self) -> list[str]:
        """Return the errors without a traceback, for IPython: all frames are ours, none is the file's."""
        return str(self).strip("\n").splitlines()

    def __str__(self) -> str:
        return self.drawn or "; ".join(
            f"{d.code}: {d.message}{f' ({d.cure})' if d.cure else ''}" for d in self.diagnostics
        )
