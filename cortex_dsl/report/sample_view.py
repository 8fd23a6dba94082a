"""What came of drawing many scenes: verdicts, attempts, and what each requirement rejected."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.blame_view import blame_view
from cortex_dsl.report.layout import columns, left, right, section
from cortex_dsl.report.numbers import counted, percent, ratio, whole
from cortex_dsl.report.requirements import requirements_view
from cortex_dsl.report.sparkline import bar
from cortex_dsl.report.tally import Tally, blame_note, most_to_blame
from cortex_dsl.report.titles import title_of
from engine.program import Program
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from engine.blame import Account

VERDICTS: Sequence[tuple[Verdict, str, str]] = (
    (Verdict.VALID, "good", "a scene was found"),
    (Verdict.EXHAUSTED, "warn", "no attempt passed"),
    (Verdict.INFEASIBLE, "warn", "shown impossible before sampling"),
    (Verdict.ABORTED, "warn", "broke a rule while it ran"),
    (Verdict.ERROR, "bad", "a bug in cortexc"),
)
BAR = 16


def sample_view(
    program: Program, tally: Tally, seconds: float, reproduce: str, account: "Account | None" = None
) -> RenderableType:
    """The whole report of `--sample N`."""
    rate = tally.attempts / seconds if seconds > 0 else 0.0
    attempts = Text.assemble(
        counted(tally.attempts, "attempt"),
        f", {percent(tally.acceptance)} of them accepted",
        (f"  {rate / 1e6:.1f} million a second" if rate > 1e5 else "", "quiet"),
    )
    requirements = requirements_view(program, tally, most_to_blame(program, tally, account))
    drawing = [verdicts_table(tally), Text(), attempts, *_params_kept(program, tally)]
    return Group(
        title_of(program),
        section(counted(tally.scenes, "scene"), Group(*drawing), reproduce),
        section("Requirements", requirements, "tested only where the earlier ones held"),
        *([] if account is None else [section("Who is to blame", blame_view(account), blame_note(account))]),
    )


def _params_kept(program: Program, tally: Tally) -> list[Text]:
    """What an attempt draws anew, and how many draws of the params are hopeless."""
    if not len(program.space):
        return []
    hopeless = int(tally.verdicts[Verdict.INFEASIBLE])
    told = [Text("a scene keeps its params: each of its attempts draws all the rest anew", "quiet")]
    if hopeless:
        told.append(Text(f"{hopeless:,} of {counted(tally.scenes, 'draw')} of the params can have no scene", "warn"))
    return told


def verdicts_table(tally: Tally) -> RenderableType:
    """Every verdict that occurred, and `valid` always."""
    rows = []
    for verdict, style, meaning in VERDICTS:
        count = int(tally.verdicts[verdict])
        if count or verdict == Verdict.VALID:
            share = ratio(count, tally.scenes)
            rows.append(
                (
                    Text(verdict.name.lower(), style),
                    Text(whole(count)),
                    Text(percent(share)),
                    Text(bar(share, 1.0, BAR), style),
                    Text(meaning, "quiet"),
                )
            )
    return columns(left(), right(), right(), left(), left(wrap=True), rows=rows)
