"""The table of commands. A new command is a function `(state, argument) -> None` and a row here.

The functions import simulators and searches when they are called, so that the prompt appears at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

from rich.text import Text

from cortex_dsl.console.terminal import UsageError
from cortex_dsl.repl import commands_cases, commands_draft, commands_info, commands_plot, commands_scenes
from cortex_dsl.repl.chunks import BARE_COMMANDS
from cortex_dsl.repl.state import State
from cortex_dsl.report.terminal.theme import columns, left
from cortex_dsl.spelling import did_you_mean, nearest


@dataclass(frozen=True)
class Command:
    """One word after a colon."""

    name: str
    argument: str
    """Argument as `:help` shows it."""
    summary: str
    function: Callable[[State, str], None]
    """Function of the session and the argument."""
    completes: tuple[str, ...] = ()
    """Kinds of its words, in order, by the names of `prompt.KINDS`; the last kind applies to all further words."""
    loud: bool = False
    """Whether `!` after its name overwrites existing contents."""


ENTERING = """\
Enter statements: each is checked at once, each `require` is tested on 10,000
draws, each `expect` on 400 runs. A definition replaces the old one of its name;
an expression shows what it is. After a colon, a comma or an open bracket a line
goes on; a blank line ends a block, Escape and Enter end anything."""


def do_help(state: State, argument: str) -> None:
    out, name = state.terminal.out, argument.removeprefix(":")
    if name and name not in COMMANDS:
        raise UsageError(f"there is no command `:{name}`", did_you_mean(name, COMMANDS) or "`:help` lists them all")
    rows = [
        (Text(f":{row.name}", "title"), Text(row.argument, "unit"), Text(row.summary))
        for row in COMMANDS.values()
        if not name or row.name == name
    ]
    if not name:
        out.print(Text(ENTERING), end="\n\n")
    out.print(columns(left(), left(), left(wrap=True), rows=rows))


SEARCH = "[N] [--objective NAME] [--metrics] [--paper]"
"""Words after the commands that search."""
_ROWS = (
    Command("help", "[COMMAND]", "this page, or one line about a command", do_help, ("command",)),
    Command("list", "", "the scenario, with the numbers of lines and entries", commands_draft.do_list),
    Command("undo", "", "undo the last change", commands_draft.do_undo),
    Command("redo", "", "redo the last undone change", commands_draft.do_redo),
    Command("edit", "N", "edit entry N; in a script, the next entry replaces it", commands_draft.do_edit, ("entry",)),
    Command("delete", "N", "remove entry N", commands_draft.do_delete, ("entry",)),
    Command("check", "", "all diagnostics, and ranges that can never be valid", commands_info.do_check),
    Command("sample", "[N]", "draw N scenes and count (10,000)", commands_scenes.do_sample),
    Command("scene", "", "draw one accepted scene here; again: the next one", commands_scenes.do_scene),
    Command("plot", "A[, B]", "distribution of an expression, or of two together", commands_plot.do_plot, ("value",)),
    Command("relax", "[SHARE%]", "which requirement to relax, to accept that share", commands_scenes.do_relax),
    Command("run", "[SEED] [--metrics]", "run one scene and show what happened", commands_scenes.do_run),
    Command("ga", SEARCH, "search genetically (10 generations of 100)", commands_scenes.do_ga, ("aim",)),
    Command("random", SEARCH, "search at random (as many runs)", commands_scenes.do_random, ("aim",)),
    Command("worst", "", "the worst cases of the last search, and their kinds", commands_cases.do_worst),
    Command(
        "watch",
        "[N] [PACE]",
        "play worst case N, as `:watch 2 0.5x` at half speed",
        commands_cases.do_watch,
        ("case", "pace"),
    ),
    Command(
        "export",
        "N FILE|FOLDER [FORMATS]",
        "write case N; the suffix (.scn, .csv …) sets the format",
        commands_cases.do_export,
        ("case", "path", "format"),
        loud=True,
    ),
    Command("show", "NAME", "what a name, unit or construct is", commands_info.do_show, ("name",)),
    Command("explain", "[CODE]", "what a code such as SCN203 means", commands_info.do_explain, ("code",)),
    Command("seed", "[N]", "the seed of all random numbers", commands_info.do_seed),
    Command("set", "[PARAM=VALUE]", "fix a param at a value; `:set PARAM` frees it", commands_info.do_set, ("param",)),
    Command("load", "FILE", "start over with a file", commands_draft.do_load, ("file",)),
    Command(
        "save",
        "[FILE]",
        "write the scenario, formatted; `:save!` overwrites",
        commands_draft.do_save,
        ("file",),
        loud=True,
    ),
    Command("quit", "", "leave (also Ctrl-D)", commands_info.do_quit),
)
COMMANDS: dict[str, Command] = {row.name: row for row in _ROWS}
SAME = {"exit": "quit", "q": "quit", "h": "help", "?": "help", "ls": "list", "l": "list"}


def execute(state: State, chunk: str) -> None:
    """Carry out a command.

    Raises:
        UsageError: there is no such command, or it cannot be carried out.
    """
    word, _, argument = chunk.strip().removeprefix(":").strip().partition(" ")
    name, loud = word.removesuffix("!"), word.endswith("!")
    name = SAME.get(name, name)
    if name not in COMMANDS or (loud and not COMMANDS[name].loud):
        raise UsageError(f"there is no command `:{word}`", _instead(name))
    command, state.editing = COMMANDS[name], None
    if argument.strip() and not command.argument:
        raise UsageError(f"`:{name}` takes no argument", "")
    command.function(state, f"! {argument.strip()}" if loud else argument.strip())


def _instead(word: str) -> str:
    near = nearest(word, (*COMMANDS, *BARE_COMMANDS))
    return f"did you mean `:{near}`?" if near else "`:help` lists them all"
