"""Commands on the draft: list it, undo, redo, edit and delete entries, load a file and save one."""

import contextlib
from pathlib import Path

from rich.text import Text

from cortex_dsl.console.terminal import UsageError
from cortex_dsl.console.user_files import is_folder, read_source, reason, user_path, write_bytes
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl import entering
from cortex_dsl.repl.draft import Draft, History, comments_above, split
from cortex_dsl.repl.state import State, check, new_errors, refuse, whole_number
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse


def do_list(state: State, _argument: str) -> None:
    """The text with line numbers, and before the first line of each entry its own number."""
    from cortex_dsl.repl.colours import coloured

    draft, out = state.draft, state.terminal.out
    if not draft.entries:
        out.print("nothing has been entered yet", style="quiet")
        return
    first_lines = {line + _skipped(draft, i): i + 1 for i, line in enumerate(draft.first_lines[:-1])}
    lines = coloured(draft.text).split("\n")
    digits, deep = len(str(len(lines))), len(str(len(first_lines))) + 2
    for number, line in enumerate(lines[: draft.first_lines[-1] - 1], 1):
        entry = f"[{first_lines[number]}]" if number in first_lines else ""
        out.print(
            Text.assemble((f"{entry:>{deep}} ", "bar"), (f"{number:>{digits}} │ ", "quiet"), line), soft_wrap=True
        )


def _skipped(draft: Draft, index: int) -> int:
    """Lines of comments with which an entry begins, unless it has nothing else."""
    above = comments_above(draft.entries[index] + "\n")
    return 0 if above.strip() == draft.entries[index].strip() else above.count("\n")


def do_undo(state: State, _argument: str) -> None:
    _go(state, state.history.undone(), "undo")


def do_redo(state: State, _argument: str) -> None:
    _go(state, state.history.redone(), "redo")


def _go(state: State, history: History | None, word: str) -> None:
    if history is None:
        raise UsageError(f"there is nothing to {word}")
    old, new = state.draft, history.present
    state.adopt(history)
    gone, come = (_first_line(a, b) for a, b in ((old, new), (new, old)))
    words = " and ".join(filter(None, (gone and f"without `{gone}`", come and f"with `{come}`")))
    state.terminal.out.print(words or "as before", style="quiet", soft_wrap=True)


def _first_line(some: Draft, others: Draft) -> str:
    """The beginning of the first entry that only the one draft has."""
    entry = next((entry for entry in some.entries if entry not in others.entries), "")
    code = (entry.removeprefix(comments_above(entry + "\n")) or entry).strip().split("\n")
    return code[0] + (" …" if len(code) > 1 else "")


def do_edit(state: State, argument: str) -> None:
    index = _entry(state, argument)
    state.editing, state.proposal = index, state.draft.entries[index].lstrip("\n")


def do_delete(state: State, argument: str) -> None:
    before = state.checked
    draft = state.draft.without(_entry(state, argument))
    checked = check(draft, state.name, state.overrides)
    if wrong := new_errors(before, checked):
        refuse(state, checked.source, wrong)
        return
    state.adopt(state.history.step(draft), checked)
    entering.show_change(state, before, checked)


def _entry(state: State, argument: str) -> int:
    count = len(state.draft.entries)
    if not argument or not count:
        raise UsageError("which entry?" if count else "there are no entries yet", "`:list` numbers them")
    return whole_number(argument.strip("[]"), 1, "the number of an entry", count) - 1


# -- files -------------------------------------------------------------------------------------------------------------

SUFFIX = ".scn"


def do_load(state: State, argument: str) -> None:
    if not argument:
        raise UsageError("which file?", "as in `:load left_turn.scn`")
    if state.interactive and state.unsaved and not _agreed("What was entered is not saved. Drop it?"):
        return
    load(state, user_path(argument))


def load(state: State, path: Path) -> None:
    """Start over with a file; one with mistakes is loaded too, as long as it can be read as statements.

    Raises:
        UsageError: there is no such file, or it cannot be read.
    """
    try:
        source = read_source(path)
        draft = Draft(split(source, parse(source)))
    except CompileError as error:
        refuse(state, error.source, error.diagnostics)
        return
    checked = check(draft, str(path), {})
    state.file, state.on_disk, state.saved, state.overrides = path, source.text, draft, {}
    state.adopt(History(draft), checked)
    if checked.errors:
        refuse(state, checked.source, checked.errors)
    if state.interactive:
        what = f"{path}: {counted(len(draft.entries), 'entry', 'entries')}"
        state.terminal.out.print(what, style="quiet", soft_wrap=True)


def do_save(state: State, argument: str) -> None:
    loud, name = argument.startswith("!"), argument.removeprefix("!").strip()
    if not state.draft.entries:
        raise UsageError("there is nothing to save yet")
    if not name and state.file is None:
        raise UsageError("under which name?", "as in `:save crossing.scn`")
    path = user_path(name) if name else state.file
    assert path is not None
    if is_folder(path):
        raise UsageError(f"`{path}` is a folder", f"name a file in it, as in `:save {path / 'crossing.scn'}`")
    path = path if path.suffix else path.with_name(path.name + SUFFIX)
    if not loud and not _may_write(state, path):
        return
    text = _formatted(state)
    write_bytes(path, text.encode("utf-8", errors="replace"))
    _adopt_file(state, path, text)
    state.terminal.out.print(f"saved {path}", style="quiet", soft_wrap=True)
    if state.overrides:
        held = ", ".join(state.overrides)
        state.terminal.out.print(f"what `:set` holds is not part of the file: {held}", style="quiet", soft_wrap=True)


def _formatted(state: State) -> str:
    """The text in the one layout; where that cannot be had, as it is."""
    from cortex_dsl.syntax.formatting import format_source

    try:
        return format_source(Source(state.name, state.draft.text))
    except CompileError:
        return state.draft.text


def _adopt_file(state: State, path: Path, text: str) -> None:
    """Replace the draft by the present contents of the file, including its layout."""
    source = Source(str(path), text)
    with contextlib.suppress(CompileError):
        draft = Draft(split(source, parse(source)))
        state.adopt(state.history.step(draft), None)
    state.file, state.on_disk, state.saved = path, text, state.draft


def _may_write(state: State, path: Path) -> bool:
    """Return whether the file is the unchanged file of the session, a new one, or the user agrees.

    Raises:
        UsageError: it is another file, and there is no user to confirm.
    """
    try:
        there = path.read_bytes()
    except FileNotFoundError:
        return True
    except OSError as error:
        raise UsageError(f"cannot write `{path}`: {reason(error)}") from None
    own = state.file is not None and path.resolve() == state.file.resolve()
    if own and there.decode("utf-8-sig", errors="replace") == state.on_disk:
        return True
    what = "has been changed since it was read" if own else "is another file"
    if not state.interactive:
        raise UsageError(f"`{path}` {what}", f"`:save! {path}` writes over it")
    return _agreed(f"`{path}` {what}. Write over it?")


def _agreed(question: str) -> bool:
    try:
        return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")
    except EOFError:
        return False
