"""The parser of a command, with the options that every command has, or most; each is worded once, here."""

import argparse
from pathlib import Path

from cortex_dsl.cli.parser import Parser, cores
from cortex_dsl.console.request import whole_number


def command_parser(name: str, usage: str, description: str, epilog: str | None = None) -> Parser:
    """The parser of `cortexc NAME`, whose texts are printed as they are written."""
    return Parser(
        prog=f"cortexc {name}",
        usage=f"cortexc {name} {usage}",
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )


def add_run(parser: Parser, text: str = "a run directory") -> None:
    """RUN: where a search left what it found."""
    parser.add_argument("run", metavar="RUN", nargs="?", type=Path, help=text)


def add_jobs(parser: Parser, who: str = "threads") -> None:
    """--jobs: as many at a time; as many as there are cores unless it is given."""
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=whole_number(1, 1024),
        default=cores(),
        help=f"{who}; results never depend on it ({cores()})",
    )


def add_dask(parser: Parser, what: str) -> None:
    """--dask: workers elsewhere."""
    parser.add_argument(
        "--dask", metavar="ADDRESS", help=f"of a Dask scheduler; `local`: one for the time of the {what}"
    )


def add_common(parser: Parser, *, json: bool = True) -> None:
    """--json, --no-colour and --help, which come last."""
    if json:
        parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
