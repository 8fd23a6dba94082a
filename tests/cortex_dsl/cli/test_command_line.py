"""The command line itself: what it takes, what it refuses, and what it says then."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from cortex_dsl.cli.command_table import FILE, MODES, SUBCOMMANDS
from cortex_dsl.cli.file_options import OPTIONS, to_request
from cortex_dsl.console.command import Command, Option, settle
from cortex_dsl.console.request import CompileRequest, Mode, Request, RunRequest, SearchRequest
from cortex_dsl.version import VERSION


def request_of(*arguments: str) -> Request:
    return to_request(settle(OPTIONS, FILE.parser().parse_args(arguments)))


def page(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return what a command line prints, without colours."""
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "\x1b" not in text
    return text


def words(text: str) -> list[str]:
    return re.findall(r"[\w-]+", text)


def test_help_is_complete(capsys: pytest.CaptureFixture[str]) -> None:
    """`--help-all` answers on stdout and names every option and command with a sentence of its own."""
    text = page(capsys, "--help-all")
    for row in FILE.rows:
        assert row.help
        assert all(name in text for name in row.flag.split() if name not in ("file", "--no-color"))
    for name, command in SUBCOMMANDS.items():
        assert re.search(rf"^  cortexc {name}\b.* {re.escape(command.summary)}$", text, re.MULTILINE)
    assert "exit codes" in text


def test_the_first_page_fits_a_screen(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """`--help` has at most 60 lines: the rows marked for it and no others, in the words of `--help-all`."""
    monkeypatch.setenv("COLUMNS", "80")
    first, everything = page(capsys, "--help"), page(capsys, "--help-all")
    assert len(first.splitlines()) <= 60
    assert set(words(first)) <= set(words(everything))
    assert "--help-all" in words(first)
    named = set(re.findall(r"^  (?:-\w, )?(--\S+)", first, re.MULTILINE))
    assert named == {row.flag.split()[-1] for row in OPTIONS if row.first_page}
    listed = set(re.findall(r"^  cortexc ([a-z-]+)", first, re.MULTILINE))
    assert listed == {name for name, row in SUBCOMMANDS.items() if row.first_page}


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["--help-all"],
        *([name, "--help"] for name in SUBCOMMANDS),
        ["--method", "list"],
        ["export", "--to", "list"],
    ],
    ids=" ".join,
)
def test_help_fits_a_narrow_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    """Every page and every list is at most 80 columns wide."""
    monkeypatch.setenv("COLUMNS", "80")
    assert main(arguments) == 0
    assert [line for line in capsys.readouterr().out.splitlines() if len(line) > 80] == []


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    """`--version` prints the version and nothing else."""
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"cortexc {VERSION}\n"


@pytest.mark.parametrize(
    ("arguments", "mode"),
    [
        ([], Mode.RUN),
        (["--ga"], Mode.SEARCH),
        (["--random"], Mode.SEARCH),
        (["--ga", "--random"], Mode.SEARCH),
        (["--sample", "10"], Mode.SAMPLE),
        (["--check"], Mode.CHECK),
        (["--emit", "ir"], Mode.EMIT),
    ],
)
def test_flags_choose_the_mode(arguments: list[str], mode: Mode) -> None:
    """One flag, one thing to do; none: one run."""
    assert request_of("a.scn", *arguments).mode is mode


def test_options_arrive() -> None:
    """Every option of a search lands in the request under its own name."""
    search = "--ga --random --generations 3 --population 4 --seed 5 --preset cortex-literal --engine world"
    more = "--rollouts 2 --aggregate q90 --jobs 6 --out there --max-attempts 7 --time-step 0.01"
    output = "--profile literature --json --no-colour"
    words = f"a.scn {search} {more} {output}".split()
    request = request_of(*words, "-p", "A=5 km/h", "-p", "B=Range(1, 2)")
    assert request.compile == CompileRequest(
        Path("a.scn"), overrides={"A": "5 km/h", "B": "Range(1, 2)"}, json=True, diagnostics_format="json"
    )
    assert request.run == RunRequest(5, "world", max_attempts=7, time_step=0.01, profile="literature", jobs=6)
    assert request.search == SearchRequest(
        ("ga", "random"), 3, 4, "cortex-literal", 2, "q90", out=Path("there"), command_line=request.search.command_line
    )


