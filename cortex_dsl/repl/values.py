"""What a single expression is worth: its kind, unit and range, as far as they are known before a run."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from cortex_dsl.diagnostics import CompileError, Diagnostic, Label, Severity
from cortex_dsl.editor.facts import described
from cortex_dsl.pipeline import compile_source
from cortex_dsl.repl.checking import STILL_TO_COME
from cortex_dsl.repl.desk import Desk
from cortex_dsl.semantics.model.context import ValueRecorder
from cortex_dsl.source import Source, Span

PLACE = "it = "
"""The expression is looked at as the value of this assignment, at the end of the draft."""
Refuse = Callable[[Desk, Source, Sequence[Diagnostic]], None]


def show_value(desk: Desk, expression: str, refuse: Refuse) -> None:
    """Print what an expression is; the draft stays as it is."""
    text = f"{desk.draft.text}{PLACE}{expression}\n"
    start = len(desk.draft.text) + len(PLACE)
    witness = ValueRecorder()
    source = Source(desk.name, text)
    try:
        compile_source(source, desk.overrides, observe=witness)
    except CompileError as error:
        wrong = [d for d in error.diagnostics if _is_about(d, start)]
        if wrong:
            refuse(desk, Source(desk.name, f"{desk.draft.text}{expression}\n"), [_as_typed(d, start) for d in wrong])
            return
    seen = witness.seen.get(Span(start, start + len(expression.rstrip()))) or _widest(witness, start)
    worth = described(seen) if seen else ""
    if worth:
        desk.terminal.out.print(worth, soft_wrap=True)
    else:
        desk.terminal.out.print("it has a value in the simulation only", style="quiet")


def _is_about(diagnostic: Diagnostic, start: int) -> bool:
    grave = diagnostic.severity is Severity.ERROR and diagnostic.code not in STILL_TO_COME
    return grave and diagnostic.label.span.end >= start - len(PLACE)


def _as_typed(diagnostic: Diagnostic, start: int) -> Diagnostic:
    """The same where the expression stands alone, as it was typed."""

    def placed(offset: int) -> int:
        return offset if offset <= start - len(PLACE) else max(offset, start) - len(PLACE)

    def moved(label: Label) -> Label:
        return replace(label, span=Span(placed(label.span.start), placed(label.span.end)))

    return replace(diagnostic, label=moved(diagnostic.label), secondary=tuple(map(moved, diagnostic.secondary)))


def _widest(witness: ValueRecorder, start: int) -> Sequence:
    """What was seen of the whole expression, whose span may leave out brackets around it."""
    fitting = [span for span in witness.seen if span.start >= start]
    return witness.seen[min(fitting, key=lambda span: (span.start, -span.end))] if fitting else ()
