"""What an entry does to the draws: acceptance before and after, and who is to blame where nothing passes any more."""

from typing import TYPE_CHECKING

from cortex_dsl.repl.checking import Checked
from cortex_dsl.repl.desk import Desk

if TYPE_CHECKING:
    from engine.program import Program

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
    from engine.blame import account

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
