"""What draws scenes of a file: `cortexc FILE` runs one and shows what happened, `--sample N` counts them."""

import shlex
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.file_options import build_parser, to_request
from cortex_dsl.console.compiling import compile_request, show
from cortex_dsl.console.request import CompileRequest, RunRequest
from cortex_dsl.console.scenario_mistakes import undefined_value
from cortex_dsl.console.simulating import announce_compilation, draw, open_scenario, perform_run, show_misplaced
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.pipeline import Compiled
from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.run_report import requirements_content
from cortex_dsl.report.findings.tally import Tally, blame_content, most_to_blame
from cortex_dsl.report.terminal.progress import with_progress
from cortex_dsl.report.terminal.requirements_view import exhausted_view
from cortex_dsl.report.terminal.sample_view import sample_view
from engine.config import SimulationConfig
from engine.feasibility import explain
from engine.program import Program
from engine.scenes import Scenes
from engine.vocabulary import Method, Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account

CROWD = 300
"""Actors from which a command says that it takes long."""


def run_once(request: CompileRequest, run: RunRequest, terminal: Terminal) -> int:
    """Draw one scene, run it, and show what happened."""
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, run, compiled)
    announce_compilation(terminal)
    _announce_crowd(scenario, terminal)
    return perform_run(request, run, scenario, terminal)


def _announce_crowd(scenario: Scenario, terminal: Terminal) -> None:
    """Say that many actors take long, before it seems to hang."""
    if (count := len(scenario.program.actors)) > CROWD:
        what = f"{count:,} actors: each is held against every other, which takes minutes; Ctrl-C ends it"
        terminal.err.print(what, style="quiet", soft_wrap=True)


# -- the scene of a file for other commands, which show it otherwise: drawn as `cortexc FILE` draws it -----------------


@dataclass(frozen=True)
class DrawnScene:
    """A valid scene, row 0, and what it was drawn from."""

    run: RunRequest
    scenario: Scenario
    scenes: Scenes


def drawn_scene(words: Sequence[str], terminal: Terminal) -> DrawnScene | Exit:
    """The scene of `cortexc WORDS…`; the exit code where the file has errors, which are shown.

    Raises:
        UsageError: no scene meets the requirements.
    """
    request = to_request(build_parser().parse_args(words), words)
    compiled = compile_request(request.compile, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request.compile, request.run, compiled)
    scenes, tally = draw(scenario, request.run.seed)
    if not scenes.valid[0]:
        raise UsageError(
            f"no scene of `{request.compile.file}` meets its requirements, after {tally.attempts:,} attempts",
            f"`{shlex.join(['cortexc', *words])}` says which of them is to blame",
        )
    return DrawnScene(request.run, scenario, scenes)


# -- `--sample N`: scenes drawn without running them, and counted ------------------------------------------------------

CHUNK = 20_000
"""Scenes drawn at once, or fewer of many actors: only their counts are kept, so any number fits in memory."""


def sample_scenes(request: CompileRequest, run: RunRequest, samples: int, terminal: Terminal) -> int:
    """Draw scenes, and count what was rejected, and why."""
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    program, scenario = compiled.program, open_scenario(request, run, compiled)
    config = scenario.config.simulation
    announce_compilation(terminal)
    _announce_crowd(scenario, terminal)
    if not request.json and explain(program).infeasible:
        return _infeasible(compiled, request, run, terminal)
    _warm_up(program, config)
    start, tally, interrupted = time.perf_counter(), Tally(), False
    try:
        for scenes in with_progress(terminal.err, samples, _chunks(program, run, samples, config)):
            tally = tally.plus(scenes)
            if (mistake := _undefined(scenario, scenes)) is not None:
                show(compiled.source, [mistake], request, terminal, failed=True)
                return Exit.DIAGNOSTICS
    except KeyboardInterrupt:
        interrupted = True
    seconds = time.perf_counter() - start
    blame = _account(program, run) if tally.scenes and not tally.always else None
    seed = f"seed {run.seed or 0}" + (f", interrupted before {samples:,}" if interrupted else "")
    if request.json:
        content = {"file": request.file, **_content(program, run, tally, blame)}
        terminal.write(document("sample", {**content, "seconds": seconds, "interrupted": interrupted}))
    elif tally.scenes:
        terminal.out.print(sample_view(program, tally, seconds, seed, blame))
    if interrupted:
        return Exit.INTERRUPTED
    return Exit.FINE if tally.valid else Exit.NO_SCENE


def _infeasible(compiled: Compiled, request: CompileRequest, run: RunRequest, terminal: Terminal) -> Exit:
    """Without a single scene, for it is proved that there is none."""
    blame = _account(compiled.program, run)
    terminal.err.print(exhausted_view(compiled.program, Tally(), Verdict.INFEASIBLE, (), blame))
    show_misplaced(compiled, blame, request, terminal)
    return Exit.NO_SCENE


def _warm_up(program: Program, config: SimulationConfig) -> None:
    """Load the kernels, so that the time that is shown is the sampler's."""
    from engine.sampling import draw_genomes, sample
    from engine.streams import key_rows

    keys = key_rows(0, Method.SAMPLE, 0, 0, [0])
    sample(program, draw_genomes(program.space, keys), keys, replace(config, max_attempts=1))


def _account(program: Program, run: RunRequest) -> "Account":
    """Return which requirement rejects most attempts; None where there is nothing to explain."""
    from engine.acceptance import account, weigh

    return account(weigh(program, seed=run.seed or 0), run.target)


def _undefined(scenario: Scenario, scenes: Scenes) -> Diagnostic | None:
    """Return the diagnostic for the first scene that holds a number which does not exist; None if there is none."""
    errors = np.flatnonzero(scenes.verdict == Verdict.ERROR)
    return undefined_value(scenario.compiled, scenes, int(errors[0])) if len(errors) else None


def _chunks(program: Program, run: RunRequest, samples: int, config: SimulationConfig) -> Iterator[Scenes]:
    """All scenes, some at a time."""
    from engine.feasibility.pruning import pruner
    from engine.sampling import draw_genomes, rows_at_once, sample
    from engine.streams import key_rows

    prune = pruner(program) if config.prune else None
    chunk = rows_at_once(program, CHUNK)
    for first in range(0, samples, chunk):
        indices = np.arange(first, min(first + chunk, samples))
        keys = key_rows(run.seed or 0, Method.SAMPLE, 0, 0, indices)
        yield sample(program, draw_genomes(program.space, keys), keys, config, run.jobs, prune)


def _content(program: Program, run: RunRequest, tally: Tally, blame: "Account | None") -> dict[str, object]:
    """What was counted, for the document."""
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
        "pruned": run.prune,
    }
