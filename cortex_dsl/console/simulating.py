"""Draw and simulate: the settings that apply, and the one run of `cortexc FILE`."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.api.scenario import Scenario, in_file
from cortex_dsl.console.command import driver_words
from cortex_dsl.console.compiling import show
from cortex_dsl.console.request import CompileRequest, RunRequest, SearchRequest
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.pipeline import Compiled
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.tally import Tally
from cortex_dsl.semantics.names.linking import held_params
from engine.config import Config, GAConfig, SearchConfig, SimulationConfig
from engine.outcomes import Outcomes
from engine.program import Program, Settings
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import EndReason, Verdict

if TYPE_CHECKING:
    from cortex_dsl.report.blocks import Block
    from cortex_dsl.report.findings.run_report import RunReport
    from engine.acceptance import Account
    from engine.driving.blocks import Driver
    from engine.metrics import Metric
    from engine.scenes import Impact
    from engine.search.campaign import Campaign


def open_scenario(
    request: CompileRequest, run: RunRequest, compiled: Compiled, search: SearchRequest | None = None
) -> Scenario:
    """The compiled file with every setting that applies: defaults, overridden by the file, overridden by flags.

    Raises:
        UsageError: a run of more steps, or a scene of more attempts, than there may be.
    """
    search = search or SearchRequest()
    simulation = _simulation_config(run, compiled.program.settings)
    _check_attempts(compiled.program, simulation.max_attempts)
    searching = SearchConfig(
        generations=search.generations,
        population=search.population,
        seed=run.seed or 0,
        rollouts=search.rollouts,
        aggregate=search.aggregate,
        jobs=run.jobs,
        engine=run.engine or "batch",
        references=run.references,
    )
    ga = replace(GAConfig(), preset=search.preset)
    config = Config(simulation=simulation, search=searching, ga=ga, driver=_driver(run))
    return Scenario(compiled, config, request.overrides, request.scenario)


def _driver(run: RunRequest) -> "Driver | None":
    """Return the driver that the command line names; None without one.

    Raises:
        ControllerError: there is no such driver.
    """
    if run.ego is None:
        return None
    from engine.driving.named import driver_of

    return driver_of(run.ego, run.ego_batch, run.ego_observes)


def _simulation_config(run: RunRequest, settings: Settings) -> SimulationConfig:
    from engine.host import MAX_SAMPLES, samples_of

    flags = {"time_step": run.time_step, "max_attempts": run.max_attempts}
    config = in_file(SimulationConfig(), settings)
    config = replace(config, **{name: value for name, value in flags.items() if value is not None}, prune=run.prune)
    if samples_of(config) > MAX_SAMPLES:
        raise UsageError(
            f"{config.max_time:g} s in steps of {config.time_step:g} s are more than {MAX_SAMPLES:,} steps",
            "take a longer --time-step, or `terminate after` a shorter time",
        )
    return config


def _check_attempts(program: Program, attempts: int) -> None:
    """A stream of random numbers is long, but not endless."""
    from engine.sampling import attempt_limit

    if attempts > (limit := attempt_limit(program)):
        raise UsageError(
            f"{attempts:,} attempts at one scene are more than the {limit:,} that its random numbers last for",
            "lower --max-attempts, or `max_attempts` in the file",
        )


# -- `cortexc FILE`: sample one scene, run it, and show the events -----------------------------------------------------


@dataclass(frozen=True)
class Simulated:
    """One scene, and its run by one of the hosts."""

    outcomes: Outcomes
    trajectory: Trajectory
    impacts: "Sequence[Impact]" = ()


def perform_run(
    request: CompileRequest, run: RunRequest, scenario: Scenario, terminal: Terminal, reproduce: str = ""
) -> Exit:
    """Sample a scene, run it, and show the events.

    `reproduce`: command that repeats the run, if it differs from the command line of the request.
    """
    scenes, tally = draw(scenario, run.seed)
    if not scenes.valid[0]:
        return show_no_scene(request, run, scenario, scenes, tally, terminal)
    engine = run.engine or "world"
    simulated = _simulate(scenario, scenes, engine)
    verdict = Verdict(int(simulated.outcomes.verdict[0]))
    if verdict == Verdict.ERROR:
        return _failed(request, scenario, scenes, simulated.outcomes, terminal)
    again = reproduce or _reproduce(request, run, scenario)
    _show(_report(run, scenario, scenes, simulated, again), request, terminal)
    return Exit.NO_SCENE if verdict == Verdict.ABORTED else Exit.FINE


def draw(scenario: Scenario, seed: int | None) -> tuple[Scenes, Tally]:
    """The first genome of the seed that allows a scene, or the last one tried; and the counts of all that were."""
    tried, tally = list(scenario.attempts(seed)), Tally()
    for scenes in tried:
        tally = tally.plus(scenes)
    return tried[-1], tally


def _simulate(scenario: Scenario, scenes: Scenes, engine: str) -> Simulated:
    if engine == "world":
        run = scenario.watch(scenes)
        return Simulated(run.outcomes, run.trajectory, run.impacts)
    from engine import batch

    config = scenario.config
    trajectory = batch.trajectory(scenario.program, scenes, 0, config.simulation, config.contact)
    return Simulated(scenario.simulate(scenes), trajectory)


def _report(run: RunRequest, scenario: Scenario, scenes: Scenes, simulated: Simulated, again: str) -> "RunReport":
    from cortex_dsl.lowering.given_out import light_colours
    from cortex_dsl.report.findings.run_report import RunReport
    from engine.metrics import recorded
    from engine.road import build_network
    from engine.road.outline import outline

    risk = scenario.assess(simulated.outcomes, run.profile)
    shown = light_colours(scenario.compiled.scenario, scenes, 0, scenario.config.simulation)
    return RunReport(
        program=scenario.program,
        scenes=scenes,
        outcomes=simulated.outcomes,
        trajectory=simulated.trajectory,
        impacts=simulated.impacts,
        metrics=_metrics(scenario, scenes, simulated),
        records=recorded(scenario.program, simulated.trajectory),
        score=int(risk.score[0]),
        parts=risk.parts[0].tolist(),
        pair=max(0, int(risk.pair[0])),
        profile=run.profile,
        engine=run.engine or "world",
        road=outline(build_network(scenario.program.road_spec), shown),
        reproduce=again,
        held=held_params(scenario.compiled.module, scenario.overrides),
    )


def _metrics(scenario: Scenario, scenes: Scenes, simulated: Simulated) -> "Sequence[Metric]":
    """Return all metrics of a valid run."""
    from engine.metrics import bodies_of, measure_impacts, measure_trajectory

    if int(simulated.outcomes.verdict[0]) != Verdict.VALID:
        return ()
    bodies = bodies_of(scenario.program, scenes.values[0])
    driven = measure_trajectory(simulated.trajectory, simulated.outcomes, bodies)
    return (*driven, *measure_impacts(simulated.impacts))


def _reproduce(request: CompileRequest, run: RunRequest, scenario: Scenario) -> str:
    """The command with everything that decides the run."""
    words = ["cortexc", as_argument(request.file), *(["--scenario", request.scenario] if request.scenario else [])]
    words += [word for name, value in request.overrides.items() for word in ("-p", f"{name}={value}")]
    pinned = scenario.program.settings.stream is not None and run.seed is None
    words += [] if pinned else ["--seed", str(run.seed or 0)]
    for flag, value in (("--max-attempts", run.max_attempts), ("--time-step", run.time_step)):
        words += [] if value is None else [flag, f"{value!r}"]
    words += ["--prune"] if run.prune else []
    words += ["--engine", run.engine] if run.engine else []
    words += driver_words(run.ego, run.ego_batch, run.ego_observes)
    words += ["--profile", run.profile] if run.profile != "paper" else []
    return shlex.join(words)


def _show(report: "RunReport", request: CompileRequest, terminal: Terminal) -> None:
    if request.json:
        from cortex_dsl.report.findings.run_report import run_content

        terminal.document("run", run_content(report, str(request.file)))
    else:
        from cortex_dsl.report.terminal.render import rendered
        from cortex_dsl.report.views.run import run_screen, with_short_names

        report = with_short_names(report)
        console, ascii_only = terminal.out, terminal.out.options.ascii_only
        console.print(rendered(run_screen(report), console.width, ascii_only=ascii_only))
        if request.metrics:
            from cortex_dsl.report.terminal.render import parts
            from cortex_dsl.report.views.measures import run_details

            console.print(parts(run_details(report), console.width, ascii_only=ascii_only))


def _print_no_scene(terminal: Terminal, view: "Sequence[Block]") -> None:
    from cortex_dsl.report.terminal.render import parts

    terminal.err.print(parts(view, terminal.err.width, ascii_only=terminal.err.options.ascii_only))


def show_no_scene(
    request: CompileRequest, run: RunRequest, scenario: Scenario, scenes: Scenes, tally: Tally, terminal: Terminal
) -> Exit:
    """Show why no scene is valid: the proof, or the requirements that reject most attempts."""
    verdict = Verdict(int(scenes.verdict[0]))
    if verdict == Verdict.ERROR:
        return _undefined(request, scenario, scenes, terminal, "a scene held a value that is not a number")
    from cortex_dsl.report.findings.run_report import no_scene_content

    empty = no_scene_content(scenario.program, Tally(), Verdict.INFEASIBLE, str(request.file))
    if (impossible := proved_impossible(scenario, request, run, terminal, "run", empty)) is not None:
        return impossible
    from engine.acceptance import account, measure_acceptance

    genome = scenes.genomes[0] if tally.scenes == 1 else None
    blame = account(measure_acceptance(scenario.program, seed=run.seed or 0, genome=genome), run.target)
    if request.json:
        from cortex_dsl.report.findings.tally import blame_content

        show_misplaced(scenario.compiled, blame, request, terminal)
        content = no_scene_content(scenario.program, tally, verdict, str(request.file))
        terminal.document("run", {**content, "blame": blame_content(blame)})
    else:
        from cortex_dsl.report.views.requirements import no_scene_view

        _print_no_scene(terminal, no_scene_view(scenario.program, tally, verdict, scenes.genomes[0], blame))
        show_misplaced(scenario.compiled, blame, request, terminal)
    return Exit.NO_SCENE


def proved_impossible(
    scenario: Scenario,
    request: CompileRequest,
    run: RunRequest,
    terminal: Terminal,
    kind: str,
    empty: Mapping[str, object],
) -> Exit | None:
    """Report that no scene exists, which is proved without sampling; return None if it is not proved.

    kind, empty: the document of the command under --json, and its contents if nothing is drawn.
    """
    from engine.acceptance import account, measure_acceptance
    from engine.feasibility import remembered

    program = scenario.program
    if not remembered(program).infeasible:
        return None
    blame = account(measure_acceptance(program, seed=run.seed or 0), run.target)
    if request.json:
        from cortex_dsl.report.findings.tally import blame_content

        show_misplaced(scenario.compiled, blame, request, terminal)
        terminal.document(kind, {"file": request.file, **empty, "blame": blame_content(blame)})
    else:
        from cortex_dsl.report.views.requirements import no_scene_view

        _print_no_scene(terminal, no_scene_view(program, Tally(), Verdict.INFEASIBLE, (), blame))
        show_misplaced(scenario.compiled, blame, request, terminal)
    return Exit.NO_SCENE


def blame_of_search(program: Program, campaign: "Campaign", seed: int) -> "Account | None":
    """Return the requirements that reject the attempts of a search; None if a scene is valid or nothing was tried."""
    if campaign.by_individual.valid or not Tally.of_search(campaign.evaluations).attempts:
        return None
    from engine.acceptance import account, measure_acceptance

    return account(measure_acceptance(program, seed=seed))


def show_misplaced(compiled: Compiled, blame: "Account", request: CompileRequest, terminal: Terminal) -> None:
    """Show the objects whose places alone reject every scene, if there are any."""
    from cortex_dsl.api.scenario_mistakes import misplaced

    proved = blame.conflict.requirements if blame.conflict is not None and blame.conflict.proved else ()
    if mistakes := misplaced(compiled, proved):
        terminal.err.print()
        show(compiled.source, mistakes, request, terminal)


def _undefined(request: CompileRequest, scenario: Scenario, scenes: Scenes, terminal: Terminal, otherwise: str) -> Exit:
    """Arithmetic without a result is the file's mistake; anything else is ours."""
    from cortex_dsl.api.scenario_mistakes import undefined_value

    diagnostic = undefined_value(scenario.compiled, scenes)
    if diagnostic is None:
        raise RuntimeError(otherwise)
    show(scenario.compiled.source, [diagnostic], request, terminal, failed=True)
    return Exit.DIAGNOSTICS


