"""Modes that sample scenes of a file: `cortexc FILE` runs one and shows it, `--sample N` counts them.

With `--ego` it also counts the endings of their runs.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.api.scenario import Scenario
from cortex_dsl.api.scenario_mistakes import failure_of, undefined_value
from cortex_dsl.cli.file_options import OPTIONS, to_request
from cortex_dsl.console.command import Parser, add_rows, settle
from cortex_dsl.console.compiling import compile_request, show
from cortex_dsl.console.kernels import RUN, SAMPLE, compile_kernels
from cortex_dsl.console.request import CompileRequest, RunRequest
from cortex_dsl.console.simulating import (
    draw,
    open_scenario,
    perform_run,
    proved_impossible,
    show_no_scene,
)
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.report.findings.driven_runs import DrivenRuns, runs_content
from cortex_dsl.report.findings.run_report import requirements_content
from cortex_dsl.report.findings.tally import Tally, blame_content, most_to_blame
from cortex_dsl.report.terminal.progress import with_progress
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.views.samples import driven_view, sample_view
from engine.config import SimulationConfig
from engine.program import Program
from engine.scenes import Scenes
from engine.vocabulary import Method, Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account
    from engine.driving.blocks import Driven

CROWD = 300
"""Actors from which a command says that it takes long."""


def run_once(request: CompileRequest, run: RunRequest, terminal: Terminal) -> int:
    """Sample one scene, run it, and show the events."""
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, run, compiled)
    compile_kernels(terminal, RUN, scenario.program, scenario.config)
    _announce_crowd(scenario, terminal)
    return perform_run(request, run, scenario, terminal)


def _announce_crowd(scenario: Scenario, terminal: Terminal) -> None:
    """Say that many actors take long, before it seems to hang."""
    if (count := len(scenario.program.actors)) > CROWD:
        what = f"{count:,} actors: each is held against every other, which takes minutes; Ctrl-C ends it"
        terminal.note(what)


# -- the scene of a file for other commands, which show it otherwise: drawn as `cortexc FILE` draws it -----------------


@dataclass(frozen=True)
class DrawnScene:
    """A valid scene, row 0, and its origin."""

    run: RunRequest
    scenario: Scenario
    scenes: Scenes


def drawn_scene(words: Sequence[str], terminal: Terminal) -> DrawnScene | Exit:
    """Return the scene of `cortexc WORDS…`, or the exit code where the file has errors or no scene is valid."""
    parser = add_rows(Parser(prog="cortexc", allow_abbrev=False, add_help=False), OPTIONS)
    request = to_request(settle(OPTIONS, parser.parse_args(words)))
    compiled = compile_request(request.compile, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request.compile, request.run, compiled)
    scenes, tally = draw(scenario, request.run.seed)
    if not scenes.valid[0]:
        return show_no_scene(request.compile, request.run, scenario, scenes, tally, terminal)
    return DrawnScene(request.run, scenario, scenes)


# -- `--sample N`: scenes drawn without running them, and counted ------------------------------------------------------

CHUNK = 20_000
"""Number of scenes that are drawn at once, fewer with many actors; memory is bounded as only counts are stored."""
DRIVEN = 4_096
"""Number of scenes at once with an external driver, or the size of its queries if larger.