def test_every_mode_is_a_row() -> None:
    """Each mode has a function, and a flag that chooses it, unless it is the run that no flag chooses."""
    assert set(MODES) == set(Mode)
    assert {row.choice for row in OPTIONS if row.choice} == {mode.value for mode in Mode} - {Mode.RUN.value}


def test_every_option_arrives_in_one_part_of_the_request() -> None:
    """A row is named as one field of one part; those that choose a method or an answer make a field together."""
    names = [field.name for part in (CompileRequest, RunRequest, SearchRequest, Request) for field in fields(part)]
    for row in OPTIONS:
        together = row.choice or row.answer or row.dest in ("help", "help_all", "no_colour")
        assert together or names.count(row.dest) == 1, row.flag


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_a_subcommand_is_a_row(name: str) -> None:
    """What a row of the table names is a command of that name, which says what it does."""
    command = SUBCOMMANDS[name].load()
    assert isinstance(command, Command)
    assert command.name == name
    assert command.description


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--ga", "--population", "1"], "--population: must be at least 2 .*not 1"),
        (["--ga", "--population", "-3"], "--population: must be at least 2"),
        (["--ga", "--population", "nan"], "--population: must be a whole number, not `nan`"),
        (["--ga", "--generations", "0"], "--generations: must be at least 1"),
        (["--ga", "--generations", "1e3"], "--generations: must be a whole number"),
        (["--ga", "--generations", "10000", "--population", "1000000"], "more than 100,000,000 simulations"),
        (["--seed", "-1"], "--seed: must be at least 0"),
        (["--seed", str(2**63)], "--seed: must be at most"),
        (["--time-step", "nan"], "--time-step: must lie between"),
        (["--time-step", "0"], "--time-step: must lie between"),
        (["--time-step", "inf"], "--time-step: must lie between"),
        (["--time-step", "soon"], "--time-step: must be a number of seconds"),
        (["--sample", "0"], "--sample: must be at least 1"),
        (["--ga", "--rollouts", "2", "--aggregate", "q100"], "--aggregate: must be `mean`, `max` or a quantile"),
        (["--ga", "--aggregate", "max"], "--aggregate has no effect"),
        (["--random", "--preset", "cortex"], "--preset has no effect"),
        (["--generations", "3"], "--generations has no effect on a single run"),
        (["--check", "--seed", "3"], "--seed has no effect on --check"),
        (["--sample", "3", "--engine", "batch"], "--engine has no effect on --sample"),
        (["--ga", "--check"], "--ga and --check ask for different things"),
        (["--emit", "nothing"], "--emit: invalid choice"),
        (["--engine", "fast"], "--engine: invalid choice"),
        (["-p", "SPEED"], "--param: must be NAME=VALUE"),
        (["-p", "=5"], "cannot be the name of a param"),
        (["bad\udcff.scn", "--ga"], "is not UTF-8"),
        (["-p", "A=1", "-p", "A=2"], "-p A is given twice"),
        (["--popluation", "5"], "unknown option `--popluation`; did you mean `--population`"),
        (["b.scn"], "unexpected argument `b.scn`"),
        (["--gener", "5"], "unknown option `--gener`"),
    ],
)
def test_slips_are_said(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A wrong command line ends with 2 and one line that says what would be right."""
    assert main(["a.scn", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("cortexc: ")
    assert re.search(message, captured.err), captured.err


def test_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    """`cortexc` alone says how to begin."""
    assert main([]) == 2
    assert "no file given" in capsys.readouterr().err


def test_subcommands_are_found_by_their_first_word(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command and a row in the table are all that a new one takes."""
    from cortex_dsl.cli import command_table

    seen: list[tuple[str, ...]] = []

    new = Command(
        name="new",
        usage="[--flag X]",
        description="Does something new.",
        options=(Option("--flag", "a flag", "X"),),
        function=lambda options, terminal: seen.append(options.command_line) or 7,
    )
    row = command_table.Subcommand(lambda: new, "does something new")
    monkeypatch.setitem(command_table.SUBCOMMANDS, "new", row)
    assert main(["new", "--flag", "x"]) == 7
    assert seen == [("--flag", "x")]
    assert main(["new", "--help"]) == 0
    assert main(["new", "--flg", "x"]) == 2
