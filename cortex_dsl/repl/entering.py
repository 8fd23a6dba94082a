"""What happens to a chunk that is no command: parsed, put in its place, compiled, and told about."""

from collections.abc import Sequence

from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.repl import weighing
from cortex_dsl.repl.checking import Checked, check, new_errors, remarks_on
from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.draft import Draft
from cortex_dsl.repl.placing import Placed, place, place_last, place_new
from cortex_dsl.repl.splitting import keys, split
from cortex_dsl.repl.values import show_value
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse


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
    weighing.tell_change(desk, before, checked)


def refuse(desk: Desk, source: Source, diagnostics: Sequence[Diagnostic]) -> None:
    """Show what is wrong."""
    desk.mistakes += 1
    desk.terminal.out.file.flush()
    print_diagnostics(source, diagnostics, desk.terminal.err)
