"""The command `cortexc`: one file a command, and one table that names them."""

from collections.abc import Sequence

from cortex_dsl.installation import provide_errors


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code; see `cortex_dsl.cli.entry`."""
    provide_errors()
    from cortex_dsl.cli import entry

    return entry.main(argv)