def _failed(
    request: CompileRequest, scenario: Scenario, scenes: Scenes, outcomes: Outcomes, terminal: Terminal
) -> Exit:
    """Show the mistake of the file; anything else is ours."""
    from cortex_dsl.api.scenario_mistakes import failure_of

    diagnostic = failure_of(scenario.compiled, scenario.config.simulation, scenes, outcomes)
    if diagnostic is None:
        from cortex_dsl.report.findings.story import end_of

        what = f"the simulation failed after {float(outcomes.end_time[0]):.2f} s"
        raise RuntimeError(f"{what}: {end_of(scenario.program, outcomes, 0).text}")
    show(scenario.compiled.source, [diagnostic], request, terminal, failed=True)
    return Exit.DIAGNOSTICS


# -- runs of a search that failed over the file itself -----------------------------------------------------------------


def mistake_of(scenario: Scenario, campaign: "Campaign") -> Diagnostic | None:
    """A behaviour that never acts, or a number that does not exist; None where no run failed over either."""
    evaluations = campaign.evaluations
    rollouts = evaluations.rollouts
    undefined = np.argwhere((rollouts.end_reason == EndReason.BROKEN) & (rollouts.end_rule >= 0))
    failed = np.argwhere(rollouts.verdict == Verdict.ERROR)
    stuck = np.argwhere(rollouts.end_reason == EndReason.STUCK)
    if not (len(undefined) or len(failed) or len(stuck)):
        return None
    from cortex_dsl.api.scenario_mistakes import never_acts, undefined_objective, undefined_value

    if len(stuck):
        first = tuple(stuck[0])
        budget = scenario.config.simulation.instruction_budget
        return never_acts(scenario.compiled, budget, int(rollouts.end_rule[first]), float(rollouts.end_time[first]))
    if len(undefined):
        number, genome = int(rollouts.end_rule[tuple(undefined[0])]), evaluations.genomes[undefined[0][0]].tolist()
        return undefined_objective(scenario.compiled, number, scenario.program.space, genome)
    row, rollout = failed[0]
    scene = scenario.scene_of(evaluations.genomes[row], evaluations.keys[row, rollout])
    return undefined_value(scenario.compiled, scene)
