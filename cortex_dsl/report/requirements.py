"""The table of every `require`: its line, how often it was tested, how often it held, and the first culprit."""

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import percent, whole
from cortex_dsl.report.sparkline import bar
from cortex_dsl.report.tally import Tally, first_culprit
from engine.program import Program

BAR = 12


def requirements_table(program: Program, tally: Tally, culprit: int | None) -> RenderableType:
    """Counts are conditional: a requirement is tested only where the earlier ones held."""
    rows = []
    for index, requirement in enumerate(program.requirements):
        tested, rate = int(tally.tested[index]), tally.pass_rate(index)
        style = "warn" if index == culprit else "" if tested else "quiet"
        rows.append(
            (
                Text(requirement.name, style),
                Text(program.place(requirement.line) if requirement.line else "–", "quiet"),
                Text(whole(tested), style),
                Text(whole(int(tally.failed[index])), style),
                Text(percent(rate), style),
                Text(bar(rate, 1.0, BAR), "warn" if index == culprit else "bar"),
            )
        )
    head = (left("requirement", wrap=True), right("line"), right("tested"), right("failed"), right("held"), left(""))
    return columns(*head, rows=rows, header=True)


def culprit_line(program: Program, tally: Tally, culprit: int | None) -> Text:
    """One sentence about the first culprit."""
    if culprit is None:
        return Text("every requirement always held", "quiet")
    requirement, rate = program.requirements[culprit], tally.pass_rate(culprit)
    where = f" (line {program.place(requirement.line)})" if requirement.line else " (built in)"
    often = "never held" if rate == 0.0 else f"held in {percent(rate)} of its tests"
    return Text.assemble("first culprit: ", (requirement.name, "warn"), where, f" {often}")


def requirements_view(program: Program, tally: Tally, culprit: int | None = None) -> RenderableType:
    """The table and its culprit, which the counts tell where nothing better is known."""
    culprit = first_culprit(program, tally) if culprit is None else culprit
    return Group(requirements_table(program, tally, culprit), Text(), culprit_line(program, tally, culprit))
