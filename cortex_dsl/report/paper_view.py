"""What the paper's arithmetic gives when it is done again."""

from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, section
from engine.paper import Claim, by_assumption, said


def paper_view(claims: Sequence[Claim], everything: bool) -> RenderableType:
    """The claims by topic; only those that do not hold, unless everything is asked for."""
    parts: list[RenderableType] = list(_summary(claims))
    for topic in dict.fromkeys(claim.topic for claim in claims):
        shown = [claim for claim in claims if claim.topic == topic and (everything or not claim.holds)]
        if shown:
            parts.append(section(topic, _table(shown)))
    if not everything:
        parts += [Text(), Text("--all shows what holds, too", "quiet")]
    return Group(*parts)


def _summary(claims: Sequence[Claim]) -> Iterator[Text]:
    """What the paper says and what we infer are counted apart: an assumption that fails is one cause, not many."""
    own = said(claims)
    wrong = sum(not claim.holds for claim in own)
    tail = " things that the paper says do not follow from its own numbers"
    yield Text.assemble((f"{wrong} of {len(own)}", "bad"), tail)
    yield Text("beside them, what would follow if (an assumption of cortexc's; where it fails, one cause):", "quiet")
    for assumption, rows in by_assumption(claims).items():
        failing = sum(not claim.holds for claim in rows)
        yield Text(
            f"  {assumption}: {failing} of {len(rows)} {'row does' if len(rows) == 1 else 'rows do'} not", "quiet"
        )


def _table(claims: Sequence[Claim]) -> RenderableType:
    rows = [
        (
            Text("holds" if claim.holds else "does not", "good" if claim.holds else "bad"),
            Text.assemble(claim.says, (_remark(claim), "quiet")),
            Text(claim.printed),
            Text(claim.found, "" if claim.holds else "warn"),
        )
        for claim in claims
    ]
    return columns(left(), left("says", wrap=True), left("printed"), left("found", wrap=True), rows=rows, header=True)


def _remark(claim: Claim) -> str:
    told = [claim.remark, f"inferred, if {claim.assumption}" if claim.inferred else ""]
    return "".join(f"; {text}" for text in told if text)
