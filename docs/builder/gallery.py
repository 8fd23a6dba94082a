"""The gallery: a search on each example, one of its ten worst cases as a replay, and a picture of it.

Of the ten the case is shown that begins farthest from the intersection: there is most to see.
"""

import ast
import contextlib
import html
import io
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from cortex_dsl.cli import main
from docs.builder.pages import ROOT

SEARCH = ("--ga", "--seed", "1")
HERO = "left_turn"
"""The example whose replay runs on the landing page."""
LOOP = ROOT / "docs" / "assets" / "loop.html"
"""Added to a replay, it leaves the road alone and plays again and again."""
PAGE = """\
---
hide: [navigation, toc, path]
---

# Gallery

Six situations of the paper, each searched by `cortexc examples/NAME.scn --ga --seed 1`: 3,000 simulations in a second
or two. A picture leads to the replay of one of the ten worst cases. Play it, step through it, read what happened and
what the risk is made of. Such a page is one file that needs no network; `cortexc replay RUN --to case.html` writes it.

<div class="gallery">
{cards}
</div>
"""
CARD = """\
<a class="film" href="{name}.html"><img src="{name}.svg" alt="The road and the two cars where they meet" loading="lazy">
<span class="film-title">{letter} · {name}</span>
<span class="film-text">{what}</span>
<span class="film-facts">risk {risk} of 22 · {collisions:,} different collisions found</span></a>"""


@dataclass(frozen=True)
class Film:
    """One example's case."""

    name: str
    title: str
    """The docstring of the file."""
    risk: int
    collisions: int
    """Colliding genomes that the search has found; no two are alike."""
    page: str
    """The replay, one self-contained HTML page."""
    picture: str
    """The road and the actors at the moment that the page opens with, as SVG."""

    @property
    def loop(self) -> str:
        """The replay without its tables and buttons, which plays by itself."""
        return self.page.replace("</body>", LOOP.read_text(encoding="utf-8") + "</body>")


def films() -> list[Film]:
    """One of each example, in the order of their letters."""
    return sorted((_film(path) for path in (ROOT / "examples").glob("*.scn")), key=lambda film: film.title)


def _film(path: Path) -> Film:
    with tempfile.TemporaryDirectory() as scratch, contextlib.redirect_stdout(io.StringIO()):
        run, replay, picture = (Path(scratch) / name for name in ("run", "replay.html", "picture.svg"))
        main([str(path), *SEARCH, "--out", str(run), "--json"])
        summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
        case = max(summary["worst"], key=lambda each: each["genome"]["EGO_INIT_DIST"] + each["genome"]["ADV_INIT_DIST"])
        for target in (replay, picture):
            main(["replay", str(run), "--case", str(case["rank"]), "--to", str(target)])
        page, drawing = (target.read_text(encoding="utf-8") for target in (replay, picture))
    title = ast.literal_eval(path.read_text(encoding="utf-8").partition("\n\n")[0].strip())
    return Film(path.stem, title, case["score"], summary["distinct_collisions"], page, drawing)


def page(found: list[Film]) -> str:
    """The gallery: a card for each film."""
    cards = []
    for film in found:
        letter, _, what = film.title.partition(": ")
        text = html.escape(what[:1].upper() + what[1:])
        cards.append(CARD.format(name=film.name, letter=letter, what=text, risk=film.risk, collisions=film.collisions))
    return PAGE.format(cards="\n".join(cards))
