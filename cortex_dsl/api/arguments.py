"""Check the arguments of a Python call, and read the params that a command fixes.

The error of a wrong argument has its name, the expected and the given value, and the cure.
"""

import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, cast, get_args

import numpy as np

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.spelling import nearest
from engine.config import Config, GAConfig, SearchConfig
from engine.errors import LEFT_OUT, ArgumentError, ArgumentKindError, kind, whole
from engine.errors import path_of as path_of
from engine.errors import row_of as row_of
from engine.program import Program
from engine.references import references

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.scenes import Scenes
    from engine.search.campaign import OnGeneration
    from engine.search.workers import Workers
    from engine.study.execution import OnRun
    from engine.tables import Floats, Ints

COUNTS = tuple(field.name for field in fields(SearchConfig) if field.type in (int, "int"))
WORDS = tuple(field.name for field in fields(SearchConfig) if field.type in (str, "str"))
"""Settings of a search that are whole numbers, and those that are words."""
OPTION, KEYWORD = "-p", "<keyword>"
"""The name, in messages, of the text of a fixed param: from the command line, and from Python."""


def several(name: str, things: object) -> list[Any]:
    """Return the items of a list, or of anything else to go through; of anything that is not, ArgumentKindError."""
    if not isinstance(things, Iterable):
        raise ArgumentKindError(
            f"{name}: expected one name, or several in a list, got {type(things).__name__}", "name one, or several"
        )
    return list(cast("Iterable[Any]", things))


def callback(name: str, value: object) -> None:
    """Raise ArgumentKindError if a callback is no function."""
    if value is not None and not callable(value):
        raise ArgumentKindError(f"{name}: expected a function, got {type(value).__name__}", LEFT_OUT)


def objectives_of(program: "Program", given: object) -> tuple[Any, ...]:
    """Return one or several objectives after checking that each exists.

    Raises:
        ArgumentError, ArgumentKindError: an unknown name, nothing, or neither a name nor a function.
    """
    from engine.search.objectives import objectives

    several: tuple[Any, ...] = tuple(cast("Sequence[Any]", given)) if isinstance(given, list | tuple) else (given,)
    if not several:
        raise ArgumentError("objective: expected one or more, got none", LEFT_OUT)
    for each in several:
        if not (isinstance(each, str) or callable(each)):
            raise ArgumentKindError(f"objective: expected a name or a function, got {each!r}", "name one, as in `risk`")
    objectives(program, several)
    return several


def one_of(name: str, value: object, choices: Iterable[str]) -> str:
    """Return the value if it is one of `choices`.

    Raises:
        ArgumentError: it is another word, or no text.
    """
    known = list(choices)
    if not isinstance(value, str) or value not in known:
        near = nearest(value, known) if isinstance(value, str) else None
        given = f"`{value}`" if isinstance(value, str) else repr(value)
        cure = f"did you mean `{near}`?" if near else LEFT_OUT
        wanted = " or ".join(known) if len(known) == 2 else f"one of {', '.join(known)}"
        raise ArgumentError(f"{name}: expected {wanted}, got {given}", cure)
    return value


def config_of(config: object) -> Config:
    """Return a config, after checking the type of every setting in it: a dataclass takes whatever it is given.

    Raises:
        ArgumentKindError: it is no config, or a setting is of another type.
    """
    kind("config", config, Config, LEFT_OUT)
    assert isinstance(config, Config)
    for part in (part for part in fields(Config) if part.name != "driver"):
        group = getattr(config, part.name)
        expected = part.default_factory
        assert isinstance(expected, type)
        kind(f"config.{part.name}", group, expected, LEFT_OUT)
        for setting in fields(expected):
            name, usual = f"config.{part.name}.{setting.name}", setting.default
            value = getattr(group, setting.name)
            if isinstance(usual, bool | str):
                kind(name, value, type(usual), LEFT_OUT)
            elif isinstance(usual, int):
                whole(name, value, 0)
            elif setting.name == "references":
                kind(name, value, tuple, LEFT_OUT)
                references(value)
            else:
                _number(name, value)
    return config


