"""Values that a notebook shows richly: the engine's types with the names that they need for it, and compile errors.

The engine knows no HTML. What a `Scenario` hands out is therefore of a subclass that also knows the program; it is
used, compared and saved like the engine's own type. `cortex_dsl.report.page.notebook` makes the HTML, when it is asked.
"""

from html import escape
from typing import Any, TypeVar

from cortex_dsl import diagnostics
from cortex_dsl.report.findings.snippet import errors_first, render_text
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes

Value = TypeVar("Value")


class _Displayed:
    """What was handed out by a scenario; a part that is taken out of it no longer knows the names."""

    _program: Program | None = None

    def _html(self, program: Program) -> str:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>" if self._program is None else self._html(self._program)


class ShownScenes(_Displayed, Scenes):
    """Scenes whose params have names."""

    def _html(self, program: Program) -> str:
        from cortex_dsl.report.page.notebook import scenes_html

        return scenes_html(program, self)


class ShownOutcomes(_Displayed, Outcomes):
    """Outcomes whose actors have names."""

    def _html(self, program: Program) -> str:
        from cortex_dsl.report.page.notebook import outcomes_html

        return outcomes_html(program, self)


def shown_scenes(program: Program, scenes: Scenes) -> Scenes:
    """The same scenes with a display."""
    return _with(ShownScenes, program, scenes)


def shown_outcomes(program: Program, outcomes: Outcomes) -> Outcomes:
    """The same outcomes with a display."""
    return _with(ShownOutcomes, program, outcomes)


def shown_run(program: Program, run: Any) -> Any:
    """The same run of the pymunk world with a display."""
    from engine.world import WorldRun

    class ShownRun(_Displayed, WorldRun):
        """A run whose actors have names."""

        def _html(self, program: Program) -> str:
            from cortex_dsl.report.page.notebook import world_run_html

            return world_run_html(program, self)

    return _with(ShownRun, program, run)


def _with(kind: type[Value], program: Program, value: Any) -> Value:
    """All fields of a frozen value, and its program, in an object of a subclass."""
    made = kind.__new__(kind)
    made.__dict__.update(vars(value), _program=program)
    return made


class Columns(dict[str, Any]):
    """Arrays by name, as `pandas.DataFrame` takes them."""

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page.notebook import columns_html

        return columns_html(self)


class CompileError(diagnostics.CompileError):
    """Every mistake of a file, as text with its source line and a caret under the place; errors before all else."""

    def __str__(self) -> str:
        return f"\n{render_text(self.source, errors_first(self.diagnostics))}".rstrip()

    def _repr_html_(self) -> str:
        from cortex_dsl.report.page.notebook import diagnostics_html

        return diagnostics_html(self.source, self.diagnostics)

    def _render_traceback_(self) -> list[str]:
        """What IPython prints instead of a traceback: the mistakes, for the frames are ours and not the file's."""
        return render_text(self.source, errors_first(self.diagnostics)).splitlines()
