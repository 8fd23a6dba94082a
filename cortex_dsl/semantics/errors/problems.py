"""The shape of a declared diagnostic, the exceptions by which elaboration gives up on a value or a variant, and the
findings that it collects over all variants.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

from cortex_dsl.diagnostics import Diagnostic, Label, Severity
from cortex_dsl.source import Span
from engine.errors import Signal
from engine.frozen import frozen


@frozen
class Problem:
    """One kind of finding. Texts are `str.format` templates over the fields passed to `at`."""

    code: str
    message: str
    reason: str = ""
    cure: str = ""
    severity: Severity = Severity.ERROR

    def at(self, span: Span, *, secondary: tuple[Label, ...] = (), label: str = "", **fields: object) -> Diagnostic:
        """The problem at a place, its texts filled in."""
        return Diagnostic(
            code=self.code,
            message=self.message.format(**fields),
            label=Label(span, label),
            severity=self.severity,
            secondary=secondary,
            reason=self.reason.format(**fields),
            cure=self.cure.format(**fields),
        )

    def mistake(self, span: Span, *, secondary: tuple[Label, ...] = (), label: str = "", **fields: object) -> "Mistake":
        """An exception that carries this problem to the nearest place that can go on without the value."""
        return Mistake(self.at(span, secondary=secondary, label=label, **fields))


class Mistake(Signal):
    """A value cannot be computed. `diagnostic` is None when the cause has been reported already."""

    def __init__(self, diagnostic: Diagnostic | None = None) -> None:
        super().__init__("" if diagnostic is None else diagnostic.message)
        self.diagnostic = diagnostic


class Rejection(Signal):
    """A variant is impossible: a random choice has nothing to choose from."""

    def __init__(self, reason: str, span: Span) -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span


class NeedsExpansion(Signal):
    """A value that was left symbolic is needed concretely: enumerate these sites (spans) instead and start again."""

    def __init__(self, sites: frozenset[Span]) -> None:
        super().__init__(str(sites))
        self.sites = sites


warning = partial(Problem, severity=Severity.WARNING)
note = partial(Problem, severity=Severity.NOTE)
hint = partial(Problem, severity=Severity.HINT)


# -- findings ----------------------------------------------------------------------------------------------------------


@dataclass
class Findings:
    """Diagnostics, each once whatever variants it comes from."""

    _found: dict[tuple[Severity, Span], dict[str, Diagnostic]] = field(default_factory=dict)
    _settled: frozenset[Span] = frozenset()
    """Places where an earlier stage found errors: further ones there are consequences."""

    def add(self, diagnostic: Diagnostic) -> None:
        """Keep one finding; a place has each code at most once, the first."""
        if diagnostic.severity is Severity.ERROR and self.is_settled(diagnostic.label.span):
            return
        here = self._found.setdefault((diagnostic.severity, diagnostic.label.span), {})
        here.setdefault(diagnostic.code, diagnostic)

    def __iter__(self) -> Iterator[Diagnostic]:
        """In the order of the file."""
        return iter(sorted((d for here in self._found.values() for d in here.values()), key=lambda d: d.label.span))

    def copy(self) -> "Findings":
        """The same, for the next stage."""
        copied = Findings()
        for finding in self:
            copied.add(finding)
        copied._settled = frozenset(span for severity, span in self._found if severity is Severity.ERROR)
        return copied

    def is_settled(self, span: Span) -> bool:
        """Whether an earlier stage reported an error at a place, so that no further one is reported there."""
        return span in self._settled

    @property
    def has_errors(self) -> bool:
        return any(severity is Severity.ERROR for severity, _ in self._found)
