"""Commands and options as rows: parsing, help, and the messages about options without effect follow from them.

The options that several commands have are rows here as well.
"""

import argparse
import os
import re
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from shlex import join
from typing import Any, NoReturn

from cortex_dsl.console.request import (
    GENERATION_LIMIT,
    SEED_LIMIT,
    RunRequest,
    SearchRequest,
    aggregate,
    assignment,
    reference_names,
    whole_number,
)
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.plain_text import harmless
from cortex_dsl.spelling import nearest
from engine.driving.names import Egos, added, words_of
from engine.frozen import frozen
from engine.vocabulary import OBSERVABLE


class Parser(argparse.ArgumentParser):
    """An argparse parser that suggests the nearest option in messages, and raises instead of ending the process."""

    def error(self, message: str) -> NoReturn:
        page = "--help-all" if HELP_ALL.flag in self._option_string_actions else "--help"
        raise UsageError(_tidy(message, self), f"`{self.prog} {page}` lists every option")

    def format_help(self) -> str:
        text = harmless(super().format_help())
        return _coloured(text) if _colour_wanted(sys.stdout) else text


def _tidy(message: str, parser: Parser) -> str:
    """The sentence of argparse, shorter, and with the option that was probably meant."""
    if found := re.fullmatch(r"unrecognized arguments: (.*)", message, re.DOTALL):
        word = found[1].split(" ")[0]
        match = nearest(word.split("=")[0], parser._option_string_actions) if word.startswith("-") else None
        if match is not None:
            return f"unknown option `{word}`; did you mean `{match}`?"
        return f"unknown option `{word}`" if word.startswith("-") else f"unexpected argument `{word}`"
    return re.sub(r"^argument (?:-p/)?(\S+?)(?:/--\S+)?: ", r"\1: ", message)


class TwoColumns(argparse.RawDescriptionHelpFormatter):
    """Two columns, each option named once with its value."""

    def __init__(self, prog: str, **_: object) -> None:
        width = max(60, min(100, shutil.get_terminal_size().columns))
        super().__init__(prog, max_help_position=27, width=width)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        names = ", ".join(name for name in action.option_strings if name != "--no-color")
        if not names:
            return super()._format_action_invocation(action)
        if action.nargs == 0:
            return names
        return f"{names} {self._format_args(action, self._get_default_metavar_for_optional(action))}"


def _colour_wanted(stream: object) -> bool:
    isatty = getattr(stream, "isatty", lambda: False)
    return isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"


def _coloured(text: str) -> str:
    """Headings bold, options in colour."""
    text = re.sub(r"^(\S[^\n]*:)$", "\x1b[1m\\1\x1b[0m", text, flags=re.MULTILINE)
    text = re.sub(r"^(usage:)", "\x1b[1m\\1\x1b[0m", text)
    return re.sub(r"^(  (?:-\S+(?:, -\S+)*|\d+ ))", "\x1b[36m\\1\x1b[0m", text, flags=re.MULTILINE)


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


# -- an option ---------------------------------------------------------------------------------------------------------

EXAMPLE_RUN = "{run}"
"""Placeholder in a help or a cure for the folder of the latest run."""


@frozen
class Condition:
    """A property of the command line on which the effect of options depends."""

    name: str
    """Noun phrase of messages: `has no effect on NAME`, `has no effect without NAME`."""
    holds: Callable[[argparse.Namespace], bool]
    """Predicate of the parsed options."""
    cure: str = ""
    """Cure of an option without effect; "": the cure of its row."""


