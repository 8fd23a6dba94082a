"""What the paper's arithmetic gives when it is done again."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, section
from engine.paper.check import Claim


def paper_view(claims: Sequence[Claim], everything: bool) -> RenderableType:
    """The claims by topic; only those that do not hold, unless everything is asked for."""
    wrong = sum(not claim.holds for claim in claims)
    summary = Text.assemble(
        (f"{wrong} of {len(claims)}", "bad"), " things that the paper says do not follow from its own numbers"
    )
    parts: list[RenderableType] = [summary]
    for topic in dict.fromkeys(claim.topic for claim in claims):
        shown = [claim for claim in claims if claim.topic == topic and (everything or not claim.holds)]
        if shown:
            parts.append(section(topic, _table(shown)))
    if not everything:
        parts += [Text(), Text("--all shows what holds, too", "quiet")]
    return Group(*parts)


def _table(claims: Sequence[Claim]) -> RenderableType:
    rows = [
        (
            Text("holds" if claim.holds else "does not", "good" if claim.holds else "bad"),
            Text.assemble(claim.says, (f"; {claim.remark}" if claim.remark else "", "quiet")),
            Text(claim.printed),
            Text(claim.found, "" if claim.holds else "warn"),
        )
        for claim in claims
    ]
    return columns(left(), left("says", wrap=True), left("printed"), left("found", wrap=True), rows=rows, header=True)
