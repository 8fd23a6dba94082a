"""What happens to a chunk that is no command: parsed, put in its place, compiled, and told about."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cortex_dsl.diagnostics import CompileError, Diagnostic, Label, Severity
from cortex_dsl.editor.facts import described
from cortex_dsl.pipeline import compile_source
from cortex_dsl.repl.draft import Draft, Placed, keys, place, place_last, place_new, split
from cortex_dsl.repl.state import STILL_TO_COME, Checked, Desk, check, new_errors, remarks_on
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.semantics.model.context import ValueRecorder
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes, parse

if TYPE_CHECKING:
    from engine.program import Program

# -- What a single expression is worth: its kind, unit and range, as far as they are known before a run ----------------

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


# ----------------------------------------------------------------------------------------------------------------------
# What an entry does to the draws: acceptance before and after, and who is to blame where nothing passes any more.

NOTABLE = 0.5
"""A fall of acceptance to less than this share is told even where no requirement was entered."""


def tell_change(desk: Desk, before: Checked, after: Checked) -> None:
    """Weigh a draft that has just changed, if there is anything to tell of it."""
    if not desk.interactive and "require" not in after.draft.text:
        return
    if after.weighable is None:
        return
    fresh = _fresh(before.weighable, after.weighable)
    if not fresh and not (desk.interactive and desk.kernels.ready):
        return
    from engine.acceptance import account

    desk.kernels.wait(desk.terminal)
    old = None if before.weighable is None else desk.weighing(before.weighable)
    new = desk.weighing(after.weighable)
    if not fresh and (old is None or new.acceptance >= NOTABLE * old.acceptance):
        return
    from cortex_dsl.report.terminal.requirements_view import weighing_view

    console = desk.terminal.out
    view = weighing_view(old, account(new), fresh, ascii_only=console.options.ascii_only)
    console.print(view)


def _fresh(before: "Program | None", after: "Program") -> set[int]:
    """Requirements of the file that were not there before."""
    known = set() if before is None else {r.name for r in before.requirements}
    return {i for i, r in enumerate(after.requirements) if r.line and r.name not in known}


# ----------------------------------------------------------------------------------------------------------------------


def enter(desk: Desk, chunk: str) -> None:
    """Add a chunk to the draft; a refused one leaves everything as it was, and a person is told so."""
    index, refused = desk.editing, desk.mistakes
    desk.editing = None
    _enter(desk, chunk, index)
    if desk.interactive and desk.mistakes > refused:
        desk.editing = index
        desk.terminal.err.print("refused: nothing was changed", style="quiet")


def _enter(desk: Desk, chunk: str, index: int | None) -> None:
    source = _below(desk, chunk)
    try:
        module = parse(source)
    except CompileError as error:
        refuse(desk, error.source, error.diagnostics)
        return
    alone = module.statements[0] if len(module.statements) == 1 else None
    if isinstance(alone, nodes.ExpressionStatement) and "\n" not in chunk.strip():
        show_value(desk, chunk.strip(), refuse)
        return
    own = Source(desk.name, chunk + "\n")
    if index is not None:
        old = desk.draft.entries[index]
        blank = old[: len(old) - len(old.lstrip("\n"))]
        _adopt(desk, [Placed(desk.draft.replaced(index, blank + chunk.strip("\n").rstrip()), index)])
        return
    _adopt(desk, _placed(desk.draft, split(own, parse(own))))


def _below(desk: Desk, chunk: str) -> Source:
    """The chunk alone, with the line numbers that it would have at the end of the draft."""
    return Source(desk.name, "\n" * (desk.draft.first_lines[-1] - 1) + chunk + "\n")


def _placed(draft: Draft, entries: Sequence[str]) -> list[Placed]:
    steps: list[Placed] = []
    known = {key for entry in draft.entries for key in keys(entry)}
    for entry in entries:
        own = keys(entry)
        steps.append(place_new(draft, entry) if known.isdisjoint(own) else place(draft, entry))
        draft = steps[-1].draft
        known |= own
    return steps


def _adopt(desk: Desk, steps: list[Placed]) -> None:
    """Take the draft over if it compiles no worse than before."""
    if not steps:
        return
    before = desk.checked
    checked, steps = _best(desk, before, steps)
    if wrong := new_errors(before, checked):
        refuse(desk, checked.source, wrong)
        return
    desk.adopt(desk.history.step(checked.draft), checked)
    _tell(desk, before, checked, steps)


def _best(desk: Desk, before: Checked, steps: list[Placed]) -> tuple[Checked, list[Placed]]:
    """A definition goes into its old place, or to the end where it uses what is defined in between."""
    checked = check(steps[-1].draft, desk.name, desk.overrides)
    if len(steps) == 1 and new_errors(before, checked):
        last = place_last(desk.draft, steps[0].draft.entries[steps[0].index])
        moved = last and check(last.draft, desk.name, desk.overrides)
        if last and moved and not new_errors(before, moved):
            return moved, [last]
    return checked, steps


def _tell(desk: Desk, before: Checked, checked: Checked, steps: list[Placed]) -> None:
    replaced = [step.replaced for step in steps if step.replaced]
    if replaced:
        desk.terminal.out.print(f"replaced {', '.join(replaced)}", style="quiet", soft_wrap=True)
    touched = dict.fromkeys(min(step.index, len(checked.draft.entries) - 1) for step in steps)
    remarks = [remark for index in touched for remark in remarks_on(checked, index)]
    fresh = [r for r in remarks if (r.code, r.message) not in {(b.code, b.message) for b in before.remarks}]
    if fresh:
        print_diagnostics(checked.source, fresh, desk.terminal.err)
    tell_change(desk, before, checked)


def refuse(desk: Desk, source: Source, diagnostics: Sequence[Diagnostic]) -> None:
    """Show what is wrong."""
    desk.mistakes += 1
    desk.terminal.out.file.flush()
    print_diagnostics(source, diagnostics, desk.terminal.err)
