"""Relations between options are data: every command refuses an option without effect, and says what to do."""

from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

import pytest

from cortex_dsl.cli.command_table import FILE, SUBCOMMANDS
from cortex_dsl.console.command import Command, Condition, Option, settle
from cortex_dsl.console.terminal import UsageError

COMMANDS = {"FILE": FILE, **{name: row.load() for name, row in SUBCOMMANDS.items()}}
ANYWHERE = {row.dest for command in COMMANDS.values() for row in command.rows}
"""Options of all commands: a row of several commands may need one of two options of which some commands have one."""
EVERY_COMMAND = pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)


def relations(kind: str) -> list[tuple[Command, Option, str]]:
    """Every option of every command that names another option as needed or excluded."""
    return [
        (command, row, each)
        for command in COMMANDS.values()
        for row in command.rows
        for each in getattr(row, kind)
        if isinstance(each, str)
    ]


def said(command: Command, *given: str) -> str:
    """Message and cure of a command line on which these options are given, and nothing else."""
    values = {row.dest: Path("file.scn") if row.dest in given or row.missing else None for row in command.rows}
    try:
        settle(command.rows, Namespace(**values))
    except UsageError as error:
        return str(error)
    return ""


def named(*kinds: str) -> Iterator[str]:
    for kind in kinds:
        yield from (f"{command.name or 'FILE'} {row.typed} {each}" for command, row, each in relations(kind))


@EVERY_COMMAND
def test_a_relation_names_options_of_the_command(command: Command) -> None:
    """A name that is misspelt would make a relation that never holds."""
    known = {row.dest for row in command.rows}
    for row in command.rows:
        for each in (*row.needs, *row.excludes):
            names = set() if isinstance(each, Condition) else set(each.split())
            assert isinstance(each, Condition) or known & names, (row.typed, each)
            assert names <= ANYWHERE, (row.typed, each)
    assert len(known) == len(command.rows)


@pytest.mark.parametrize(("command", "row", "other"), relations("excludes"), ids=named("excludes"))
def test_an_excluded_option_is_refused(command: Command, row: Option, other: str) -> None:
    """Together with the option that excludes it, and not because of the other one alone."""
    flag = {each.dest: each.typed for each in command.rows}[other]
    assert f"{row.typed} has no effect with {flag} (leave {row.typed} out" in said(command, row.dest, other)
    assert f"has no effect with {flag}" not in said(command, row.dest)


@pytest.mark.parametrize(("command", "row", "other"), relations("needs"), ids=named("needs"))
def test_an_option_that_needs_another_is_refused_alone(command: Command, row: Option, other: str) -> None:
    """The message names the option that is missing, the cure adds it; with the option the message is gone."""
    message = said(command, row.dest)
    if row.excludes and "has no effect on" in message:  # a search option: what it needs is asked on a search
        assert "has no effect without" in said(command, row.dest, "ga")
        assert "has no effect without" not in said(command, row.dest, "ga", other)
        return
    assert message.startswith(f"{row.typed} has no effect without --"), message
    assert "(add --" in message
    for name in other.split():
        if name in {each.dest for each in command.rows}:
            assert message != said(command, row.dest, name)


@EVERY_COMMAND
def test_options_of_different_tasks_exclude_each_other(command: Command) -> None:
    """In the order of the rows, and whichever of a task's options is given."""
    tasks = [row for row in command.rows if row.choice]
    for one in tasks:
        for other in tasks[tasks.index(one) + 1 :]:
            both = said(command, one.dest, other.dest)
            refused = f"{one.typed} and {other.typed} ask for different things (give one of them)"
            assert (both == refused) is (one.choice != other.choice)
