"""`cortexc`: from a command line to an exit code, whatever happens on the way."""

import contextlib
import os
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import cortex_dsl
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.terminal import Terminal


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code; never raises, except under CORTEXC_DEBUG=1."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    terminal = Terminal(colour=False if {"--no-colour", "--no-color"} & set(arguments) else None)
    _tolerate_encodings()
    try:
        code = _dispatch(arguments, terminal)
        sys.stdout.flush()
    except UsageError as error:
        terminal.complain(error.message, error.cure)
        code = Exit.USAGE
    except KeyboardInterrupt:
        terminal.complain("interrupted")
        code = Exit.INTERRUPTED
    except BrokenPipeError:
        code = _reader_left()
    except Exception as error:
        if os.environ.get("CORTEXC_DEBUG") == "1":
            raise
        code = _our_bug(error, arguments, terminal)
    return int(code)


def _dispatch(arguments: Sequence[str], terminal: Terminal) -> int:
    _insist_on_own_engine()
    from cortex_dsl.cli import commands
    from cortex_dsl.cli.parser import build_parser, to_request

    if arguments and arguments[0] in commands.SUBCOMMANDS:
        return commands.execute_subcommand(arguments[0], arguments[1:], terminal)
    parser = build_parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.version:
        from cortex_dsl.version import VERSION

        terminal.write(f"cortexc {VERSION}")
        return Exit.FINE
    return commands.execute(to_request(options, arguments), terminal)


def _insist_on_own_engine() -> None:
    """`engine` and `grammar` are common names: another package of that name may hide ours."""
    home = Path(cortex_dsl.__file__).resolve().parent.parent
    for name in ("engine", "grammar"):
        spec = find_spec(name)
        places = [] if spec is None else [Path(p).resolve() for p in spec.submodule_search_locations or ()]
        if home / name not in places:
            found = f"at {places[0]}" if places else "nowhere"
            raise UsageError(
                f"its package `{name}` should be at {home / name} but was found {found}",
                f"another package or folder called `{name}` hides it; install cortexc in an environment of its own",
            )


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


def _our_bug(error: Exception, arguments: Sequence[str], terminal: Terminal) -> Exit:
    from cortex_dsl.cli.bug import report_bug

    report_bug(error, arguments, terminal)
    return Exit.BUG
