"""`cortexc`: from a command line to an exit code, whatever happens on the way."""

import atexit
import contextlib
import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import cortex_dsl
from cortex_dsl.console.terminal import Exit, Terminal, UsageError


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code; never raises, except under CORTEXC_DEBUG=1."""
    _open_streams()
    _start_light()
    arguments = list(sys.argv[1:] if argv is None else argv)
    terminal = Terminal(colour=False if {"--no-colour", "--no-color"} & set(arguments) else None)
    _tolerate_encodings()
    try:
        code = _dispatch(arguments, terminal)
        sys.stdout.flush()
    except UsageError as error:
        terminal.complain(error.message, error.cure)
        code = _documented(Exit.USAGE, error.message, error.cure, arguments, terminal)
    except KeyboardInterrupt:
        terminal.complain("interrupted")
        code = _documented(Exit.INTERRUPTED, "interrupted", "", arguments, terminal)
    except BrokenPipeError:
        code = _reader_left()
    except OSError as error:
        code = _no_output(error, terminal)
    except Exception as error:
        if os.environ.get("CORTEXC_DEBUG") == "1":
            raise
        code = _our_bug(error, arguments, terminal)
    return int(code)


def _documented(code: Exit, message: str, cure: str, arguments: Sequence[str], terminal: Terminal) -> Exit:
    """Under --json stdout holds one document even where the command could not start or go on."""
    if "--json" not in arguments or terminal.wrote:
        return code
    from cortex_dsl.report.documents import document

    try:
        terminal.write(document("error", {"message": message, "help": cure or None, "exit_code": int(code)}))
        sys.stdout.flush()
    except OSError:
        _reader_left()
    return code


def _dispatch(arguments: Sequence[str], terminal: Terminal) -> int:
    _insist_on_own_engine()
    from cortex_dsl.cli import command_table
    from cortex_dsl.cli.file_options import build_parser, to_request

    if arguments and arguments[0] in command_table.SUBCOMMANDS:
        return command_table.execute_subcommand(arguments[0], arguments[1:], terminal)
    command_table.refuse_guesses(arguments, command_table.SUBCOMMANDS)
    parser = build_parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.version:
        from cortex_dsl.version import VERSION

        terminal.write(f"cortexc {VERSION}")
        return Exit.FINE
    if options.method == "list":
        terminal.write(import_module("cortex_dsl.cli.search").method_list())
        return Exit.FINE
    return command_table.execute(to_request(options, arguments), terminal)


def _insist_on_own_engine() -> None:
    """`engine` is a common name: another package of that name may hide ours."""
    home = Path(cortex_dsl.__file__).resolve().parent.parent / "engine"
    spec = find_spec("engine")
    places = [] if spec is None else [Path(p).resolve() for p in spec.submodule_search_locations or ()]
    if home not in places:
        found = f"at {places[0]}" if places else "nowhere"
        raise UsageError(
            f"its package `engine` should be at {home} but was found {found}",
            "another package or folder called `engine` hides it; install cortexc in an environment of its own",
        )


def _start_light() -> None:
    """What nobody here needs costs half of a short command: threads for matrices, which only spin, and looking for
    garbage, again and again while the compiler makes what lives until the end, and once more at the end, when all of it
    goes anyway.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(200_000)
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)


def _open_streams() -> None:
    """A command that was started with `>&-` has no streams: what it says goes nowhere."""
    if sys.stdout is None:
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - open until the process ends
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - open until the process ends


def _tolerate_encodings() -> None:
    """A terminal that cannot show a character shows a question mark instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")


def _reader_left() -> Exit:
    """`cortexc ... | head`: the reader has seen enough. Python must not fail again when it closes stdout."""
    with contextlib.suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return Exit.FINE


def _no_output(error: OSError, terminal: Terminal) -> Exit:
    """Paths are checked where they are used; what is left is stdout, on a full disk."""
    from cortex_dsl.console.user_files import reason

    where = f"`{error.filename}`" if error.filename else "the output"
    terminal.complain(f"cannot write {where}: {reason(error)}", "free some space, or write elsewhere")
    _reader_left()
    return Exit.USAGE


def _our_bug(error: Exception, arguments: Sequence[str], terminal: Terminal) -> Exit:
    from cortex_dsl.console.terminal import report_bug

    report_bug(error, arguments, terminal)
    return _documented(Exit.BUG, f"a bug in cortexc: {type(error).__name__}", "please report it", arguments, terminal)
