"""What the tests of the semantics share: compile a text, and see what was said."""

from collections.abc import Callable, Mapping

import pytest

from cortex_dsl import ir
from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse

NO_OVERRIDES: Mapping[str, str] = {}
HEADER = "map intersection()\nlane = network.lanes[0]\n"
EGO = "ego = new Car in lane.centerline\n"


def findings(text: str, overrides: Mapping[str, str] = NO_OVERRIDES) -> tuple[Diagnostic, ...]:
    """Everything that is said about a text, whether it compiles or not."""
    source = Source("test.scn", text)
    try:
        return elaborate(parse(source), source, overrides)[1]
    except CompileError as error:
        return error.diagnostics


def scenario(text: str, overrides: Mapping[str, str] = NO_OVERRIDES) -> ir.Scenario:
    """The scenario of a text that compiles."""
    source = Source("test.scn", text)
    return elaborate(parse(source), source, overrides)[0]


@pytest.fixture
def compiled() -> Callable[..., ir.Scenario]:
    """Compile lines that follow a map, a `lane` and an `ego`."""
    return lambda text, overrides=NO_OVERRIDES: scenario(HEADER + EGO + text, overrides)


@pytest.fixture
def alone() -> Callable[..., ir.Scenario]:
    """Compile a whole file."""
    return scenario


@pytest.fixture
def said() -> Callable[..., list[str]]:
    """Codes of all findings about lines that follow a map, a `lane` and an `ego`."""
    return lambda text, overrides=NO_OVERRIDES: [d.code for d in findings(HEADER + EGO + text, overrides)]


@pytest.fixture
def answered() -> Callable[..., list[tuple[str, str]]]:
    """Codes and cures of all findings about lines that follow a map, a `lane`, an `ego` and what comes before."""
    return lambda text, before="": [(d.code, d.cure) for d in findings(HEADER + EGO + before + text)]