@frozen
class Option:
    """An option or an argument of a command: words, value, and relations to other options."""

    flag: str
    """Spellings, separated by blanks, such as `-p --param`; name of an argument without a flag."""
    help: str
    """Text of the help; the default is appended in brackets."""
    metavar: str = ""
    """Name of the value; "" without `type` and `choices`: a switch."""
    type: Callable[[str], Any] | None = None
    """Function from text to value; raises `ArgumentTypeError` or `UsageError`."""
    choices: tuple[str, ...] = ()
    """Permitted values; (): all."""
    default: Any = None
    """Value of an option that is not given, set after all relations were checked."""
    name: str = ""
    """Attribute of the parsed options, and field of a request; "": the flag without dashes."""
    implies: Mapping[str, Any] = field(default_factory=dict)
    """Defaults of other options if this one is given, by their attributes."""
    nargs: str | None = None
    """Number of values, as in `argparse`."""
    const: Any = True
    """Value of an option that is given without a value."""
    collect: Callable[[Any, Any], Any] | None = None
    """Function from the earlier value (None at first) and the new value to both; raises `ValueError`."""
    answer: Callable[[argparse.Namespace], str] | None = None
    """Function from the options to a text that is printed instead of running the command; "": the command runs."""
    missing: tuple[str, str] | None = None
    """Message and cure if an argument that the command needs is not given."""
    group: str = ""
    """Heading in the help."""
    first_page: bool = True
    """Whether `--help` shows the row; if not, only `--help-all` does."""
    choice: str = ""
    """Task that the option chooses; options that choose different tasks exclude each other."""
    needs: tuple[str | Condition, ...] = ()
    """Conditions, or names of other options; "a b": at least one of the two."""
    excludes: tuple[str | Condition, ...] = ()
    """Conditions, or names of other options, under which the option has no effect."""
    cure: str = ""
    """Cure if the option has no effect; "": leave it out."""

    @property
    def typed(self) -> str:
        """The spelling that messages use."""
        return self.flag.split(" ")[0] if self.flag.startswith("-") else self.metavar

    @property
    def dest(self) -> str:
        """The attribute of the parsed options."""
        return self.name or self.flag.split(" ")[0].lstrip("-").replace("-", "_")

    def words(self, value: str) -> str:
        """Return flag and value, as one types them."""
        return f"{self.typed} {self.choices[0] if len(self.choices) == 1 else value}".rstrip()

    def add_to(self, parser: argparse._ActionsContainer) -> None:
        """Add the option to a parser, or to a group of one."""
        is_flag = self.flag.startswith("-")
        is_switch = is_flag and not (self.metavar or self.type or self.choices)
        keywords: dict[str, Any] = {
            "row": self,
            "nargs": 0 if is_switch else self.nargs,
            "const": self.const,
            "type": self.type,
            "choices": self.choices or None,
            "help": self.help if self.help is argparse.SUPPRESS else with_example(self.help) + _shown(self.default),
            "metavar": self.metavar or None,
        }
        if is_flag:
            parser.add_argument(*self.flag.split(" "), action=_Store, dest=self.dest, **keywords)
        else:
            parser.add_argument(self.dest, action=_Store, **keywords)


def _shown(default: Any) -> str:
    """Return a default as the help shows it, such as ` (30)`; "" if there is none."""
    if default is None or default is False or default in ((), {}):
        return ""
    match default:
        case tuple():
            shown = ",".join(default)
        case str():
            shown = default
        case int():
            shown = f"{default:,}"
        case _:
            shown = f"{default:g}"
    return f" ({shown})"


class _Store(argparse.Action):
    """Stores the value of an option; the row says how values of a repeated option are collected."""

    def __init__(self, row: Option, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.row = row

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,  # noqa: ARG002 - a parameter of argparse
    ) -> None:
        value = self.const if self.nargs == 0 else values
        if self.row.collect is not None:
            try:
                value = self.row.collect(getattr(namespace, self.dest), value)
            except ValueError as error:
                parser.error(f"{self.row.typed} {values}: {error}")
        setattr(namespace, self.dest, value)


def add_rows(parser: Parser, rows: Sequence[Option]) -> Parser:
    """Add options to a parser, each below its heading; return the parser."""
    groups: dict[str, argparse._ActionsContainer] = {"": parser}
    for row in rows:
        if row.group not in groups:
            groups[row.group] = parser.add_argument_group(row.group)
        row.add_to(groups[row.group])
    return parser


def settle(rows: Sequence[Option], options: argparse.Namespace) -> argparse.Namespace:
    """Check the given options, set the defaults and `options.choice`, and return the options.

    Raises:
        UsageError: an argument is missing, or an option has no effect; the row gives message and cure.
    """
    given = {row.dest: row for row in rows if getattr(options, row.dest) not in (None, [])}
    for row in rows:
        if row.missing is not None and row.dest not in given:
            raise UsageError(row.missing[0], with_example(row.missing[1]))
    chosen = {row.choice: row.typed for row in reversed(given.values()) if row.choice}
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(reversed(chosen.values()))} ask for different things", "give one of them")
    options.choice = next(iter(chosen), "")
    known = {row.dest: row for row in rows}
    for row in given.values():
        _check_effect(row, known, given, options)
    implied = {name: value for row in given.values() for name, value in row.implies.items()}
    for row in rows:
        if row.dest not in given:
            setattr(options, row.dest, implied.get(row.dest, row.default))
    return options


