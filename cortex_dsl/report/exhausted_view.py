"""Why there is no scene: every requirement with its counts, the params that were tried, and what to do."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.blame_view import blame_view
from cortex_dsl.report.layout import section
from cortex_dsl.report.numbers import counted
from cortex_dsl.report.params import params_view
from cortex_dsl.report.requirements import requirements_view
from cortex_dsl.report.tally import Tally, blame_note, cure_of_conflict
from engine.program import Program
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from engine.blame import Account

REASONS = {
    Verdict.INFEASIBLE: "the requirements contradict each other for these params",
    Verdict.EXHAUSTED: "no attempt met every requirement",
}


def exhausted_view(
    program: Program,
    tally: Tally,
    verdict: Verdict,
    genome: Sequence[float],
    account: "Account | None" = None,
) -> RenderableType:
    """What exit code 3 says where nothing could be run; `verdict` is one of `REASONS`."""
    parts: list[RenderableType] = [Text.assemble(("no valid scene", "bad"), _tried(tally, verdict))]
    if len(tally.tested):
        parts.append(
            section("Requirements", requirements_view(program, tally), "tested only where the earlier ones held")
        )
    if account is not None:
        parts.append(section("Who is to blame", blame_view(account), blame_note(account)))
    if len(program.space) and tally.scenes == 1:
        parts.append(section("Params of this attempt", params_view(program.space, genome)))
    parts += [Text(), _cure(account)]
    return Group(*parts)


def _tried(tally: Tally, verdict: Verdict) -> str:
    if tally.scenes == 0:
        return " can be drawn from this file; that is proved, so none was tried"
    draws = f" over {counted(tally.scenes, 'draw')} of the params" if tally.scenes > 1 else ""
    return f" in {counted(tally.attempts, 'attempt')}{draws}: {REASONS[verdict]}"


def _cure(account: "Account | None") -> Text:
    if account is not None and (cure := cure_of_conflict(account)):
        return Text(f"help: {cure}")
    return Text("help: another --seed, a wider range or window in the file, or more --max-attempts")
