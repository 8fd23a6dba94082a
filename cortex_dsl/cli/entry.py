"""`cortexc`: from a command line to an exit code, for every outcome.

`main` may be called from a test or a notebook: it changes nothing of its process. `cortex_dsl/__main__.py` has the code
for a process of its own.
"""

import contextlib
import os
import re
import sys
from collections.abc import Sequence

from cortex_dsl.console.terminal import Exit, Terminal, UsageError, report_bug
from cortex_dsl.installation import HOME, check_engine
from engine.errors import ControllerError, HiddenEngineError


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code; never raises, except under CORTEXC_DEBUG=1."""
    words = list(sys.argv[1:] if argv is None else argv)
    terminal = Terminal(colour=False if {"--no-colour", "--no-color"} & set(words) else None)
    try:
        code = _dispatch(words, terminal)
        sys.stdout.flush()
    except (UsageError, HiddenEngineError, ControllerError) as error:
        if isinstance(error, ControllerError) and error.raised is not None:
            _trace(error.raised, terminal)
        terminal.complain(error.message, error.cure)
        code = _documented(Exit.USAGE, error.message, error.cure, words, terminal)
    except KeyboardInterrupt:
        terminal.complain("interrupted")
        code = _documented(Exit.INTERRUPTED, "interrupted", "", words, terminal)
    except BrokenPipeError:  # `cortexc ... | head`: the reader has seen enough
        code = Exit.FINE
    except OSError as error:
        code = _no_output(error, terminal)
    except MemoryError as error:
        message = f"this takes more memory than there is{_how_much(error)}"
        cure = "fewer actors, scenes or steps take less"
        terminal.complain(message, cure)
        code = _documented(Exit.USAGE, message, cure, words, terminal)
    except Exception as error:
        if os.environ.get("CORTEXC_DEBUG") == "1":
            raise
        report_bug(error, words, terminal)
        code = _documented(Exit.BUG, f"a bug in cortexc: {type(error).__name__}", "please report it", words, terminal)
    return int(code)


def _trace(cause: BaseException, terminal: Terminal) -> None:
    """Print the traceback of an error in the user's own driver."""
    import traceback

    ours = tuple(str(HOME / package) for package in ("engine", "cortex_dsl"))
    frames = [frame for frame in traceback.extract_tb(cause.__traceback__) if not frame.filename.startswith(ours)]
    if len(frames) > 1:
        terminal.err.print("".join(traceback.format_list(frames)).rstrip(), style="quiet", markup=False, soft_wrap=True)


def _documented(code: Exit, message: str, cure: str, arguments: Sequence[str], terminal: Terminal) -> Exit:
    """Under --json stdout holds one document even where the command could not start or go on."""
    if "--json" not in arguments or terminal.wrote:
        return code
    with contextlib.suppress(OSError):
        terminal.document("error", {"message": message, "help": cure or None, "exit_code": int(code)})
        sys.stdout.flush()
    return code


def _dispatch(arguments: Sequence[str], terminal: Terminal) -> int:
    if strange := next(filter(_is_no_text, arguments), None):
        raise UsageError(f"`{strange}` is not UTF-8", "give the file a name of letters that are")
    check_engine()
    from cortex_dsl.cli.command_table import run_words

    return run_words(arguments, terminal)


def _is_no_text(word: str) -> bool:
    """Return whether a word has bytes that are no letters: journals, pages and JSON cannot name such a file."""
    return any("\ud800" <= letter <= "\udfff" for letter in word)


def _how_much(error: MemoryError) -> str:
    """Return the size that numpy reports in a memory error; empty without one."""
    found = re.search(r"allocate (\S+ \S+) for", str(error))
    return f": {found[1]} at once" if found else ""


def _no_output(error: OSError, terminal: Terminal) -> Exit:
    """Report that stdout is full: paths are checked where they are used, so the error is that of stdout."""
    from cortex_dsl.console.user_files import reason

    where = f"`{error.filename}`" if error.filename else "the output"
    terminal.complain(f"cannot write {where}: {reason(error)}", "free some space, or write elsewhere")
    return Exit.USAGE
