"""Command lines as people guess them who know other tools: `cortexc check FILE`, `cortexc --explain CODE`."""

import os
import shlex
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.spelling import nearest

_FLAGS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("run", "simulate", "sim", "start"), ""),
        **dict.fromkeys(("check", "lint", "validate", "compile"), "--check"),
        **dict.fromkeys(("ga", "search", "hunt", "fuzz"), "--ga"),
        "random": "--random",
        "sample": "--sample 10000",
        "emit": "--emit ast",
    }
)
"""First words that are no commands, and the flag that does what they say."""
_COMMANDS: Mapping[str, str] = MappingProxyType(
    {"format": "fmt", "analyze": "analyse", "shell": "repl", "convert": "export", "play": "replay"}
)
"""Words for commands that have another name here."""
_PAGES = ("help", "version")


def refuse_guesses(arguments: Sequence[str], commands: Iterable[str]) -> None:
    """Answer a command line whose first word is taken from elsewhere.

    Raises:
        UsageError: it is; the cure is the line as it should be.
    """
    if not arguments or os.access(arguments[0], os.F_OK):
        return
    first, rest = arguments[0], arguments[1:]
    if first in _PAGES:
        raise UsageError(f"`{first}` is an option here", f"write `cortexc --{first}`")
    if first in _FLAGS:
        raise UsageError(
            f"there is no command `{first}`", f"write `{_line(*(rest or ['FILE']), *_FLAGS[first].split())}`"
        )
    if (meant := _command(first, tuple(commands))) is not None:
        told = f"`{meant}` is a command, not an option" if first == f"--{meant}" else f"there is no command `{first}`"
        raise UsageError(told, f"write `{_line(meant, *rest)}`")


def _command(word: str, commands: Sequence[str]) -> str | None:
    """The command that is meant by a word, which may be written as an option."""
    bare = word.removeprefix("--")
    if bare in commands or bare in _COMMANDS:
        return _COMMANDS.get(bare, bare)
    is_word = bare == word and word.replace("-", "").isalpha()
    return nearest(word, commands) if is_word else None


def _line(*words: str) -> str:
    return shlex.join(("cortexc", *words))
