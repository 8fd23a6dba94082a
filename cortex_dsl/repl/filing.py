"""Commands that read and write files."""

import contextlib
from pathlib import Path

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.files import is_folder, read_source, reason
from cortex_dsl.cli.writing import write_bytes
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.checking import check
from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.draft import Draft, History
from cortex_dsl.repl.entering import refuse
from cortex_dsl.repl.splitting import split
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.formatting import format_source

SUFFIX = ".scn"


def do_load(desk: Desk, argument: str) -> None:
    if not argument:
        raise UsageError("which file?", "as in `:load left_turn.scn`")
    if desk.interactive and desk.unsaved and not _agreed("What was entered is not saved. Drop it?"):
        return
    load(desk, _path(argument))


def load(desk: Desk, path: Path) -> None:
    """Begin anew with a file; one with mistakes is loaded too, as long as it can be read as statements.

    Raises:
        UsageError: there is no such file, or it cannot be read.
    """
    try:
        source = read_source(path)
        draft = Draft(split(source, parse(source)))
    except CompileError as error:
        refuse(desk, error.source, error.diagnostics)
        return
    checked = check(draft, str(path), {})
    desk.file, desk.on_disk, desk.saved, desk.overrides = path, source.text, draft, {}
    desk.adopt(History(draft), checked)
    if checked.errors:
        refuse(desk, checked.source, checked.errors)
    if desk.interactive:
        what = f"{path}: {counted(len(draft.entries), 'entry', 'entries')}"
        desk.terminal.out.print(what, style="quiet", soft_wrap=True)


def _path(name: str) -> Path:
    """A path as typed, `~` being the home of a user.

    Raises:
        UsageError: it cannot be one.
    """
    if "\0" in name:
        raise UsageError(f"`{name}` cannot be the name of a file")
    try:
        return Path(name).expanduser()
    except RuntimeError:
        raise UsageError(f"there is no home folder `{name.split('/')[0]}`", "write the whole path") from None


def do_save(desk: Desk, argument: str) -> None:
    loud, name = argument.startswith("!"), argument.removeprefix("!").strip()
    if not desk.draft.entries:
        raise UsageError("there is nothing to save yet")
    if not name and desk.file is None:
        raise UsageError("under which name?", "as in `:save crossing.scn`")
    path = _path(name) if name else desk.file
    assert path is not None
    if is_folder(path):
        raise UsageError(f"`{path}` is a folder", f"name a file in it, as in `:save {path / 'crossing.scn'}`")
    path = path if path.suffix else path.with_name(path.name + SUFFIX)
    if not loud and not _may_write(desk, path):
        return
    text = _formatted(desk)
    write_bytes(path, text.encode("utf-8", errors="replace"))
    _adopt_file(desk, path, text)
    desk.terminal.out.print(f"saved {path}", style="quiet", soft_wrap=True)
    if desk.overrides:
        held = ", ".join(desk.overrides)
        desk.terminal.out.print(f"what `:set` holds is not part of the file: {held}", style="quiet", soft_wrap=True)


def _formatted(desk: Desk) -> str:
    """The text in the one layout; where that cannot be had, as it is."""
    try:
        return format_source(Source(desk.name, desk.draft.text))
    except CompileError:
        return desk.draft.text


def _adopt_file(desk: Desk, path: Path, text: str) -> None:
    """The draft is what is in the file now, layout included."""
    source = Source(str(path), text)
    with contextlib.suppress(CompileError):
        draft = Draft(split(source, parse(source)))
        desk.adopt(desk.history.step(draft), None)
    desk.file, desk.on_disk, desk.saved = path, text, desk.draft


def _may_write(desk: Desk, path: Path) -> bool:
    """Whether the file is the session's own as it left it, a new one, or the user says so.

    Raises:
        UsageError: it is another one, and nobody can be asked.
    """
    try:
        there = path.read_bytes()
    except FileNotFoundError:
        return True
    except OSError as error:
        raise UsageError(f"cannot write `{path}`: {reason(error)}") from None
    own = desk.file is not None and path.resolve() == desk.file.resolve()
    if own and there.decode("utf-8-sig", errors="replace") == desk.on_disk:
        return True
    what = "has been changed since it was read" if own else "is another file"
    if not desk.interactive:
        raise UsageError(f"`{path}` {what}", f"`:save! {path}` writes over it")
    return _agreed(f"`{path}` {what}. Write over it?")


def _agreed(question: str) -> bool:
    try:
        return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")
    except EOFError:
        return False
