"""Values that a notebook shows richly: the engine's types with the names that they need for it, and compile errors.

The engine knows no HTML. What a `Scenario` hands out is therefore of a subclass of the engine's type, which also knows
the program; it is used, taken apart and pickled like the engine's own. `cortex_dsl.report.page.notebook` makes the HTML
when somebody looks.
"""

from functools import cache
from html import escape
from typing import Any, TypeVar

from cortex_dsl import diagnostics
from cortex_dsl.report.findings.snippet import errors_first, render_text
from engine.program import Program

Value = TypeVar("Value")

MAKERS = {
    "Scenes": "scenes_html",
    "Outcomes": "outcomes_html",
    "WorldRun": "world_run_html",
    "Campaign": "campaign_html",
}
"""By the engine's type, the function of `cortex_dsl.report.page.notebook` that shows it."""


def displayed(program: Program, value: Value) -> Value:
    """The same value of the engine with a rich display in notebooks."""
    made: Any = object.__new__(_kind(type(value)))
    made.__dict__.update(vars(value), _program=program)
    return made


class _Displayed:
    """What a scenario handed out. A part that is taken out of it does not know the names, and shows itself in words."""

    _program: Program | None = None

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page import notebook

        if self._program is None:
            return f"<pre>{escape(repr(self))}</pre>"
        return getattr(notebook, MAKERS[type(self).__name__])(self._program, self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as the engine's own type and the program, for the subclass has no place of its own."""
        fields = {name: value for name, value in vars(self).items() if name != "_program"}
        return _restored, (type(self).__mro__[2], fields, self._program)


@cache
def _kind(base: type[Any]) -> type[Any]:
    """The displayed form of a type of the engine."""
    if issubclass(base, _Displayed):
        return base
    return type(base.__name__, (_Displayed, base), {"__module__": base.__module__, "__doc__": base.__doc__})


def _restored(base: type[Any], fields: dict[str, Any], program: Program | None) -> Any:
    value = object.__new__(base)
    value.__dict__.update(fields)
    return value if program is None else displayed(program, value)


class Columns(dict[str, Any]):
    """Arrays by name, as `pandas.DataFrame` takes them."""

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page.notebook import columns_html

        return columns_html(self)


class CompileError(diagnostics.CompileError):
    """Every mistake of a file as text, with its source line and a caret under the place; errors before all else."""

    def __str__(self) -> str:
        return f"\n{self._text()}".rstrip()

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page.notebook import diagnostics_html

        return diagnostics_html(self.source, self.diagnostics)

    def _render_traceback_(self) -> list[str]:
        """What IPython prints instead of a traceback: the mistakes alone, for its frames are ours, not the file's."""
        return self._text().splitlines()

    def _text(self) -> str:
        return render_text(self.source, errors_first(self.diagnostics))
