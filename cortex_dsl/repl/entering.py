"""Processing of a chunk that is no command.

A single expression is shown with its value. Any other chunk is parsed, placed, compiled, and its effect shown:
acceptance of draws before and after, and the requirement that rejects all. A refused chunk changes nothing.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.draft import Draft, Placed, keys, place, place_last, place_new, place_with_sources, split
from cortex_dsl.repl.expressions import show_value
from cortex_dsl.repl.state import Checked, State, check, new_errors, refuse, remarks_on
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse
from engine.vocabulary import RuleKind

if TYPE_CHECKING:
    from engine.program import Program, Rule

# -- effect of an entry on draws ---------------------------------------------------------------------------------------

NOTABLE = 0.5
"""A fall of acceptance to less than this share is shown even where no requirement was entered."""


def show_change(state: State, before: Checked, after: Checked) -> None:
    """Show the effect of an entry: acceptance of draws, and results of its objectives in instant runs."""
    _show_acceptance(state, before, after)
    _show_objectives(state, before, after)


def _show_acceptance(state: State, before: Checked, after: Checked) -> None:
    """Estimate the acceptance of a draft, and show it where the change is notable."""
    if not state.interactive and "require" not in after.draft.text:
        return
    if after.weighable is None:
        return
    fresh = _fresh(before.weighable, after.weighable)
    if not fresh and not (state.interactive and state.kernels.ready):
        return
    from engine.acceptance import account

    state.kernels.wait(state.terminal, ("weigh",), after.weighable)
    old = None if before.weighable is None else state.weighing(before.weighable)
    new = state.weighing(after.weighable)
    if not fresh and (old is None or new.acceptance >= NOTABLE * old.acceptance):
        return
    from cortex_dsl.report.terminal.render import parts
    from cortex_dsl.report.terminal.theme import MARGIN, indented
    from cortex_dsl.report.views.requirements import weighing_view

    console = state.terminal.out
    line, below = weighing_view(old, account(new), fresh)
    plain = console.options.ascii_only
    console.print(parts([line], console.width, ascii_only=plain))
    console.print(indented(parts(below, console.width - MARGIN, ascii_only=plain)))


def _fresh(before: "Program | None", after: "Program") -> set[int]:
    """Requirements of the file that were not there before."""
    known = set() if before is None else {r.name for r in before.requirements}
    return {i for i, r in enumerate(after.requirements) if r.line and r.name not in known}


# -- results in runs ---------------------------------------------------------------------------------------------------


def _show_objectives(state: State, before: Checked, after: Checked) -> None:
    """Evaluate new `expect`, `maximize`, `minimize` and requirements on the run in some hundred runs."""
    if after.compiled is None:
        return
    program, lines = after.compiled.program, _new_lines(before.draft, after.draft)
    if not any(each.line in lines for each in (*program.judged.objectives, *_on_run(program))):
        return
    from cortex_dsl.repl.instant import INSTANT, instant_runs
    from cortex_dsl.report.findings.objectives import weighed_objectives
    from cortex_dsl.report.findings.readable import speed_unit
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.terminal.theme import indented
    from cortex_dsl.report.views.measures import weighed_table

    instant = instant_runs(state, state.scenario(INSTANT))
    if instant is None:
        return
    found = [each for each in weighed_objectives(program, instant.outcomes) if each.line in lines]
    console = state.terminal.out
    view = rendered(weighed_table(found, speed_unit(program)), console.width, ascii_only=console.options.ascii_only)
    console.print(indented(view))


def _on_run(program: "Program") -> Iterator["Rule"]:
    return (rule for rule in program.rules if rule.kind is RuleKind.ABORT)


def _new_lines(before: Draft, after: Draft) -> set[int]:
    """Lines of the entries that were not there before."""
    known, places = set(before.entries), pairwise(after.first_lines)
    new = (range(*ends) for entry, ends in zip(after.entries, places, strict=True) if entry not in known)
    return {line for lines in new for line in lines}


# -- an entry ----------------------------------------------------------------------------------------------------------


def enter(state: State, chunk: str) -> None:
    """Add a chunk to the draft; a refused one leaves everything as it was, and a person sees that."""
    index, refused, before = state.editing, state.mistakes, state.draft
    state.editing = None
    _enter(state, chunk, index)
    if state.interactive and state.mistakes > refused and state.draft == before:
        state.editing = index
        state.terminal.err.print("refused: nothing was changed", style="quiet")


def _enter(state: State, chunk: str, index: int | None) -> None:
    source = Source(state.name, "\n" * (state.draft.first_lines[-1] - 1) + chunk + "\n")
    try:
        module = parse(source)
    except CompileError as error:
        refuse(state, error.source, error.diagnostics)
        return
    alone = module.statements[0] if len(module.statements) == 1 else None
    if isinstance(alone, nodes.ExpressionStatement) and "\n" not in chunk.strip():
        show_value(state, chunk.strip())
        return
    own = Source(state.name, chunk + "\n")
    if index is not None:
        old = state.draft.entries[index]
        blank = old[: len(old) - len(old.lstrip("\n"))]
        _adopt(state, [Placed(state.draft.replaced(index, blank + chunk.strip("\n").rstrip()), index)])
        return
    _adopt(state, _placed(state.draft, split(own, parse(own))))


def _placed(draft: Draft, entries: Sequence[str]) -> list[Placed]:
    steps: list[Placed] = []
    known = {key for entry in draft.entries for key in keys(entry)}
    for entry in entries:
        own = keys(entry)
        steps.append(place_new(draft, entry) if known.isdisjoint(own) else place(draft, entry))
        draft = steps[-1].draft
        known |= own
    return steps


def _adopt(state: State, steps: list[Placed]) -> None:
    """Take the draft over if it compiles no worse than before."""
    if not steps:
        return
    before = state.checked
    checked, steps = _best(state, before, steps)
    if wrong := new_errors(before, checked):
        refuse(state, checked.source, wrong)
        return
    state.adopt(state.history.step(checked.draft), checked)
    _show_remarks(state, before, checked, steps)


def _best(state: State, before: Checked, steps: list[Placed]) -> tuple[Checked, list[Placed]]:
    """Return the checked draft and its steps, with a definition in its old place.

    If it reads definitions from further down, it goes to the end, or, if other entries read it, those definitions move
    above it.
    """
    checked = check(steps[-1].draft, state.name, state.overrides)
    if len(steps) == 1 and new_errors(before, checked):
        entry = steps[0].draft.entries[steps[0].index]
        for place_elsewhere in (place_last, place_with_sources):
            placed = place_elsewhere(state.draft, entry)
            moved = placed and check(placed.draft, state.name, state.overrides)
            if placed and moved and not new_errors(before, moved):
                return moved, [placed]
    return checked, steps


def _show_remarks(state: State, before: Checked, checked: Checked, steps: list[Placed]) -> None:
    replaced = [step.replaced for step in steps if step.replaced]
    if replaced:
        state.terminal.out.print(f"replaced {', '.join(replaced)}", style="quiet", soft_wrap=True)
    touched = dict.fromkeys(min(step.index, len(checked.draft.entries) - 1) for step in steps)
    remarks = [remark for index in touched for remark in remarks_on(checked, index)]
    fresh = [r for r in remarks if (r.code, r.message) not in {(b.code, b.message) for b in before.remarks}]
    if fresh:
        print_diagnostics(checked.source, fresh, state.terminal.err)
    show_change(state, before, checked)
