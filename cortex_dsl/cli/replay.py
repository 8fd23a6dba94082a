"""`cortexc replay RUN --case K` and `cortexc replay FILE.scn`: a case again, in the terminal or as a file to show."""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.cases import PICTURES, pace, picture, play_case
from cortex_dsl.console.command import DRIVER, EXAMPLE_RUN, SEED, Command, Condition, Option, driver_words
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import write_output
from cortex_dsl.shipped import SUFFIX

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
    found = _of_file(options, terminal) if options.what.suffix == SUFFIX else _of_run(options, terminal)
    if isinstance(found, int):
        return found
    if options.to is None:
        play_case(found.shown, options.speed, terminal)
    else:
        write_output(options.to, picture(found.shown, options.to, options.speed, found.case, found.folder))
        terminal.write(str(options.to))
    return Exit.FINE


def _target(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in PICTURES:
        cure = "name a file that ends in .html, .gif or .svg"
        raise UsageError(f"`{path}`: a replay becomes a page, a film or a picture", cure)
    return path


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

    words = [str(options.what), *([] if options.seed is None else ["--seed", str(options.seed)])]
    words += driver_words(options.ego, options.ego_batch, options.ego_observes)
    drawn = drawn_scene(words, terminal)
    if isinstance(drawn, Exit):
        return drawn
    return Replayed(replay_case(drawn.scenario, drawn.scenes, drawn.run.profile, name=options.what.name))


_RUN = Condition(
    "a run, whose cases have scenes and decisions of their own",
    lambda options: options.what.suffix != SUFFIX,
    "name a case with --case K",
)
_SCENARIO = Condition("a scenario, which has no cases", lambda options: options.what.suffix == SUFFIX)

REPLAY = Command(
    name="replay",
    usage="RUN [--case K] | FILE.scn [--seed N] [--to FILE] [options]",
    description="Run one case again and watch it: in the terminal, as a page, film or picture.",
    options=(
        Option(
            "what",
            "folder of a run, or a scenario",
            "RUN|FILE.scn",
            Path,
            nargs="?",
            missing=("replay what? name a run or a scenario", f"cortexc replay {EXAMPLE_RUN} --case 1"),
        ),
        Option(
            "--case",
            "which of the run's cases; 1 is the worst",
            "K",
            whole_number(1, MOST_CASES),
            default=1,
            excludes=(_SCENARIO,),
        ),
        replace(SEED, help="seed of the scene of a scenario (0)", excludes=(_RUN,)),
        *(replace(row, excludes=(_RUN,)) for row in DRIVER),
        Option("--speed", "speed of playback; 2 is twice as fast", "X", pace, default=1.0),
        Option("--to", "write a page (.html), film (.gif) or picture (.svg) instead", "FILE", _target),
    ),
    function=_replay,
    json=False,
)
