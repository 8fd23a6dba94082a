"""cortexc in Python: load a scenario, draw scenes, run them, search. Prints nothing.

    >>> from cortex_dsl.session import load
    >>> scenario = load("examples/left_turn.scn")
    >>> scenes = scenario.sample(1000, seed=1)
    >>> outcomes = scenario.simulate(scenes)
    >>> outcomes.collided.mean(), scenario.assess(outcomes).score.max()
    >>> campaign = scenario.search("ga", generations=30, population=100)
    >>> print(scenario.concrete(scenario.scene(campaign.worst[0])))

`grammar/API.md` goes through all of it.

A search that keeps everything on disk, and can be gone on with: `search(…, out="runs/mine")`, `cortex_dsl.hunting`,
`cortex_dsl.runs`. A searcher of your own: `engine.search.plugins`.

Arrays are row-aligned and in SI units, genomes in the file's own; their shapes stand at `engine.scenes.Scenes`,
`engine.scenes.Outcomes` and `engine.search.evaluations.Evaluations`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cortex_dsl import asking
from cortex_dsl.concrete import concrete_files
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.files import DISK, Folder
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from engine.config import Config, SimulationConfig
from engine.program import Program, Settings
from engine.vocabulary import Method

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from cortex_dsl.columns import Columns
    from cortex_dsl.report.page.notebook import Picture, Shown
    from engine.risk import Risk
    from engine.scenes import Outcomes, Scenes
    from engine.search.campaign import Campaign, OnGeneration
    from engine.search.ranking import Case
    from engine.search.workers import Workers
    from engine.tables import Floats
    from engine.world import WorldRun


def load(path: str | Path, config: Config | None = None, scenario: str | None = None, **params: object) -> "Scenario":
    """Compile a file. Keywords fix params to constants: `load(path, EGO_SPEED="50 km/h", EGO_BRAKE=0)`; `scenario`
    names the one to run where the file has several.

    Raises:
        CompileError: with every mistake in the file.
        OSError: the file cannot be read.
    """
    text = Path(path).read_text(encoding="utf-8")
    return compile_text(text, str(path), config, scenario, None, **params)


def compile_text(
    text: str,
    name: str = "<text>",
    config: Config | None = None,
    scenario: str | None = None,
    folder: str | Path | None = None,
    **params: object,
) -> "Scenario":
    """Compile a scenario given as text; `name` is what messages call it, `folder` is where its imports lie."""
    overrides = {param: str(value) for param, value in params.items()}
    files = DISK if folder is None else Folder(Path(folder))
    try:
        compiled = compile_source(Source(name, text), overrides, scenario=scenario, files=files)
    except CompileError as error:
        raise CompileError(error.source, asking.in_python(error.diagnostics)) from None
    compiled = replace(compiled, diagnostics=asking.in_python(compiled.diagnostics))
    config = config or Config()
    simulation = in_file(config.simulation, compiled.program.settings)
    return Scenario(compiled, replace(config, simulation=simulation), overrides, scenario)


def in_file(config: SimulationConfig, settings: Settings) -> SimulationConfig:
    """The config, with what the file itself says about its simulation put in."""
    said = {name: getattr(settings, name) for name in ("time_step", "max_time", "max_attempts")}
    return replace(config, **{name: value for name, value in said.items() if value is not None})


@dataclass(frozen=True)
class Scenario:
    """A compiled file and the settings that everything it is asked for uses."""

    compiled: Compiled
    config: Config
    overrides: Mapping[str, str]
    chosen: str | None = None
    """The scenario of the file that was asked for; None: the file's own choice."""

    def __repr__(self) -> str:
        """One line, for notebooks: the whole would be the compiler's every table."""
        params, actors = ", ".join(self.program.space.names) or "none", ", ".join(self.program.actors)
        return f"Scenario({self.program.name}: params {params}; actors {actors})"

    @property
    def program(self) -> Program:
        """What the simulators run: params, actors, rules and requirements by name, and the compiled tables."""
        return self.compiled.program

    def sample(self, count: int = 1, seed: int = 0, genome: "ArrayLike | None" = None, jobs: int = 1) -> "Scenes":
        """Draw scenes: their genes from the file's own distributions, or all from one genome (d,) in file units.

        Raises:
            TypeError, ValueError: `count`, `seed` or `jobs` cannot be, or the genome has another length.
        """
        from engine.sampling import draw_genomes, sample
        from engine.streams import key_rows

        count, jobs = asking.whole("count", count, 0), asking.whole("jobs", jobs, 1)
        keys = key_rows(asking.whole("seed", seed, 0), Method.SAMPLE, 0, 0, range(count))
        drawn = draw_genomes(self.program.space, keys) if genome is None else np.tile(self._genome(genome), (count, 1))
        return sample(self.program, drawn, keys, self.config.simulation, jobs)

    def scene_of_seed(self, seed: int | None = None) -> "Scenes":
        """The one scene of `cortexc FILE --seed N`, or without a seed that of `cortexc FILE`: up to a hundred genomes
        are drawn until one allows a scene. It is not valid where none did.
        """
        from cortex_dsl.single import attempts

        seed = None if seed is None else asking.whole("seed", seed, 0)
        *_, scenes = attempts(self.program, self.config.simulation, seed)
        return scenes

    def table(self, thing: "Scenes | Outcomes | WorldRun") -> "Columns":
        """Columns by name with their units, as for `pandas.DataFrame`: of scenes the verdict, the params and how
        everybody starts, of outcomes how they ended and the metrics of each pair, of a run everybody over time.

        Raises:
            TypeError: it is nothing of these.
        """
        from cortex_dsl import columns
        from engine.scenes import Outcomes, Scenes

        if isinstance(thing, Scenes):
            return columns.of_scenes(self.program, self._own(thing))
        if isinstance(thing, Outcomes):
            return columns.of_outcomes(self.program, thing)
        if hasattr(thing, "trajectory"):
            return columns.of_run(self.program, thing)
        raise TypeError(f"expected scenes, outcomes or a run, got {type(thing).__name__}")

    def simulate(self, scenes: "Scenes", engine: str = "batch", jobs: int = 1) -> "Outcomes":
        """Run scenes up to first contact or their end, in the batch host or in the pymunk world."""
        self._own(scenes)
        jobs = asking.whole("jobs", jobs, 1)
        if engine == "batch":
            from engine import batch

            return batch.simulate(self.program, scenes, self.config.simulation, jobs)
        if engine == "world":
            from engine import world

            return world.simulate(self.program, scenes, self.config, jobs)
        raise ValueError(f"engine: expected batch or world, got `{engine}`")

    def watch(self, scenes: "Scenes", row: int = 0) -> "WorldRun":
        """Run one scene in the pymunk world, through contact and its aftermath, and keep its states over time.

        `.records` of what comes back holds what the file asks to be recorded, up to contact or the end.
        """
        from engine import world

        return world.run(self.program, self._own(scenes), asking.row_of(scenes, row), self.config)

    def assess(self, outcomes: "Outcomes", profile: str = "paper") -> "Risk":
        """Risk of each outcome: the integer score 0 .. 22 (-1 invalid), its parts, the continuous score.

        `profile`: where the bands of the score end, `paper`, `paper-mm` or `literature` (see `engine.risk`).
        """
        from engine.risk import PROFILES, assess
        from engine.scenes import Outcomes

        asking.kind("outcomes", outcomes, Outcomes, "`simulate` makes them of scenes")
        if profile not in PROFILES:
            raise ValueError(f"profile: expected one of {', '.join(PROFILES)}, got `{profile}`")
        return assess(outcomes, PROFILES[profile])

    def search(
        self,
        method: str = "ga",
        *,
        profile: str = "paper",
        preset: str = "cortex",
        on_generation: "OnGeneration | None" = None,
        workers: "Workers | None" = None,
        out: str | Path | None = None,
        **settings: Any,
    ) -> "Campaign":
        """Hunt for the worst by `method`, a name of `engine.search.searchers.known_searchers()` such as `ga`, `random`,
        `niching`, `cmaes`; `preset` of the genetic algorithm is `cortex` or `cortex-literal`.

        Settings are fields of `engine.config.SearchConfig`: generations, population, seed, rollouts, aggregate, jobs,
        engine. `on_generation` is called with a `Progress` after each generation; `workers` run the simulations (see
        `engine.search.workers`; processes need a main module that can be imported). `out` is a new folder for journal,
        tables and worst cases; `cortex_dsl.runs.open_run` opens it, `cortex_dsl.hunting.resume` goes on with it.

        Raises:
            TypeError: there is no such setting, or it is no number.
            ValueError: an unknown method, preset, profile, aggregate or engine, or a number that cannot be.
        """
        from engine.search.study import search

        asking.settings(settings)
        config = replace(
            self.config,
            search=replace(self.config.search, **settings),
            ga=replace(self.config.ga, preset=preset),
        )
        if out is None:
            return search(self.program, method, config, profile, on_generation, workers=workers)
        return self._kept(method, Path(out), config, profile=profile, on_generation=on_generation, workers=workers)

    def _kept(self, method: str, out: Path, config: Config, **how: Any) -> "Campaign":
        """A search in a run directory of its own."""
        from cortex_dsl.hunting import hunt
        from engine.search.store import new_directory

        found = hunt(replace(self, config=config), method, new_directory(out), **how)
        if found.trouble is not None:
            raise found.trouble
        return found.campaign

    def scene(self, case: "Case") -> "Scenes":
        """The one scene of a campaign's case, drawn again from its genome and stream key."""
        from engine.search.ranking import Case

        asking.kind("case", case, Case, "a campaign has some in `worst`")
        return self.scene_of(np.array(case.genome), np.array(case.key, dtype=np.int64))

    def scene_of(self, genome: "ArrayLike", key: "ArrayLike") -> "Scenes":
        """The one scene of a genome (d,) and a stream key (6,)."""
        from engine.sampling import sample
        from engine.scenes import StreamKey

        keys = np.asarray(key, dtype=np.int64)
        if keys.shape != (len(StreamKey._fields),):
            raise ValueError(f"key: expected {', '.join(StreamKey._fields)}, got shape {keys.shape}")
        return sample(self.program, self._genome(genome)[np.newaxis], keys[np.newaxis], self.config.simulation)

    def _genome(self, genome: "ArrayLike") -> "Floats":
        """A value for each param."""
        values, names = np.asarray(genome, dtype=np.float64), self.program.space.names
        if values.shape != (len(names),):
            raise ValueError(f"genome: expected a value for each of {', '.join(names)}, got shape {values.shape}")
        return values

    def _own(self, scenes: "Scenes") -> "Scenes":
        """Scenes that can be of this scenario."""
        from engine.scenes import Scenes

        asking.kind("scenes", scenes, Scenes, "`sample` draws some, `scene` is that of a case")
        widths = len(self.program.space), self.program.code.output_register.shape[1]
        if (scenes.genomes.shape[1], scenes.values.shape[1]) != widths:
            raise ValueError("scenes: these are of another scenario, or of this one with other params fixed")
        return scenes

    def show(self, thing: "Scenes | Case | Campaign", row: int = 0) -> "Picture | Shown":
        """For notebooks: one of some scenes as a picture, a case as a page that plays, a campaign as a table."""
        from cortex_dsl.report.page import notebook

        return notebook.show(self, thing, row)

    def replay(self, scenes: "Scenes", row: int = 0) -> "Shown":
        """For notebooks: one scene run in the pymunk world, as a page that plays."""
        from cortex_dsl.report.page import notebook

        return notebook.replay(self, scenes, row)

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page import notebook

        return str(notebook.scenario_table(self))

    def concrete(self, scenes: "Scenes", row: int = 0, remark: str = "") -> str:
        """One scene as a scenario of its own, which runs to the same outcome bit for bit. See `concrete_files` for one
        with imports.
        """
        return next(iter(self.concrete_files(scenes, row, remark).values()))

    def concrete_files(
        self, scenes: "Scenes", row: int = 0, remark: str = "", name: str = "copy.scn", *, laid_out: bool = True
    ) -> dict[str, str]:
        """The same with the files that it imports, by the names under which they must be written side by side. Without
        `laid_out` every line stays where the author has it.

        Raises:
            IndexError, ValueError: there is no such row, or its scene is not valid.
        """
        row = asking.row_of(self._own(scenes), row)
        if not scenes.valid[row]:
            raise ValueError(f"scene {row} is not valid; only a valid one can be written")
        return concrete_files(
            self.program,
            self.compiled.module,
            scenes,
            row,
            self.config.simulation,
            overrides=self.overrides,
            remark=remark,
            imports=self.compiled.imports,
            scenario=self.chosen,
            name=name,
            laid_out=laid_out,
        )
