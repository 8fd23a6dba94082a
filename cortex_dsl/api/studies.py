"""Studies in Python: every scenario by every method many times, with or without a folder, and compared run by run.

    >>> import cortex_dsl as cx
    >>> done = cx.study("examples", ["random", "ga"], runs=5, generations=4, population=20, out="runs/mine")
    >>> done.findings.verdict

`cortexc study` begins, carries out and continues a study by the same functions.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from os.path import commonpath, relpath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from cortex_dsl.api import arguments
from cortex_dsl.api.arguments import PRESET, PROFILE, StudySettings
from cortex_dsl.api.restoring import restore_study
from cortex_dsl.api.run_folder import origin_of
from cortex_dsl.api.scenario import Scenario, load
from engine.display import counted, facts_table
from engine.errors import ArgumentError
from engine.risk import PROFILES
from engine.search.searchers import canonical
from engine.search.store import StoreError, hold, new_directory, without_folders
from engine.search.workers import Workers, open_workers
from engine.study.database import Study, StudyStore, read_study
from engine.study.execution import perform_all
from engine.study.plan import RUNS, Plan, Subject, check, with_own_seeds
from engine.study.run_records import Finished, RunRecord
from engine.study.verdict import Findings, findings

if TYPE_CHECKING:
    from engine.study.execution import OnRun

Files = str | Path | Scenario


@dataclass(frozen=True)
class Studied:
    """A study as far as it got."""

    plan: Plan
    records: tuple[RunRecord, ...]
    """Records of the finished runs, in the order of the plan."""
    folder: Path | None = None
    """Folder with every evaluation; None: evaluations are not stored."""

    @property
    def complete(self) -> bool:
        """Return whether every run of the plan is finished; Ctrl-C ends a study earlier."""
        return len(self.records) == sum(1 for _ in self.plan.addresses())

    @cached_property
    def findings(self) -> Findings:
        """Return comparisons run by run, rates of collision of random search, and permitted claims."""
        return findings(self.plan, self.records)

    def __repr__(self) -> str:
        """One line, for notebooks."""
        plan = self.plan
        size = " x ".join((counted(len(plan.subjects), "scenario"), ", ".join(plan.methods), counted(plan.runs, "run")))
        return f"Studied({size}; {len(self.records)} finished)"

    def _repr_html_(self) -> str:
        facts = [("study", repr(self)), ("kept in", str(self.folder) if self.folder else "memory")]
        return facts_table([*facts, *(("finding", sentence) for sentence in self.findings.verdict)])


@arguments.with_keywords
def study(
    files: Files | Iterable[Files],
    methods: str | Iterable[str] = ("random", "ga"),
    runs: int = RUNS,
    *,
    objective: str | Iterable[str] = "risk",
    out: str | Path | None = None,
    ego: object = None,
    **settings: Unpack[StudySettings],
) -> Studied:
    """Search every scenario by every method `runs` times, and compare the methods run by run.

    Args:
        files: scenarios, by path or loaded; for a folder all its `*.scn`. Each gets a seed of its own.
        methods: names as `Scenario.search` takes them; if `random` is among them, the others are compared with it.
        runs: number of runs of each method on each scenario; claims need 30 or more.
        objective: one or several names that every scenario has.
        out: a new folder for every evaluation and for the tables of the study, as with `cortexc study`; None: results
            stay in memory, without the single evaluations.
        ego: driver, as for `Scenario.driven_by`; with several `jobs` by its name, `"python:module:function"`.
        settings:
            jobs: processes, each with a whole run; more than 1 need a main module that can be imported.
            profile: set of risk bands, `paper`, `paper-mm` or `literature`.
            preset: preset of the genetic algorithm, `cortex` or `cortex-literal`.
            on_run: called with each `engine.study.run_records.Finished`, in no certain order.
            references: names of the reference drivers that judge collisions.
            generations, population, seed, rollouts, aggregate, engine, run, probes: fields of
                `engine.config.SearchConfig`, in place of those of each scenario's config.

    Raises:
        CompileError: a file has errors, or it is proved that none of its scenes is valid.
        UnknownMethodError, MissingExtraError, PluginError: a method cannot be used here.
        ArgumentError, ArgumentKindError: no scenario, one without params, an impossible number, an unknown setting.
        StoreError: the folder cannot be written, or a worker was killed.
    """
    arguments.check_keywords("a study", StudySettings, settings)
    profile, preset = settings.pop("profile", PROFILE), settings.pop("preset", PRESET)
    on_run, jobs, runs = settings.pop("on_run", None), settings.pop("jobs", 1), arguments.whole("runs", runs, 1)
    arguments.one_of("profile", profile, PROFILES)
    scenarios = _scenarios([files] if isinstance(files, Files) else arguments.several("files", files))
    if ego is not None:
        scenarios = [(name, scenario.driven_by(ego)) for name, scenario in scenarios]
    subjects = [_subject(name, scenario, preset, settings) for name, scenario in scenarios]
    words = [methods] if isinstance(methods, str) else arguments.several("methods", methods)
    for word in words:
        arguments.kind("methods", word, str, "`known_searchers` lists all")
    aims = (objective,) if isinstance(objective, str) else tuple(arguments.several("objective", objective))
    for aim in aims:
        arguments.kind("objective", aim, str, "a study compares by names; `Scenario.search` takes a function, too")
    plan = Plan(with_own_seeds(subjects), tuple(dict.fromkeys(map(canonical, words))), runs, profile, aims)
    check(plan)
    if out is None:
        return _in_memory(plan, Workers("processes", jobs), on_run)
    folder = new_directory(arguments.path_of("out", out, "name a folder"))
    with hold(folder), closing(StudyStore.create(folder, plan, facts(plan, ()))) as store:
        carry_out(plan, (), _both(store.write, on_run), Workers("processes", jobs))
    return _tabulated(folder)


def resume_study(folder: str | Path, *, jobs: int = 1, on_run: "OnRun | None" = None, ego: object = None) -> Studied:
    """Continue a study that was stopped or killed, from its folder; a complete study is only read.

    `ego` is the driver of the earlier runs.

    Raises:
        StoreError: no readable study, another process writes it, or another version of the engine began it.
    """
    folder, jobs = arguments.path_of("folder", folder, "name the folder of a study"), arguments.whole("jobs", jobs, 1)
    found = read_study(folder).driven_by(ego)
    if not found.complete:
        insist_on_same_engine(found)
        with hold(folder):
            found = read_study(folder).driven_by(ego)  # read again under the lock: no process can change it any more
            with closing(StudyStore.reopen(folder)) as store:
                carry_out(found.plan, found.records, _both(store.write, on_run), Workers("processes", jobs))
    return _tabulated(folder)


def carry_out(plan: Plan, earlier: Sequence[RunRecord], on_run: "OnRun", workers: Workers) -> bool:
    """Do the runs that are left; return whether Ctrl-C came first."""
    done = [record.address for record in earlier]
    try:
        if workers.kind == "dask":
            with open_workers(workers) as executor:
                perform_all(plan, on_run, workers.jobs, done, executor)
        else:
            perform_all(plan, on_run, workers.jobs, done)
    except KeyboardInterrupt:
        return True
    return False


def facts(plan: Plan, command_line: Sequence[str]) -> dict[str, object]:
    """Return the facts on how a study came to be."""
    from engine.kernels.jit import source_hash

    versions: dict[str, str] = {}
    for method in plan.methods:
        versions |= plan.manifest(plan.subjects[0], method).versions
    return {
        "command_line": [without_folders(word) for word in command_line],
        "versions": versions,
        "engine": source_hash(),
    }


def insist_on_same_engine(study: Study) -> None:
    """Check that a study is continued by the engine that began it: runs of two engines must not be compared.

    Raises:
        StoreError: it was begun by another engine.
    """
    from engine.kernels.jit import source_hash

    if study.manifest.get("engine") != source_hash():
        wrote = study.manifest.get("versions", {}).get("cortexc", "unknown")
        raise StoreError(
            f"the study in `{study.folder}` was begun by another version of the engine",
            f"use the version that began it, cortexc {wrote}, or begin a new study",
        )


def short_names(files: Sequence[Path]) -> list[str]:
    """Return a unique name for each file: its stem, or its path from the folder of all where two stems are equal."""
    stems = [file.stem for file in files]
    home = commonpath([file.absolute().parent for file in files]) if files else ""
    return [stem if stems.count(stem) == 1 else relpath(file, home) for file, stem in zip(files, stems, strict=True)]


# -- from arguments to a plan ------------------------------------------------------------------------------------------


def _scenarios(files: Iterable[Files]) -> list[tuple[str, Scenario]]:
    """Return each scenario with its short name; a folder is replaced by the scenarios in it."""
    loaded: list[tuple[Path, Scenario]] = []
    for each in files:
        arguments.kind("files", each, (str, Path, Scenario), "name scenario files or folders, or load them")
        if isinstance(each, Scenario):
            loaded.append((Path(each.compiled.source.name), each))
        else:
            loaded += [(path, load(path)) for path in _unfolded(arguments.path_of("files", each))]
    return list(zip(short_names([path for path, _ in loaded]), [scenario for _, scenario in loaded], strict=True))


def _unfolded(path: Path) -> list[Path]:
    inside = sorted(path.glob("*.scn")) if path.is_dir() else [path]
    if not inside:
        raise ArgumentError(f"files: there is no scenario (*.scn) in `{path}`", "name another folder, or files")
    return inside


def _subject(name: str, scenario: Scenario, preset: str, settings: Mapping[str, Any]) -> Subject:
    if not len(scenario.program.space):
        raise ArgumentError(f"files: `{name}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    scenario.check_possible()
    config = scenario.config
    config = replace(config, search=replace(config.search, **settings), ga=replace(config.ga, preset=preset))
    return Subject(name, scenario.compiled.source.name, scenario.program, config, origin_of(scenario))


# -- results -----------------------------------------------------------------------------------------------------------


def _in_memory(plan: Plan, workers: Workers, on_run: "OnRun | None") -> Studied:
    records: dict[Any, RunRecord] = {}

    def keep(finished: Finished) -> None:
        records[finished.record.address] = finished.record

    carry_out(plan, (), _both(keep, on_run), workers)
    return Studied(plan, tuple(records[address] for address in plan.addresses() if address in records))


def _both(first: "OnRun", second: "OnRun | None") -> Callable[[Finished], None]:
    def on_run(finished: Finished) -> None:
        first(finished)
        if second is not None:
            second(finished)

    return on_run


def _tabulated(folder: Path) -> Studied:
    """Return the study of a folder, after writing its tables there."""
    study = read_study(folder)
    done = Studied(study.plan, study.records, folder)
    restore_study(study, done.findings)
    return done
