"""`cortexc replay RUN --case K` and `cortexc replay FILE.scn`: a case again, in the terminal or as a file to show."""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.cases import PICTURES, pace, picture, play_case
from cortex_dsl.console.command import EXAMPLE_RUN, Command, Parser, add_ego, driver_words, refuse_driver
from cortex_dsl.console.request import SEED_LIMIT, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import write_output

if TYPE_CHECKING:
    from cortex_dsl.report.findings.case_replay import CaseReplay
    from engine.search.ranking import Case

MOST_CASES = 10_000_000


@dataclass(frozen=True)
class Replayed:
    """A case, and of which run it is."""

    shown: "CaseReplay"
    case: "Case | None" = None
    folder: Path | None = None


def _replay(options: argparse.Namespace, terminal: Terminal) -> int:
    _check_target(options.to)
    if options.seed is not None and options.what.suffix != ".scn":
        raise UsageError("--seed draws a scenario's scene, and a run has its own", "name a case with --case K")
    if options.what.suffix != ".scn":
        refuse_driver(options)
    found = _of_file(options, terminal) if options.what.suffix == ".scn" else _of_run(options, terminal)
    if isinstance(found, int):
        return found
    if options.to is None:
        play_case(found.shown, options.speed, terminal)
    else:
        write_output(options.to, picture(found.shown, options.to, options.speed, found.case, found.folder))
        terminal.write(str(options.to))
    return Exit.FINE


def _check_target(path: Path | None) -> None:
    if path is not None and path.suffix.lower() not in PICTURES:
        cure = "name a file that ends in .html, .gif or .svg"
        raise UsageError(f"`{path}`: a replay becomes a page, a film or a picture", cure)


def _of_run(options: argparse.Namespace, terminal: Terminal) -> Replayed:
    """A case of a run, by default the worst."""
    from cortex_dsl.cli.search_output import cases_of, opened_run, usage_errors
    from cortex_dsl.report.page.run_page import replay_of_case

    folder, rank = options.what, options.case or 1
    run = opened_run(folder, terminal)
    case = cases_of(run, folder, rank)[rank - 1]
    with usage_errors():
        return Replayed(replay_of_case(run, case), case, run.folder)


def _of_file(options: argparse.Namespace, terminal: Terminal) -> Replayed | int:
    """The run that `cortexc FILE.scn` shows."""
    from cortex_dsl.cli.draw_modes import drawn_scene
    from cortex_dsl.report.findings.case_replay import replay_case

    if options.case is not None:
        raise UsageError("--case names a case of a run, and a scenario has none", "name the run, or leave --case out")
    words = [str(options.what), *([] if options.seed is None else ["--seed", str(options.seed)])]
    words += driver_words(options.ego, options.ego_batch, options.ego_observes)
    drawn = drawn_scene(words, terminal)
    if isinstance(drawn, Exit):
        return drawn
    return Replayed(replay_case(drawn.scenario, drawn.scenes, drawn.run.profile, name=options.what.name))


def _options(parser: Parser) -> None:
    parser.add_argument("what", nargs="?", type=Path, metavar="RUN|FILE.scn", help="folder of a run, or a scenario")
    parser.add_argument(
        "--case", type=whole_number(1, MOST_CASES), metavar="K", help="which of the run's cases; 1 is the worst (1)"
    )
    parser.add_argument(
        "--seed", type=whole_number(0, SEED_LIMIT), metavar="N", help="seed of the scene of a scenario (0)"
    )
    add_ego(parser)
    parser.add_argument(
        "--speed", type=pace, default=1.0, metavar="X", help="speed of playback; 2 is twice as fast (1)"
    )
    parser.add_argument(
        "--to", type=Path, metavar="FILE", help="write a page (.html), film (.gif) or picture (.svg) instead"
    )


REPLAY = Command(
    name="replay",
    usage="RUN [--case K] | FILE.scn [--seed N] [--to FILE] [options]",
    description="Run one case again and watch it: in the terminal, as a page, film or picture.",
    options=_options,
    function=_replay,
    needs=("what", "replay what? name a run or a scenario", f"cortexc replay {EXAMPLE_RUN} --case 1"),
    json=False,
)
