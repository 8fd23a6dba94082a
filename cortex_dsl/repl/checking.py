"""A draft, compiled: what is wrong with it, and what is merely still to come."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.repl.draft import Draft
from cortex_dsl.semantics.errors.names import DEAD_GENE, UNUSED_BEHAVIOUR, UNUSED_GENE, UNUSED_NAME
from cortex_dsl.semantics.errors.objects import NO_EGO
from cortex_dsl.semantics.errors.roads import DEFAULT_MAP
from cortex_dsl.semantics.errors.scenarios import UNUSED_MONITOR
from cortex_dsl.semantics.errors.statements import EMPTY_FILE
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import decode
from engine.program import Program

STILL_TO_COME = (NO_EGO.code, EMPTY_FILE.code)
OF_THE_WHOLE = (
    DEFAULT_MAP.code,
    UNUSED_BEHAVIOUR.code,
    UNUSED_MONITOR.code,
    UNUSED_GENE.code,
    DEAD_GENE.code,
    UNUSED_NAME.code,
)
"""Remarks that make sense when a scenario is complete."""
STAND_IN = "\nego = new Car on road, with regionContainedIn None\n"
"""Takes the place of an ego that is still to come, so that requirements on params alone can be weighed."""


@dataclass(frozen=True)
class Checked:
    """What the compiler says of a draft."""

    draft: Draft
    source: Source
    compiled: Compiled | None = None
    errors: tuple[Diagnostic, ...] = ()
    remarks: tuple[Diagnostic, ...] = ()
    """Warnings and notes."""
    missing: bool = False
    """Whether there is no ego yet."""
    overrides: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def weighable(self) -> Program | None:
        """What requirements can be weighed with."""
        if self.compiled is not None:
            return self.compiled.program
        waits = self.missing and not self.errors and self.source.text
        return _with_stand_in(self.source, self.overrides) if waits else None


def check(draft: Draft, name: str, overrides: Mapping[str, str]) -> Checked:
    """Compile a draft; `overrides` are params that are held. Mistakes of the overrides are errors, too."""
    if not draft.text.strip():
        return Checked(draft, Source(name, ""), missing=True, overrides=overrides)
    try:
        source = decode(name, draft.text.encode("utf-8", errors="replace"))
        compiled = compile_source(source, overrides)
    except CompileError as error:
        return _failed(draft, error, overrides)
    return Checked(draft, compiled.source, compiled, (), compiled.diagnostics, overrides=overrides)


def _failed(draft: Draft, error: CompileError, overrides: Mapping[str, str]) -> Checked:
    grave = tuple(d for d in error.diagnostics if d.severity is Severity.ERROR)
    remarks = tuple(d for d in error.diagnostics if d.severity is not Severity.ERROR)
    wrong = tuple(d for d in grave if d.code not in STILL_TO_COME)
    return Checked(draft, error.source, None, wrong, remarks, len(wrong) < len(grave), overrides)


def _with_stand_in(source: Source, overrides: Mapping[str, str]) -> Program | None:
    try:
        return compile_source(Source(source.name, source.text + STAND_IN), overrides).program
    except CompileError:
        return None


def new_errors(before: Checked, after: Checked) -> tuple[Diagnostic, ...]:
    """The errors that a draft had not before: a file that is loaded with some can be mended one by one."""
    known = {(d.code, d.message) for d in before.errors}
    return tuple(d for d in after.errors if (d.code, d.message) not in known)


def remarks_on(checked: Checked, index: int) -> list[Diagnostic]:
    """What is to be said of one entry at once: warnings and notes about its lines."""
    first, last = checked.draft.first_lines[index : index + 2]
    fitting = (d for d in checked.remarks if d.severity is not Severity.HINT and d.code not in OF_THE_WHOLE)
    return [d for d in fitting if first <= checked.source.row(d.label.span.start) < last]
