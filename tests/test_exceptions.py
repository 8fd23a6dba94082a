"""Every exception of ours says what is wrong and how to mend it, or never leaves the house."""

import pickle
import pkgutil
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

import pytest

import cortex_dsl
import engine
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from engine.errors import CortexError, HiddenEngineError, InterchangeError, Signal, UnreadableFileError
from engine.extras import MissingExtraError
from engine.road.specification import RoadError
from engine.search.past import ForeignPastError
from engine.search.searchers import PluginError, UnknownMethodError
from engine.search.store import RemovedError


def classes() -> Iterator[type[BaseException]]:
    """All exceptions that our modules define."""
    for package in (cortex_dsl, engine):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                for thing in vars(import_module(module.name)).values():
                    if isinstance(thing, type) and issubclass(thing, BaseException) and thing.__module__ == module.name:
                        yield thing


ALL = sorted(set(classes()), key=lambda kind: kind.__qualname__)
FOR_USERS = [kind for kind in ALL if issubclass(kind, CortexError)]


def compile_error() -> CompileError:
    """Of a text with a mistake."""
    with pytest.raises(CompileError) as caught:
        parse(Source("a.scn", "ego = new Car at (0, 0\n"))
    return caught.value


MADE: dict[type[CortexError], Callable[[], CortexError]] = {
    CompileError: compile_error,
    ForeignPastError: lambda: ForeignPastError(3),
    HiddenEngineError: lambda: HiddenEngineError(Path("here/engine"), "at there/engine"),
    InterchangeError: lambda: InterchangeError("what", "how", "case.xosc, line 12"),
    MissingExtraError: lambda: MissingExtraError("figures need", "matplotlib", "report"),
    PluginError: lambda: PluginError("mine", "fails"),
    RemovedError: lambda: RemovedError(Path("runs/mine")),
    RoadError: lambda: RoadError("what", "lanes", "how"),
    UnknownMethodError: lambda: UnknownMethodError("gaa"),
    UnreadableFileError: lambda: UnreadableFileError("a.scn", FileNotFoundError(2, "No such file or directory")),
}
"""Those that are not made of a message and a cure alone."""


def test_they_are_found() -> None:
    """The walk sees those of both packages."""
    assert {CompileError, RemovedError, CortexError, Signal} <= set(ALL)
    assert len(ALL) > 20


@pytest.mark.parametrize("kind", ALL)
def test_each_is_for_users_or_stays_inside(kind: type[BaseException]) -> None:
    """Nothing in between: a user can catch all that concerns him by one name."""
    assert issubclass(kind, CortexError) != issubclass(kind, Signal)


@pytest.mark.parametrize("kind", FOR_USERS)
def test_those_for_users_are_called_errors(kind: type[BaseException]) -> None:
    """As Python's own are."""
    assert kind.__name__.endswith("Error")


@pytest.mark.parametrize("kind", FOR_USERS)
def test_each_keeps_message_and_cure(kind: type[CortexError]) -> None:
    """As attributes and as text, and through pickle, as a worker of another process sends it."""
    error = MADE[kind]() if kind in MADE else kind("what is wrong", "what to do")
    assert error.message
    assert error.cure
    assert error.message in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind
    assert (again.message, again.cure, str(again)) == (error.message, error.cure, str(error))
    assert set(vars(again)) == set(vars(error))


def test_what_was_noted_travels_too() -> None:
    """PEP 678."""
    error = CortexError("what", "how")
    error.add_note("while it rained")
    assert pickle.loads(pickle.dumps(error)).__notes__ == ["while it rained"]


def test_without_a_cure_nothing_hangs_at_the_end() -> None:
    """The text is the message alone."""
    assert str(CortexError("what")) == "what"
