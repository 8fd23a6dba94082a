"""From one chunk to the next; an error in a chunk does not end the session."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from cortex_dsl.console.terminal import Exit, Terminal, UsageError, report_bug
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.chunks import is_command
from cortex_dsl.repl.commands import execute
from cortex_dsl.repl.entering import enter
from cortex_dsl.repl.state import State, refuse

NO_TERMINALS = ("dumb", "unknown", "")
"""Values of TERM that say that nothing can be edited there."""


class Input(Protocol):
    """Where chunks come from."""

    def read(self) -> str | None:
        """The next chunk, without line breaks at its end; None at the end of the input.

        Raises:
            KeyboardInterrupt: the user wants to start the chunk again, or a pipe is to be left.
        """
        ...


def start(file: Path | None, terminal: Terminal) -> int:
    """Run a session, with a file if there is one; return its exit code."""
    state = State(terminal, interactive=sys.stdin is not None and sys.stdin.isatty())
    if state.interactive:
        _greet(terminal)
    chunks = _input(state)
    if state.interactive:
        state.kernels.start()
    if file is not None:
        from cortex_dsl.repl.commands_draft import load

        load(state, file)
    try:
        return run(state, chunks)
    finally:
        state.kernels.stop()


def _input(state: State) -> Input:
    able = sys.stdout.isatty() and os.environ.get("TERM", "") not in NO_TERMINALS
    if state.interactive and able:
        from cortex_dsl.repl.prompt import EditedInput

        return EditedInput(state)
    from cortex_dsl.repl.chunks import PlainInput

    return PlainInput(state)


def _greet(terminal: Terminal) -> None:
    from cortex_dsl.version import VERSION

    terminal.out.print(f"cortexc {VERSION}", style="title", end="")
    terminal.out.print("  :help lists the commands, Tab completes, Ctrl-D leaves", style="quiet")


def run(state: State, chunks: Input) -> int:
    """Read and do until the end; the exit code."""
    warned = False
    while not state.leaving:
        try:
            chunk = chunks.read()
        except KeyboardInterrupt:
            if not state.interactive:
                raise
            state.editing, warned = None, False
            continue
        if chunk is not None and not chunk.strip():
            continue
        if chunk is None:
            state.leaving = True
        else:
            do(state, chunk)
        if state.leaving and state.interactive and state.unsaved and not warned:
            state.leaving, warned = False, True
            state.terminal.out.print("not saved: `:save FILE` keeps it, leaving again drops it", style="warn")
        elif chunk is not None:
            warned = False
    return exit_code(state)


def do(state: State, chunk: str) -> None:
    """Carry out one chunk, and show its errors."""
    act: Callable[[State, str], None] = execute if is_command(chunk) else enter
    try:
        act(state, chunk)
    except UsageError as error:
        state.mistakes += 1
        complain(state, error.message, error.cure)
    except CompileError as error:
        refuse(state, error.source, error.diagnostics)
    except KeyboardInterrupt:
        if not state.interactive:
            raise
        state.terminal.err.print("interrupted", style="warn")
    except (BrokenPipeError, SystemExit):
        raise
    except Exception as error:
        if os.environ.get("CORTEXC_DEBUG") == "1":
            raise
        state.bugs += 1
        report_bug(error, ("repl", chunk), state.terminal)
    finally:
        state.kernels.over()


def complain(state: State, message: str, cure: str) -> None:
    """Show a problem that the user can solve, with its cure."""
    state.terminal.out.file.flush()
    err = state.terminal.err
    err.print(message, style="bad", soft_wrap=True)
    if cure:
        err.print(f"  help: {cure}", soft_wrap=True)


def exit_code(state: State) -> Exit:
    """Return whether a script ran without mistakes; at a terminal the user has seen the mistakes."""
    if state.interactive:
        return Exit.FINE
    if state.bugs:
        return Exit.BUG
    if state.mistakes:
        return Exit.DIAGNOSTICS
    return Exit.NO_SCENE if state.no_scene else Exit.FINE
