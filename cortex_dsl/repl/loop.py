"""From one chunk to the next; whatever happens to one of them, the session goes on."""

import os
from collections.abc import Callable
from typing import Protocol

from cortex_dsl.console.terminal import Exit, UsageError, report_bug
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.chunks import is_command
from cortex_dsl.repl.commands import obey
from cortex_dsl.repl.entering import enter, refuse
from cortex_dsl.repl.state import Desk


class Input(Protocol):
    """Where chunks come from."""

    def read(self) -> str | None:
        """The next chunk, without line breaks at its end; None at the end of the input.

        Raises:
            KeyboardInterrupt: the user wants to begin the chunk anew, or a pipe is to be left.
        """
        ...


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
