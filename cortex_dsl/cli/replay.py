"""`cortexc replay RUN --case K` and `cortexc replay FILE.scn`: a case again, in the terminal or as a file to show."""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.cases import (
    CASE,
    OF_RUN,
    PICTURES,
    SEED_OF_SCENE,
    is_scenario,
    pace,
    picture,
    play_case,
    run_or_scenario,
)
from cortex_dsl.console.command import DRIVER, Command, Option, driver_words, excluded_by
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import write_output

if TYPE_CHECKING:
    from cortex_dsl.report.findings.case_replay import CaseReplay
    from engine.search.ranking import Case


@dataclass(frozen=True)
class Replayed:
    """A case, and of which run it is."""

    shown: "CaseReplay"
    case: "Case | None" = None
    folder: Path | None = None


def _replay(options: argparse.Namespace, terminal: Terminal) -> int:
    found = _of_file(options, terminal) if is_scenario(options.what) else _of_run(options, terminal)
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
    from cortex_dsl.report.findings.case_replay import replay_of_case

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


REPLAY = Command(
    name="replay",
    usage="RUN [--case K] | FILE.scn [--seed N] [--to FILE] [options]",
    description="Run one case again and watch it: in the terminal, as a page, film or picture.",
    options=(
        run_or_scenario("replay", "--case 1"),
        replace(CASE, help="which of the run's cases; 1 is the worst"),
        SEED_OF_SCENE,
        *excluded_by(OF_RUN, *DRIVER),
        Option("--speed", "speed of playback; 2 is twice as fast", "X", pace, default=1.0),
        Option("--to", "write a page (.html), film (.gif) or picture (.svg) instead", "FILE", _target),
    ),
    function=_replay,
    json=False,
)
