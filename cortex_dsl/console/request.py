"""The request of a command line, in parts that its options make, and the types of their values."""

import math
import re
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Mapping
from dataclasses import field
from enum import Enum
from pathlib import Path
from typing import TypeVar

from engine.config import DEFAULT_REFERENCES
from engine.driving.names import Egos
from engine.frozen import frozen
from engine.vocabulary import RECORDS


class Mode(Enum):
    """Task of `cortexc FILE`."""

    RUN = "run"
    SEARCH = "search"
    SAMPLE = "sample"
    CHECK = "check"
    EMIT = "emit"


OF_SYSTEM = ("*",)
"""Value of `freeze`: params that the file calls the system's, if it names any."""


@frozen
class CompileRequest:
    """File to compile, fixed params, and the form of the diagnostics."""

    file: Path
    overrides: Mapping[str, str] = field(default_factory=dict)
    """The `-p NAME=VALUE` pairs; values are read by the rules of the language."""
    freeze: tuple[str, ...] | None = None
    """Params to hold fixed; (): those that the file calls the system's; `OF_SYSTEM`: the same, or none."""
    scenario: str | None = None
    """Which of several scenarios to run; None: the file's own choice."""
    json: bool = False
    metrics: bool = False
    """Whether every measure, param and ending is shown."""
    paper: bool = False
    """Whether the figures of the paper are shown."""
    diagnostics_format: str = "text"
    hints: bool = False
    """Whether hints are shown: they belong to `--check`, not to every run."""


@frozen
class RunRequest:
    """How scenes are drawn and simulated. An option that was not given is None, so that the file may decide."""

    seed: int | None = None
    """Seed; None: the seed of a concrete file, else 0."""
    engine: str | None = None
    max_attempts: int | None = None
    time_step: float | None = None
    profile: str = "paper"
    prune: bool = False
    jobs: int = 1
    ego: Egos | None = None
    """Driver for the controllers of the file."""
    ego_batch: int = 256
    """Number of scenes in one query to the driver."""
    ego_observes: str = RECORDS
    """Observation of the driver (`engine.vocabulary.OBSERVABLE`)."""
    target: float | None = None
    """Acceptance that `--sample` shall reach by relaxing a requirement."""
    references: tuple[str, ...] = DEFAULT_REFERENCES
    """Names of the reference drivers that judge each collision."""


@frozen
class SearchRequest:
    """Methods, effort and output folder of a search."""

    methods: tuple[str, ...] = ()
    """Names of `engine.search.searchers`, each once."""
    generations: int = 30
    population: int = 100
    preset: str = "cortex"
    rollouts: int = 1
    aggregate: str = "mean"
    objective: tuple[str, ...] = ("risk",)
    """Objectives of the search."""
    dask: str | None = None
    """Address of a scheduler, or `local`."""
    out: Path | None = None
    tables: bool = False
    """Whether the text tables are written for a search of any size."""
    command_line: tuple[str, ...] = ()
    """Command line without the program's name; stored in the manifest of a search."""


@frozen
class Request:
    """One `cortexc FILE ...`: its task, and the parts of the command line; each mode gets the parts that it reads."""

    mode: Mode
    compile: CompileRequest
    run: RunRequest = field(default_factory=RunRequest)
    search: SearchRequest = field(default_factory=SearchRequest)
    samples: int = 0
    """Number of scenes for `--sample`."""
    stage: str = ""
    """Stage that `--emit` prints."""


Part = TypeVar("Part")


def filled(part: type[Part], options: Namespace) -> Part:
    """Return a part of a request from the options of the same names; an option that is None leaves the default."""
    given = {name: getattr(options, name, None) for name in part.__dataclass_fields__}  # type: ignore[attr-defined]
    return part(**{name: value for name, value in given.items() if value is not None})


# -- types of arguments: each takes the text and returns a value, or an error with the right form ----------------------

SEED_LIMIT = 2**63 - 1
"""Seeds are part of a stream's key, which holds signed 64-bit integers."""
GENERATION_LIMIT = 2**16 - 1
"""Generations have sixteen bits of a stream's address."""


def whole_number(minimum: int, maximum: int, why: str = "") -> Callable[[str], int]:
    """Return a parser of whole numbers within inclusive bounds; `why` explains the lower one."""

    def parse(text: str) -> int:
        value = _int(text)
        if value is None:
            raise ArgumentTypeError(f"must be a whole number, not `{text}`")
        if value < minimum:
            reason = f" ({why})" if why else ""
            raise ArgumentTypeError(f"must be at least {minimum}{reason}, not {text}")
        if value > maximum:
            raise ArgumentTypeError(f"must be at most {maximum:,}, not {text}")
        return value

    return parse


def seconds(minimum: float, maximum: float) -> Callable[[str], float]:
    """A finite duration within inclusive bounds; a trailing `s` is understood."""

    def parse(text: str) -> float:
        try:
            value = float(text.removesuffix("s"))
        except ValueError:
            raise ArgumentTypeError(f"must be a number of seconds, not `{text}`") from None
        if not math.isfinite(value) or not minimum <= value <= maximum:
            raise ArgumentTypeError(f"must lie between {minimum:g} and {maximum:g} seconds, not {text}")
        return value

    return parse


def share(text: str) -> float:
    """A share of a whole above 0: `50%`, `50 %` or `0.5`."""
    number = text.strip().removesuffix("%")
    try:
        value = float(number) * (0.01 if number != text.strip() else 1.0)
    except ValueError:
        raise ArgumentTypeError(f"must be a share such as `50%`, not `{text}`") from None
    if not 0.0 < value <= 1.0:
        raise ArgumentTypeError(f"must be above 0% and at most 100%, not {text}")
    return value


def aggregate(text: str) -> str:
    """`mean`, `max` or a quantile `q01` .. `q99`."""
    if text in ("mean", "max") or re.fullmatch(r"q(0[1-9]|[1-9][0-9]?)", text):
        return text
    raise ArgumentTypeError(f"must be `mean`, `max` or a quantile such as `q90`, not `{text}`")


def reference_names(text: str) -> tuple[str, ...]:
    """`NAME,NAME`: names of reference drivers, in the order of their table."""
    from engine.errors import ArgumentError
    from engine.references import references

    try:
        return tuple(each.name for each in references([word.strip() for word in text.split(",") if word.strip()]))
    except ArgumentError as error:
        raise ArgumentTypeError(f"{error.message}; {error.cure}") from error


def assignment(text: str) -> tuple[str, str]:
    """`NAME=VALUE`; the value is read later, by the rules of the language."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not value:
        raise ArgumentTypeError(f"must be NAME=VALUE, such as `EGO_SPEED=50 km/h`, not `{text}`")
    if not name.isidentifier():
        raise ArgumentTypeError(f"`{name}` cannot be the name of a param")
    return name, value


def param_names(text: str) -> tuple[str, ...]:
    """`NAME,NAME`; nothing at all is fine, too."""
    words = tuple(word.strip() for word in text.split(",") if word.strip())
    for word in words:
        if not word.isidentifier():
            raise ArgumentTypeError(f"`{word}` cannot be the name of a param")
    return words


def _int(text: str) -> int | None:
    """The text as a whole number written in plain digits (`1_000` and `1e3` are not)."""
    return int(text) if re.fullmatch(r"[+-]?[0-9]{1,30}", text.strip()) else None
