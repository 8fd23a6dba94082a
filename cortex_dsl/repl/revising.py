"""Commands that look at the draft and change it."""

from rich.text import Text

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.repl import weighing
from cortex_dsl.repl.checking import check, new_errors
from cortex_dsl.repl.colours import coloured
from cortex_dsl.repl.commands import whole_number
from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.draft import Draft, History
from cortex_dsl.repl.entering import refuse
from cortex_dsl.repl.splitting import comments_above


def do_list(desk: Desk, _argument: str) -> None:
    """The text with line numbers, and before the first line of each entry its own number."""
    draft, out = desk.draft, desk.terminal.out
    if not draft.entries:
        out.print("nothing has been entered yet", style="quiet")
        return
    heads = {line + _skipped(draft, i): i + 1 for i, line in enumerate(draft.first_lines[:-1])}
    lines = coloured(draft.text).split("\n")
    digits, deep = len(str(len(lines))), len(str(len(heads))) + 2
    for number, line in enumerate(lines[: draft.first_lines[-1] - 1], 1):
        entry = f"[{heads[number]}]" if number in heads else ""
        out.print(
            Text.assemble((f"{entry:>{deep}} ", "bar"), (f"{number:>{digits}} │ ", "quiet"), line), soft_wrap=True
        )


def _skipped(draft: Draft, index: int) -> int:
    """Lines of comments with which an entry begins, unless it has nothing else."""
    above = comments_above(draft.entries[index] + "\n")
    return 0 if above.strip() == draft.entries[index].strip() else above.count("\n")


def do_undo(desk: Desk, _argument: str) -> None:
    _go(desk, desk.history.undone(), "undo")


def do_redo(desk: Desk, _argument: str) -> None:
    _go(desk, desk.history.redone(), "redo")


def _go(desk: Desk, history: History | None, word: str) -> None:
    if history is None:
        raise UsageError(f"there is nothing to {word}")
    old, new = desk.draft, history.present
    desk.adopt(history)
    gone, come = (_first_line(a, b) for a, b in ((old, new), (new, old)))
    words = " and ".join(filter(None, (gone and f"without `{gone}`", come and f"with `{come}`")))
    desk.terminal.out.print(words or "as before", style="quiet", soft_wrap=True)


def _first_line(some: Draft, others: Draft) -> str:
    """The beginning of the first entry that only the one draft has."""
    entry = next((entry for entry in some.entries if entry not in others.entries), "")
    code = (entry.removeprefix(comments_above(entry + "\n")) or entry).strip().split("\n")
    return code[0] + (" …" if len(code) > 1 else "")


def do_edit(desk: Desk, argument: str) -> None:
    index = _entry(desk, argument)
    desk.editing, desk.proposal = index, desk.draft.entries[index].lstrip("\n")


def do_delete(desk: Desk, argument: str) -> None:
    before = desk.checked
    draft = desk.draft.without(_entry(desk, argument))
    checked = check(draft, desk.name, desk.overrides)
    if wrong := new_errors(before, checked):
        refuse(desk, checked.source, wrong)
        return
    desk.adopt(desk.history.step(draft), checked)
    weighing.tell_change(desk, before, checked)


def _entry(desk: Desk, argument: str) -> int:
    count = len(desk.draft.entries)
    if not argument or not count:
        raise UsageError("which entry?" if count else "there are no entries yet", "`:list` numbers them")
    return whole_number(argument.strip("[]"), 1, "the number of an entry", count) - 1
