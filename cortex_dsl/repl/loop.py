"""From one chunk to the next; whatever happens to one of them, the session goes on."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from cortex_dsl.console.terminal import Exit, Terminal, UsageError, report_bug
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.chunks import is_command
from cortex_dsl.repl.commands import obey
from cortex_dsl.repl.entering import enter, refuse
from cortex_dsl.repl.state import Desk

NO_TERMINALS = ("dumb", "unknown", "")
"""Values of TERM that say that nothing can be edited there."""


class Input(Protocol):
    """Where chunks come from."""

    def read(self) -> str | None:
        """The next chunk, without line breaks at its end; None at the end of the input.

        Raises:
            KeyboardInterrupt: the user wants to begin the chunk anew, or a pipe is to be left.
        """
        ...


def start(file: Path | None, terminal: Terminal) -> int:
    """Begin a session, with a file if there is one; return its exit code."""
    desk = Desk(terminal, interactive=sys.stdin is not None and sys.stdin.isatty())
    if desk.interactive:
        _greet(terminal)
    chunks = _input(desk)
    if desk.interactive:
        desk.kernels.start()
    if file is not None:
        from cortex_dsl.repl.commands_draft import load

        load(desk, file)
    return run(desk, chunks)


def _input(desk: Desk) -> Input:
    able = sys.stdout.isatty() and os.environ.get("TERM", "") not in NO_TERMINALS
    if desk.interactive and able:
        from cortex_dsl.repl.prompt import EditedInput

        return EditedInput(desk)
    from cortex_dsl.repl.chunks import PlainInput

    return PlainInput(desk)


def _greet(terminal: Terminal) -> None:
    from cortex_dsl.version import VERSION

    terminal.out.print(f"cortexc {VERSION}", style="title", end="")
    terminal.out.print("  :help lists the commands, Tab completes, Ctrl-D leaves", style="quiet")


def run(desk: Desk, chunks: Input) -> int:
    """Read and do until the end; the exit code."""
    asked = False
    while not desk.leaving:
        try:
            chunk = chunks.read()
        except KeyboardInterrupt:
            if not desk.interactive:
                raise
            desk.editing, asked = None, False
            continue
        if chunk is not None and not chunk.strip():
            continue
        if chunk is None:
            desk.leaving = True
        else:
            do(desk, chunk)
        if desk.leaving and desk.interactive and desk.unsaved and not asked:
            desk.leaving, asked = False, True
            desk.terminal.out.print("not saved: `:save FILE` keeps it, leaving again drops it", style="warn")
        elif chunk is not None:
            asked = False
    return exit_code(desk)


def do(desk: Desk, chunk: str) -> None:
    """One chunk. What goes wrong in it is told here."""
    act: Callable[[Desk, str], None] = obey if is_command(chunk) else enter
    try:
        act(desk, chunk)
    except UsageError as error:
        desk.mistakes += 1
        complain(desk, error.message, error.cure)
    except CompileError as error:
        refuse(desk, error.source, error.diagnostics)
    except KeyboardInterrupt:
        if not desk.interactive:
            raise
        desk.terminal.err.print("interrupted", style="warn")
    except (BrokenPipeError, SystemExit):
        raise
    except Exception as error:
        if os.environ.get("CORTEXC_DEBUG") == "1":
            raise
        desk.bugs += 1
        report_bug(error, ("repl", chunk), desk.terminal)


def complain(desk: Desk, message: str, cure: str) -> None:
    """A slip, with its cure."""
    desk.terminal.out.file.flush()
    err = desk.terminal.err
    err.print(message, style="bad", soft_wrap=True)
    if cure:
        err.print(f"  help: {cure}", soft_wrap=True)


def exit_code(desk: Desk) -> Exit:
    """Of a script: whether all of it was fine. Whoever sits at a terminal has seen what was not."""
    if desk.interactive:
        return Exit.FINE
    if desk.bugs:
        return Exit.BUG
    if desk.mistakes:
        return Exit.DIAGNOSTICS
    return Exit.NO_SCENE if desk.no_scene else Exit.FINE
