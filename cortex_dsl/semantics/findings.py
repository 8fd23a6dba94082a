"""What elaboration collects over all variants: diagnostics, each once, and the pool of numeric options."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from cortex_dsl.diagnostics import Diagnostic, Severity
from cortex_dsl.source import Span


@dataclass
class Findings:
    """Diagnostics, each once whatever variants it comes from."""

    _found: dict[tuple[Severity, Span], dict[str, Diagnostic]] = field(default_factory=dict)
    _settled: frozenset[Span] = frozenset()
    """Places where an earlier stage found errors: further ones there are consequences."""

    def add(self, diagnostic: Diagnostic) -> None:
        """Keep one finding; a place has each code at most once, the first."""
        if diagnostic.severity is Severity.ERROR and diagnostic.label.span in self._settled:
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

    @property
    def has_errors(self) -> bool:
        return any(severity is Severity.ERROR for severity, _ in self._found)


@dataclass
class Pool:
    """Numeric options of discrete choices, shared by all variants."""

    values: list[float] = field(default_factory=list)
    _offsets: dict[tuple[float, ...], int] = field(default_factory=dict)

    def offset(self, options: Sequence[float]) -> int:
        key = tuple(options)
        if key not in self._offsets:
            self._offsets[key] = len(self.values)
            self.values.extend(key)
        return self._offsets[key]
