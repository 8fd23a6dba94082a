"""The two sides of a comparison, and their checks.

A side is a driver from outside (`python:…`, `process:…`), a behavior of the language in the place of the ego's
`ExternalBehavior`, a version of a file, or the folder of a search. On a file it becomes a scenario that runs.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np

from cortex_dsl import pipeline
from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.api.scenario import Scenario, compile_text, load
from cortex_dsl.api.seeded_runs import fitting_driver
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.plain_text import as_argument
from cortex_dsl.semantics.names.builtins import BUILTINS, Kind
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.shipped import SUFFIX
from cortex_dsl.source import Span
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import nodes
from engine.driving.blocks import BLOCK, Driver
from engine.driving.named import driver_of
from engine.driving.names import FORMS, parted, words_of
from engine.driving.observations import EGOCENTRIC, observed
from engine.errors import ArgumentError, ControllerError, CortexError
from engine.kernels.egocentric import NEAREST
from engine.program import ParamSpace, Program
from engine.search.store import JOURNAL
from engine.vocabulary import RECORDS, Distribution

EXTERNAL = "ExternalBehavior"
_DRIVER = re.compile(r"([^=]+=)?(python|process):", re.DOTALL)
_BEHAVIOUR = re.compile(r"([A-Za-z_]\w*)\s*(\(.*\))?", re.DOTALL)


class NotComparableError(CortexError):
    """The two sides cannot be compared on this file."""


class SideKind(StrEnum):
    """Kind of a side of a comparison."""

    DRIVER = "driver"
    BEHAVIOUR = "behavior"
    VERSION = "file"
    RUN = "run"


ON_FILES = (SideKind.DRIVER, SideKind.BEHAVIOUR)
"""Kinds that need files to drive in."""


@dataclass(frozen=True)
class Side:
    """One side of a comparison as it is named."""

    word: str
    """Name as typed."""
    kind: SideKind
    driver: Driver | None = None
    """Driver of the controllers; None: no controller is needed."""
    driver_words: tuple[str, ...] = ()
    """Words of a command line that name the driver."""


@dataclass(frozen=True)
class Contender:
    """A side on a file."""

    scenario: Scenario
    """Scenario without a driver in its config."""
    driver: Driver | None
    command: tuple[str, ...]
    """Words of the command that repeats a run of a seed, without the seed; (): no single command does."""
    remarks: tuple[str, ...] = ()
    unobserved: tuple[str, ...] = ()
    """Features of the scenario that the driver does not observe."""

    @property
    def program(self) -> Program:
        return self.scenario.program


# -- what a word names -------------------------------------------------------------------------------------------------


def side_of(
    word: str, ego: object = None, block: int = BLOCK, observe: str = RECORDS, words: Sequence[str] = ()
) -> Side:
    """Return the side that a word names; `ego` drives the controllers of a file or run, and `words` name its settings.

    Raises:
        ArgumentError: it names nothing, or `ego` is given for a driver.
        ControllerError: there is no such driver.
    """
    if not word.strip():
        cure = f"name {FORMS}, or a behavior such as `EmergencyBrakeBehavior`"
        raise ArgumentError("the name of a driver is empty", cure)
    path = Path(word)
    if _DRIVER.match(word):
        kind, egos = SideKind.DRIVER, parted(word)
        driver, named = driver_of(egos, block, observe), words_of(egos)
    else:
        kind, driver = _kind_of(word, path), driver_of(ego, block, observe)
        named = words_of(ego) if isinstance(ego, str | dict) else []
    if ego is not None and kind in ON_FILES:
        raise ArgumentError(f"`{word}` is a {kind} and needs no further driver", "name drivers for files and runs only")
    return Side(word, kind, driver, (*named, *words) if named else ())


def _kind_of(word: str, path: Path) -> SideKind:
    """Return the kind of a side that is no driver from outside.

    Raises:
        ArgumentError: the word names nothing.
    """
    if path.is_dir() or path.name == JOURNAL:
        return SideKind.RUN
    if path.suffix == SUFFIX:
        return SideKind.VERSION
    if found := _BEHAVIOUR.fullmatch(word.strip()):
        name = found[1]
        behaviours = [row.name for row in BUILTINS.values() if row.kind is Kind.BEHAVIOUR]
        if name in behaviours or found[2] is not None:
            return SideKind.BEHAVIOUR
        if near := nearest(name, behaviours):
            raise ArgumentError(f"`{word}` names no driver, file or run", f"did you mean `{near}`?")
    cure = f"name {FORMS}, a behavior such as `GivingWayBehavior(10 m/s)`, a file, or the folder of a search"
    raise ArgumentError(f"`{word}` names no driver, file or run", cure)


def check_sides(a: Side, b: Side, *, has_files: bool) -> None:
    """Check that two sides belong together.

    Raises:
        NotComparableError: they do not.
    """
    if (a.kind in ON_FILES) != (b.kind in ON_FILES) or (a.kind not in ON_FILES and a.kind is not b.kind):
        message = f"`{a.word}` is a {a.kind}, and `{b.word}` is a {b.kind}"
        raise NotComparableError(message, "compare two drivers on files, two versions of a file, or two runs")
    if a.kind in ON_FILES and not has_files:
        raise NotComparableError("no files given", "name files or folders in which both drive")
    if a.kind not in ON_FILES and has_files:
        raise NotComparableError(f"`{a.word}` is a {a.kind}, which needs no further files", "leave the others out")


# -- a side on a file --------------------------------------------------------------------------------------------------


def contender(side: Side, path: Path) -> Contender:
    """Return a driver, a behavior or a version on a file; the path of a version is its own.

    Raises:
        CompileError: the file has errors.
        ControllerError: the driver does not fit the file, or none is named.
        NotComparableError: no actor of the file is driven from outside, or the behavior does not fit.
        UnreadableFileError: the file cannot be read.
    """
    scenario = load(path)
    if side.kind is not SideKind.VERSION and not scenario.program.controls:
        message = f"no actor in {path} has `{EXTERNAL}`, so that no driver can be compared on it"
        raise NotComparableError(message, f"give the ego `with behavior {EXTERNAL}(trajectory=…)`")
    if side.kind is SideKind.BEHAVIOUR:
        return Contender(_with_behaviour(scenario, side.word), None, ())
    return _driven(scenario, side, (as_argument(path),))


def _driven(scenario: Scenario, side: Side, command: tuple[str, ...]) -> Contender:
    """Return a scenario with the driver of a side.

    Raises:
        ControllerError: the file has controllers, and no driver is named, or it does not fit.
    """
    program = scenario.program
    if program.controls and side.driver is None:
        names = ", ".join(f"`{control.controller}`" for control in program.controls)
        raise ControllerError(f"nobody drives for {names} in {side.word}", "name drivers with --ego-a and --ego-b")
    driver = fitting_driver(program, side.driver)
    unused = side.driver is not None and driver is None
    remarks = (f"{side.word} has no controller, so that its driver has no effect",) if unused else ()
    words = (*command, *(side.driver_words if driver is not None else ()))
    unobserved = () if driver is None else tuple(_unobserved(scenario, driver))
    return Contender(scenario, driver, words, remarks, unobserved)


def _unobserved(scenario: Scenario, driver: Driver) -> Iterator[str]:
    """Yield features of a scenario that a driver with the egocentric observation does not observe."""
    program = scenario.program
    if observed(program, driver.observe == RECORDS) is not EGOCENTRIC:
        return
    if any(variant.lights is not None for variant in scenario.compiled.scenario.variants):
        yield "traffic lights"
    if (others := len(program.actors) - 1) > NEAREST:
        yield f"{others - NEAREST} of {others} other actors: the {NEAREST} nearest are observed"


def _with_behaviour(scenario: Scenario, word: str) -> Scenario:
    """Return a scenario whose ego has a behavior in the place of `ExternalBehavior`.

    Raises:
        NotComparableError: the place is not in the file, another actor is driven from outside, or the text with the
            behavior does not compile.
    """
    compiled, name = scenario.compiled, scenario.compiled.source.name
    call = _external_call(compiled)
    text = compiled.source.text
    behaviour = _with_arguments(word.strip(), call, text)
    whole = text[: call.span.start] + behaviour + text[call.span.end :]
    try:
        found = compile_text(whole, name, folder=Path(name).parent)
    except CompileError as error:
        message = f"`{behaviour}` cannot drive in {name}: {_placed(error, behaviour, call.span.start)}"
        cure = error.cure or f"write it as it would be in the place of `{EXTERNAL}`"
        raise NotComparableError(message, cure) from error
    if found.program.controls:
        others = ", ".join(f"`{control.controller}`" for control in found.program.controls)
        message = f"{others} in {name} would have no driver"
        raise NotComparableError(message, "compare drivers from outside, one for each controller")
    return found


def _placed(error: CompileError, behaviour: str, start: int) -> str:
    """Return the first error with its place in the text of a behavior, which begins at `start` of the whole, or in the
    file.
    """
    first = next(each for each in error.diagnostics if each.severity is Severity.ERROR)
    span = first.label.span
    place = span.start - start
    if 0 <= place <= len(behaviour):
        word = behaviour[place : max(place + 1, min(span.end - start, len(behaviour)))].split("\n")[0].strip()
        return f"character {place + 1}{f' (`{word}`)' if word else ''}: {error.message}"
    return f"line {error.source.position(span.start).line} of the file: {error.message}"


def _external_call(compiled: pipeline.Compiled) -> nodes.Call:
    """Return the call of `ExternalBehavior` that drives the ego: the only one of the file, or that of the ego's object.

    Raises:
        NotComparableError: there is none in the file itself.
    """
    calls = [node for node in everything_in(compiled.module) if isinstance(node, nodes.Call) and _is_external(node)]
    if len(calls) != 1:
        own = [
            each.span for each in compiled.module.statements if isinstance(each, nodes.Assign) and "ego" in each.targets
        ]
        calls = [call for call in calls if any(_holds(span, call.span) for span in own)]
    if len(calls) == 1:
        return calls[0]
    message = f"the `{EXTERNAL}` of the ego is not in {compiled.source.name} itself"
    raise NotComparableError(message, f"give it to the ego there: `ego = new Car …, with behavior {EXTERNAL}(…)`")


def _is_external(call: nodes.Call) -> bool:
    return isinstance(call.function, nodes.Name) and call.function.id == EXTERNAL


def _holds(outer: Span, inner: Span) -> bool:
    return outer.start <= inner.start and inner.end <= outer.end


def _with_arguments(word: str, call: nodes.Call, text: str) -> str:
    """Return a behavior as a call: a bare name takes the trajectory of the external behavior, or wraps a driver that
    follows it.
    """
    row = BUILTINS.get(word)
    if row is None:
        return word
    given = next((each.value.span for each in call.arguments if each.name == "trajectory"), None)
    trajectory = "" if given is None else f"trajectory={text[given.start : given.end]}"
    names = [parameter.name for parameter in row.parameters]
    if "behavior" in names:
        inner = f"FollowTrajectoryBehavior({trajectory})" if trajectory else "FollowLaneBehavior()"
        return f"{word}({inner})"
    return f"{word}({trajectory if 'trajectory' in names else ''})"


# -- two programs ------------------------------------------------------------------------------------------------------


def check_spaces(a: Program, b: Program) -> None:
    """Check that two programs have the same params with the same ranges.

    Raises:
        NotComparableError: they do not; the message has every difference.
    """
    found = list(_differences(a.space, b.space))
    if found:
        cure = "compare versions of a file that have the same params and ranges"
        raise NotComparableError(f"{a.name} and {b.name} have different params: {'; '.join(found)}", cure)


def _differences(a: ParamSpace, b: ParamSpace) -> Iterator[str]:
    for name in dict.fromkeys((*a.names, *b.names)):
        if (name in a.names) != (name in b.names):
            yield f"`{name}` is in {'A' if name in a.names else 'B'} only"
        elif (one := _gene_text(a, name)) != (other := _gene_text(b, name)):
            yield f"`{name}` is {one} in A, {other} in B"
    if set(a.names) == set(b.names) and a.names != b.names:
        yield f"their order is {', '.join(a.names)} in A, {', '.join(b.names)} in B"


def _gene_text(space: ParamSpace, name: str) -> str:
    gene = space.names.index(name)
    unit = space.units[gene]
    if space.options[gene]:
        weights = f" with weights {', '.join(f'{w:g}' for w in space.weights[gene])}" if space.weights[gene] else ""
        return f"one of {', '.join(space.options[gene])}{weights}"
    kind = Distribution(space.distribution[gene])
    shape = (
        "" if kind is Distribution.UNIFORM else f" {kind.name.lower()} {' '.join(f'{x:g}' for x in space.shape[gene])}"
    )
    return f"{space.low[gene]:g} to {space.high[gene]:g} {unit}".rstrip() + shape


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SearchedSide:
    """The folder of a search, and its failing scenes."""

    run: OpenedRun
    contender: Contender


def searched_side(side: Side) -> SearchedSide:
    """Return the folder of a search as a side.

    Raises:
        StoreError: there is no readable journal.
        ControllerError: a controller drove, and no driver is named, or it does not fit.
    """
    run = open_run(Path(side.word))
    scenario = replace(run.scenario, config=replace(run.scenario.config, driver=None))
    return SearchedSide(run, _driven(scenario, side, ()))


def failing_scenes(run: OpenedRun) -> tuple[np.ndarray, np.ndarray]:
    """Return genomes (n, d) and stream keys (n, 6) of the runs of a search that collided or broke an `expect`, each
    once, the riskiest first.
    """
    evaluations = run.record.evaluations
    rollouts = evaluations.rollouts
    broken = (rollouts.broken == 1.0).any(axis=-1) if rollouts.broken.shape[-1] else np.zeros_like(rollouts.collided)
    failed = (
        (rollouts.collided | broken | rollouts.found) & evaluations.simulated[:, np.newaxis] & (rollouts.verdict == 0)
    )
    rows, places = np.nonzero(failed)
    order = np.argsort(-np.nan_to_num(rollouts.continuous[rows, places], nan=-1.0), kind="stable")
    rows, places = rows[order], places[order]
    return evaluations.genomes[rows], evaluations.keys[rows, places]