def _check_effect(
    row: Option, known: Mapping[str, Option], given: Mapping[str, Option], options: argparse.Namespace
) -> None:
    """Check the relations of an option that is given.

    Raises:
        UsageError: the option has no effect.
    """
    leave_out = row.cure or f"leave {row.typed} out"
    for each in row.excludes:
        if isinstance(each, Condition):
            if each.holds(options):
                raise UsageError(f"{row.typed} has no effect on {each.name}", each.cure or leave_out)
        elif each in given:
            raise UsageError(f"{row.typed} has no effect with {given[each].typed}", leave_out)
    for each in row.needs:
        if isinstance(each, Condition):
            if not each.holds(options):
                raise UsageError(f"{row.typed} has no effect without {each.name}", each.cure or leave_out)
            continue
        others = [known[name] for name in each.split() if name in known]
        if not any(other.dest in given for other in others):
            without = " or ".join(other.words("") for other in others)
            add = " or ".join(other.words(other.metavar) for other in others)
            raise UsageError(f"{row.typed} has no effect without {without}", f"add {add}, or {leave_out}")


# -- a command ---------------------------------------------------------------------------------------------------------


@frozen
class Command:
    """A command `cortexc NAME`: words, help, options, and the function behind them.

    All commands have --help and --no-colour, and --json if they can answer with a document.
    """

    name: str
    """First word; "": the command `cortexc FILE`."""
    usage: str
    """Words after the name, one line per form."""
    description: str
    options: Sequence[Option]
    """Rows of the options, in the order of the help."""
    function: Callable[[argparse.Namespace, Terminal], int]
    """Function from the options to an exit code; `options.command_line` holds the words as typed."""
    epilog: str = ""
    """Text at the end of the help."""
    json: bool = True
    """Whether the command can answer with one document."""
    layout: type[argparse.HelpFormatter] = argparse.RawDescriptionHelpFormatter
    """Layout of the help; `argparse.HelpFormatter` wraps the texts to the width of the terminal."""
    first_page: tuple[str, str] | None = None
    """Description and epilog of `--help` where `--help-all` has more; None: there is one help."""

    @property
    def rows(self) -> list[Option]:
        """All options, including those that every command has."""
        own = {row.dest for row in self.options}
        shared = (*((JSON,) if self.json else ()), replace(NO_COLOUR, help=argparse.SUPPRESS), HELP)
        return [*self.options, *(row for row in shared if row.dest not in own)]

    def parser(self) -> Parser:
        """Return the parser of the command line, with its options in order."""
        parser = Parser(
            prog=f"cortexc {self.name}".rstrip(),
            usage="\n       ".join(f"cortexc {f'{self.name} {line}'.strip()}" for line in self.usage.split("\n")),
            description=self.description,
            epilog=with_example(self.epilog) or None,
            formatter_class=self.layout,
            allow_abbrev=False,
            add_help=False,
        )
        return add_rows(parser, self.rows)

    def help_page(self, *, all_rows: bool) -> str:
        """Return the text of `--help-all`, or of `--help` without `all_rows`."""
        if all_rows or self.first_page is None:
            return self.parser().format_help()
        description, epilog = self.first_page
        options = [row for row in self.options if row.first_page]
        return replace(self, description=description, epilog=epilog, options=options).parser().format_help()


def run_command(command: Command, words: Sequence[str], terminal: Terminal) -> int:
    """Run a command with these words and return its exit code.

    Raises:
        UsageError: the words are not as the command needs them.
    """
    rows = command.rows
    options = command.parser().parse_args(words)
    all_rows = bool(getattr(options, HELP_ALL.dest, False))
    if options.help or all_rows:
        terminal.write(command.help_page(all_rows=all_rows), coloured=True)
        return Exit.FINE
    for row in rows:
        if row.answer and getattr(options, row.dest) is not None and (text := row.answer(options)):
            terminal.write(text)
            return Exit.FINE
    options.command_line = tuple(words)
    return command.function(settle(rows, options), terminal)


FORM = ("--json", "--no-colour", "--no-color")
"""Options that change only the form of the output."""


def typed_again(name: str, words: Sequence[str]) -> str:
    """Return the command line as it was typed, without the options of `FORM`."""
    return join(["cortexc", name, *(word for word in words if word not in FORM)])


def with_example(text: str) -> str:
    """Return the text with the folder of a run in the place of `EXAMPLE_RUN`."""
    if EXAMPLE_RUN not in text:
        return text
    from engine.search.store import example_run

    return text.replace(EXAMPLE_RUN, str(example_run()))


# -- rows that several commands have -----------------------------------------------------------------------------------