All decisions of a scene are stored until it is counted.
"""


@dataclass
class _Sampled:
    """Counts over the scenes so far."""

    tally: Tally = field(default_factory=Tally)
    runs: DrivenRuns = field(default_factory=DrivenRuns)
    mistake: Diagnostic | None = None
    reported: set[str] = field(default_factory=set)
    """Ways of failing of the driver that people know."""
    interrupted: bool = False


def sample_scenes(request: CompileRequest, run: RunRequest, samples: int, terminal: Terminal) -> int:
    """Sample scenes, and count rejections by reason; with a driver, drive them and count their endings."""
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    program, scenario = compiled.program, open_scenario(request, run, compiled)
    compile_kernels(terminal, SAMPLE, scenario.program, scenario.config)
    _announce_crowd(scenario, terminal)
    empty = {**_content(program, run, Tally(), None), "seconds": 0.0, "interrupted": False}
    if (impossible := proved_impossible(scenario, request, run, terminal, "sample", empty)) is not None:
        return impossible
    _warm_up(program, scenario.config.simulation)
    start = time.perf_counter()
    sampled = _sampled(scenario, run, samples, terminal)
    seconds = time.perf_counter() - start
    if sampled.mistake is not None:
        show(compiled.source, [sampled.mistake], request, terminal, failed=True)
        return Exit.DIAGNOSTICS
    until = f", interrupted before {samples:,}" if sampled.interrupted else ""
    _show(request, run, scenario, sampled, seconds, f"seed {run.seed or 0}{until}", terminal)
    if sampled.interrupted:
        return Exit.INTERRUPTED
    return Exit.FINE if sampled.tally.valid else Exit.NO_SCENE


def _sampled(scenario: Scenario, run: RunRequest, samples: int, terminal: Terminal) -> _Sampled:
    """Return the counts of all scenes, or of those before Ctrl-C, or before the first that shows a mistake of the file.

    Raises:
        ControllerError: no actor has an external controller, or the driver cannot be queried.
    """
    sampled = _Sampled()
    try:
        for scenes in with_progress(terminal.err, samples, _chunks(scenario, run, samples)):
            sampled.tally = sampled.tally.plus(scenes)
            sampled.mistake = _undefined(scenario, scenes)
            if sampled.mistake is None and scenario.config.driver is not None:
                _drive(sampled, scenario, scenes, run.jobs)
            if sampled.mistake is not None:
                break
    except KeyboardInterrupt:
        sampled.interrupted = True
    return sampled


def _drive(sampled: _Sampled, scenario: Scenario, scenes: Scenes, jobs: int) -> None:
    """Drive scenes, and count how their runs ended."""
    from engine.verdicts import blame

    program, config = scenario.program, scenario.config
    assert config.driver is not None
    done: Driven = config.driver.drive(program, scenes, config.simulation, config.contact, jobs)
    errors = np.flatnonzero(done.outcomes.verdict == Verdict.ERROR)
    if len(errors):
        sampled.mistake = failure_of(
            scenario.compiled, scenario.config.simulation, done.scenes, done.outcomes, int(errors[0])
        )
        return
    driven = done.tell(sampled.reported).scenes
    said = blame(program, driven, config.simulation, config.contact, jobs, config.search.references)
    sampled.runs = sampled.runs.plus(program, done.outcomes, said)


def _show(
    request: CompileRequest,
    run: RunRequest,
    scenario: Scenario,
    sampled: _Sampled,
    seconds: float,
    note: str,
    terminal: Terminal,
) -> None:
    """Show the counts."""
    program, driver, tally = scenario.program, scenario.config.driver, sampled.tally
    blame = _account(program, run) if tally.scenes and not tally.always else None
    if request.json:
        content = {"file": request.file, **_content(program, run, tally, blame)}
        content |= {} if driver is None else {"driven": runs_content(sampled.runs, driver.name)}
        terminal.document("sample", {**content, "seconds": seconds, "interrupted": sampled.interrupted})
    elif tally.scenes:
        driven = None if driver is None else driven_view(sampled.runs, driver.name)
        view = sample_view(program, tally, seconds if driver is None else 0.0, note, blame, driven)
        terminal.out.print(rendered(view, terminal.out.width, ascii_only=terminal.out.options.ascii_only))


def _warm_up(program: Program, config: SimulationConfig) -> None:
    """Load the kernels, so that the time that is shown is the sampler's."""
    from engine.sampling import draw_genomes, sample
    from engine.streams import key_rows

    keys = key_rows(0, Method.SAMPLE, 0, 0, [0])
    sample(program, draw_genomes(program.space, keys), keys, replace(config, max_attempts=1))


def _account(program: Program, run: RunRequest) -> "Account":
    """Return which requirement rejects most attempts; None where there is nothing to explain."""
    from engine.acceptance import account, measure_acceptance

    return account(measure_acceptance(program, seed=run.seed or 0), run.target)


def _undefined(scenario: Scenario, scenes: Scenes) -> Diagnostic | None:
    """Return the diagnostic for the first scene that holds a number which does not exist; None if there is none."""
    errors = np.flatnonzero(scenes.verdict == Verdict.ERROR)
    return undefined_value(scenario.compiled, scenes, int(errors[0])) if len(errors) else None


def _chunks(scenario: Scenario, run: RunRequest, samples: int) -> Iterator[Scenes]:
    """All scenes, some at a time; of those that are driven, whole blocks."""
    from engine.sampling import draw_genomes, rows_at_once, sample
    from engine.streams import key_rows

    program, config, driver = scenario.program, scenario.config.simulation, scenario.config.driver
    chunk = rows_at_once(program, CHUNK) if driver is None else driver.block * max(1, DRIVEN // driver.block)
    for first in range(0, samples, chunk):
        indices = np.arange(first, min(first + chunk, samples))
        keys = key_rows(run.seed or 0, Method.SAMPLE, 0, 0, indices)
        yield sample(program, draw_genomes(program.space, keys), keys, config, run.jobs)


def _content(program: Program, run: RunRequest, tally: Tally, blame: "Account | None") -> dict[str, object]:
    """Return the counts as a document."""
    culprit = most_to_blame(program, tally, blame)
    return {
        "program": program.digest,
        "seed": run.seed or 0,
        "scenes": tally.scenes,
        "verdicts": {each.name.lower(): tally.verdicts[each] for each in Verdict if each != Verdict.CONTROLLER},
        "attempts": tally.attempts,
        "acceptance": tally.acceptance,
        "requirements": requirements_content(program, tally),
        "first_culprit": None if culprit is None else program.requirements[culprit].name,
        "blame": blame and blame_content(blame),
        "pruned": run.prune and tally.long > 0,
    }
