"""A scenario in Python: load it, draw scenes, run them, judge them, search. Prints nothing.

    >>> import cortex_dsl as cx
    >>> scenario = cx.load("examples/left_turn.scn")
    >>> scenes = scenario.sample(1000, seed=1)
    >>> outcomes = scenario.simulate(scenes)
    >>> outcomes.collided.mean(), scenario.assess(outcomes).score.max()
    >>> campaign = scenario.search("ga", generations=30, population=100)
    >>> print(scenario.concrete(scenario.scene(campaign.worst[0])))

`docs/reference/python.md` goes through all of it.

A search that keeps everything on disk, and can be gone on with: `search(…, out="runs/mine")`,
`cortex_dsl.api.run_folder`, `cortex_dsl.api.runs`. A searcher of your own: `engine.search.searchers`.

Arrays are row-aligned and in SI units, genomes in the file's own; their shapes stand at `engine.scenes.Scenes`,
`engine.outcomes.Outcomes` and `engine.search.evaluations.Evaluations`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Unpack

import numpy as np

from cortex_dsl.api import arguments
from cortex_dsl.api.arguments import PRESET, PROFILE, SearchSettings
from cortex_dsl.api.concrete import Original, concrete_files
from cortex_dsl.api.known_outcomes import KnownOutcomes
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.files import DISK, Folder
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import read_source
from engine.config import Config, SimulationConfig
from engine.errors import ArgumentError, ArgumentKindError, UnreadableFileError
from engine.program import Program, Settings
from engine.vocabulary import OBSERVABLE, RECORDS, Method, Verdict

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from cortex_dsl.api.named_columns import Columns
    from cortex_dsl.report.page.notebook import Picture, Shown
    from engine.environment import Environment
    from engine.outcomes import Outcomes
    from engine.risk import Risk
    from engine.scenes import Scenes
    from engine.search.campaign import Campaign
    from engine.search.protocol import ObjectiveSpec
    from engine.search.ranking import Case
    from engine.tables import Floats, Ints
    from engine.world import WorldRun


NO_SCENE = (Verdict.EXHAUSTED, Verdict.INFEASIBLE)
"""Verdicts of a scene that no attempt made valid."""
MOST_SCENES = 1 << 32
"""The largest number of scenes: one seed has no more streams."""


@dataclass(frozen=True)
class Scenario:
    """A compiled file, and the settings by which it is drawn, run and searched."""

    compiled: Compiled
    config: Config
    overrides: Mapping[str, str]
    chosen: str | None = None
    """Name of the scenario to run; None: the file's own choice."""
    _known: KnownOutcomes = field(default_factory=KnownOutcomes, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        arguments.config_of(self.config)

    def __repr__(self) -> str:
        """One line, for notebooks: the whole would be the compiler's every table."""
        params, actors = ", ".join(self.program.space.names) or "none", ", ".join(self.program.actors)
        return f"Scenario({self.program.name}: params {params}; actors {actors})"

    @property
    def program(self) -> Program:
        """Return the input of the simulators: params, actors, rules, requirements by name, and the compiled tables."""
        return self.compiled.program

    def sample(self, count: int = 1, seed: int = 0, genome: "ArrayLike | None" = None, jobs: int = 1) -> "Scenes":
        """Draw scenes: their genes from the file's own distributions, or all from one genome (d,) in file units.

        Raises:
            ArgumentKindError, ArgumentError: `count`, `seed` or `jobs` cannot be, or the genome has another length.
        """
        from engine.sampling import draw_genomes
        from engine.streams import key_rows

        count, jobs = arguments.whole("count", count, 0), arguments.whole("jobs", jobs, 1)
        if count > MOST_SCENES:
            what = f"count: expected at most {MOST_SCENES:,}, got {count:,}"
            raise ArgumentError(what, "draw fewer, by several seeds")
        keys = key_rows(arguments.whole("seed", seed, 0), Method.SAMPLE, 0, 0, range(count))
        given = None if genome is None else np.tile(arguments.genome_of(self.program, genome), (count, 1))
        return self._drawn(draw_genomes(self.program.space, keys) if given is None else given, keys, jobs)

    def check_possible(self) -> None:
        """Check that it is not proved that no scene is valid.

        Raises:
            CompileError: it is, with the requirements that exclude each other.
        """
        from engine.feasibility import remembered

        if not (found := remembered(self.program)).infeasible:
            return
        from cortex_dsl.report.findings.impossible import no_scene_at_all

        source = self.compiled.source
        with arguments.drawn_errors():
            raise CompileError(source, [no_scene_at_all(self.program, source, found)])

    def _drawn(self, genomes: "Floats", keys: "Ints", jobs: int = 1) -> "Scenes":
        """Sample scenes, with the driver that the config names."""
        from engine.sampling import sample

        scenes = sample(self.program, genomes, keys, self.config.simulation, jobs)
        if self.config.driver is None:
            return scenes
        from engine.driving.blocks import driven

        return self._known.keep(driven(self.config.driver, self.program, scenes, self.config, jobs))

    def driven_by(self, ego: object, block: int = 256, observe: str = RECORDS) -> "Scenario":
        """Return the scenario with a driver for its controllers (`ExternalBehavior`).

        Every run and search of the result uses the driver.

        `ego`: a function of observations (n, d) to actions (n, a), an object with `reset(lanes, keys)` and
        `act(observations, active)`, `"python:package.module:function"`, or a mapping from the names of controllers to
        these. `block`: scenes in one query, and `observe`, `records` of the file, if it has any, or `egocentric`: both
        influence the results.

        Raises:
            ControllerError: no actor here has a controller, there is none of such a name, or it cannot be queried.
        """
        from engine.driving.named import driver_for

        block, observe = arguments.whole("block", block, 1), arguments.one_of("observe", observe, OBSERVABLE)
        return replace(self, config=replace(self.config, driver=driver_for(self.program, ego, block, observe)))

    def environment(
        self,
        n: int = 1,
        *,
        controller: str = "",
        others: "Mapping[str, object] | None" = None,
        reward: "ObjectiveSpec" = "risk",
        observe: str = RECORDS,
        jobs: int = 1,
    ) -> "Environment":
        """Return `n` parallel scenes that an external program drives step by step.

        They have `reset(seed)` and `step(actions)` on arrays. A lane that has ended begins its next episode with the
        next step.

        `controller`: name of the controller to replace, by default the ego's; `others` drive for the other controllers,
        by default those of `driven_by`. `reward`: an objective; its value at the end of a run counts against the ego
        and for all others. A file with `record … as "reward"` takes precedence. `observe`: `records` of the file, or
        `egocentric`.
        """
        from engine.environment import Environment, Episodes, others_of

        n, jobs = arguments.whole("n", n, 1), arguments.whole("jobs", jobs, 1)
        arguments.one_of("observe", observe, OBSERVABLE)
        (aim,) = arguments.objectives_of(self.program, reward)
        others = others_of(self.program, self.config.driver, controller, observe) if others is None else others
        config = replace(self.config, driver=None, search=replace(self.config.search, jobs=jobs))
        return Environment(Episodes(self.program, n, config, (controller,) * bool(controller), others, aim, observe))

    def scene_of_seed(self, seed: int | None = None) -> "Scenes":
        """Return the scene of `cortexc FILE --seed N`, or without a seed of `cortexc FILE`: up to a hundred genomes
        are drawn until one allows a scene. It is not valid where none did.
        """
        *_, scenes = self.attempts(seed)
        return scenes

    def attempts(self, seed: int | None = None) -> "Iterator[Scenes]":
        """Yield scenes, each of a genome of its own; the last one is the scene of the seed, if it is valid.

        A single scene if it is proved that no scene is valid. Without a seed, the stream is that of a concrete file, or
        else that of seed 0.
        """
        from engine.feasibility import explain
        from engine.sampling import draw_genomes
        from engine.streams import single_keys

        seed = None if seed is None else arguments.whole("seed", seed, 0)
        for number, key in enumerate(single_keys(self.program, seed)):
            scenes = self._drawn(draw_genomes(self.program.space, key), key)
            yield scenes
            if scenes.verdict[0] not in NO_SCENE:
                return
            if number == 0 and explain(self.program).infeasible:
                return

    def table(self, thing: "Scenes | Outcomes | WorldRun") -> "Columns":
        """Return columns by name with their units, as for `pandas.DataFrame`: of scenes the verdict, the params and how
        each actor starts, of outcomes how they ended and the metrics of each pair, of a run the states over time.

        Raises:
            ArgumentKindError: the argument is neither scenes, nor outcomes, nor a run.
        """
        from cortex_dsl.api import named_columns
        from engine.outcomes import Outcomes
        from engine.scenes import Scenes

        if isinstance(thing, Scenes):
            return named_columns.of_scenes(self.program, self._own(thing))
        if isinstance(thing, Outcomes):
            return named_columns.of_outcomes(self.program, thing)
        if hasattr(thing, "trajectory"):
            return named_columns.of_run(self.program, thing)
        raise ArgumentKindError(
            f"thing: expected scenes, outcomes or a run, got {type(thing).__name__}",
            "`sample`, `simulate` and `watch` make them",
        )

    def simulate(self, scenes: "Scenes", engine: str = "batch", jobs: int = 1) -> "Outcomes":
        """Run scenes up to the ego's first contact or their end, in the batch host or in the pymunk world."""
        self._own(scenes)
        jobs = arguments.whole("jobs", jobs, 1)
        if arguments.one_of("engine", engine, ("batch", "world")) == "batch":
            from engine import batch

            if (known := self._known.of(scenes)) is not None:
                return known
            return batch.simulate(self.program, scenes, self.config.simulation, jobs, self.config.contact)
        from engine import world

        return world.simulate(self.program, scenes, self.config, jobs)

    def watch(self, scenes: "Scenes", row: int = 0) -> "WorldRun":
        """Run one scene in the pymunk world, through contact and its aftermath, and return its states over time.

        `.records` of the result holds the records of the file, up to contact or the end.
        """
        from engine import world

        return world.run(self.program, self._own(scenes), arguments.row_of(scenes, row), self.config)

    def assess(self, outcomes: "Outcomes", profile: str = "paper") -> "Risk":
        """Return the risk of each outcome: the integer score 0 .. 22 (-1 invalid), its parts, the continuous score.

        `profile`: where the bands of the score end, `paper`, `paper-mm` or `literature` (see `engine.risk`).
        """
        from engine.outcomes import Outcomes
        from engine.risk import PROFILES, assess

        arguments.kind("outcomes", outcomes, Outcomes, "`simulate` makes them of scenes")
        return assess(outcomes, PROFILES[arguments.one_of("profile", profile, PROFILES)])

    @arguments.with_keywords
    def search(
        self,
        method: str = "ga",
        *,
        objective: "ObjectiveSpec | Sequence[ObjectiveSpec]" = "risk",
        out: str | Path | None = None,
        ego: object = None,
        **settings: Unpack[SearchSettings],
    ) -> "Campaign":
        """Search for the worst cases by `method`.

        Args:
            method: a name of `engine.search.searchers.known_searchers()` such as `ga`, `random`, `niching`, `cmaes`.
            objective: a name (`engine.search.objectives`, or one of the file), or a function from `Outcomes` to one
                number a scene, the larger the better; `nsga2` and `map_elites` take several.
            out: a new folder for journal, tables and worst cases; `cx.open_run` opens it, `cx.resume` continues it.
            ego: driver, as for `driven_by`.
            settings:
                profile: set of risk bands, `paper`, `paper-mm` or `literature`.
                preset: preset of the genetic algorithm, `cortex` or `cortex-literal`.
                on_generation: called with a `Progress` after each generation.
                workers: how the simulations are run (see `engine.search.workers`; processes need a main module that
                    can be imported).
                tables: with `out`: write CSV and JSON lines also for a search of more than 20,000 simulations.
                references: names of the reference drivers that judge collisions.
                generations, population, seed, rollouts, aggregate, jobs, engine, run, probes: fields of
                    `engine.config.SearchConfig`, in place of those of `config`.

        Raises:
            ArgumentKindError: there is no such setting, or it is no number.
            UnknownMethodError, ArgumentError: an unknown method, preset, profile, aggregate or engine, or an impossible
                number.
            MissingExtraError, PluginError: the method cannot be used here.
            CompileError: it is proved that no scene of the file is valid.
        """
        from engine.search.run import search
        from engine.search.workers import Workers

        if ego is not None:
            return self.driven_by(ego).search(method, objective=objective, out=out, **settings)
        arguments.check_keywords("a search", SearchSettings, settings)
        profile, preset = settings.pop("profile", PROFILE), settings.pop("preset", PRESET)
        on_generation, workers = settings.pop("on_generation", None), settings.pop("workers", None)
        arguments.kind("workers", workers, (Workers, NoneType), "`engine.search.workers.Workers` are some")
        tables = settings.pop("tables", False)
        arguments.kind("tables", tables, bool, "write True or False")
        arguments.kind("method", method, str, "`known_searchers` lists all")
        aims = arguments.objectives_of(self.program, objective)
        settled = replace(self.config.search, **settings)
        config = replace(self.config, search=settled, ga=replace(self.config.ga, preset=preset))
        self.check_possible()
        if out is None:
            return search(self.program, method, config, profile, on_generation, workers=workers, objective=aims)
        from cortex_dsl.api.run_folder import SearchOptions, search_and_keep

        options = SearchOptions(profile, aims, workers, on_generation, tables=tables)
        found = search_and_keep(replace(self, config=config), method, arguments.path_of("out", out), options)
        if found.failure is not None:
            raise found.failure
        return found.campaign

    def scene(self, case: "Case") -> "Scenes":
        """Return the one scene of a campaign's case, drawn again from its genome and stream key."""
        from engine.search.ranking import Case

        arguments.kind("case", case, Case, "a campaign has some in `worst`")
        return self.scene_of(np.array(case.genome), np.array(case.key))

    def scene_of(self, genome: "ArrayLike", key: "ArrayLike") -> "Scenes":
        """Return the one scene of a genome (d,) and a stream key (6,)."""
        values, keys = arguments.genome_of(self.program, genome), arguments.key_of(key)
        return self._drawn(values[np.newaxis], keys[np.newaxis])

    def _own(self, scenes: object) -> "Scenes":
        """Return the scenes, after checking that they fit this scenario."""
        return arguments.scenes_of(self.program, scenes)

    def show(self, thing: "Scenes | Case | Campaign", row: int = 0) -> "Picture | Shown":
        """Show in a notebook: a scene as a picture, a case as a page with a replay, a campaign as a table."""
        from cortex_dsl.report.page import notebook

        return notebook.show(self, thing, row)

    def replay(self, scenes: "Scenes", row: int = 0) -> "Shown":
        """Show in a notebook one scene, run in the pymunk world, as a page that plays."""
        from cortex_dsl.report.page import notebook

        return notebook.replay(self, scenes, row)

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page import notebook

        return str(notebook.scenario_table(self))

    def concrete(self, scenes: "Scenes", row: int = 0, remark: str = "") -> str:
        """Return one scene as a scenario of its own, which runs to the same outcome bit for bit.

        `concrete_files` does so for a scenario with imports.
        """
        return next(iter(self.concrete_files(scenes, row, remark).values()))

    def concrete_files(
        self, scenes: "Scenes", row: int = 0, remark: str = "", name: str = "copy.scn", *, laid_out: bool = True
    ) -> dict[str, str]:
        """Return the same with the files that it imports, by the names under which they stand side by side. Without
        `laid_out` every line stays where the author has it.

        Raises:
            RowError, ArgumentError: there is no such row, or its scene is not valid.
        """
        row = arguments.row_of(self._own(scenes), row)
        if not scenes.valid[row]:
            what = f"scene {row} is not valid; only a valid one can be written"
            raise ArgumentError(what, "`scenes.valid` says which are")
        compiled, settings = self.compiled, self.config.simulation
        original = Original(self.program, compiled.module, settings, self.overrides, compiled.imports, self.chosen)
        return concrete_files(original, scenes, row, remark=remark, name=name, laid_out=laid_out)


# -- load --------------------------------------------------------------------------------------------------------------


def load(path: str | Path, config: Config | None = None, scenario: str | None = None, **params: object) -> Scenario:
    """Compile a file. Keywords fix params to constants: `load(path, EGO_SPEED="50 km/h", EGO_BRAKE=0)`.

    `scenario` is the name of the scenario to run if the file has several.

    Raises:
        CompileError: with every mistake in the file.
        UnreadableFileError: the file cannot be read.
    """
    arguments.path_of("path", path, "name a file; `compile_text` takes the text itself")
    try:
        with arguments.drawn_errors():
            source = read_source(path)
    except OSError as error:
        raise UnreadableFileError(path, error) from error
    return _compiled(source, config, scenario, DISK, params)


def compile_text(
    text: str,
    name: str = "<text>",
    config: Config | None = None,
    scenario: str | None = None,
    folder: str | Path | None = None,
    **params: object,
) -> Scenario:
    """Compile a scenario given as text; `name` is its name in messages, `folder` the folder of its imports.

    Raises:
        CompileError: with every mistake in the text.
    """
    arguments.kind("text", text, str, "`load` takes the path of a file")
    files = DISK if folder is None else Folder(arguments.path_of("folder", folder))
    return _compiled(Source(name, text), config, scenario, files, params)


def _compiled(
    source: Source, config: Config | None, scenario: str | None, files: Folder, params: Mapping[str, object]
) -> Scenario:
    config = Config() if config is None else arguments.config_of(config)
    arguments.kind("scenario", scenario, (str, NoneType), arguments.LEFT_OUT)
    overrides = {param: str(value) for param, value in params.items()}
    with arguments.drawn_errors():
        compiled = compile_source(source, overrides, scenario=scenario, files=files)
    compiled = replace(compiled, diagnostics=arguments.in_python(compiled.diagnostics))
    simulation = in_file(config.simulation, compiled.program.settings)
    return Scenario(compiled, replace(config, simulation=simulation), overrides, scenario)


def in_file(config: SimulationConfig, settings: Settings) -> SimulationConfig:
    """Return the config with the settings that the file itself makes."""
    said = {name: getattr(settings, name) for name in ("time_step", "max_time", "max_attempts")}
    return replace(config, **{name: value for name, value in said.items() if value is not None})
