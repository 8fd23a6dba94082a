"""Cases for other people's tools, and recordings from them: `cortexc export` and `cortexc measure` in Python.

>>> import cortex_dsl as cx
>>> cx.export(cx.open_run("runs/left_turn-ga-001"), ["xosc", "csv"], "elsewhere", top=3)
>>> cx.measure("elsewhere/left_turn-case01.csv").risk.score
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from shlex import join
from types import NoneType
from typing import TYPE_CHECKING, Unpack, cast

import numpy as np

from cortex_dsl.api import arguments
from cortex_dsl.api.arguments import WritingSettings
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.interchange.formats import FORMATS, RECORDINGS, missing_extra
from engine.errors import ArgumentError
from engine.search.store import store_errors

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from engine.interchange.every_pair import RankedWindows
    from engine.interchange.measuring import Measured
    from engine.interchange.openscenario.read import Imported


@arguments.with_keywords
def export(
    what: OpenedRun | Scenario,
    formats: str | Iterable[str],
    out: str | Path,
    *,
    case: int | None = None,
    top: int | None = None,
    seed: int | None = None,
    **settings: Unpack[WritingSettings],
) -> list[Path]:
    """Write a case for other tools; return the paths of all its files, first the file to open.

    Args:
        what: an opened run, or a scenario.
        formats: one or more of xosc, xodr, commonroad, scenic, csv, parquet, mcap, scn.
        out: folder of the files, made if it is not there.
        case: number of a case of a run; None: 1, the worst.
        top: number of worst cases of a run to write, instead of one case.
        seed: for a scenario, the seed of its scene; None: 0, or the stream that a concrete file names.
        settings:
            osc: version of an xosc, 1.0 to 1.3; None: 1.2.
            mode: form of an xosc: `trajectory` (None) replays the case exactly, `maneuver` describes it by speeds,
                routes and triggers.
            player: `carla`: an xosc that CARLA's ScenarioRunner replays exactly, with the controller for it.
            after_contact: content of a replay after contact: `through` (None, of an xosc), `stop` or `physics` (None,
                of recordings).
            force: write over files with other contents.

    Raises:
        ArgumentKindError, ArgumentError: no such format or case, an option without effect here (`seed` of a run, `case`
            of a scenario, `osc` without xosc), a scene that is not valid, or a file in the way.
        MissingExtraError: a format needs a package that is not installed.
        InterchangeError: a format cannot carry the case.
        StoreError: the files cannot be written; none of them is.
    """
    from cortex_dsl.interchange.formats import gather
    from engine.atomic import standing, write_all
    from engine.interchange.contract import ExportOptions

    arguments.check_keywords("an export", WritingSettings, settings)
    osc, mode, player = (settings.get(name) for name in ("osc", "mode", "player"))
    after_contact, force = settings.get("after_contact"), settings.get("force", False)
    folder = arguments.path_of("out", out, "name a folder")
    names = _formats([formats] if isinstance(formats, str) else arguments.several("formats", formats))
    if "xosc" not in names:
        cure = "leave it out, or add xosc to the formats"
        _no_effect("without the format xosc", cure, osc=osc, mode=mode, player=player)
    how = ExportOptions(osc or ("1.2" if player is None else "1.0"), mode or "trajectory", player, after_contact)
    gathered = gather(_cases(what, case, top, seed), names, how)
    for refused in gathered.refused.values():
        raise refused
    with store_errors(folder):
        there = standing(folder, gathered.files)
    if there.other and not force:
        place = folder / there.other[0]
        raise ArgumentError(
            f"out: `{place}` holds something else", "name another folder, or write over it with `force`"
        )
    with store_errors(folder):
        files = {name: content for name, content in gathered.files.items() if name not in there.same}
        write_all(folder, files, over=force)
    return [folder / name for name in gathered.files]


def measure(
    file: str | Path,
    *,
    ego: str | None = None,
    step: float | None = None,
    profile: str = "paper",
    rate: float | None = None,
    window: tuple[float, float] | None = None,
    columns: Mapping[str, str] | None = None,
) -> "Measured":
    """Assess a recording, from any driver, by the kernels that assess our runs.

    The result has `.outcomes` and `.risk` (one row each), `.metrics` (name, value, unit) and the `.trajectory` on whole
    steps.

    Args:
        file: a table of trajectories (`.csv`, `.parquet`), a log of a simulator, or an OpenSCENARIO file (`.xosc`)
            whose actors follow timed polylines.
        ego: name of the assessed actor; None: the one called ego, or else the first.
        step: time step of the metrics [s]; None: that of the file.
        profile: set of risk bands, `paper`, `paper-mm` or `literature`.
        rate: samples a second, if a table counts frames without a rate.
        window: begin and end of a part of it [s after its first row]; None: all of it.
        columns: names of columns by their meaning, as in `{"time [ms]": "zeit"}`, if their names do not show it.

    Raises:
        ArgumentError: a file of another kind, no such profile, or times that are no window.
        InterchangeError: it cannot be read, or is no motion.
    """
    from engine.interchange.measuring import measure as judged
    from engine.risk import PROFILES

    arguments.one_of("profile", profile, PROFILES)
    read = read_recording(file, ego=ego, step=step, rate=rate, window=window, columns=columns)
    return judged(read.recording, profile)


def read_recording(
    file: str | Path,
    *,
    ego: str | None = None,
    step: float | None = None,
    rate: float | None = None,
    window: tuple[float, float] | None = None,
    columns: Mapping[str, str] | None = None,
) -> "Imported":
    """Return the input of `measure`: the recording of a file, its road if it has one, and unsupported contents.

    Raises:
        ArgumentError, InterchangeError: as `measure`.
    """
    path = _recording_path(file, step=step, rate=rate)
    arguments.kind("ego", ego, (str, NoneType), arguments.LEFT_OUT)
    from engine.interchange.sources import read_recording as read_any

    part = None if window is None else _window(window)
    return read_any(path, ego=ego, step=step, rate=rate, window=part, columns=_columns(columns))


def _columns(columns: object) -> Mapping[str, str]:
    """Return the names of columns by their meaning."""
    cure = 'name columns by what they are, as in {"time": "zeit"}'
    arguments.kind("columns", columns, (Mapping, NoneType), cure)
    found = {} if columns is None else dict(cast("Mapping[object, object]", columns))
    for text in (*found, *found.values()):
        arguments.kind("columns", text, (str,), cure)
    return cast("dict[str, str]", found)


def _window(window: object) -> tuple[float, float]:
    """Two times [s], the first from 0 on and the second after it."""
    cure = "name two times, as in (12.4, 18)"
    arguments.kind("window", window, (tuple, list), cure)
    times = arguments.several("window", window)
    for time in times:
        arguments.kind("window", time, (int, float, np.integer), cure)
    if len(times) != 2 or not 0.0 <= times[0] < times[1] < np.inf:
        raise ArgumentError(f"window: expected a time from 0 on and a later one, got {window!r}", cure)
    return float(times[0]), float(times[1])


def _recording_path(file: str | Path, **numbers: float | None) -> Path:
    """The path of a recording that is read; options that are numbers are such, or left out."""
    path = arguments.path_of("file", file, "name a recording by its path")
    for name, value in numbers.items():
        arguments.kind(name, value, (int, float, np.integer, NoneType), arguments.LEFT_OUT)
    if path.suffix.lower() not in RECORDINGS:
        raise ArgumentError(
            f"file: expected one that ends in {', '.join(RECORDINGS)}, got `{path}`", "name a recording of these kinds"
        )
    return path


def measure_all(
    file: str | Path,
    *,
    near: float | None = None,
    step: float | None = None,
    profile: str = "paper",
    rate: float | None = None,
    columns: Mapping[str, str] | None = None,
) -> "RankedWindows":
    """Assess every pair of a recording while its centres are near one another; the worst window is the first row.

    Args:
        file: a recording of any kind that `measure` reads.
        near: distance below which a pair is assessed [m]; None: 50.
        step: time step of the metrics [s]; None: that of the file.
        profile: set of risk bands.
        rate: samples a second, if a table counts frames without a rate.
        columns: as in `measure`.

    Raises:
        ArgumentError, InterchangeError: as `measure`.
    """
    from engine.interchange.every_pair import NEAR, rank_pairs
    from engine.interchange.sources import read_traffic
    from engine.risk import PROFILES

    arguments.one_of("profile", profile, PROFILES)
    path = _recording_path(file, near=near, step=step, rate=rate)
    traffic = read_traffic(path, rate, columns=_columns(columns))
    return rank_pairs(traffic, near=NEAR if near is None else near, step=step, profile=profile)


def _formats(names: Iterable[str]) -> tuple[str, ...]:
    """Return each format once; all of them are known and installed."""
    from engine.extras import MissingExtraError

    words = tuple(dict.fromkeys(arguments.one_of("formats", name, FORMATS) for name in names))
    if not words:
        raise ArgumentError("formats: expected one or more, got none", f"there are {', '.join(FORMATS)}")
    for name in words:
        if missing_extra(name):
            raise MissingExtraError(f"{name} needs", FORMATS[name].package, FORMATS[name].extra)
    return words


def _cases(what: OpenedRun | Scenario, case: int | None, top: int | None, seed: int | None) -> "list[ExportCase]":
    arguments.kind("what", what, (OpenedRun, Scenario), "`open_run` opens a run, `load` a scenario")
    if isinstance(what, Scenario):
        _no_effect("for a scenario, which has no cases", "leave it out, or export an opened run", case=case, top=top)
        return [_scene(what, seed)]
    _no_effect("for a run, whose cases have scenes of their own", "name a case with `case`", seed=seed)
    if case is not None:
        _no_effect("beside `case`", "name one of the two", top=top)
    return _of_run(what, 1 if case is None else case, top)


def _no_effect(where: str, cure: str, **options: object) -> None:
    """Raises ArgumentError for the first option that is given."""
    for name, value in options.items():
        if value is not None:
            raise ArgumentError(f"{name}: it has no effect {where}, got {value!r}", cure)


def _of_run(run: OpenedRun, case: int, top: int | None) -> "list[ExportCase]":
    from cortex_dsl.interchange.cases import case_of_run

    cases = run.every_case()
    if not cases:
        raise ArgumentError(f"what: `{run.folder}` has no case: none of its simulations was valid", "search again")
    if top is not None:
        return [case_of_run(run, each) for each in run.first_cases(arguments.whole("top", top, 1))]
    if arguments.whole("case", case, 1) > len(cases):
        raise ArgumentError(f"case: expected 1 to {len(cases):,}, got {case:,}", "1 is the worst")
    return [case_of_run(run, cases[case - 1])]


def _scene(scenario: Scenario, seed: int | None) -> "ExportCase":
    from cortex_dsl.interchange.cases import case_of_scene
    from engine.vocabulary import Verdict

    scenes = scenario.scene_of_seed(seed)
    if not scenes.valid[0]:
        raise ArgumentError("seed: no scene meets the requirements of the file", "try another seed, or relax them")
    pinned = scenario.program.settings.stream is not None and seed is None
    number = None if pinned else seed or 0
    case = case_of_scene(scenario, scenes, Path(scenario.compiled.source.name), number, _command(scenario, number))
    if case.outcomes.verdict[0] == Verdict.ERROR:
        raise ArgumentError("seed: the run of this scene fails", "`cortexc FILE --seed N` says why")
    return case


def _command(scenario: Scenario, seed: int | None) -> str:
    """The command line that shows the same scene; "" for a text that came from no file."""
    file = scenario.compiled.source.name
    if not Path(file).is_file():
        return ""
    chosen = [] if scenario.chosen is None else ["--scenario", scenario.chosen]
    params = [word for name, value in scenario.overrides.items() for word in ("-p", f"{name}={value}")]
    return join(["cortexc", file, *chosen, *params, *([] if seed is None else ["--seed", str(seed)])])
