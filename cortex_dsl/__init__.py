"""cortexc: a language, compiler, simulator and search laboratory for the corner cases of autonomous driving.

    >>> import cortex_dsl as cx
    >>> scenario = cx.load("examples/left_turn.scn")
    >>> campaign = cx.search(scenario, "ga", generations=30, population=100, out="runs/mine")
    >>> case = campaign.worst[0]
    >>> cx.export(cx.open_run("runs/mine"), ["xosc", "csv"], "elsewhere")

These are all names that a user needs; the modules behind them may move. Nothing is imported before it is used, and
nothing here prints. Each error is a `CortexError`, with its reason and its cure.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cortex_dsl.api.comparing import compare
    from cortex_dsl.api.coverage import coverage
    from cortex_dsl.api.opinions import verify
    from cortex_dsl.api.proofs import prove
    from cortex_dsl.api.resuming import resume
    from cortex_dsl.api.runs import open_run, search
    from cortex_dsl.api.scenario import Scenario, compile_text, load
    from cortex_dsl.api.studies import study
    from cortex_dsl.api.suites import run_suite
    from cortex_dsl.api.testing import run_tests
    from cortex_dsl.diagnostics import CompileError
    from cortex_dsl.interchange.exchange import export, measure, measure_all
    from engine.config import Config
    from engine.errors import CortexError
    from engine.search.probability.functions import probability

    __version__: str

__all__ = [
    "CompileError",
    "Config",
    "CortexError",
    "Scenario",
    "__version__",
    "compare",
    "compile_text",
    "coverage",
    "export",
    "load",
    "measure",
    "measure_all",
    "open_run",
    "probability",
    "prove",
    "resume",
    "run_suite",
    "run_tests",
    "search",
    "study",
    "verify",
]

_HOMES = {
    "CompileError": "cortex_dsl.diagnostics",
    "Config": "engine.config",
    "Scenario": "cortex_dsl.api.scenario",
    "compare": "cortex_dsl.api.comparing",
    "compile_text": "cortex_dsl.api.scenario",
    "coverage": "cortex_dsl.api.coverage",
    "export": "cortex_dsl.interchange.exchange",
    "load": "cortex_dsl.api.scenario",
    "measure": "cortex_dsl.interchange.exchange",
    "measure_all": "cortex_dsl.interchange.exchange",
    "open_run": "cortex_dsl.api.runs",
    "probability": "engine.search.probability.functions",
    "prove": "cortex_dsl.api.proofs",
    "resume": "cortex_dsl.api.resuming",
    "run_suite": "cortex_dsl.api.suites",
    "run_tests": "cortex_dsl.api.testing",
    "search": "cortex_dsl.api.runs",
    "study": "cortex_dsl.api.studies",
    "verify": "cortex_dsl.api.opinions",
}
"""The module of each name."""


def __getattr__(name: str) -> Any:
    """Import and return the object of a public name, at its first use.

    Raises:
        HiddenEngineError: another package called `engine` comes before ours.
    """
    if name == "__version__":
        return import_module("cortex_dsl.version").VERSION
    if name not in _HOMES and name != "CortexError":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from cortex_dsl.installation import check_engine, errors

    if name == "CortexError":
        return errors().CortexError  # caught even where nothing else can be had
    check_engine()
    thing = getattr(import_module(_HOMES[name]), name)
    globals()[name] = thing
    return thing


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