def _with_param(earlier: dict[str, str] | None, pair: tuple[str, str]) -> dict[str, str]:
    name, value = pair
    if name in (earlier or {}):
        raise UsageError(f"-p {name} is given twice", "give every param once")
    return {**(earlier or {}), name: value}


HELP = Option("-h --help", "this page", name="help")
HELP_ALL = Option("--help-all", "every command, every option, and the exit codes")
JSON = Option("--json", "one JSON document on stdout, and nothing else there", default=False)
METRICS = Option("--metrics", "show every measure, the params, and how runs ended", default=False, excludes=("json",))
PAPER = Option(
    "--paper",
    "show the figures of the paper: RL, NC, MDG, MDEC, NIS",
    default=False,
    excludes=("json",),
)
NO_COLOUR = Option("--no-colour --no-color", "plain output", default=False)
JOBS = Option("--jobs", "threads; results never depend on it", "N", whole_number(1, 1024), default=cores())
DASK = Option("--dask", "address of a Dask scheduler; `local` starts one for the search", "ADDRESS")
PARAM = Option("-p --param", "fix a param", "NAME=VALUE", assignment, name="overrides", default={}, collect=_with_param)
SCENARIO = Option("--scenario", "the scenario to run, where the file has several (Main)", "NAME")
SEED = Option("--seed", "seed of all random numbers (0)", "N", whole_number(0, SEED_LIMIT))
EGO = Option(
    "--ego",
    "driver of the ego: python:package.module:function or process:COMMAND; of several controllers one for each: "
    "--ego CONTROLLER=python:...",
    "NAME",
    collect=added,
)
DRIVER = (
    EGO,
    Option(
        "--ego-observes",
        "what it observes: records of the file, where it has any, or egocentric, what is seen from its seat",
        "WHAT",
        choices=OBSERVABLE,
        default=RunRequest.ego_observes,
        needs=("ego",),
    ),
    Option(
        "--ego-batch",
        "scenes passed to this driver in one call",
        "N",
        whole_number(1, 10**6),
        default=RunRequest.ego_batch,
        needs=("ego",),
    ),
)
PROFILE = Option(
    "--profile",
    "thresholds of the risk score",
    "NAME",
    choices=("paper", "paper-mm", "literature"),
    default=RunRequest.profile,
)
GENERATIONS = Option(
    "--generations", "generations", "N", whole_number(1, GENERATION_LIMIT), default=SearchRequest.generations
)
POPULATION = Option(
    "--population",
    "individuals in each generation",
    "N",
    whole_number(2, 10**6, "a crossover needs two parents"),
    default=SearchRequest.population,
)
PRESET = Option(
    "--preset",
    "preset of the genetic algorithm",
    "NAME",
    choices=("cortex", "cortex-literal"),
    default=SearchRequest.preset,
)
OBJECTIVE = Option(
    "--objective",
    "goal of the search; may be repeated",
    "NAME",
    default=SearchRequest.objective,
    collect=lambda earlier, name: (*(earlier or ()), name),
)
REFERENCES = Option(
    "--reference",
    "reference drivers that judge collisions, separated by commas: careful, reg157, rss, fsm, cc",
    "NAMES",
    reference_names,
    name="references",
    default=RunRequest.references,
)
ROLLOUTS = Option(
    "--rollouts", "scenes for each individual", "K", whole_number(1, 10_000), default=SearchRequest.rollouts
)
AGGREGATE = Option(
    "--aggregate",
    "one score from K: mean, max or a quantile such as q90",
    "HOW",
    aggregate,
    default=SearchRequest.aggregate,
    needs=("rollouts",),
)


def run_of(command: str) -> Option:
    """Return the argument of a command that needs a run."""
    cure = f"name the folder of one, such as `cortexc {command} {EXAMPLE_RUN}`"
    return Option("run", "a run directory", "RUN", Path, nargs="?", missing=("no run given", cure))


def excluded_by(condition: str | Condition, *rows: Option) -> tuple[Option, ...]:
    """Return rows that have no effect under a condition, or with another option, either."""
    return tuple(replace(row, excludes=(*row.excludes, condition)) for row in rows)


def driver_words(ego: Egos | None, batch: int | None, observes: str | None) -> list[str]:
    """Return the words of a command line that name a driver again; settings that are usual give no word."""
    words = [] if ego is None else words_of(ego)
    words += [] if batch in (None, RunRequest.ego_batch) else ["--ego-batch", str(batch)]
    return words + ([] if observes in (None, RunRequest.ego_observes) else ["--ego-observes", str(observes)])
