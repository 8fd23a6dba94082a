"""`cortexc resume RUN`: go on with a search that was stopped or killed, as if nothing had happened."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from cortex_dsl.api.runs import OpenedRun, go_on, open_run
from cortex_dsl.cli.arguments import GENERATION_LIMIT, whole_number
from cortex_dsl.cli.common_options import add_common, add_dask, add_jobs, add_run, command_parser
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.hunting import asked_workers, removed, tell, usage_errors, watched
from cortex_dsl.cli.parser import Parser
from cortex_dsl.cli.request import Mode, Request
from cortex_dsl.cli.simulation import compile_kernels
from cortex_dsl.cli.study import resume as go_on_with_study
from cortex_dsl.cli.study import study_workers
from cortex_dsl.cli.terminal import Terminal
from engine.search.manifest import changed_versions
from engine.search.store import example_run
from engine.study.store import is_study

EPILOG = """\
The run goes on with the text and the settings that it was started with, and
ends with the journal that an undisturbed one would have written. Where it was
finished its report is shown again, unless --generations asks for more.

example:
  cortexc resume {run}"""


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.run is None:
        raise UsageError("no run given", f"name the folder of one, such as `cortexc resume {example_run()}`")
    if is_study(options.run):
        if options.generations is not None:
            raise UsageError("--generations has no effect on a study: it goes on as it was begun", "leave it out")
        return go_on_with_study(options.run, terminal, study_workers(options), json=options.json)
    with usage_errors():
        run = open_run(options.run)
        request = _request(run, options)
        _say(run, request, terminal)
        compile_kernels(run.scenario, terminal)
        manifest, search = run.record.manifest, run.scenario.config.search
        with watched(terminal, manifest.method, request.generations, run.record) as on_generation:
            found = go_on(
                run,
                generations=options.generations,
                on_generation=on_generation,
                on_removed=removed(terminal),
                workers=asked_workers(request, search.engine),
            )
    return tell([found], run.scenario, request, terminal)


def _request(run: OpenedRun, options: argparse.Namespace) -> Request:
    """The command as the reports know one."""
    manifest = run.record.manifest
    return Request(
        file=Path(manifest.file),
        mode=Mode.SEARCH,
        methods=(manifest.method,),
        generations=options.generations or run.scenario.config.search.generations,
        jobs=options.jobs,
        dask=options.dask,
        json=options.json,
    )


def _say(run: OpenedRun, request: Request, terminal: Terminal) -> None:
    """What the user may not expect, on stderr."""
    done, manifest = len(run.record.generations), run.record.manifest
    if run.record.status == "finished" and request.generations == run.scenario.config.search.generations:
        terminal.err.print(f"finished already, all {done} generations; this is its report", style="quiet")
        return
    terminal.err.print(f"going on after generation {done} of {request.generations}", style="quiet")
    for name in run.edited:
        terminal.err.print(f"`{name}` was edited since; the run goes on with the text that it was started with")
    if changed := changed_versions(manifest):
        terminal.err.print(f"started with {', '.join(changed)}: what follows may differ from what it would have been")


def _parser() -> Parser:
    parser = command_parser(
        "resume",
        "RUN [--generations N] [--jobs N] [--dask ADDRESS] [--json]",
        "Go on with a search or a study that was stopped with Ctrl-C, or killed.",
        EPILOG.format(run=example_run()),
    )
    add_run(parser, "a run directory, or that of a study")
    parser.add_argument(
        "--generations", metavar="N", type=whole_number(1, GENERATION_LIMIT), help="as many in all (as it was planned)"
    )
    add_jobs(parser, "workers: threads of --engine batch, processes of --engine world")
    add_dask(parser, "search")
    add_common(parser)
    return parser
