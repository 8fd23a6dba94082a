"""The table of commands. A new one is a function `(state, argument) -> None` and a row here."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from cortex_dsl.console.terminal import UsageError
from cortex_dsl.repl.chunks import BARE_COMMANDS
from cortex_dsl.repl.state import State
from cortex_dsl.spelling import nearest


@dataclass(frozen=True)
class Command:
    """One word after a colon."""

    name: str
    argument: str
    """As `:help` shows it."""
    summary: str
    module: str
    """In this package; its function has the name of the command, and is imported when it is first asked for."""
    completes: tuple[str, ...] = ()
    """What its words are, in their order, by the names of `offers.KINDS`; the last goes on to the end."""
    loud: bool = False
    """Whether `!` after its name writes over what is there."""


_ROWS = (
    Command("help", "[COMMAND]", "this page, or one line about a command", "commands_info", ("command",)),
    Command("list", "", "the scenario, with the numbers of lines and entries", "commands_draft"),
    Command("undo", "", "undo the last change", "commands_draft"),
    Command("redo", "", "redo the last undone change", "commands_draft"),
    Command("edit", "N", "edit entry N; in a script, the next entry replaces it", "commands_draft", ("entry",)),
    Command("delete", "N", "remove entry N", "commands_draft", ("entry",)),
    Command("check", "", "all diagnostics, and ranges that can never be valid", "commands_info"),
    Command("sample", "[N]", "draw N scenes and count (10,000)", "commands_scenes"),
    Command("scene", "", "draw one accepted scene here; again: the next one", "commands_scenes"),
    Command("plot", "A[, B]", "distribution of an expression, or of two together", "commands_plot", ("value",)),
    Command("relax", "[SHARE%]", "which requirement to relax, to accept that share", "commands_scenes"),
    Command("run", "[SEED]", "run one scene and show what happened", "commands_scenes"),
    Command(
        "ga",
        "[N] [--objective NAME]",
        "search genetically (10 generations of 100)",
        "commands_scenes",
        ("aim",),
    ),
    Command("random", "[N] [--objective NAME]", "search at random (as many runs)", "commands_scenes", ("aim",)),
    Command("worst", "", "the worst cases of the last search, and their kinds", "commands_cases"),
    Command(
        "watch",
        "[N] [PACE]",
        "play worst case N, as `:watch 2 0.5x` at half speed",
        "commands_cases",
        ("case", "pace"),
    ),
    Command(
        "export",
        "N FILE|FOLDER [FORMATS]",
        "write case N; the suffix (.scn, .csv …) sets the format",
        "commands_cases",
        ("case", "path", "format"),
        loud=True,
    ),
    Command("show", "NAME", "what a name, unit or construct is", "commands_info", ("name",)),
    Command("explain", "[CODE]", "what a code such as SCN203 means", "commands_info", ("code",)),
    Command("seed", "[N]", "the seed of all random numbers", "commands_info"),
    Command("set", "[PARAM=VALUE]", "fix a param at a value; `:set PARAM` frees it", "commands_info", ("param",)),
    Command("load", "FILE", "start over with a file", "commands_draft", ("file",)),
    Command(
        "save",
        "[FILE]",
        "write the scenario, formatted; `:save!` overwrites",
        "commands_draft",
        ("file",),
        loud=True,
    ),
    Command("quit", "", "leave (also Ctrl-D)", "commands_info"),
)
COMMANDS: dict[str, Command] = {row.name: row for row in _ROWS}
SAME = {"exit": "quit", "q": "quit", "h": "help", "?": "help", "ls": "list", "l": "list"}


def execute(state: State, chunk: str) -> None:
    """Carry out a command.

    Raises:
        UsageError: there is no such command, or it cannot do what it was asked for.
    """
    word, _, argument = chunk.strip().removeprefix(":").strip().partition(" ")
    name, loud = word.removesuffix("!"), word.endswith("!")
    name = SAME.get(name, name)
    if name not in COMMANDS or (loud and not COMMANDS[name].loud):
        raise UsageError(f"there is no command `:{word}`", _instead(name))
    command, state.editing = COMMANDS[name], None
    if argument.strip() and not command.argument:
        raise UsageError(f"`:{name}` takes no argument", "")
    act: Callable[[State, str], None] = getattr(import_module(f"cortex_dsl.repl.{command.module}"), f"do_{name}")
    act(state, f"! {argument.strip()}" if loud else argument.strip())


def _instead(word: str) -> str:
    near = nearest(word, (*COMMANDS, *BARE_COMMANDS))
    return f"did you mean `:{near}`?" if near else "`:help` lists them all"


def whole_number(text: str, default: int, what: str, most: int) -> int:
    """A count from 1 to `most`; without a text the default.

    Raises:
        UsageError: the text is no such count.
    """
    digits = text.replace(",", "").replace("_", "")
    if not text:
        return default
    if not digits.isascii() or not digits.isdigit() or not 1 <= int(digits[:12]) <= most:
        raise UsageError(f"{what} must be a whole number from 1 to {most:,}, not `{text}`")
    return int(digits)
