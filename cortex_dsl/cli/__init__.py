"""The command `cortexc`: one file a command, and one table that names them."""

from cortex_dsl.cli.entry import main

__all__ = ["main"]
