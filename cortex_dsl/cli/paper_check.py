"""`cortexc paper-check`: the arithmetic of the CORTEX-AVD paper, done again."""

import argparse
from collections.abc import Sequence

from cortex_dsl.console.command import Parser
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.report.documents import document
from cortex_dsl.report.terminal.study_view import paper_view
from engine.paper import claims


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    options = _parser().parse_args(arguments)
    if options.help:
        terminal.write(_parser().format_help())
        return Exit.FINE
    checked = claims()
    if options.json:
        terminal.write(document("paper-check", {"claims": checked}))
    else:
        terminal.out.print(paper_view(checked, options.all))
    return Exit.FINE


def _parser() -> Parser:
    parser = Parser(
        prog="cortexc paper-check",
        usage="cortexc paper-check [--all] [--json]",
        description="Recompute what the paper prints from its own numbers, and show what does not hold.",
        allow_abbrev=False,
        add_help=False,
    )
    parser.add_argument("--all", action="store_true", help="what holds, too")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
    return parser
