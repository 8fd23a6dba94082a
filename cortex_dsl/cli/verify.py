"""`cortexc verify RUN`: a second opinion on the worst cases of a search, by a better model of the car."""

import argparse

from cortex_dsl.api.opinions import MODELS, keep, verify
from cortex_dsl.api.runs import WORST
from cortex_dsl.cli.search_output import checked_run, usage_errors
from cortex_dsl.console.command import EXAMPLE_RUN, Command, Parser, add_ego, add_jobs, add_run
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.simulating import compile_kernels
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.report.documents import document, plain
from cortex_dsl.report.findings.verification_report import verification_content
from cortex_dsl.report.terminal.verification_view import verification_view


def _verify(options: argparse.Namespace, terminal: Terminal) -> int:
    run = checked_run(options.run, terminal, options.ego)
    compile_kernels(run.scenario, terminal)
    with usage_errors():
        found = verify(run, options.worst, model=options.model, jobs=options.jobs)
    program = run.scenario.program
    content = plain(verification_content(program, found.cases, found.answers))
    if options.json:
        terminal.write(document("verification", {"folder": run.folder, **content}))
    else:
        terminal.out.print(verification_view(program, found.cases, found.answers, terminal.out.width))
    with usage_errors():
        path = keep(run, content)
    terminal.err.print(f"kept in {path}; `cortexc report` shows it", style="quiet", soft_wrap=True)
    return Exit.FINE if len(found) else Exit.NO_SCENE


def _options(parser: Parser) -> None:
    add_run(parser)
    parser.add_argument(
        "--model", choices=MODELS, metavar="NAME", default=MODELS[0], help="dynamic: tyres that slip (dynamic)"
    )
    parser.add_argument(
        "--worst", metavar="N", type=whole_number(1, 10**6), default=WORST, help=f"cases, worst first ({WORST})"
    )
    add_jobs(parser)
    add_ego(parser, batch=False)


VERIFY = Command(
    name="verify",
    usage="RUN [--model dynamic] [--worst N] [--jobs N] [--json]",
    description="""\
The worst cases again, their cars driven by a dynamic model whose tyres slip:
which survive, which differ, and which are artefacts of the search's model or
of its time step.""",
    options=_options,
    function=_verify,
    needs=("run", "no run given", f"name the folder of one, such as `cortexc verify {EXAMPLE_RUN}`"),
)