def _number(name: str, value: object) -> None:
    """Raises ArgumentKindError where a value is no number, ArgumentError where it is not finite."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise ArgumentKindError(f"{name}: expected a number, got {value!r}", LEFT_OUT)
    if not np.isfinite(value):
        raise ArgumentError(f"{name}: expected a finite number, got {value!r}", LEFT_OUT)


# -- keywords that a function passes on --------------------------------------------------------------------------------

PROFILE, PRESET = "paper", GAConfig().preset
"""Default set of risk bands, and default preset of the genetic algorithm."""


class BudgetSettings(TypedDict, total=False):
    """Fields of `engine.config.SearchConfig`; those that are left out are as in the config of the scenario."""

    generations: int
    population: int
    seed: int
    rollouts: int
    aggregate: str
    engine: str
    run: int
    probes: int
    references: tuple[str, ...]


class SearchSettings(BudgetSettings, total=False):
    """Keywords of a search."""

    jobs: int
    profile: str
    preset: str
    on_generation: "OnGeneration | None"
    workers: "Workers | None"
    tables: bool


class StudySettings(BudgetSettings, total=False):
    """Keywords of a study."""

    jobs: int
    profile: str
    preset: str
    on_run: "OnRun | None"


class WritingSettings(TypedDict, total=False):
    """Keywords of an export: options of single formats, and `force`."""

    osc: str | None
    mode: str | None
    player: str | None
    after_contact: str | None
    force: bool


Function = TypeVar("Function", bound=Callable[..., Any])


def with_keywords(function: Function) -> Function:
    """Show each keyword of `**settings: Unpack[...]` in `help` and in the completions of notebooks, with its default.

    Editors that check types show them without this.
    """
    signature = inspect.signature(function)
    *named, rest = signature.parameters.values()
    (settings,) = get_args(rest.annotation)
    defaults: dict[str, Any] = {each.name: each.default for each in fields(SearchConfig)}
    defaults |= {"profile": PROFILE, "preset": PRESET, "force": False, "tables": False}
    keywords = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=defaults.get(name), annotation=annotation)
        for name, annotation in settings.__annotations__.items()
    ]
    function.__signature__ = signature.replace(parameters=[*named, *keywords])  # type: ignore[attr-defined]
    return function


def check_keywords(of: str, settings: type, given: Mapping[str, object]) -> None:
    """Check the keywords that a function takes by `**`, and the numbers and words among them.

    Raises:
        ArgumentKindError: there is no such keyword, or its value is of another type.
        ArgumentError: a number is too low.
    """
    known = list(settings.__annotations__)
    for name, value in given.items():
        if name not in known:
            near = nearest(name, known)
            meant = f"did you mean `{near}`?" if near else f"there are {', '.join(known)}"
            raise ArgumentKindError(f"{of} has no setting `{name}`", meant)
        if name in COUNTS:
            whole(name, value, 0 if name in ("seed", "run", "probes") else 1)
        elif name in WORDS:
            kind(name, value, str, LEFT_OUT)
        elif name == "references":
            kind(name, value, tuple, LEFT_OUT)
            references(cast("tuple[str, ...]", value))
        elif name.startswith("on_"):
            callback(name, value)


def genome_of(program: Program, genome: "ArrayLike") -> "Floats":
    """Return the genome as an array (d,), a value for each param.

    Raises:
        ArgumentKindError: the values are no numbers.
        ArgumentError: it has another length.
    """
    names = program.space.names
    try:
        values = np.asarray(genome, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentKindError(
            f"genome: expected numbers, {error}", f"give one for each of {', '.join(names)}"
        ) from error
    if values.shape != (len(names),):
        raise ArgumentError(
            f"genome: expected a value for each of {', '.join(names)}, got shape {values.shape}",
            "name the others' values too, or fix params when the file is loaded",
        )
    return values


def key_of(key: "ArrayLike") -> "Ints":
    """Return the stream key as an array (6,).

    Raises:
        ArgumentKindError: the values are no whole numbers.
        ArgumentError: it has another shape.
    """
    from engine.streams import StreamKey

    try:
        keys = np.asarray(key, dtype=np.int64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentKindError(
            f"key: expected whole numbers, {error}", "take a row of `keys` of some scenes"
        ) from error
    if keys.shape != (len(StreamKey._fields),):
        raise ArgumentError(
            f"key: expected {', '.join(StreamKey._fields)}, got shape {keys.shape}",
            "take a row of `keys` of some scenes, or `key` of a case",
        )
    return keys


def scenes_of(program: Program, scenes: object) -> "Scenes":
    """Return the scenes, after checking that they fit this program.

    Raises:
        ArgumentKindError, ArgumentError: the value holds no scenes, or those of another program.
    """
    from engine.scenes import Scenes

    kind("scenes", scenes, Scenes, "`sample` draws some, `scene` is that of a case")
    assert isinstance(scenes, Scenes)
    widths = len(program.space), program.code.output_register.shape[1]
    if (scenes.genomes.shape[1], scenes.values.shape[1]) != widths:
        raise ArgumentError(
            "scenes: these are of another scenario, or of this one with other params fixed",
            "draw them from this one: `sample` draws some",
        )
    return scenes


@contextmanager
def drawn_errors() -> Iterator[None]:
    """Draw a CompileError as the command does, errors first, in the words of Python instead of `-p`."""
    try:
        yield
    except CompileError as error:
        from cortex_dsl.report.findings.snippet import render_text

        source = replace(error.source, name=KEYWORD) if error.source.name == OPTION else error.source
        diagnostics = in_python(error.diagnostics)
        first = sorted(diagnostics, key=lambda each: each.severity is not Severity.ERROR)
        drawn = "\n" + render_text(source, first).rstrip()
        raise CompileError(source, diagnostics, drawn) from None


def in_python(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics in the words of Python: a param is fixed by a keyword, not by `-p`."""
    return tuple(
        replace(each, message=_words(each.message), reason=_words(each.reason), cure=_words(each.cure))
        for each in diagnostics
    )


def _words(text: str) -> str:
    text = re.sub(r'`-p "(\w+)=([^"`]+)"`', r'`\1="\2"`', text)
    return re.sub(r"`-p (\w+)", r"`\1", text).replace("`-p`", "a keyword")
