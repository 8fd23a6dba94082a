"""Check the arguments of a Python call, and read the params that a command fixes.

The error of a wrong argument has its name, the expected and the given value, and the cure.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.semantics.names.linking import override_text, param_entries
from cortex_dsl.spelling import nearest
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import UNIT_WORDS
from engine.config import Config, SearchConfig
from engine.errors import LEFT_OUT, ArgumentError, ArgumentKindError, RowError, whole
from engine.program import Program

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.scenes import Scenes
    from engine.tables import Floats, Ints

COUNTS = tuple(field.name for field in fields(SearchConfig) if field.type in (int, "int"))
OPTION, KEYWORD = "-p", "<keyword>"
"""The name, in messages, of the text of a fixed param: from the command line, and from Python."""


def row_of(things: Any, row: int) -> int:
    """Return the index of an existing row, counted from 0.

    Raises:
        RowError: there is no such row.
    """
    if not -len(things) <= whole("row", row, -len(things)) < len(things):
        rows = f"its rows are 0 to {len(things) - 1}" if len(things) else "it has none"
        raise RowError(f"row: there is no {row} in {things!r}", rows)
    return range(len(things))[row]


def kind(name: str, value: object, expected: type | tuple[type, ...], cure: str) -> None:
    """Raise ArgumentKindError if a value is of another type than expected."""
    if not isinstance(value, expected):
        kinds = expected if isinstance(expected, tuple) else (expected,)
        wanted = " or ".join(each.__name__ for each in kinds)
        raise ArgumentKindError(f"{name}: expected {wanted}, got {type(value).__name__}", cure)


def several(name: str, things: object) -> list[Any]:
    """Return the items of a list, or of anything else to go through; of anything that is not, ArgumentKindError."""
    if not isinstance(things, Iterable):
        raise ArgumentKindError(
            f"{name}: expected one name, or several in a list, got {type(things).__name__}", "name one, or several"
        )
    return list(cast("Iterable[Any]", things))


def path_of(name: str, value: object, cure: str = "name it by its path") -> Path:
    """Return the value as a path, if a file can have it.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: no file can have this name.
    """
    kind(name, value, (str, Path), cure)
    if "\0" in str(value):
        raise ArgumentError(f"{name}: no file can be called {str(value)!r}", cure)
    return Path(str(value))


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
            else:
                _number(name, value)
    return config


def _number(name: str, value: object) -> None:
    """Raises ArgumentKindError where a value is no number, ArgumentError where it is not finite."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise ArgumentKindError(f"{name}: expected a number, got {value!r}", LEFT_OUT)
    if not np.isfinite(value):
        raise ArgumentError(f"{name}: expected a finite number, got {value!r}", LEFT_OUT)


def settings(given: Mapping[str, object]) -> None:
    """Raises ArgumentKindError where a search has no such setting, or a count is no number; ArgumentError where it is
    too low.
    """
    known = [field.name for field in fields(SearchConfig)]
    for name, value in given.items():
        if name not in known:
            near = nearest(name, known)
            meant = f"did you mean `{near}`?" if near else f"there are {', '.join(known)}"
            raise ArgumentKindError(f"a search has no setting `{name}`", meant)
        if name in COUNTS:
            whole(name, value, 0 if name in ("seed", "run", "probes") else 1)
        else:
            kind(name, value, str, LEFT_OUT)


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


# -- Params that the command line holds fixed, as the file would write them --------------------------------------------

AMOUNT = re.compile(r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?) *(?P<unit>\S*)")


@dataclass(frozen=True)
class FixedParam:
    """One param that is no gene in this run."""

    name: str
    value: float | str
    """Number in the file's own unit, or the text of the command line."""
    unit: str = ""

    @property
    def text(self) -> str:
        """The value without its unit."""
        return self.value if isinstance(self.value, str) else f"{self.value:.10g}"


def held_params(module: nodes.Module, overrides: Mapping[str, str]) -> tuple[FixedParam, ...]:
    """Return the params that `-p` and `--freeze` fix, in the order given."""
    entries = param_entries(module)
    return tuple(
        _held(name, override_text(entries[name], text) if name in entries else text) for name, text in overrides.items()
    )


def _held(name: str, text: str) -> FixedParam:
    amount = AMOUNT.fullmatch(text.strip())
    if amount is None or amount["unit"] not in ("", *UNIT_WORDS):
        return FixedParam(name, text)
    return FixedParam(name, float(amount["number"]), amount["unit"])
