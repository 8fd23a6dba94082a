"""How a command ends: its exit codes, and the exception that means the user's own slip."""

from enum import IntEnum

from engine.errors import CortexError


class Exit(IntEnum):
    """Exit codes of every command."""

    FINE = 0
    DIAGNOSTICS = 1
    """The file has errors."""
    USAGE = 2
    """A wrong command line, or a path that cannot be read or written."""
    NO_SCENE = 3
    """Infeasible, exhausted, or a single run that was aborted."""
    BUG = 70
    """Ours. `EX_SOFTWARE` of sysexits.h."""
    INTERRUPTED = 130
    """Ctrl-C: 128 + SIGINT."""


class UsageError(CortexError):
    """The command cannot go on, and the user can mend it: what is wrong, and how to cure it."""
